"""The open LIGGGHTS solver.

Contacts between particles are LIGGGHTS's own; those with the surface are found by our bridge
(``adapters/particles/bridge``) and handed to the same contact model:
docs/theory/particle_surface_contact.md.
"""

from __future__ import annotations

from collections.abc import Iterable
from contextlib import ExitStack
from pathlib import Path as FilePath
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt

from adapters.particles.liggghts.domain_cuts import UNEVEN, Places, cuts_on_the_way, even_cuts
from adapters.particles.liggghts.input import FIRST_EVALUATION
from adapters.particles.liggghts.ledger import ParticleLedger
from orchestrator.ports import (
    Account,
    Array,
    BrokenRecord,
    ContactTangent,
    Crossings,
    HermitePath,
    Load,
    Overlaps,
    ParticleSnapshot,
    Removed,
    Saved,
    sort_removed,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.grains import Grain, Grains, placed_spheres, upright
from orchestrator.ports.plans import ParticleList, ParticlesPlan, SolverFailed, SolverMissing
from orchestrator.ports.state import as_arrays, like

try:
    from mpi4py import MPI

    from adapters.particles.liggghts.engine import (
        begin_path,
        create_bodies,
        create_particles,
        floats,
        parts,
        start_engine,
    )
    from adapters.particles.liggghts.input import cutoff_m, has_bodies
except ImportError as missing:
    raise SolverMissing(
        f"the particles by LIGGGHTS need their compiled part, which docker/setup.sh builds: {missing}"
    ) from missing

BALANCED_EVERY = 100
"""Number of sync intervals after which the ranks compare their numbers of particles."""
FEW = 500
"""Number of particles per rank below which it does not matter who has them."""

Arrays = dict[str, npt.NDArray[Any]]
"""Arrays by LIGGGHTS's names, one row per particle of this rank; ``type`` counts from 1."""


class Liggghts:
    """A solver of a plan's particles by LIGGGHTS; all calls are collective over the plan's communicator."""

    def __init__(self, plan: ParticlesPlan) -> None:
        self._plan = plan
        self._comm: Any = plan.communicator or MPI.COMM_SELF
        self._ledger = ParticleLedger(plan, self._comm)
        self._created = 0
        self._has_bodies = has_bodies(plan)
        self._deepest, self._crossings = Overlaps(), Crossings.none()
        self._unprepared = False
        self._removed: list[Removed] = []
        with ExitStack() as opened:
            # LIGGGHTS's log goes to the plan's folder, or to one that goes with the solver
            folder = plan.folder or FilePath(
                opened.enter_context(TemporaryDirectory(prefix="flipflow_liggghts_"))
            )
            folder.mkdir(parents=True, exist_ok=True)
            try:
                self._engine = start_engine(plan, self._comm, folder)
                self._create(plan.particles)
                self._engine.command(FIRST_EVALUATION)
            except RuntimeError as error:
                raise SolverFailed(f"LIGGGHTS refuses its input: {error}") from error
            self._check(0.0, *self._tally()[:2])
            self._ledger.open(self._engine)
            self._opened = opened.pop_all()

    def _create(self, new: ParticleList) -> None:
        create = create_bodies if self._has_bodies else create_particles
        create(self._engine, new, self._created + 1)
        self._created += len(new)

    def initial(self) -> Load:
        return Load(self._summed(self._engine.force_N()))

    def advance(self, interval: Interval, path: HermitePath) -> Load:
        """Move the particles over an interval; see ``Particles.advance``.

        Raises SolverFailed if LIGGGHTS fails, loses a particle or makes a NaN, and BrokenRecord if
        the path is not that of the plan's surface points."""
        points = len(self._plan.surface.position_m)
        if len(path.start) != points or len(path.end) != points:
            raise BrokenRecord(f"HermitePath: {points} points wanted, got {len(path.start)}")
        steps = interval.steps(self._plan.step_s)
        try:
            begin_path(self._engine, path, interval.length_s, steps)
            self._balance(interval)
            self._feed(interval)
            self._prepare()
            self._engine.run(steps=steps, step_s=interval.length_s / steps)
        except RuntimeError as error:
            raise SolverFailed(f"LIGGGHTS failed after t = {interval.start_s:.6g} s: {error}") from error
        self._ledger.add_gravity(interval.length_s)
        present, nowhere, removed, crossed = self._tally()
        if removed:
            self._take_out(interval, interval.length_s / steps)
        self._check(interval.end_s, present, nowhere)
        if crossed:
            self._add_crossings(interval.start_s, interval.length_s / steps)
        return Load(self._summed(self._engine.impulse_N_s()) / interval.length_s)

    def snapshot(self) -> ParticleSnapshot:
        """Return all particles in the order of their ids, on the first rank; none on the others."""
        self._prepare()
        columns = ("size", "shape", "turn") if self._has_bodies else ("radius",)
        names = ("tag", "x", "v", "omega", "f", "density", "type", *columns)
        of_all = self._engine.bodies() if self._has_bodies else self._engine.particles()
        mine = [self._engine.contact_numbers(), *(np.array(of_all[name]) for name in names)]
        ranks = self._comm.gather(mine)
        if self._comm.rank != 0:
            ranks = [[values[:0] for values in mine]]
        order = np.argsort(np.concatenate([values[1] for values in ranks]))
        contacts, tag, x, v, omega, force, *grains = (
            np.concatenate(parts).take(order, axis=0) for parts in zip(*ranks, strict=True)
        )
        return ParticleSnapshot(
            id=tag.astype(np.int64),
            position_m=x,
            velocity_m_per_s=v,
            spin_rad_per_s=omega,
            grains=self._grains(dict(zip(names[5:], grains, strict=True))),
            force_N=force,
            contacts=contacts,
            orientation=grains[-1] if self._has_bodies else upright(len(tag)),
        )

    def removed(self) -> Removed:
        mine, self._removed = self._removed, []
        ranks = self._comm.gather(mine)
        return self._sorted(part for rank in ranks or [] for part in rank)

    def overlaps(self) -> Overlaps:
        self._prepare()
        since, self._deepest = self._deepest_of_rank(), Overlaps()
        values = np.array(list(vars(since).values()))
        self._comm.Allreduce(MPI.IN_PLACE, values, MPI.MAX)
        return Overlaps(*values.tolist())

    def crossings(self) -> Crossings:
        return self._crossings

    def worn_m3(self) -> Array:
        return self._summed(self._engine.worn_m3())

    def contact_tangent(self, length_s: float) -> ContactTangent:
        assert self._plan.predicts_load, "asked of a plan without"
        mine = self._engine.contact_tangent(length_s)
        return ContactTangent(**{name: self._summed(values) for name, values in mine.items()})

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """Return views of this rank's particles in LIGGGHTS's own memory, valid until the next advance.

        They are x, v, omega, f, torque (n, 3), radius, rmass, density, type (from 1), tag (n,), all SI."""
        return self._engine.particles()

    def account(self) -> Account:
        """Return the account; only ``contact_dissipation``, the remainder of the balance, is inexact."""
        self._prepare()
        return self._ledger.account(self._engine)

    def save(self) -> Saved:
        self._prepare()
        return {
            "engine": self._engine.save(),
            "ledger": self._ledger.save(),
            "created": np.array(self._created),
            "deepest": as_arrays(self._deepest_of_rank()),
            "crossings": as_arrays(self._crossings),
            "removed": as_arrays(self._sorted(self._removed)),
        }

    def restore(self, saved: Saved) -> None:
        self._engine.restore(saved["engine"])
        self._ledger.restore(saved["ledger"])
        self._created = int(saved["created"])
        self._engine.take_deepest_overlaps()  # of what was evaluated to get back there
        self._deepest = like(Overlaps(), saved["deepest"])
        self._crossings = like(Crossings.none(), saved["crossings"])
        self._removed = [like(self._sorted([]), saved["removed"])]
        self._unprepared = False

    def close(self) -> None:
        del self._engine
        self._opened.close()

    def _grains(self, columns: Arrays) -> Grains:
        """Return the grains of the engine's columns (n,), of bodies or of single spheres."""
        material = columns["type"].astype(np.int64) - 1
        shapes = self._plan.particles.grains.shapes
        if self._has_bodies:
            size_m, shape = columns["size"], columns["shape"].astype(np.int64)
        else:
            size_m, shape = 2.0 * columns["radius"], np.zeros_like(material)
        return Grain(size_m, columns["density"], material, shape, shapes)

    def _sorted(self, removed: Iterable[Removed]) -> Removed:
        plan = self._plan
        return sort_removed([*removed], plan.particles.grains.shapes, plan.counted_panels)

    def _summed(self, by_point: Array) -> Array:
        self._comm.Allreduce(MPI.IN_PLACE, by_point)
        return by_point

    def _tally(self) -> list[int]:
        """Return the sums of the ranks' tallies of particles (``Engine.tally``)."""
        tally = self._engine.tally()
        self._comm.Allreduce(MPI.IN_PLACE, tally)
        numbers: list[int] = tally.tolist()
        return numbers

    def _balance(self, interval: Interval) -> None:
        """Now and then cut the box elsewhere, if one rank has far more particles than the mean."""
        if self._comm.size == 1 or interval.index % BALANCED_EVERY:
            return
        present = np.zeros(self._comm.size, dtype=int)
        position_m = self._engine.particles()["x"]
        self._comm.Allgather(np.array(len(position_m)), present)
        if present.sum() < FEW * self._comm.size or present.max() <= UNEVEN * present.mean():
            return
        now, corners_m = self._engine.cuts(), self._engine.box_m()
        shares = self._summed(Places.of_particles(position_m).in_slices(corners_m) * len(position_m))
        wanted = even_cuts(shares, parts(self._engine), corners_m, cutoff_m(self._plan))
        self._engine.cut_later(cuts_on_the_way(now, wanted))

    def _feed(self, interval: Interval) -> None:
        if self._plan.feed is None:
            return
        offer = self._plan.feed.due(interval)
        if len(offer) == 0:
            return
        grain, place_m, radius_m = placed_spheres(offer.grains, offer.position_m, offer.orientation)
        overlapping = np.array(
            self._engine.overlaps(position_m=floats(place_m), diameter_m=floats(2.0 * radius_m))
        )
        blocked = np.bincount(grain, overlapping, minlength=len(offer)) > 0
        self._comm.Allreduce(MPI.IN_PLACE, blocked, MPI.LOR)
        accepted = ~blocked
        if accepted.any():
            new = offer.part(accepted)
            self._engine.store_history()
            self._create(new)
            self._ledger.add_fed(new)
            self._unprepared = True
        self._plan.feed.settle(accepted)

    def _take_out(self, interval: Interval, step_s: float) -> None:
        mine = self._engine.take_removed()
        # within a step, LIGGGHTS's velocity is half a step old; without contacts, gravity fills that up (what
        # air would take in half a step is left out, here and in the books)
        filled_s = step_s * mine["velocity_behind"]
        mine["v"] += np.outer(filled_s, self._plan.gravity_m_per_s2)
        self._ledger.subtract_removed(mine, interval.length_s - step_s * mine["step"], filled_s)
        if len(mine["tag"]):
            contacts, over_s, within_reach_s = np.split(mine["deck"][:, 1:], 3, axis=1)
            record = Removed(
                id=mine["tag"].astype(np.int64),
                time_s=interval.start_s + step_s * mine["step"],
                position_m=mine["x"],
                velocity_m_per_s=mine["v"],
                grains=self._grains(mine),
                exit=mine["exit"].astype(np.int64),
                contacts=contacts.astype(np.int32),
                over_s=over_s.astype(np.float32),
                within_reach_s=within_reach_s.astype(np.float32),
                last_panel=mine["deck"][:, 0].astype(np.int64),
            )
            self._removed.append(record)

    def _prepare(self) -> None:
        """Sort the particles and evaluate their forces, if particles were added."""
        if self._unprepared:
            self._engine.prepare()
            self._unprepared = False

    def _deepest_of_rank(self) -> Overlaps:
        """Return the deepest of this rank's contacts since the last call of ``overlaps``."""
        self._deepest = self._deepest.deepest(Overlaps(**self._engine.take_deepest_overlaps()))
        return self._deepest

    def _add_crossings(self, start_s: float, step_s: float) -> None:
        """Add the crossings of all ranks in the last interval to the record, on every rank."""
        ranks = self._comm.allgather(_crossings(self._engine.take_crossings(), start_s, step_s))
        some = [crossings for crossings in ranks if crossings.number]
        for later in sorted(some, key=lambda one: (one.first_time_s, one.first_id)):
            self._crossings = self._crossings.followed_by(later)

    def _check(self, time_s: float, present: int, nowhere: int) -> None:
        """Raise SolverFailed where a particle is missing or nowhere."""
        if nowhere:
            raise SolverFailed(f"LIGGGHTS at t = {time_s:.6g} s: a particle's place or velocity is NaN")
        expected = self._created - self._ledger.removed_count
        if present != expected:
            raise SolverFailed(
                f"LIGGGHTS lost particles before t = {time_s:.6g} s: {present} of {expected} are left"
            )


def _crossings(mine: Arrays, start_s: float, step_s: float) -> Crossings:
    """Return the record of this rank's particles that went through the surface in an interval.

    The interval began at ``start_s``; within one step the lowest id counts as the first.
    """
    if not len(mine["tag"]):
        return Crossings.none()
    first = np.lexsort((mine["tag"], mine["step"]))[0]
    time_s = start_s + step_s * int(mine["step"][first])
    return Crossings(len(mine["tag"]), int(mine["tag"][first]), time_s, mine["x"][first])
