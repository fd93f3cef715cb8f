"""Trials of mats: the cheapest panel solver that bends moves each between its clamps, without a load.

The clamps follow the steady motion of the frames, which grows smoothly over ``RUN_UP_TURNS`` turns.  What a
mat does afterwards depends on how it got there; a machine that runs up another way may end in another one of
several regimes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.sparse import block_diag, csr_array

from orchestrator.case import solvers
from orchestrator.ports import Array, Load, MeshedPanel, Motion, PanelState
from orchestrator.ports.acceleration import QUOTED_HZ, acceleration_m_per_s2
from orchestrator.ports.adapters import PanelAdapter
from orchestrator.ports.clock import Interval
from orchestrator.ports.panel import Joinable
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.ports.plans import PanelPlan
from orchestrator.preflight.mats.regime import PHASES, Regime

CELLS = 32
"""Cells along a mat: with 16, the peaks of mats between turned clamps are off by a third."""
MOST_STEPS, MOST_ROWS = 400_000, 60_000
"""Of a trial: some ten seconds."""
INTERVAL_S = 4e-4
"""Time between rows: accelerations reach 1.25 kHz."""
RUN_UP_TURNS, SETTLING_TURNS, WATCHED_TURNS = 4, 6, 24


@dataclass(frozen=True)
class Trial:
    """A mat between clamps that move by Re(``amplitude_m`` exp(i w t)), (2, 3), the first and the second.

    ``added_kg_per_m2`` is a load that moves with the mat.
    """

    plan: PanelPlan
    amplitude_m: Array
    speed_rad_per_s: float
    added_kg_per_m2: float = 0.0

    @property
    def turn_s(self) -> float:
        """The time of a turn."""
        return 2 * math.pi / self.speed_rad_per_s

    @property
    def stroke_m(self) -> float:
        """The amplitude of one clamp against the other along the mat."""
        return float(abs((self.amplitude_m[1] - self.amplitude_m[0]) @ self.plan.rectangle.along))

    def at(self, stroke_m: float, speed_rad_per_s: float, span_m: float) -> Trial:
        """Return the same mat at another stroke, to which all amplitudes are proportional, another speed, and
        another distance of the clamps."""
        return replace(
            self,
            plan=replace(self.plan, rectangle=replace(self.plan.rectangle, span_m=span_m)),
            amplitude_m=self.amplitude_m * (stroke_m / self.stroke_m),
            speed_rad_per_s=speed_rad_per_s,
        )

    def open(self, adapter: PanelAdapter, cells: int) -> MeshedPanel:
        """Open the mat at rest.  Raises SolverFailed and SolverMissing."""
        plan, material = self.plan, self.plan.material
        share = plan.apertures.material_share(plan.rectangle) if plan.apertures else 1.0
        own_kg_per_m2 = material.density_kg_per_m3 * plan.thickness_m * share
        heavier = 1.0 + self.added_kg_per_m2 / own_kg_per_m2
        loaded = replace(material, density_kg_per_m3=heavier * material.density_kg_per_m3)
        return adapter.build(
            replace(
                plan,
                material=loaded,
                cells=(cells, 1),
                integrator="explicit",
                step_s=0.0,
                sync_interval_s=INTERVAL_S,
                stops=(),
                point_masses=(),
            )
        )


def is_costly(trial: Trial) -> bool:
    """Return whether a trial would take longer than a preflight may, as one of a steel plate does."""
    adapter = _adapter(mat_solver())
    watched_s = (RUN_UP_TURNS + SETTLING_TURNS + WATCHED_TURNS) * trial.turn_s
    plan = replace(trial.plan, cells=(CELLS, 1), integrator="explicit", apertures=None)
    step_s = adapter.largest_step_s(plan) if adapter.largest_step_s is not None else INTERVAL_S
    return watched_s > MOST_STEPS * step_s or watched_s > MOST_ROWS * INTERVAL_S


def mat_solver() -> str:
    """Return the name of the cheapest solver whose panels bend and yield."""

    def can(adapter: PanelAdapter) -> bool:
        return adapter.deforms and adapter.yields and "explicit" in adapter.integrators

    able = {name: _adapter(name) for name in solvers.names("panel")}
    return min((name for name in able if can(able[name])), key=lambda name: able[name].fidelity)


def _adapter(name: str) -> PanelAdapter:
    """Return a panel solver's adapter.  Raises SolverMissing."""
    adapter = solvers.adapter("panel", name)
    assert isinstance(adapter, PanelAdapter), "the port's adapters are of its kind"
    return adapter


def regimes(
    trials: Sequence[Trial], cells: int = CELLS, watched_turns: int = WATCHED_TURNS, solver: str = ""
) -> list[Regime]:
    """Return the regime of each mat over ``watched_turns`` turns; all are moved together.

    ``solver`` is a panel solver's name, by default the cheapest's.  Raises SolverFailed and SolverMissing.
    """
    adapter = _adapter(solver or mat_solver())
    turns = RUN_UP_TURNS + SETTLING_TURNS + watched_turns
    rows = math.ceil(turns * max(trial.turn_s for trial in trials) / INTERVAL_S)
    with ExitStack() as opened:
        panels = []
        for trial in trials:
            panels.append(trial.open(adapter, cells))
            opened.callback(panels[-1].close)
        middle_m, middle_m_per_s = _move(trials, panels, rows)
    time_s = INTERVAL_S * np.arange(rows + 1)
    return [
        _watch(trial, time_s, middle_m[:, number], middle_m_per_s[:, number], watched_turns)
        for number, trial in enumerate(trials)
    ]


def _move(trials: Sequence[Trial], panels: Sequence[MeshedPanel], rows: int) -> tuple[Array, Array]:
    """Return the places and velocities (rows + 1, mats, 3) of the mats' middles.

    Rows are ``INTERVAL_S`` apart; the first is that of the mats at rest.
    """
    states = [panel.initial() for panel in panels]
    state = _concatenate(states)
    mount_m = np.concatenate([panel.mount.position_m for panel in panels])
    amplitude_m = np.concatenate([_amplitudes_m(*pair) for pair in zip(trials, panels, strict=True)])
    counts = [len(panel.mount.frame) for panel in panels]
    speed, run_up_s = (
        np.repeat(values, counts)
        for values in np.array([(t.speed_rad_per_s, RUN_UP_TURNS * t.turn_s) for t in trials]).T
    )
    to_middle = csr_array(block_diag([_middle(*pair) for pair in zip(trials, panels, strict=True)]))
    first = panels[0]
    join = first.join(panels) if isinstance(first, Joinable) and len(panels) > 1 else None
    surfaces = np.cumsum([0, *(len(state.surface) for state in states)])
    clamps = np.cumsum([0, *counts])

    def advance(interval: Interval, motion: Motion, load: Load) -> PanelState:
        if join is not None:
            return join(interval, motion, load)
        parts = zip(panels, pairwise(clamps), pairwise(surfaces), strict=True)
        return _concatenate(
            [
                panel.advance(interval, motion.part(slice(*held)), load.part(slice(*touched)))
                for panel, held, touched in parts
            ]
        )

    unloaded = Load.zero(len(state.surface))
    places_m, velocities_m_per_s = np.empty((2, rows + 1, len(trials), 3))
    for row in range(rows + 1):
        if row:
            time_s = row * INTERVAL_S
            share = np.minimum(time_s / run_up_s, 1.0)
            grown = ((1 - np.cos(math.pi * share)) / 2)[:, None]
            growing = (np.sin(math.pi * share) * math.pi / (2 * run_up_s))[:, None]
            wave_m = amplitude_m * np.exp(1j * speed * time_s)[:, None]
            velocity_m_per_s = grown * (1j * speed[:, None] * wave_m).real + growing * wave_m.real
            motion = Motion(mount_m + grown * wave_m.real, velocity_m_per_s)
            state = advance(Interval(row - 1, INTERVAL_S), motion, unloaded)
        places_m[row] = to_middle @ state.surface.position_m
        velocities_m_per_s[row] = to_middle @ state.surface.velocity_m_per_s
    return places_m, velocities_m_per_s


def _concatenate(states: Sequence[PanelState]) -> PanelState:
    motions = [state.surface for state in states]
    surface = Motion(
        np.concatenate([motion.position_m for motion in motions]),
        np.concatenate([motion.velocity_m_per_s for motion in motions]),
    )
    return PanelState(surface, Load(np.concatenate([state.reaction.force_N for state in states])))


def _amplitudes_m(trial: Trial, panel: MeshedPanel) -> Array:
    """Return the amplitudes (clamp points, 3) of a panel's clamp points."""
    at = trial.plan.rectangle
    along_m = (panel.mount.position_m - at.corner_m) @ at.along
    return np.asarray(trial.amplitude_m[(along_m > at.span_m / 2).astype(int)])


def _middle(trial: Trial, panel: MeshedPanel) -> csr_array:
    """Return the matrix (1, surface points) that takes values at the surface points to the mat's middle."""
    at = trial.plan.rectangle
    return panel.interpolation(np.array([[at.length_m / 2, at.width_m / 2]])).values


def _watch(trial: Trial, time_s: Array, middle_m: Array, middle_m_per_s: Array, watched_turns: int) -> Regime:
    """Return the regime of a mat whose middle moves as in (rows, 3)."""
    at, wave = trial.plan.rectangle, np.exp(1j * trial.speed_rad_per_s * time_s)
    between_m = (wave[:, None] * trial.amplitude_m.mean(axis=0)).real
    rest_m = at.corner_m + at.span_m / 2 * at.along
    height_m = (middle_m - rest_m - between_m) @ at.normal
    start_s = (RUN_UP_TURNS + SETTLING_TURNS) * trial.turn_s
    phase = np.arange(watched_turns * PHASES) / PHASES
    heights_m = np.interp(start_s + phase * trial.turn_s, time_s, height_m).reshape(watched_turns, PHASES)
    number = np.floor((time_s - start_s) / trial.turn_s).astype(int)
    peaks = []
    for band in ({}, {"band_Hz": QUOTED_HZ}):
        size = np.linalg.norm(acceleration_m_per_s2(middle_m_per_s, INTERVAL_S, **band), axis=1)
        size_g = size / STANDARD_GRAVITY_M_PER_S2
        peaks.append(np.array([size_g[number == turn].max() for turn in range(watched_turns)]))
    return Regime(at.length_m, heights_m, *peaks)
