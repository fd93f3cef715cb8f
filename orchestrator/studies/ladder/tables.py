"""A ladder as rows: on the console, ``ladder.csv`` and ``ladder.json``."""

from __future__ import annotations

import csv
import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich import box
from rich.table import Table

from orchestrator.output.records.run_folder import write_json
from orchestrator.studies.figures import QUANTITIES, Figures, errors, figures
from orchestrator.studies.ladder.climb import Step

SHORT = {
    "deflection_m": "deflection",
    "shape": "shape",
    "clamp_peak_N": "clamp peak",
    "clamp_rms_N": "clamp rms",
    "peak_g": "acc. peak",
    "rms_g": "acc. rms",
    "frame_m": "frame",
    "passing_kg_per_s": "passing",
    "efficiency_percent": "efficiency",
    "velocity_m_per_s": "velocity",
}


@dataclass(frozen=True)
class Row:
    """A rung with what was measured; ``error`` against its ladder's ``reference``."""

    step: Step
    reference: str
    figures: Figures | None
    error: dict[str, float]
    why: str


def rows(steps: Sequence[Step]) -> list[Row]:
    """In order; the reference of a ladder is the last of its rungs that was done."""
    measured = {
        step.point.folder: figures(step.point.folder)
        for step in steps
        if step.done and step.point is not None
    }
    found = []
    for step in steps:
        mine = [s for s in steps if s.rung.ladder == step.rung.ladder and s.done]
        best = mine[-1] if mine else step
        here = measured.get(step.point.folder) if step.point is not None else None
        highest = measured.get(best.point.folder) if best.point is not None else None
        error = errors(here, highest) if here and highest and step is not best else {}
        failed = f"{step.point.status()}: {step.point.folder}.log" if step.point else "not run"
        why = step.omitted or ("" if here else failed)
        found.append(Row(step, best.rung.name, here, error, why))
    return found


def as_table(ladder: str, table: Sequence[Row]) -> Table:
    """For the console: errors in per cent, times and memory."""
    mine = [row for row in table if row.step.rung.ladder == ladder]
    names = [name for name in QUANTITIES if any(name in row.error for row in mine)]
    found = Table(title=f"{ladder}: error against {mine[0].reference}", box=box.SIMPLE_HEAD)
    found.title_justify = "left"
    found.add_column("rung", no_wrap=True)
    for name in names:
        found.add_column(SHORT[name], justify="right")
    for name in ("wall / s", "processor / s", "MiB"):
        found.add_column(name, justify="right")
    for row in mine:
        if row.figures is None:
            continue
        cells = [percent(row.error.get(name)) for name in names]
        seconds = (f"{row.figures.wall_s:.1f}", f"{row.figures.processor_s:.1f}")
        found.add_row(row.step.rung.name, *cells, *seconds, f"{row.figures.memory_MiB:.0f}")
    return found


def percent(error: float | None) -> str:
    """Two digits; empty where there is none."""
    if error is None:
        return ""
    return f"{100 * error:.2g} %" if error < 0.1 else f"{100 * error:.0f} %"


def not_run(ladder: str, table: Sequence[Row]) -> list[str]:
    """A line for each rung that was not, with the reason."""
    mine = [row for row in table if row.step.rung.ladder == ladder and row.figures is None]
    return [f"  {row.step.rung.name}: {row.why}" for row in mine]


def as_json(case: str, level: str, table: Sequence[Row]) -> dict[str, Any]:
    """What ``ladder.json`` holds."""
    return {"case": case, "level": level, "quantities": QUANTITIES, "rungs": [_entry(row) for row in table]}


def _entry(row: Row) -> dict[str, Any]:
    step, measured = row.step, row.figures
    entry: dict[str, Any] = {
        "ladder": step.rung.ladder,
        "rung": step.rung.name,
        "sets": list(step.rung.sets),
        "reference": row.reference,
        "predicted_s": step.predicted_s,
        "omitted": row.why,
    }
    if measured is None:
        return entry
    return entry | {
        "folder": step.point.folder.name if step.point else "",
        "simulated_s": measured.simulated_s,
        "wall_s": measured.wall_s,
        "wall_by_part_s": measured.wall_by_part_s,
        "processor_s": measured.processor_s,
        "peak_memory_MiB": measured.memory_MiB,
        "values": measured.values,
        "uncertainty": measured.own,
        "shape_change_from_cycle_to_cycle": measured.change,
        "error": row.error,
    }


def write(case: str, level: str, table: Sequence[Row], folder: Path) -> list[Path]:
    """Both files."""
    written = [folder / "ladder.json", folder / "ladder.csv"]
    write_json(written[0], as_json(case, level, table))
    columns = ["ladder", "rung", "reference", "wall_s", "processor_s", "peak_memory_MiB"]
    columns += [f"{name}{kind}" for name in QUANTITIES for kind in ("", "_error")]
    with written[1].open("w", newline="", encoding="utf-8") as text:
        writer = csv.DictWriter(text, [*columns, "omitted"])
        writer.writeheader()
        for row in table:
            entry = json.loads(json.dumps(_entry(row)))
            line = {name: entry.get(name, "") for name in [*columns[:6], "omitted"]}
            line |= entry.get("values", {})
            line |= {f"{name}_error": value for name, value in entry.get("error", {}).items()}
            writer.writerow(line)
    return written
