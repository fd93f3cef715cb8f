"""Beams below panels: under the free length, and no stiffer than the sync interval allows."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.case.deck.panels import SinglePanel, single_panels
from orchestrator.case.deck.stops import stiffest_Pa_per_m
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.stop import Stop


def stops(case: Case) -> Iterator[CaseProblem]:
    """Each row of panels once."""
    rows = {panel.table_name: panel for panel in reversed(single_panels(case))}
    for table_name, panel in reversed(rows.items()):
        for name, stop in panel.table.stops.items():
            yield from _stop(("screen", "panels", table_name, "stops", name), case, panel, stop)


def _stop(key: Key, case: Case, panel: SinglePanel, stop: Stop) -> Iterator[CaseProblem]:
    free_m = panel.table.length_m
    if stop.to_m > free_m * (1 + 1e-9):
        what = f"lies beyond the free length of {free_m:g} m"
        yield CaseProblem((*key, "to_m"), what, "stops lie between the clamps' inner edges")
    if stop.from_m >= stop.to_m:
        yield CaseProblem((*key, "from_m"), f"is not before to_m = {stop.to_m:g} m")
    if panel.table.material not in case.materials or stop.stiffness_Pa_per_m is None:
        return
    most_Pa_per_m = stiffest_Pa_per_m(case, panel)
    if stop.stiffness_Pa_per_m > most_Pa_per_m:
        interval_s = case.coupling.sync_interval_s
        what = f"is too stiff for a sync interval of {interval_s:g} s: the panel would be kicked"
        hint = f"at most {most_Pa_per_m:.3g} Pa/m, or a shorter coupling.sync_interval_s"
        yield CaseProblem((*key, "stiffness_Pa_per_m"), what, hint)
