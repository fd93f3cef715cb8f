"""Trials of mats: the cheapest panel solver that bends moves each between its clamps, without a load.

The clamps follow the frames while the machine starts, and then their steady motion: what a mat does depends
on how it got there.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from scipy.fft import next_fast_len
from scipy.interpolate import CubicSpline
from scipy.sparse import block_diag, csr_array

from orchestrator.case import solvers
from orchestrator.ports import Array, Indices, Load, MeshedPanel, Motion, PanelState
from orchestrator.ports.acceleration import QUOTED_HZ, acceleration_m_per_s2
from orchestrator.ports.adapters import PanelAdapter
from orchestrator.ports.clock import Interval
from orchestrator.ports.panel import Joinable
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.ports.plans import PanelPlan
from orchestrator.preflight.mats.regime import PHASES, Regime
from orchestrator.preflight.scene.starting import STEPS

CELLS = 32
"""Cells along a mat: with 16, the peaks of mats between turned clamps are off by a third."""
MOST_STEPS, MOST_ROWS = 400_000, 60_000
"""Of a trial: some ten seconds."""
INTERVAL_S = 4e-4
"""Time between rows: accelerations reach 1.25 kHz."""
SETTLING_TURNS, WATCHED_TURNS = 6, 24
ALIKE = 0.3  # of the stroke: clamps whose amplitudes differ by less move alike


@dataclass(frozen=True)
class Trial:
    """A mat between clamps that move by Re(``amplitude_m`` exp(i w t)), (2, 3), the first and the second.

    ``transient_m`` (n, 2, 3) is what they differ from that by, ``STEPS`` to a turn from the start of the
    machine on; its last ``SETTLING_TURNS`` turns fade.  ``added_kg_per_m2`` is a load that moves along.
    """

    plan: PanelPlan
    amplitude_m: Array
    speed_rad_per_s: float
    transient_m: Array
    added_kg_per_m2: float = 0.0

    @property
    def turns_before(self) -> int:
        """The turns of the start, before those that are watched."""
        return (len(self.transient_m) - 1) // STEPS

    @property
    def turn_s(self) -> float:
        """The time of a turn."""
        return 2 * math.pi / self.speed_rad_per_s

    @property
    def stroke_m(self) -> float:
        """The amplitude of one clamp against the other along the mat."""
        return float(abs((self.amplitude_m[1] - self.amplitude_m[0]) @ self.plan.rectangle.along))

    @property
    def clamps_m(self) -> Array:
        """The amplitudes (2, 2) of both clamps along the mat and normal to it; the stroke's phase is 0."""
        at = self.plan.rectangle
        clamps_m = self.amplitude_m @ np.column_stack([at.along, at.normal])
        stroke_m = clamps_m[1, 0] - clamps_m[0, 0]
        return np.asarray(clamps_m * (abs(stroke_m) / stroke_m))

    def moves_as(self, other: Trial) -> bool:
        """Return whether clamps move as another mat's do, or as those do if it is turned round."""
        mirrored_m = self.clamps_m[::-1] * [-1.0, 1.0]
        most_m = ALIKE * max(self.stroke_m, other.stroke_m)
        return any(np.abs(way_m - other.clamps_m).max() <= most_m for way_m in (self.clamps_m, mirrored_m))

    def at(self, stroke_m: float, speed_rad_per_s: float, span_m: float) -> Trial:
        """Return the same mat at another stroke, to which all motion is proportional, another speed, with the
        same turns of the start, and another distance of the clamps."""
        share = stroke_m / self.stroke_m
        return replace(
            self,
            plan=replace(self.plan, rectangle=replace(self.plan.rectangle, span_m=span_m)),
            amplitude_m=share * self.amplitude_m,
            transient_m=share * self.transient_m,
            speed_rad_per_s=speed_rad_per_s,
        )

    def clamps_at(self, time_s: Array) -> tuple[Array, Array]:
        """Return displacements and velocities (times, 2, 3) of the clamps."""
        turn = time_s / self.turn_s
        wave_m = np.multiply.outer(np.exp(2j * math.pi * turn), self.amplitude_m)
        moved_m, moved_m_per_s = wave_m.real, (1j * self.speed_rad_per_s * wave_m).real
        starting = turn <= self.turns_before
        at = np.arange(len(self.transient_m)) / STEPS
        fade = np.clip((at[-1] - at) / SETTLING_TURNS, 0.0, 1.0)
        left_m = CubicSpline(at, (0.5 - np.cos(math.pi * fade) / 2)[:, None, None] * self.transient_m)
        moved_m[starting] += left_m(turn[starting])
        moved_m_per_s[starting] += left_m(turn[starting], 1) / self.turn_s
        return moved_m, moved_m_per_s

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
    watched_s = (trial.turns_before + WATCHED_TURNS) * trial.turn_s
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
    watched_s = max((trial.turns_before + watched_turns) * trial.turn_s for trial in trials)
    rows = next_fast_len(math.ceil(watched_s / INTERVAL_S))
    time_s = INTERVAL_S * np.arange(rows + 1)
    paths = [trial.clamps_at(time_s) for trial in trials]
    with ExitStack() as opened:
        panels = []
        for trial in trials:
            panels.append(trial.open(adapter, cells))
            opened.callback(panels[-1].close)
        middle_m, middle_m_per_s = _move(trials, panels, paths)
    return [
        _watch(trial, time_s, paths[number][0], middle_m[:, number], middle_m_per_s[:, number], watched_turns)
        for number, trial in enumerate(trials)
    ]


def _move(
    trials: Sequence[Trial], panels: Sequence[MeshedPanel], paths: Sequence[tuple[Array, Array]]
) -> tuple[Array, Array]:
    """Return the places and velocities (times, mats, 3) of the mats' middles.

    ``paths`` are displacements and velocities (times, 2, 3) of the clamps of each.  Times are ``INTERVAL_S``
    apart; the first is that of the mats at rest.
    """
    states = [panel.initial() for panel in panels]
    state = _concatenate(states)
    mount_m = np.concatenate([panel.mount.position_m for panel in panels])
    counts = [len(panel.mount.frame) for panel in panels]
    clamps = np.stack(paths, axis=2)
    rows = clamps.shape[1]
    of_clamp = np.concatenate([_clamp_of(*pair) for pair in zip(trials, panels, strict=True)])
    of_mat = np.repeat(np.arange(len(trials)), counts)
    to_middle = csr_array(block_diag([_middle(*pair) for pair in zip(trials, panels, strict=True)]))
    first = panels[0]
    join = first.join(panels) if isinstance(first, Joinable) and len(panels) > 1 else None
    surfaces = np.cumsum([0, *(len(state.surface) for state in states)])
    held = np.cumsum([0, *counts])

    def advance(interval: Interval, motion: Motion, load: Load) -> PanelState:
        if join is not None:
            return join(interval, motion, load)
        parts = zip(panels, pairwise(held), pairwise(surfaces), strict=True)
        return _concatenate(
            [
                panel.advance(interval, motion.part(slice(*mount)), load.part(slice(*touched)))
                for panel, mount, touched in parts
            ]
        )

    unloaded = Load.zero(len(state.surface))
    places_m, velocities_m_per_s = np.empty((2, rows, len(trials), 3))
    for row in range(rows):
        if row:
            moved_m, moved_m_per_s = clamps[:, row, of_mat, of_clamp]
            motion = Motion(mount_m + moved_m, moved_m_per_s)
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


def _clamp_of(trial: Trial, panel: MeshedPanel) -> Indices:
    """Return the clamp, 0 or 1, of each of a panel's clamp points."""
    at = trial.plan.rectangle
    along_m = (panel.mount.position_m - at.corner_m) @ at.along
    return (along_m > at.span_m / 2).astype(np.int64)


def _middle(trial: Trial, panel: MeshedPanel) -> csr_array:
    """Return the matrix (1, surface points) that takes values at the surface points to the mat's middle."""
    at = trial.plan.rectangle
    return panel.interpolation(np.array([[at.length_m / 2, at.width_m / 2]])).values


def _watch(
    trial: Trial, time_s: Array, clamps_m: Array, middle_m: Array, middle_m_per_s: Array, watched_turns: int
) -> Regime:
    """Return the regime of a mat whose clamps move as in (times, 2, 3) and whose middle as in (times, 3)."""
    at = trial.plan.rectangle
    between_m = clamps_m.mean(axis=1)
    rest_m = at.corner_m + at.span_m / 2 * at.along
    height_m = (middle_m - rest_m - between_m) @ at.normal
    start_s = trial.turns_before * trial.turn_s
    phase = np.arange(watched_turns * PHASES) / PHASES
    heights_m = np.interp(start_s + phase * trial.turn_s, time_s, height_m).reshape(watched_turns, PHASES)
    number = np.floor((time_s - start_s) / trial.turn_s).astype(int)
    peaks = []
    for band in ({}, {"band_Hz": QUOTED_HZ}):
        size = np.linalg.norm(acceleration_m_per_s2(middle_m_per_s, INTERVAL_S, **band), axis=1)
        size_g = size / STANDARD_GRAVITY_M_PER_S2
        peaks.append(np.array([size_g[number == turn].max() for turn in range(watched_turns)]))
    return Regime(at.length_m, heights_m, *peaks)
