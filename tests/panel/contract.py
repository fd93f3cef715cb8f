"""The contract of the adapters of the panel port; ``CASES`` lists the adapters.

Each case builds the real solver on a small panel.  A package that is missing makes the case fail
with SolverMissing: nothing is skipped.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array, identity, vstack

from orchestrator.case import solvers
from orchestrator.coupling.mapping import OffsetPanel
from orchestrator.ports import (
    Account,
    Array,
    Interpolation,
    Load,
    MeshedPanel,
    Motion,
    Mount,
    Panel,
    PanelState,
    Saved,
)
from orchestrator.ports.adapters import PanelAdapter
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import AperturePattern
from orchestrator.ports.plans import PanelPlan
from tests.panel.elastic_plans import plan

INTERVAL_S = 1e-4
# enough damping for a small panel to settle within 0.3 s
DAMPED = ((1.0, 3e-3), (0.5, 5e-4))


@dataclass(frozen=True)
class Case:
    """A panel 0.12 m long, stretched to 0.123 m; ``still_N``: the largest change of a clamp
    point's force that counts as none, from the way the adapter finds its rest; ``rims``: it is seen
    with the rims of openings that are 6 mm deep."""

    solver: str
    plan: PanelPlan
    still_N: float
    rims: bool = False

    def open(self, interval_s: float = INTERVAL_S, split: int = 1) -> MeshedPanel:
        """``split`` divides the largest step that the adapter takes by itself."""
        solver = solvers.adapter("panel", self.solver)
        assert isinstance(solver, PanelAdapter)
        changed = replace(self.plan, sync_interval_s=interval_s)
        if solver.largest_step_s is not None and changed.integrator == "explicit":
            changed = replace(changed, step_s=0.8 * solver.largest_step_s(changed) / split)
        panel: MeshedPanel = solver.build(changed)
        return RimmedPanel(panel, changed) if self.rims else panel


class RimmedPanel(OffsetPanel):
    """A panel with openings 6 mm deep: its surface points are its own ones, and then the corners of the
    openings' walls, 3 mm above and 3 mm below its surface."""

    def __init__(self, panel: MeshedPanel, given: PanelPlan) -> None:
        own = identity(len(panel.initial().surface), format="csr")
        rims = panel.interpolation(rims_m(given))
        nothing = csr_array(own.shape)
        super().__init__(
            panel,
            Interpolation(
                csr_array(vstack([own, rims.values])),
                csr_array(vstack([nothing, rims.along])),
                csr_array(vstack([nothing, rims.across])),
                np.concatenate([np.zeros(own.shape[0]), rims.offset_m]),
            ),
        )
        self._meshed = panel

    def interpolation(self, coordinates_m: Array) -> Interpolation:
        """Return the interpolation from all the surface points, of which the panel's own ones are needed."""
        meshed, points = self._meshed.interpolation(coordinates_m), len(self._seen)
        matrices = (meshed.values, meshed.along, meshed.across)
        values, along, across = (
            csr_array((m.data, m.indices, m.indptr), shape=(m.shape[0], points)) for m in matrices
        )
        return Interpolation(values, along, across, meshed.offset_m)


OPENINGS = AperturePattern("rectangle", 0.016, 0.008, 0.024, 0.014, 0.0, 0.02, 0.0)
"""3 x 3 openings of 16 x 8 mm, half a land at the sides."""


def rims_m(given: PanelPlan) -> Array:
    """Return the corners (n, 3) of the walls of all openings, 6 mm deep, in material coordinates."""
    pattern = given.apertures or OPENINGS
    centres_m = pattern.centres_m(given.rectangle)
    corners_m = (centres_m[:, None] + pattern.outline_m()).reshape(-1, 2)
    return np.vstack([np.column_stack([corners_m, np.full(len(corners_m), z)]) for z in (0.003, -0.003)])


class StillPanel:
    """A panel whose surface has a given motion and keeps it; it notes the last load."""

    def __init__(self, surface: Motion) -> None:
        self.surface, self.load = surface, Load.zero(len(surface))
        self.mount = Mount(np.zeros((1, 3)), ("frame",))

    def initial(self) -> PanelState:
        return PanelState(self.surface, Load.zero(1))

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        self.load = load
        return self.initial()

    def account(self) -> Account:
        return Account(np.zeros(3), np.zeros(3), received_J={"load": 0.0, "clamps": 0.0})

    def save(self) -> Saved:
        return {}

    def restore(self, saved: Saved) -> None:
        pass

    def close(self) -> None:
        pass


def small(integrator: str, cells: tuple[int, int] = (8, 1)) -> PanelPlan:
    return plan(length_m=0.12, span_m=0.123, cells=cells, integrator=integrator, branches=DAMPED)


def hinged(integrator: str, cells: tuple[int, int] = (8, 1)) -> PanelPlan:
    """Return a panel with clamps that have no depth and so let its ends turn; it is twice as thick, because
    only its bending damps its swinging and that is less where the ends turn."""
    given = small(integrator, cells)
    rectangle = replace(given.rectangle, clamp_m=0.0)
    return replace(given, rectangle=rectangle, thickness_m=2 * given.thickness_m)


def perforated(integrator: str, cells: tuple[int, int] = (8, 1)) -> PanelPlan:
    return replace(small(integrator, cells), apertures=OPENINGS)


def mounted(integrator: str, cells: tuple[int, int] = (8, 1)) -> PanelPlan:
    """Slack, with clamps that point down into the sag, and moulded with a sag."""
    return plan(
        length_m=0.12,
        span_m=0.119,
        cells=cells,
        integrator=integrator,
        branches=DAMPED,
        clamp_angle_deg=15.0,
        moulded_sag_m=0.004,
    )


def pierced() -> PanelPlan:
    """One opening of 40 x 20 mm, for a mesh that has it: few cells."""
    opening = AperturePattern("rectangle", 0.04, 0.02, 0.12, 0.05)
    return replace(small("implicit", (3, 1)), apertures=opening)


CASES = {
    "rigid": Case("rigid", small("explicit"), 1e-12),
    "strip": Case("strip", small("explicit"), 1e-9),
    "sheet-explicit": Case("sheet", small("explicit", (6, 1)), 1e-4),
    "sheet-implicit": Case("sheet", small("implicit", (6, 1)), 1e-4),
    "solid": Case("solid", small("implicit", (4, 1)), 1e-4),
    "solid-openings": Case("solid", pierced(), 1e-4),
    "rigid-openings": Case("rigid", perforated("explicit"), 1e-12),
    "strip-openings": Case("strip", perforated("explicit"), 1e-9),
    "strip-hinged": Case("strip", hinged("explicit"), 1e-9),
    "sheet-hinged": Case("sheet", hinged("explicit", (6, 1)), 1e-4),
    "solid-hinged": Case("solid", hinged("implicit", (4, 1)), 1e-4),
    "rigid-mounted": Case("rigid", mounted("explicit"), 1e-12),
    "strip-mounted": Case("strip", mounted("explicit"), 1e-9),
    "sheet-explicit-mounted": Case("sheet", mounted("explicit", (6, 1)), 1e-4),
    "sheet-implicit-mounted": Case("sheet", mounted("implicit", (6, 1)), 1e-4),
    "solid-mounted": Case("solid", mounted("implicit", (4, 1)), 1e-4),
    "sheet-openings": Case("sheet", perforated("explicit", (6, 3)), 1e-4),
    "rigid-rims": Case("rigid", perforated("explicit"), 1e-12, rims=True),
    "strip-rims": Case("strip", perforated("explicit"), 1e-9, rims=True),
    "sheet-rims": Case("sheet", perforated("explicit", (6, 3)), 1e-4, rims=True),
    "solid-rims": Case("solid", pierced(), 1e-4, rims=True),
}
NEEDS_SOLVER = {name for name, case in CASES.items() if case.solver in ("sheet", "solid")}
NEEDS_SOLVER |= {"strip-openings", "strip-rims"}


def held(panel: Panel) -> Motion:
    """The clamps where they are mounted, at rest."""
    return Motion(panel.mount.position_m, np.zeros_like(panel.mount.position_m))


def shifted(panel: Panel, shift_m: Array, velocity_m_per_s: Array) -> Motion:
    """All clamps moved alike; both (3,)."""
    moved = panel.mount.position_m + shift_m
    return Motion(moved, np.broadcast_to(velocity_m_per_s, moved.shape).copy())


def swung(panel: Panel, time_s: float) -> Motion:
    """The second clamp moves by (4, 2, -3) mm sin^2(40 t), from rest."""
    amplitude_m = 1e-3 * np.array([4.0, 2.0, -3.0])
    on = np.array([frame == "driven" for frame in panel.mount.frame]) * 1.0
    moved = panel.mount.position_m + np.outer(on, amplitude_m * np.sin(40 * time_s) ** 2)
    return Motion(moved, np.outer(on, amplitude_m * 40 * np.sin(80 * time_s)))


def loads(points: int, time_s: float) -> Load:
    """Return some newton on each point, reproducible and smooth in time."""
    size_N = np.random.default_rng(6).normal(size=(points, 3))
    return Load(size_N * (10.0 / points) * np.sin(90 * time_s))


@dataclass(frozen=True)
class Run:
    """States and accounts at the start and after each interval, and the loads between."""

    states: list[PanelState]
    accounts: list[Account]
    loads: list[Load]


def driven(panel: Panel, intervals: int, interval_s: float = INTERVAL_S, first: int = 0) -> Run:
    """Clamp swung, surface loaded, from interval ``first`` on."""
    states, accounts, given = [panel.initial()], [panel.account()], []
    for index in range(first, first + intervals):
        load = loads(len(states[0].surface), (index + 0.5) * interval_s)
        end = swung(panel, (index + 1) * interval_s)
        states.append(panel.advance(Interval(index, interval_s), end, load))
        accounts.append(panel.account())
        given.append(load)
    return Run(states, accounts, given)


def defect_J(start: Account, end: Account) -> float:
    """Zero for a perfect solver; see ``Account``."""

    def total(account: Account) -> float:
        kept = sum(account.stored_J.values()) + sum(account.lost_J.values())
        return kept - sum(account.supplied_J.values()) - sum(account.received_J.values())

    return total(end) - total(start)
