"""A study as rows, one for each point, and what they recommend."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import inf

from orchestrator.studies.accuracy.measured import Error, Measured, against, errors, worst
from orchestrator.studies.accuracy.model import Proposal
from orchestrator.studies.accuracy.points import CALIBRATION, Point
from orchestrator.studies.accuracy.study import Study

RECOMMENDED = (0.01, 0.05, 0.1)


@dataclass(frozen=True)
class Row:
    """A point: its errors against the reference by quantity, the ``worst`` of those that decide,
    and those against known answers."""

    point: Point
    measured: Measured | None
    errors: dict[str, Error]
    worst: tuple[str, Error] | None
    answers: dict[str, float]
    proposal: Proposal | None

    @property
    def error(self) -> Error | None:
        return self.worst[1] if self.worst else None

    @property
    def why(self) -> str:
        """Why nothing was measured."""
        if self.measured is not None:
            return ""
        states = {run.status() for run in self.point.runs}
        return self.point.omitted or f"{', '.join(sorted(states))}: {self.point.runs[0].folder}"


@dataclass(frozen=True)
class Recommendation:
    """The cheapest row within a tolerance, None where there is none; ``proven``: also at the upper
    end of its confidence interval."""

    tolerance: float
    row: Row | None
    proven: bool = False


def rows(study: Study) -> list[Row]:
    """In the order in which they were run; the short part is not among them."""
    best = study.measured[study.reference]
    found = []
    for one in study.points:
        if one.kind == CALIBRATION:
            continue
        there = study.measured.get(one.name)
        wrong = errors(there, best, study.spread) if there and there is not best else {}
        found.append(
            Row(
                one,
                there,
                wrong,
                worst(wrong, study.judged_by),
                against(there, study.listed.known) if there else {},
                study.proposals.get(one.name),
            )
        )
    return found


def pareto(table: Sequence[Row]) -> list[Row]:
    """From cheap to dear, those that no other beats in both error and processor time."""
    front: list[Row] = []
    least = inf
    for row in sorted((r for r in table if r.error), key=_cost_s):
        if row.error is not None and row.error.value < least:
            front.append(row)
            least = row.error.value
    return front


def recommended(table: Sequence[Row], tolerance: float) -> Recommendation:
    """Of all points that were measured; where chance leaves none proven, the one of which most is
    sure.  The reference is no candidate: nobody knows its error."""
    within = [r for r in table if r.error and r.error.value <= tolerance]
    sure = [r for r in within if r.error and r.error.known and r.error.at_most <= tolerance]
    best = min(sure, key=_cost_s) if sure else min(within, key=_at_most, default=None)
    return Recommendation(tolerance, best, bool(sure))


def _cost_s(row: Row) -> float:
    assert row.measured is not None
    return row.measured.processor_s


def _at_most(row: Row) -> float:
    return row.error.at_most if row.error else inf
