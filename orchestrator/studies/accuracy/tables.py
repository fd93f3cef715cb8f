"""A study as rows, one for each point, what they recommend, and the files for other programs."""

from __future__ import annotations

import csv
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from math import inf
from pathlib import Path
from typing import Any

import pyarrow
from pyarrow import parquet
from rich import box
from rich.table import Table

from orchestrator.output.records.run_folder import write_json
from orchestrator.studies.accuracy.combinations import CALIBRATION, Combination
from orchestrator.studies.accuracy.convergence import Compared, compare_axis
from orchestrator.studies.accuracy.measured import Error, Measured, against, errors, worst
from orchestrator.studies.accuracy.model import Proposal
from orchestrator.studies.accuracy.study import Study
from orchestrator.studies.metrics import DEFECTS, QUANTITIES
from orchestrator.studies.tables import percent

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
    sure = [r for r in within if r.error and r.error.known and r.error.at_most <= tolerance]
    best = min(sure, key=_cost_s) if sure else min(within, key=_at_most, default=None)
    return Recommendation(tolerance, best, bool(sure))


def _cost_s(row: Row) -> float:
    assert row.measured is not None
    return row.measured.processor_s


def _at_most(row: Row) -> float:
    return row.error.at_most if row.error else inf


Cell = str | float | int | None


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
    columns = dict.fromkeys(name for entry in found for name in entry)
    return [{name: entry.get(name) for name in columns} for entry in found]


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
    """All three."""
    lines = entries(table, study.reference)
    files = [folder / f"accuracy.{kind}" for kind in ("csv", "parquet", "json")]
    with files[0].open("w", newline="", encoding="utf-8") as text:
        writer = csv.DictWriter(text, [*lines[0]])
        writer.writeheader()
        writer.writerows(lines)
    parquet.write_table(pyarrow.Table.from_pylist(lines), files[1])
    write_json(files[2], as_json(study, table))
    return files


def as_json(study: Study, table: Sequence[Row]) -> dict[str, Any]:
    """What ``flipflow plan`` needs to know."""
    there = study.listed
    return {
        "case": there.loaded.name,
        "level": there.loaded.level,
        "sets": list(there.asked.sets),
        "shared": list(there.shared),
        "duration_s": study.base.metrics[0].simulated_s,
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
        "models": [
            _model(each, every)
            for axis in AXES_OF_MODELS
            for every in [_compared(study, axis)]
            for each in every
        ],
        "points": entries(table, study.reference),
    }


def _compared(study: Study, axis: str) -> list[Compared]:
    return compare_axis(axis, study.families, study.spread)


def _model(one: Compared, every: Sequence[Compared]) -> dict[str, Any]:
    best = next(each for each in every if each.is_best)
    return {
        "axis": one.series.axis,
        "variant": one.series.variant,
        "label": one.setting.label,
        "sets": list(one.setting.sets),
        "error": {name: error.value for name, error in one.errors.items()},
        "processor_s": one.measured.processor_s,
        "reference": best.setting.label,
        "reference_processor_s": best.measured.processor_s,
    }


def _chance(study: Study) -> float | None:
    """Largest half width of an error that decides; None where a single seed tells nothing."""
    seeds = len(study.base.metrics)
    found = [study.spread.half_width(name, (seeds, seeds)) for name in study.judged_by]
    return max((one for one in found if one is not None), default=None)


def _cost(one: Measured) -> dict[str, Any]:
    return {
        "simulated_s": one.metrics[0].simulated_s,
        "processor_s": one.processor_s,
        "wall_s": one.wall_s,
        "side_by_side": one.side_by_side,
        "peak_memory_MiB": one.memory_MiB,
        "processor_by_part_s": one.processor_by_part_s,
    }


def as_table(study: Study, table: Sequence[Row]) -> Table:
    """For the console: cost and error of every point, from cheap to dear."""
    found = Table(title=f"error against {study.reference}", box=box.SIMPLE_HEAD)
    found.title_justify = "left"
    found.add_column("settings")
    for name in ("processor / s", "MiB", "error", "+-", "of"):
        found.add_column(name, justify="right" if name != "of" else "left", no_wrap=True)
    there = [(row, row.measured) for row in table if row.measured]
    for row, one in sorted(there, key=lambda pair: pair[1].processor_s):
        wrong = row.error
        cells = [percent(wrong.value if wrong else None), percent(wrong.half_width if wrong else None)]
        if wrong is None:
            cells = ["reference", ""]
        seconds = (f"{one.processor_s:.1f}", f"{one.memory_MiB:.0f}")
        found.add_row(row.point.label, *seconds, *cells, row.worst[0] if row.worst else "")
    return found


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
