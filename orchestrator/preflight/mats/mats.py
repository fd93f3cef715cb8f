"""The mats of a machine: which are alike, how they flip, empty and with a load, and what to doubt."""

from __future__ import annotations

import math
import pickle
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from orchestrator.case.solver_plans import panel_plans
from orchestrator.ports import Array
from orchestrator.ports.plans import PanelPlan, SolverFailed, SolverMissing
from orchestrator.preflight.mats.regime import Regime
from orchestrator.preflight.mats.trial import CELLS, SETTLING_TURNS, WATCHED_TURNS, Trial, is_costly, regimes
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.scene import scene as describe
from orchestrator.preflight.scene.shaking import Shaking, free_frames
from orchestrator.preflight.scene.starting import find_transients_m, run_up_turns

MOST_KINDS = 4  # of mats that are tried, those of the largest strokes
REMEMBERED = 64  # machines whose mats are known
REMEDY = (
    "a shorter stroke, clamps that point into the sag (clamp_angle_deg), a thicker mat or another "
    "tension_m may keep it down; flipflow show has a map"
)


@dataclass(frozen=True)
class Mats:
    """Panels that are alike and move alike, and the regime of the one with the largest stroke.

    ``loaded`` is its regime with the mass of the bed on it, None without particles.
    """

    panels: tuple[str, ...]
    trial: Trial
    empty: Regime
    loaded: Regime | None

    @property
    def name(self) -> str:
        """The name of the panel that is tried, and how many more there are."""
        return f"{self.panels[0]} and {len(self.panels) - 1} more" if self.panels[1:] else self.panels[0]

    def as_json(self) -> dict[str, Any]:
        """Return the mats as a table (docs/json-output.md)."""
        loaded = None if self.loaded is None else _table(self.loaded)
        return {"panels": list(self.panels), "empty": _table(self.empty), "loaded": loaded}


def _table(regime: Regime) -> dict[str, Any]:
    return {
        "side": regime.side,
        "turns": regime.turns,
        "turns_up": regime.turns_up,
        "repeats_after_turns": regime.repeats_after,
        "cycle_peak_g": regime.mean_peak_g,
        "cycle_peak_100_Hz_g": regime.mean_quoted_peak_g,
    }


def find_mats(scene: Scene) -> tuple[Mats, ...]:
    """Return the kinds of mats of a scene, in which frames shake, with their regimes.

    Mats that come to lie on stops are left out, since only a run has those, and so are mats whose trial would
    take long.  Raises SolverFailed and SolverMissing.
    """
    kinds = [kind for kind in trials_of(scene) if not is_costly(kind[1])]
    kinds = sorted(kinds, key=lambda kind: -kind[1].stroke_m)[:MOST_KINDS]
    load_kg_per_m2 = scene.bed_kg_per_m2
    trials = [trial for _, trial in kinds]
    if load_kg_per_m2:
        trials += [replace(trial, added_kg_per_m2=load_kg_per_m2) for trial in trials]
    found = remembered_regimes(trials) if trials else ()
    count = len(kinds)
    loaded: Sequence[Regime | None] = found[count:] or [None] * count
    return tuple(
        Mats(panels, trial, found[number], loaded[number]) for number, (panels, trial) in enumerate(kinds)
    )


def remembered_regimes(
    trials: Sequence[Trial], cells: int = CELLS, watched_turns: int = WATCHED_TURNS
) -> tuple[Regime, ...]:
    """Return the regimes of trials, which several parts of a command ask for."""
    return _remembered(pickle.dumps(trials), cells, watched_turns)


@lru_cache(REMEMBERED)
def _remembered(pickled_trials: bytes, cells: int, watched_turns: int) -> tuple[Regime, ...]:
    return tuple(regimes(pickle.loads(pickled_trials), cells, watched_turns))


def trials_of(scene: Scene) -> Iterator[tuple[tuple[str, ...], Trial]]:
    """Yield the names of panels that are alike and move alike, that of the largest stroke first, and the
    trial of this one.

    Neighbours on two frames are no such panels: one opens while it goes up, the other while it goes down.
    The frames of a slice move as those of the whole machine.
    """
    if scene.case.whole_machine is not scene.case:
        whole = describe(scene.case.whole_machine)
        scene = replace(scene, plan=whole.plan, springs=whole.springs, shaken=whole.shaken)
    starts = {shaking.speed_rad_per_s: _start_m(scene, shaking) for shaking in scene.shaken}
    if not starts:
        return
    sheets: dict[bytes, list[Trial]] = {}
    for plan in panel_plans(scene.case):
        shaking = max(scene.shaken, key=lambda shaking: _stroke_m(shaking, plan))
        trial = Trial(plan, *_clamps_m(scene, shaking, plan, starts[shaking.speed_rad_per_s]))
        if trial.stroke_m > 0.0 and not plan.stops:
            sheets.setdefault(pickle.dumps(_sheet(plan)), []).append(trial)
    for trials in sheets.values():
        kinds: list[list[Trial]] = []
        for trial in sorted(trials, key=lambda trial: -round(trial.stroke_m, 6)):
            alike = next((kind for kind in kinds if kind[0].moves_as(trial)), None)
            if alike is None:
                kinds.append([trial])
            else:
                alike.append(trial)
        for kind in kinds:
            yield tuple(trial.plan.name for trial in kind), kind[0]


def _stroke_m(shaking: Shaking, plan: PanelPlan) -> float:
    return float(abs(shaking.relative_m(plan.frames) @ plan.rectangle.along))


def _start_m(scene: Scene, shaking: Shaking) -> dict[str, Array]:
    """Return what the frames differ from their steady motion by while the machine starts."""
    turns = math.ceil(run_up_turns(scene.plan, shaking.speed_rad_per_s)) + SETTLING_TURNS
    return find_transients_m(scene.plan, scene.springs, shaking, turns)


def _clamps_m(
    scene: Scene, shaking: Shaking, plan: PanelPlan, start_m: dict[str, Array]
) -> tuple[Array, float, Array]:
    """Return amplitudes (2, 3), speed and start (n, 2, 3) of both clamps; free frames stand still if no force
    moves them."""
    still = () if scene.case.frames.adapter.moved_by_forces else free_frames(scene.plan)
    moves = [name not in still for name in plan.frames]
    amplitude_m = np.array([moves[n] * shaking.amplitude_m[name] for n, name in enumerate(plan.frames)])
    transient_m = np.stack([moves[n] * start_m[name] for n, name in enumerate(plan.frames)], axis=1)
    return amplitude_m, shaking.speed_rad_per_s, transient_m


def _sheet(plan: PanelPlan) -> PanelPlan:
    """Return the plan of a mat without its name and place."""
    unplaced = replace(
        plan.rectangle, corner_m=np.zeros(3), along=np.eye(3)[0].copy(), across=np.eye(3)[1].copy()
    )
    weightless = replace(plan, gravity_m_per_s2=np.zeros(3))
    return replace(weightless, name="", rectangle=unplaced, frames=("", ""))


def mats_or_reason(scene: Scene) -> tuple[Mats, ...] | str:
    """Return the kinds of mats of a scene, or why it is not known how they flip.

    A trial is no run: where its solver fails, is missing or lacks memory, a command goes on.
    """
    try:
        return find_mats(scene)
    except (SolverFailed, SolverMissing, MemoryError, ValueError) as error:
        return str(error) or "out of memory"


def mat_lines(scene: Scene) -> Iterator[str]:
    """Yield a line for each kind of mats, empty and loaded."""
    found = mats_or_reason(scene)
    if isinstance(found, str):
        yield f"mats: how they flip is not known: {found}"
        return
    for mats in found:
        yield f"mat {mats.name}, empty: {mats.empty.in_words}"
        if mats.loaded is not None:
            yield f"  with {scene.bed_kg_per_m2:.3g} kg/m2 that move with it: {mats.loaded.in_words}"


def mat_warnings(scene: Scene) -> Iterator[str]:
    """Yield a warning for each kind of mats that arch up when the machine is empty."""
    found = mats_or_reason(scene) if scene.case.panel.adapter.yields else ()
    for mats in found if not isinstance(found, str) else ():
        if mats.empty.turns_up:
            yield f"mat {mats.name}, empty: {mats.empty.in_words}; {REMEDY}"


def mat_tables(scene: Scene) -> list[dict[str, Any]] | None:
    """Return a table for each kind of mats (docs/json-output.md), or None if they are not known."""
    found = mats_or_reason(scene)
    return None if isinstance(found, str) else [mats.as_json() for mats in found]
