"""How the mats of a run flipped: turns up, turns until they repeat themselves, and whether that lasts."""

from __future__ import annotations

import numpy as np

from orchestrator.case.deck.panels import single_panels
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array
from orchestrator.preflight.mats.regime import TAUT, repeats_after

FEWEST_TURNS = 8  # whose halves are compared
BY_CHANCE = 0.01  # probability of a difference between halves, shared by all panels, that is taken for chance
LARGEST_CHANGE = 0.1  # of the middle's mean range in a turn, from one half of the turns to the other


def mat_turns(run: RunReader, name: str, start_s: float, end_s: float) -> tuple[float | None, int | None]:
    """Return how a panel flipped in the whole cycles from ``start_s`` to ``end_s``.

    The first is the share of turns in which its middle is farther above the line between its clamps
    than below, and not within 2 % of its length of it.  The second is the smallest number of
    turns after which lowest and highest middle are alike within a tenth of their root mean square about their
    mean (``repeats_after``).  Both are None where nothing drives the machine.
    """
    if not run.is_driven:
        return None, None
    extremes_m = _extremes_m(run, name, start_s, end_s)
    return float(_is_up(run, name, extremes_m).mean()), repeats_after(extremes_m)


def why_not_settled(run: RunReader, start_s: float, end_s: float) -> str:
    """Return why the mats do not flip in the second half of the turns as in the first; empty if they do.

    Turns up and ranges of the middle may differ as far as chance lets them, which it does where a motion
    never repeats itself.
    """
    from scipy.stats import fisher_exact  # takes a tenth of a second

    names = run.names("panel_cycles") if run.is_driven else []
    for name in names:
        extremes_m = _extremes_m(run, name, start_s, end_s)
        if (turns := len(extremes_m)) < FEWEST_TURNS:
            return ""
        half, chance = turns // 2, BY_CHANCE / len(names)
        up = _is_up(run, name, extremes_m)
        early, late = int(up[:half].sum()), int(up[-half:].sum())
        if fisher_exact([[early, half - early], [late, half - late]]).pvalue < chance:
            return (
                f"mat {name} arches up in {early} of the first {half} turns and in {late} of the last {half}"
            )
        range_m = np.ptp(extremes_m, axis=1)
        first_m, last_m = range_m[:half], range_m[-half:]
        changed = float(abs(last_m.mean() / first_m.mean() - 1)) if first_m.mean() > 0 else 0.0
        if changed > LARGEST_CHANGE and _differ(first_m, last_m, chance):
            return f"the range of mat {name} in a turn still changes: by {changed:.0%} between halves"
    return ""


def _differ(first: Array, last: Array, chance: float) -> bool:
    """Return whether two samples have different means beyond chance (Welch's test)."""
    from scipy.stats import ttest_ind

    if np.ptp(first) == 0.0 == np.ptp(last):
        return bool(first[0] != last[0])
    return bool(ttest_ind(first, last, equal_var=False).pvalue < chance)


def _extremes_m(run: RunReader, name: str, start_s: float, end_s: float) -> Array:
    """Return the lowest and the highest middle (turns, 2) of each cycle."""
    rows = run.read_cycles(f"panel_cycles/{name}", start_s, end_s)
    return np.column_stack([rows["middle_least_m"], rows["middle_most_m"]])


def _is_up(run: RunReader, name: str, extremes_m: Array) -> Array:
    """Tell in which turns (turns,) a mat arches up."""
    length_m = next((p.rectangle.length_m for p in single_panels(run.case) if p.name == name), 0.0)
    lowest_m, highest_m = extremes_m.T
    return np.asarray((highest_m > -lowest_m) & (highest_m >= TAUT * length_m))
