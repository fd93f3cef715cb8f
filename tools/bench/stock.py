"""LIGGGHTS alone: a bed on rigid walls that LIGGGHTS itself makes of the surface's triangles.

The walls are LIGGGHTS's ``mesh/surface``, one for each material.  They stand still, or all move to and fro
as one (``move/mesh wiggle``).  Contact laws and steps are those of the case, skin and bins those that suit
LIGGGHTS.  The laws run as the package has them; of ``jkr``, which it lacks, the law is ours and the loop over
pairs the package's.
"""

from __future__ import annotations

import math
import multiprocessing
import time
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, fields, replace
from multiprocessing.connection import Connection
from pathlib import Path

import numpy as np
from mpi4py import MPI

from adapters.particles._liggghts import Engine
from adapters.particles.liggghts.engine import contact_distance_factor, create_particles
from adapters.particles.liggghts.input import (
    CLASS_RATIO,
    FIRST_EVALUATION,
    contact_model,
    cutoff_m,
    input_text,
    skin_m,
    smallest_box_m,
    words,
)
from orchestrator.case.solver_plans import particles_plan
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array, ParticleSnapshot
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import RigidVertices, TriangleSurface
from orchestrator.ports.plans import ParticleList, ParticlesPlan

SPAWN = multiprocessing.get_context("spawn")
MARGIN_M = 0.1
"""The distance from surface and bed to the sides of the box."""
ROOM_M = 1e-6
"""The least distance of the meshes from periodic sides."""
LISTED = 90.0, 0.7
"""The costs of LIGGGHTS's own lists of neighbours for ``skin_m``: each of both has the skin that suits it."""
BINS_PER_PARTICLE = 64
LARGEST_M = 0.1
"""The largest length of a triangle of the meshes."""
FACET = """\
facet normal 0 0 0
outer loop
vertex {} {} {}
vertex {} {} {}
vertex {} {} {}
endloop
endfacet
"""


@dataclass(frozen=True)
class Wiggle:
    """A harmonic motion of the whole surface, with ``amplitude_m`` (3,)."""

    amplitude_m: Array
    period_s: float

    @staticmethod
    def like(velocities_m_per_s: list[Array], period_s: float) -> Wiggle:
        """Return the motion whose velocity has the root mean square of these, (points, 3) each."""
        squares = np.concatenate(velocities_m_per_s) ** 2
        return Wiggle(np.sqrt(2.0 * squares.mean(axis=0)) * period_s / (2.0 * math.pi), period_s)


class StockRunner:
    """LIGGGHTS alone, which advances block by block; without a ``wiggle`` its walls stand still.

    It begins with the particles ``bed`` on the surface ``surface``.  Nothing is fed, and no exit takes
    particles out.  It has a process of its own, since the tables of contact models are those of a process.
    """

    def __init__(
        self, case: Case, surface: TriangleSurface, bed: ParticleSnapshot, wiggle: Wiggle | None, folder: Path
    ) -> None:
        folder.mkdir()
        self._plan = _stock_plan(case, surface, bed)
        self._steps = Interval(0, self._plan.sync_interval_s).steps(self._plan.step_s)
        self._pipe, end = SPAWN.Pipe()
        self._process = SPAWN.Process(target=_serve, args=(end, self._plan, wiggle, folder), daemon=True)
        self._process.start()
        end.close()  # so that the pipe ends with the process
        self._pipe.recv()
        self.wall_s, self.particle_steps = 0.0, 0
        self.blocks_s: list[float] = []  # CPU time of each block

    def block(self, intervals: int) -> None:
        """Advance by as many steps as that many sync intervals have, and add the times.

        Raises EOFError if the process has ended."""
        started = time.perf_counter()
        self._pipe.send(intervals * self._steps)
        self.blocks_s.append(self._pipe.recv())
        self.wall_s += time.perf_counter() - started
        self.particle_steps += intervals * self._steps * len(self._plan.particles)

    def close(self) -> None:
        """End the process."""
        self._pipe.close()
        self._process.join()


def _stock_plan(case: Case, surface: TriangleSurface, bed: ParticleSnapshot) -> ParticlesPlan:
    """Return the case's plan with these particles on this surface, without feed and exits."""
    rows = {field.name: getattr(bed, field.name) for field in fields(ParticleList)}
    plan = particles_plan(case, surface)
    assert plan is not None, "asked of a case without particles"
    if plan.periodic_y:  # stock meshes end the run where a node lies beyond a periodic side, be it by microns
        _, (low_m, high_m), _ = np.array(plan.domain_m).T
        inside_m = surface.vertices_m.copy()
        inside_m[:, 1] = inside_m[:, 1].clip(low_m + ROOM_M, high_m - ROOM_M)
        plan = replace(plan, surface=replace(surface, position_m=inside_m, rigid=RigidVertices.none()))
    return replace(plan, particles=ParticleList(**rows), feed=None, exits=())


def _serve(pipe: Connection, plan: ParticlesPlan, wiggle: Wiggle | None, folder: Path) -> None:
    """Run the numbers of steps that come through a pipe, and answer with the CPU time of each, in s."""
    engine = stock_engine(plan, wiggle, folder)
    pipe.send(0.0)
    with suppress(EOFError):
        while True:
            steps = pipe.recv()
            cpu_s = time.process_time()
            engine.command(f"run {steps} pre no post no")
            pipe.send(time.process_time() - cpu_s)


def stock_engine(
    plan: ParticlesPlan, wiggle: Wiggle | None, folder: Path, as_packaged: bool = True
) -> Engine:
    """Return LIGGGHTS with the particles of a plan on its own walls, which is ready to run.

    All engines of a process have laws ``as_packaged``, or all have ours.
    """
    engine = Engine(
        communicator=MPI.COMM_SELF.py2f(),
        screen_file=str(folder / "screen.liggghts"),
        log_file=str(folder / "log.liggghts"),
        contact_distance_factor=contact_distance_factor(plan),
        class_ratio=CLASS_RATIO,
        as_packaged=as_packaged,
    )
    for line in stock_input(plan, wiggle, folder):
        engine.command(line)
    create_particles(engine, plan.particles, 1)
    engine.command(f"neigh_modify binsize {_bins_m(plan)!r}")
    engine.command(FIRST_EVALUATION)
    return engine


def stock_input(plan: ParticlesPlan, wiggle: Wiggle | None, folder: Path) -> Iterator[str]:
    """Yield the case's own input for LIGGGHTS, line by line, with stock mesh walls in place of ours.

    It writes the meshes to ``folder``.  The box is fixed, since LIGGGHTS fails where a mesh meets a periodic
    box that shrinks; particles that leave it are gone.
    """
    low_m, high_m = smallest_box_m(plan)
    margin_m = MARGIN_M * np.array([1.0, not plan.periodic_y, 1.0])
    box = words(np.column_stack([low_m - margin_m, high_m + margin_m]).round(12))
    for line in input_text(plan).splitlines():
        match line.split()[:2]:
            case ["boundary", _]:
                yield "boundary f p f" if plan.periodic_y else "boundary f f f"
            case ["region", "box"]:
                yield f"region box block {box} units box"
            case ["fix", "surface"]:
                yield from _stock_walls(plan, wiggle, folder)
            case ["neighbor", _]:
                yield f"neighbor {skin_m(plan, *LISTED, class_ratio=math.inf)!r} bin"
            case ["fix", "exits"]:
                yield "thermo_modify lost ignore"
            case _:
                yield line


def _stock_walls(plan: ParticlesPlan, wiggle: Wiggle | None, folder: Path) -> Iterator[str]:
    model, meshes = contact_model(plan), []
    for number in np.unique(plan.surface.material):
        name = f"mesh{number}"
        stl, triangles = folder / f"{name}.stl", plan.surface.triangles[plan.surface.material == number]
        write_stl(stl, divided(plan.surface.vertices_m[triangles]))
        yield f"fix {name} all mesh/surface file {stl} type {number + 1} curvature_tolerant yes"
        meshes.append(name)
    yield f"fix surface all wall/gran {model} mesh n_meshes {len(meshes)} meshes {' '.join(meshes)}"
    if wiggle is not None:
        amplitude = " ".join(repr(float(value)) for value in wiggle.amplitude_m)
        motion = f"wiggle amplitude {amplitude} period {wiggle.period_s!r}"
        yield from (f"fix move_{name} all move/mesh mesh {name} {motion}" for name in meshes)


def divided(corners_m: Array) -> Array:
    """Return triangles (m, 3, 3) cut into four until none is longer than ``LARGEST_M``.

    LIGGGHTS fails to find the common corners of a few large triangles.
    """
    edges_m = np.linalg.norm(corners_m - np.roll(corners_m, 1, axis=1), axis=2).max(axis=1, initial=0.0)
    large, small = corners_m[edges_m > LARGEST_M], corners_m[edges_m <= LARGEST_M]
    if not len(large):
        return np.asarray(small)
    a, b, c = (large[:, corner] for corner in range(3))
    ab, bc, ca = (a + b) / 2, (b + c) / 2, (c + a) / 2
    four = [np.stack(parts, axis=1) for parts in ((a, ab, ca), (ab, b, bc), (ca, bc, c), (ab, bc, ca))]
    return np.concatenate([small, divided(np.concatenate(four))])


def write_stl(path: Path, corners_m: Array) -> None:
    """Write triangles (m, 3, 3) as an STL file, without losing digits."""
    facets = "".join(FACET.format(*map(repr, row)) for row in corners_m.reshape(-1, 9).tolist())
    path.write_text(f"solid surface\n{facets}endsolid surface\n", encoding="ascii")


def _bins_m(plan: ParticlesPlan) -> float:
    """Return the size of the bins in which LIGGGHTS finds neighbours: half a cutoff, as by default, or more.

    There are at most ``BINS_PER_PARTICLE`` in all, which it clears for every list."""
    box_m3 = float(np.prod(np.diff(smallest_box_m(plan), axis=0)))
    return max(cutoff_m(plan) / 2.0, float(np.cbrt(box_m3 / (BINS_PER_PARTICLE * len(plan.particles)))))
