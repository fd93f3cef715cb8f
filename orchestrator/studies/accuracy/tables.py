"""A study as rows, one for each point, what they recommend, and the files for other programs."""

from __future__ import annotations

import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

from rich.table import Table

from orchestrator.output.records.run_folder import write_json
from orchestrator.studies.accuracy.combinations import CALIBRATION, Combination
from orchestrator.studies.accuracy.convergence import compare_axis
from orchestrator.studies.accuracy.measured import Error, Measured, against, errors, worst
from orchestrator.studies.accuracy.model import Proposal
from orchestrator.studies.accuracy.study import Study
from orchestrator.studies.metrics import DEFECTS, QUANTITIES
from orchestrator.studies.tables import Cell, aligned, console_table, percent, write_csv, write_parquet

AXES_OF_MODELS = ("panel", "frames", "particles", "stiffness", "number")
RECOMMENDED = (0.01, 0.05, 0.1)


@dataclass(frozen=True)
class Row:
    """A point: its errors against the reference by quantity, the ``worst`` of those that decide,
    and those against known answers."""

    point: Combination
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
    sure = [r for r in within if r.error and r.error.half_width is not None and r.error.at_most <= tolerance]
    best = min(sure, key=_cost_s) if sure else min(within, key=_at_most, default=None)
    return Recommendation(tolerance, best, bool(sure))


def _cost_s(row: Row) -> float:
    assert row.measured is not None
    return row.measured.processor_s


def _at_most(row: Row) -> float:
    return row.error.at_most if row.error else inf


def entries(table: Sequence[Row], reference: str) -> list[dict[str, Cell]]:
    """A row's columns, all rows alike; None where something is not known."""
    found = []
    for row in table:
        entry: dict[str, Cell] = {
            "point": row.point.name,
            "kind": "reference" if row.point.name == reference else row.point.kind,
            "settings": row.point.label,
            "sets": shlex.join(row.point.sets),
            "status": row.why or "done",
            "predicted_processor_s": row.point.predicted_s,
            "predicted_error": row.proposal.error if row.proposal else None,
            "error": row.error.value if row.error else None,
            "error_half_width": row.error.half_width if row.error else None,
            "error_of": row.worst[0] if row.worst else None,
        }
        found.append(entry | _measured(row))
    return aligned(found)


def _measured(row: Row) -> dict[str, Cell]:
    there = row.measured
    if there is None:
        return {}
    entry: dict[str, Cell] = {
        "seeds": len(there.metrics),
        "processor_s": there.processor_s,
        "wall_s": there.wall_s,
        "side_by_side": there.side_by_side,
        "peak_memory_MiB": there.memory_MiB,
    }
    for name in (*QUANTITIES, *DEFECTS):
        if there.values(name):
            entry[name] = there.mean(name)
        if name in row.errors:
            entry[f"{name}_error"] = row.errors[name].value
            entry[f"{name}_error_half_width"] = row.errors[name].half_width
    return entry | {f"against {name}": error for name, error in row.answers.items()}


def write(study: Study, table: Sequence[Row], folder: Path) -> list[Path]:
    """Writes all three."""
    lines, file = entries(table, study.reference), folder / "accuracy.json"
    write_json(file, as_json(study, table))
    return [
        write_csv(lines, folder / "accuracy.csv"),
        write_parquet(lines, folder / "accuracy.parquet"),
        file,
    ]


def as_json(study: Study, table: Sequence[Row]) -> dict[str, Any]:
    """What ``flipflow plan`` needs to know."""
    there = study.listed
    return {
        "case": there.loaded.name,
        "level": there.loaded.level,
        "sets": list(there.asked.sets),
        "shared": list(there.shared),
        "duration_s": study.base.metrics[0].summary["simulated_s"],
        "judged_by": study.judged_by,
        "reference": study.reference,
        "seeds": len(study.base.metrics),
        "chance": _chance(study),
        "base": _cost(study.base),
        "short": {
            name: _cost(one) | {"sets": list(one.point.sets)}
            for name, one in study.measured.items()
            if one.point.kind == CALIBRATION
        },
        "remaining": study.remaining,
        "options": {
            axis: [
                {
                    "label": one.setting.label,
                    "sets": list(one.setting.sets),
                    "error": one.error,
                    "ratio": one.ratio,
                }
                for one in options
            ]
            for axis, options in study.options.items()
        },
        "models": [row for axis in AXES_OF_MODELS for row in _model_rows(study, axis)],
        "points": entries(table, study.reference),
    }


def _model_rows(study: Study, axis: str) -> list[dict[str, Any]]:
    every = compare_axis(axis, study.families, study.spread)
    best = next((each for each in every if each.is_best), None)
    return [
        {
            "axis": each.series.axis,
            "variant": each.series.variant,
            "label": each.setting.label,
            "sets": list(each.setting.sets),
            "error": {name: error.value for name, error in each.errors.items()},
            "processor_s": each.measured.processor_s,
            "reference": best.setting.label,
            "reference_processor_s": best.measured.processor_s,
        }
        for each in every
        if best is not None
    ]


def _chance(study: Study) -> float | None:
    """Largest half width of an error that decides; None where a single seed tells nothing."""
    seeds = len(study.base.metrics)
    found = [study.spread.half_width(name, (seeds, seeds)) for name in study.judged_by]
    return max((one for one in found if one is not None), default=None)


def _cost(one: Measured) -> dict[str, Any]:
    return {
        "simulated_s": one.metrics[0].summary["simulated_s"],
        "processor_s": one.processor_s,
        "wall_s": one.wall_s,
        "side_by_side": one.side_by_side,
        "peak_memory_MiB": one.memory_MiB,
        "processor_by_part_s": one.processor_by_part_s,
    }


def as_table(study: Study, table: Sequence[Row]) -> Table:
    """Returns the cost and error of every point for the console, from cheap to dear."""
    lines = []
    for row in sorted((row for row in table if row.measured), key=_cost_s):
        assert row.measured is not None
        seconds = (f"{row.measured.processor_s:.1f}", f"{row.measured.memory_MiB:.0f}")
        error = ("reference", "")
        if row.error is not None:
            error = (percent(row.error.value), percent(row.error.half_width))
        lines.append((row.point.label, *seconds, *error, row.worst[0] if row.worst else ""))
    head = ("settings", "processor / s", "MiB", "error", "+-", "of")
    return console_table(f"error against {study.reference}", head, lines, left=("of",))


def advice(table: Sequence[Row]) -> list[str]:
    """A line for each tolerance."""
    lines = []
    for tolerance in RECOMMENDED:
        one = recommended(table, tolerance)
        if one.row is None or one.row.measured is None:
            lines.append(f"{100 * tolerance:g} %: no point of this study is so good")
            continue
        sure = "" if one.proven else " (as far as chance lets one see: more --seeds would tell)"
        words = " ".join(f"--set {each}" for each in one.row.point.sets) or "the case as it is"
        lines.append(f"{100 * tolerance:g} %: {words}, {one.row.measured.processor_s:.1f} s{sure}")
    return lines
