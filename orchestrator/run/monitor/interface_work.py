"""The work that crosses the interfaces, and the energy that the coupling creates there.

Between two sync points, each side of an interface moves from a known place to a known place under a
known mean load.  The work therefore needs no call of a solver, and no rank waits.

Particles and panels: the panels move from x to y under the load P.  The particles see a path from p to
q under their mean load F, after a jump from the end of their last path to p under a load J.  The
particles receive -F.(q - p) and -J.jump, and the panels P.(y - x); the sum is the energy created.  The
load J = (2 F + 5 F_before - F_twice_before)/6 is exact for loads that are quadratic in time.  Two
terms are left out: the error of J and, on a curved path, the product of the deviations of load and
velocity from their means.  Both are of second order in the changes within an interval.

Panels and frames: the clamps are told to go to y - e, where R is the panels' mean reaction, and the
frames go to y under Q.  The energy created is (Q - R).(y - x) + R.(e - e_before).  The terms left out
are of the same kind.

docs/theory/stability.md derives both; tests/monitor compares both with the ledger.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.case.tables.case import Case
from orchestrator.coupling._kernel import clamp_works, contact_works
from orchestrator.coupling.machine import Machine
from orchestrator.coupling.metered import MeteredSolvers
from orchestrator.coupling.schemes.scheme import State
from orchestrator.ports import InterfaceData
from orchestrator.ports.state import SavedAttributes

SLOW_M_PER_S = 1e-3  # nothing on a screen that moves slower counts
FADE = 1 - 1 / 20  # factor by which the weight of an interval in recent sums falls with each later interval


def interface_data(members: MeteredSolvers, length_s: float) -> InterfaceData:
    """Return the data that crossed in the last interval, from the members' meters."""
    particles = members.particles.last if members.particles is not None else None
    return InterfaceData(length_s, members.frames.last, members.panel.last, particles)


@dataclass
class ExchangedEnergy:
    """The energy that went through an interface since t = 0, as a scale for the energy created there.

    The work that one side has done on the other since t = 0 (``given_J``) rises and falls.  Its range is
    the energy exchanged, whether the other side keeps the work (a bed that is thrown) or gives it back (a
    ball that bounces).  An interface at rest exchanges nothing, so that rounding errors would be divided
    by zero.  ``slow_J`` is therefore added: the work that the largest load so far does in a sync interval
    on points that move at ``SLOW_M_PER_S``.
    """

    given_J: float = 0.0
    least_J: float = 0.0
    most_J: float = 0.0
    slow_J: float = 0.0

    def add(self, work_J: float, size_N: float, length_s: float) -> None:
        """Add the work of an interval of ``length_s`` under a mean load, whose components have sizes
        that sum up to ``size_N``."""
        self.given_J += work_J
        self.least_J = min(self.least_J, self.given_J)
        self.most_J = max(self.most_J, self.given_J)
        self.slow_J = max(self.slow_J, SLOW_M_PER_S * length_s * size_N)

    @property
    def scale_J(self) -> float:
        """The energy exchanged, with ``slow_J``."""
        return self.most_J - self.least_J + self.slow_J


@dataclass
class Balance:
    """The energy created at an interface, against the energy that went through it.

    ``through_J`` sums the absolute work along each axis at each point since t = 0; points that are slower
    than ``SLOW_M_PER_S`` count as if they had this speed.  ``created_J`` is the energy created since
    t = 0, and is negative if energy was destroyed.  The recent values fade with each interval, and
    ``newest_J`` is the energy through the interface in the last interval alone.
    """

    created_J: float = 0.0
    through_J: float = 0.0
    recent_created_J: float = 0.0
    recent_through_J: float = 0.0
    newest_J: float = 0.0

    def add(self, created_J: float, through_J: float) -> None:
        """Add the energies of an interval."""
        self.created_J += created_J
        self.through_J += through_J
        self.recent_created_J = FADE * self.recent_created_J + created_J
        self.recent_through_J = FADE * self.recent_through_J + through_J
        self.newest_J = through_J

    def recent_share(self) -> float:
        """Return the energy created over the energy that went through in the last twenty intervals or so.

        Created energy counts only beyond the energy through the newest interval, since the next interval
        may take it back.
        """
        beyond_J = abs(self.recent_created_J) - self.newest_J
        if beyond_J <= 0 or self.recent_through_J <= 0:
            return 0.0
        return beyond_J / self.recent_through_J

    def begin_anew(self, in_transit_J: float = 0.0) -> None:
        """Forget the recent energies, apart from the energy in transit that the next interval takes back."""
        self.recent_created_J = in_transit_J / FADE  # fades to its full value in the next interval
        self.recent_through_J = self.newest_J = 0.0


def book(
    balance: Balance,
    exchange: ExchangedEnergy,
    intervals: list[InterfaceData],
    works: list[tuple[float, float, float, float]],
) -> None:
    """Add the works of successive intervals at an interface to its balance and its exchanged energy."""
    for data, (exchanged_J, size_N, created_J, through_J) in zip(intervals, works, strict=True):
        exchange.add(exchanged_J, size_N, data.length_s)
        balance.add(created_J, through_J)


class ContactWork(SavedAttributes):
    """The work between particles and panels; ``exchange`` covers all that particles touch, with walls.

    The panels' points come first among the surface's.
    """

    STATE = ("balance", "exchange", "_surface_m", "_path_end_m", "_load_N", "_load_before_N")
    LEDGER_NAME = "particles-panel"

    def __init__(self, start: State, points: slice) -> None:
        """Start at the state ``start``; ``points`` are the points of the surface that count."""
        self.balance, self.exchange = Balance(), ExchangedEnergy()
        self._surface_m = self._path_end_m = start.panel.surface.position_m
        self._load_N = self._load_before_N = start.load.force_N
        self._counted = len(self._load_N[points])

    def add(self, intervals: list[InterfaceData]) -> None:
        """Book successive intervals, at least one."""
        works = contact_works(
            intervals,
            counted=self._counted,
            before_m=self._surface_m,
            path_before_m=self._path_end_m,
            load_before_N=self._load_N,
            load_twice_before_N=self._load_before_N,
            slow_m_per_s=SLOW_M_PER_S,
        )
        book(self.balance, self.exchange, intervals, works)
        for data in intervals[-2:]:
            assert data.particles is not None
            path, load = data.particles
            self._load_before_N, self._load_N = self._load_N, load.force_N
        self._surface_m, self._path_end_m = data.panel[2].surface.position_m, path.end.position_m

    def begin_anew(self) -> None:
        """Forget recent intervals: the next ones have another length."""
        late_m = (self._surface_m - self._path_end_m)[: self._counted]
        self.balance.begin_anew(float(np.vdot(self._load_N[: self._counted], late_m)))


class ClampWork(SavedAttributes):
    """The work between panels and frames; ``exchange`` covers everything that frames carry, with walls."""

    STATE = ("balance", "exchange", "_clamps_m", "_target_m", "_reaction_N")
    LEDGER_NAME = "panel-frames"

    def __init__(self, start: State, points: slice) -> None:
        """Start at the state ``start``; ``points`` are the points of the clamps that count."""
        self.balance, self.exchange = Balance(), ExchangedEnergy()
        self._clamps_m = self._target_m = start.clamps.position_m
        self._reaction_N = start.panel.reaction.force_N
        self._counted = len(self._reaction_N[points])

    def add(self, intervals: list[InterfaceData]) -> None:
        """Book successive intervals, at least one."""
        works = clamp_works(
            intervals,
            counted=self._counted,
            before_m=self._clamps_m,
            target_before_m=self._target_m,
            slow_m_per_s=SLOW_M_PER_S,
        )
        book(self.balance, self.exchange, intervals, works)
        target, _, state = intervals[-1].panel
        self._clamps_m, self._target_m = intervals[-1].frames[1].position_m, target.position_m
        self._reaction_N = state.reaction.force_N

    def begin_anew(self) -> None:
        """Forget recent intervals: the next ones have another length."""
        missed_m = (self._clamps_m - self._target_m)[: self._counted]
        self.balance.begin_anew(float(np.vdot(self._reaction_N[: self._counted], missed_m)))


Works = dict[str, ContactWork | ClampWork]


def interface_works(case: Case, machine: Machine, start: State) -> Works:
    """Return the works at both interfaces of the panels, whose points come first in the surface.

    An interface whose exchange is turned off has no work, because its energy does not close.
    """
    surface = slice(0, max((panel.surface.stop for panel in machine.panels), default=None))
    clamps = slice(0, max((panel.clamps.stop for panel in machine.panels), default=None))
    exchange, works = case.exchange, Works()
    if machine.members.particles is not None and exchange.panel_motion and exchange.particle_load:
        works["particles and panels"] = ContactWork(start, surface)
    if exchange.frame_motion and exchange.panel_reaction:
        works["panels and frames"] = ClampWork(start, clamps)
    return works


def exchanged_J(works: Works) -> dict[str, float]:
    """Return the scale for the energy created at each interface, by the ledger's names."""
    return {work.LEDGER_NAME: work.exchange.scale_J for work in works.values()}
