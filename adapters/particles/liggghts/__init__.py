"""Particles by LIGGGHTS 3.8.0 (DEM: C. Kloss et al., Prog. Comput. Fluid Dyn. 12 (2012) 140-152,
doi 10.1504/PCFD.2012.047457), in this process and without files.

Contacts between particles are LIGGGHTS's own; those with the surface are found by our bridge
(``bridge/``) and handed to the same contact model: docs/theory/particle_surface_contact.md.
"""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path as FilePath
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import numpy.typing as npt

from adapters.particles.liggghts.input import FIRST_EVALUATION
from adapters.particles.liggghts.ledger import Ledger
from adapters.particles.liggghts.records import Arrays, crossings, removed, snapshot
from orchestrator.ports import (
    Account,
    Array,
    BrokenRecord,
    Crossings,
    Load,
    Overlaps,
    ParticleSnapshot,
    Removed,
    Response,
    Saved,
    in_order,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.hermite import Path
from orchestrator.ports.plans import ParticleList, ParticlesPlan, SolverFailed, SolverMissing
from orchestrator.ports.state import as_arrays, like

try:
    from mpi4py import MPI

    from adapters.particles.liggghts.start import create, start
except ImportError as missing:
    raise SolverMissing(
        "the LIGGGHTS bridge is not built: install Debian's libliggghts-dev, libopenmpi-dev and "
        f"g++, then `pip install .` ({missing})"
    ) from missing


def build(plan: ParticlesPlan) -> Liggghts:
    """Start LIGGGHTS with the plan's particles on the surface at t = 0.

    Raises :class:`SolverFailed` if LIGGGHTS refuses the input.  In a parallel run an error can
    stop a single rank; the caller must then abort the communicator.
    """
    return Liggghts(plan)


class Liggghts:
    """The open solver; collective over the plan's communicator."""

    def __init__(self, plan: ParticlesPlan) -> None:
        self._plan = plan
        self._comm: Any = plan.communicator or MPI.COMM_SELF
        self._ledger = Ledger(plan, self._comm)
        self._created = 0
        self._deepest, self._crossings = np.zeros(4), Crossings.none()
        self._unprepared = False
        self._removed: list[Removed] = []
        with ExitStack() as opened:
            # LIGGGHTS's log goes to the plan's folder, or to one that goes with the solver
            folder = plan.folder or FilePath(
                opened.enter_context(TemporaryDirectory(prefix="flipflow_liggghts_"))
            )
            folder.mkdir(parents=True, exist_ok=True)
            self._launch(folder)
            self._check(0.0)
            self._ledger.open(self._engine)
            self._opened = opened.pop_all()

    def _launch(self, folder: FilePath) -> None:
        try:
            self._engine = start(self._plan, self._comm, folder)
            self._create(self._plan.particles)
            self._engine.command(FIRST_EVALUATION)
        except RuntimeError as error:
            raise SolverFailed(f"LIGGGHTS refuses its input: {error}") from error

    def _create(self, new: ParticleList) -> None:
        create(self._engine, new, self._created + 1)
        self._created += len(new)

    def initial(self) -> Load:
        return Load(self._summed(self._engine.force_N()))

    def advance(self, interval: Interval, path: Path) -> Load:
        """Raises :class:`SolverFailed` if LIGGGHTS fails, loses a particle or makes a NaN, and
        :class:`BrokenRecord` if the path is not that of the plan's surface points."""
        points = len(self._plan.surface.position_m)
        if len(path.start) != points or len(path.end) != points:
            raise BrokenRecord(f"Path: {points} points wanted, got {len(path.start)}")
        steps = interval.steps(self._plan.step_s)
        try:
            self._engine.begin_path(
                path.start.position_m,
                path.start.velocity_m_per_s,
                path.end.position_m,
                path.end.velocity_m_per_s,
                interval.length_s,
                steps,
            )
            self._feed(interval)
            self._prepare()
            self._engine.run(steps, interval.length_s / steps)
        except RuntimeError as error:
            raise SolverFailed(f"LIGGGHTS failed after t = {interval.start_s} s: {error}") from error
        self._ledger.fell(interval.length_s)
        self._take_out(interval, interval.length_s / steps)
        crossed = self._engine.take_crossings()
        if self._check(interval.end_s, len(crossed["tag"])):
            self._add_crossings(crossed, interval.start_s, interval.length_s / steps)
        return Load(self._summed(self._engine.impulse_N_s()) / interval.length_s)

    def snapshot(self) -> ParticleSnapshot:
        return snapshot(self._engine.particles(), self._comm)

    def removed(self) -> Removed:
        mine, self._removed = self._removed, []
        ranks = self._comm.gather(mine)
        return in_order([one for rank in ranks or [] for one in rank])

    def overlaps(self) -> Overlaps:
        self._prepare()
        since, self._deepest = self._deepest_mine(), np.zeros(4)
        self._comm.Allreduce(MPI.IN_PLACE, since, MPI.MAX)
        return Overlaps(*since.tolist())

    def crossings(self) -> Crossings:
        return self._crossings

    def worn_m3(self) -> Array:
        return self._summed(self._engine.worn_m3())

    def response(self, length_s: float) -> Response:
        assert self._plan.responds, "asked of a plan without"
        push_N, impedance_N_s_per_m = (self._summed(a) for a in self._engine.response(length_s))
        return Response(push_N, impedance_N_s_per_m.reshape(-1, 3, 3))

    def arrays(self) -> dict[str, npt.NDArray[Any]]:
        """This rank's particles in LIGGGHTS's own memory: x, v, omega, f, torque (n, 3), radius,
        rmass, density, type (from 1), tag (n,), all SI.  Valid until the next advance."""
        return self._engine.particles()

    def account(self) -> Account:
        """Exact but for ``contact_dissipation``, which is what is left of the energy balance."""
        self._prepare()
        return self._ledger.account(self._engine)

    def save(self) -> Saved:
        self._prepare()
        return {
            "engine": self._engine.save(),
            "ledger": self._ledger.save(),
            "created": np.array(self._created),
            "deepest": self._deepest_mine(),
            "crossings": as_arrays(self._crossings),
            "removed": as_arrays(in_order(self._removed)),
        }

    def restore(self, saved: Saved) -> None:
        self._engine.restore(saved["engine"])
        self._ledger.restore(saved["ledger"])
        self._created = int(saved["created"])
        self._engine.take_deepest_overlaps()  # of what was evaluated to get back there
        self._deepest = np.array(saved["deepest"])
        self._crossings = like(Crossings.none(), saved["crossings"])
        self._removed = [like(in_order([]), saved["removed"])]
        self._unprepared = False

    def close(self) -> None:
        del self._engine
        self._opened.close()

    def _summed(self, by_point: Array) -> Array:
        self._comm.Allreduce(MPI.IN_PLACE, by_point)
        return by_point

    def _feed(self, interval: Interval) -> None:
        if self._plan.feed is None:
            return
        offer = self._plan.feed.due(interval)
        if len(offer) == 0:
            return
        blocked = np.array(self._engine.overlaps(offer.position_m, offer.diameter_m))
        self._comm.Allreduce(MPI.IN_PLACE, blocked, MPI.LOR)
        accepted = ~blocked
        if accepted.any():
            new = offer.part(accepted)
            self._engine.store_history()
            self._create(new)
            self._ledger.fed(new)
            self._unprepared = True
        self._plan.feed.settle(accepted)

    def _take_out(self, interval: Interval, step_s: float) -> None:
        mine = self._engine.take_removed()
        # LIGGGHTS stopped half a step before; without contacts, gravity alone fills that up
        mine["v"] += step_s / 2.0 * self._plan.gravity_m_per_s2
        self._ledger.removed(mine, interval.length_s - step_s * mine["step"], step_s)
        if len(mine["tag"]):
            self._removed.append(removed(mine, interval.start_s + step_s * mine["step"]))

    def _prepare(self) -> None:
        """After particles came: sort them and evaluate their forces."""
        if self._unprepared:
            self._engine.prepare()
            self._unprepared = False

    def _deepest_mine(self) -> Array:
        """Of this rank's contacts since ``overlaps`` was last asked, in the order of the record."""
        self._deepest = np.maximum(self._deepest, self._engine.take_deepest_overlaps())
        return self._deepest.copy()

    def _add_crossings(self, mine: Arrays, start_s: float, step_s: float) -> None:
        """Of the last interval; every rank gets those of all."""
        ranks = self._comm.allgather(crossings(mine, start_s, step_s))
        some = [one for one in ranks if one.number]
        for one in sorted(some, key=lambda one: (one.first_time_s, one.first_id)):
            self._crossings = self._crossings.followed_by(one)

    def _check(self, time_s: float, crossed: int = 0) -> int:
        """Of all ranks' ``crossed``, the sum.  Raises SolverFailed where a particle is missing, or
        is nowhere."""
        mine = self._engine.particles()
        bad = int(not (np.isfinite(mine["x"]).all() and np.isfinite(mine["v"]).all()))
        counts = np.array([len(mine["x"]), bad, crossed])
        present, bad, crossed = self._comm.allreduce(counts)
        if bad:
            raise SolverFailed(f"LIGGGHTS at t = {time_s} s: a particle's place or velocity is NaN")
        expected = self._created - self._ledger.removed_count
        if present != expected:
            raise SolverFailed(
                f"LIGGGHTS lost particles before t = {time_s} s: {present} of {expected} are left"
            )
        return crossed
