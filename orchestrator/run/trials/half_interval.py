"""A trial of half the sync interval, after a run that its coupling made doubtful or ended."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from orchestrator.coupling.ledger import share_created
from orchestrator.output.records import trust
from orchestrator.output.results.run_reader import summary_of
from orchestrator.ports.clock import exact
from orchestrator.preflight.cost import in_words
from orchestrator.preflight.judge import load_judged
from orchestrator.run.trials.scratch import NoResult, run_in_scratch

KEY = "coupling.sync_interval_s"
DEARER = 2.0
"""The ratio of the time that half the interval takes to that of the run, at most."""
PATIENCE = 3.0
"""The multiple of the time allowed, after which a trial is ended."""


def try_half(folder: Path, trial_s: float) -> Iterator[str]:
    """Yield a line on what half the interval does, where the run in ``folder`` advises a shorter one.

    The trial repeats the run from its start to its end, without pictures, if that takes at most ``trial_s``
    (wall time / s); otherwise the line says that nothing was tried.
    """
    figures = summary_of(folder)
    if not any(KEY in text for text in (figures.get("reason", ""), *figures.get("doubts", ()))):
        return
    case = load_judged(folder, None, []).case
    half_s = case.coupling.sync_interval_s / 2
    if (cost_s := DEARER * figures["wall_s"]) > trial_s:
        yield f"not tried: {KEY} = {half_s:.4g}, half of the run's, would take about {in_words(cost_s)}"
        return
    outputs = math.ceil(figures["simulated_s"] / case.output.interval_s) + 1
    duration_s = min(case.duration_s, float(outputs * exact(case.output.interval_s)))
    sets = (f"{KEY}={half_s!r}", f"duration_s={duration_s!r}", "output.pictures=false")
    begin = f"tried: with {KEY} = {half_s:.4g}, half of the run's, to {duration_s:.4g} s, the run"
    try:
        tried = run_in_scratch(folder, "", sets, PATIENCE * trial_s)
    except NoResult as why:
        yield f"{begin} {why}"
        return
    told = [*tried["doubts"], tried["reason"]]
    if trust.is_trusted(tried["status"]) or not any(KEY in text for text in told):
        end = "the shorter interval helps"
    elif _created(tried) < _created(figures) / DEARER:
        end = "a shorter interval helps, and half is not enough"
    else:
        end = "half the interval helps little: shorten it much more, or look for another cause"
    yield f"{begin} ends {tried['status']}, {100 * _created(tried):.2g} % created or destroyed: {end}"


def _created(figures: Mapping[str, Any]) -> float:
    """Return the size of the share of energy created, infinite for a run that ended before its balance."""
    return abs(share_created(figures)) if "energy_ledger_J" in figures else math.inf
