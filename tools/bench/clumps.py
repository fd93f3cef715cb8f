"""The command that times clumps beside LIGGGHTS's own multispheres, which fall on a rigid plane of triangles.

python -m tools.bench.clumps

Both have as many bodies of equal shape, size and material in a box above the plane, from which they fall and
come to rest in a thin layer; LIGGGHTS's own are placed by its own random insertion, ours by flipflow's.
"""

from __future__ import annotations

import argparse
import multiprocessing
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from mpi4py import MPI

from adapters.particles import liggghts
from adapters.particles._liggghts import Engine
from adapters.particles.liggghts.input import CLASS_RATIO
from orchestrator.case.bed.packing import equal_particles, find_places, random_orientations
from orchestrator.ports import Array, HermitePath, Motion
from orchestrator.ports.clock import Interval
from orchestrator.ports.clumps import clump
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.grains import Grain, Shape, ShapeTable
from orchestrator.ports.plans import GrainMaterial, ParticlesPlan
from tools.bench.stock import divided, write_stl

SIZE_M, DENSITY_KG_PER_M3, STEP_S, INTERVAL_S = 0.005, 1430.0, 5e-6, 1e-3
BOX_M = np.array([[-0.1, -0.1, 0.005], [0.1, 0.1, 0.06]])
HALF_M = 0.3  # of the plane
SHAPES: dict[int, tuple[tuple[float, float, float, float], ...]] = {
    1: ((0.0, 0.0, 0.0, 1.0),),
    3: tuple((0.0, 0.0, z, 1.0) for z in (-0.5, 0.0, 0.5)),
    8: tuple((x, y, z, 0.8) for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.6, 0.6)),
}
STOCK = """\
units si
atom_style granular
atom_modify map array
boundary f f f
newton off
communicate single vel yes
region all block -0.31 0.31 -0.31 0.31 -0.01 0.3 units box
create_box 1 all
neighbor 0.001 bin
neigh_modify delay 0
fix youngs all property/global youngsModulus peratomtype 1e7
fix poisson all property/global poissonsRatio peratomtype 0.3
fix restitution all property/global coefficientRestitution peratomtypepair 1 0.5
fix friction all property/global coefficientFriction peratomtypepair 1 0.3
pair_style gran model hertz tangential history
pair_coeff * *
timestep {step}
fix gravity all gravity 9.81 vector 0 0 -1
fix mesh all mesh/surface file {mesh} type 1 curvature_tolerant yes
fix plane all wall/gran model hertz tangential history mesh n_meshes 1 meshes mesh
region box block {box} units box
{template}
fix sizes all particledistribution/discrete 15485867 1 grains 1.0
fix fill all insert/pack seed 32452843 distributiontemplate sizes vel constant 0 0 -0.1 insert_every once \
overlapcheck yes all_in yes particles_in_region {bodies} region box
{motion}
run 1
"""


def plane_m() -> Array:
    """Return the corners (4, 3) of the plane."""
    return HALF_M * np.array([[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]])


def ours_s(shape: Shape, bodies: int, settling: int, timed: int) -> float:
    """Return the processor time per body and step, in s, of flipflow's bodies after some settling steps."""
    random = np.random.default_rng(1)
    size_m = np.full(bodies, SIZE_M)
    grains = Grain(1.0, DENSITY_KG_PER_M3, 0, 0, ShapeTable.of([shape])).of_sizes(size_m)
    place_m, placed = find_places(grains.bounding_radius_m, BOX_M, random, 200)
    assert placed.all(), "the box has room"
    turns = random_orientations(bodies, random)
    corners_m = plane_m()
    surface = TriangleSurface(corners_m, np.array([[0, 1, 2], [0, 2, 3]]), np.zeros(2, dtype=np.int64))
    plan = ParticlesPlan(
        surface=surface,
        materials=(GrainMaterial("grain", 1e7, 0.3),),
        restitution=np.full((1, 1), 0.5),
        sliding_friction=np.full((1, 1), 0.3),
        rolling_friction=np.zeros((1, 1)),
        particles=equal_particles(place_m, np.array([0.0, 0.0, -0.1]), grains, turns),
        shapes=(shape,),
        largest_radius_m=float(grains.bounding_radius_m.max()),
        domain_m=np.array([[-HALF_M, -HALF_M, -0.01], [HALF_M, HALF_M, 0.3]]),
        gravity_m_per_s2=np.array([0.0, 0.0, -9.81]),
        step_s=STEP_S,
        sync_interval_s=INTERVAL_S,
    )
    solver = liggghts.build(plan)
    still = Motion(corners_m, np.zeros_like(corners_m))
    each = round(INTERVAL_S / STEP_S)
    intervals = (settling // each, timed // each)
    index = 0
    for count in intervals:
        began_s = time.process_time()
        for _ in range(count):
            solver.advance(Interval(index, INTERVAL_S), HermitePath(still, still, INTERVAL_S))
            index += 1
        took_s = time.process_time() - began_s
    solver.close()
    return took_s / (intervals[1] * each * bodies)


def stock_s(shape: Shape, bodies: int, settling: int, timed: int) -> float:
    """Return the same of LIGGGHTS's own multispheres, or of its spheres for a shape of one."""
    with tempfile.TemporaryDirectory() as folder:
        engine = Engine(
            communicator=MPI.COMM_SELF.py2f(),
            screen_file=str(Path(folder) / "screen"),
            log_file=str(Path(folder) / "log"),
            contact_distance_factor=1.05,
            class_ratio=CLASS_RATIO,
            as_packaged=True,
        )
        for line in stock_input(shape, bodies, Path(folder)):
            engine.command(line)
        engine.command(f"run {settling}")
        began_s = time.process_time()
        engine.command(f"run {timed} pre no post no")
        return (time.process_time() - began_s) / (timed * bodies)


def stock_input(shape: Shape, bodies: int, folder: Path) -> Iterator[str]:
    """Yield LIGGGHTS's input, line by line, and write its plane to ``folder``."""
    mesh, corners_m = folder / "plane.stl", plane_m()
    write_stl(mesh, divided(corners_m[np.array([[0, 1, 2], [0, 2, 3]])]))
    own = np.array(shape.spheres) * SIZE_M
    kind = f"atom_type 1 density constant {DENSITY_KG_PER_M3}"
    if len(own) == 1:
        template = f"fix grains all particletemplate/sphere 15485863 {kind} radius constant {own[0, 3]!r}"
        motion = "fix motion all nve/sphere"
    else:
        listed = " ".join(repr(float(number)) for number in own.ravel())
        template = (
            f"fix grains all particletemplate/multisphere 15485863 {kind} nspheres {len(own)} "
            f"ntry 1000000 spheres {listed} type 1"
        )
        motion = "fix motion all multisphere"
    box = " ".join(repr(float(edge)) for edge in BOX_M.T.ravel())
    text = STOCK.format(step=STEP_S, box=box, template=template, bodies=bodies, motion=motion, mesh=mesh)
    yield from (line for line in text.splitlines() if line)


def main() -> None:
    """Read the command line, and print a row for each number of spheres."""
    parser = argparse.ArgumentParser("python -m tools.bench.clumps", description=__doc__.splitlines()[0])
    parser.add_argument("--bodies", type=int, default=1000)
    parser.add_argument("--settling", type=int, default=30_000, help="steps before those that are timed")
    parser.add_argument("--timed", type=int, default=4000, help="steps")
    args = parser.parse_args()
    print("spheres  flipflow  LIGGGHTS alone, ns per body and step")
    for count, listed in SHAPES.items():
        shape = clump(f"of-{count}", "", listed)
        row = []
        for timer in (ours_s, stock_s):  # contact models are tables of a process
            with multiprocessing.get_context("spawn").Pool(1) as pool:
                row.append(1e9 * pool.apply(timer, (shape, args.bodies, args.settling, args.timed)))
        print(f"{count:7d}  {row[0]:8.0f}  {row[1]:8.0f}", flush=True)


if __name__ == "__main__":
    main()
