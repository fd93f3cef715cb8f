"""A study in files: ``accuracy.csv``, ``accuracy.parquet`` and ``accuracy.json``."""

from __future__ import annotations

import csv
import shlex
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyarrow
from pyarrow import parquet
from rich import box
from rich.table import Table

from orchestrator.output.records.run_folder import write_json
from orchestrator.studies.accuracy.measured import Measured
from orchestrator.studies.accuracy.points import CALIBRATION
from orchestrator.studies.accuracy.rows import RECOMMENDED, Row, recommended
from orchestrator.studies.accuracy.study import Study
from orchestrator.studies.figures import DEFECTS, QUANTITIES
from orchestrator.studies.ladder.tables import percent

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
        "seeds": len(there.figures),
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
        "duration_s": study.base.figures[0].simulated_s,
        "judged_by": study.judged_by,
        "reference": study.reference,
        "seeds": len(study.base.figures),
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
        "points": entries(table, study.reference),
    }


def _chance(study: Study) -> float | None:
    """Largest half width of an error that decides; None where a single seed tells nothing."""
    seeds = len(study.base.figures)
    found = [study.spread.half_width(name, (seeds, seeds)) for name in study.judged_by]
    return max((one for one in found if one is not None), default=None)


def _cost(one: Measured) -> dict[str, Any]:
    return {
        "simulated_s": one.figures[0].simulated_s,
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
