"""``accuracy.html``: a study on one page that holds everything in itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from orchestrator.output.records.run_folder import write_text
from orchestrator.output.report.drawing import data_uri
from orchestrator.output.report.filled import filled
from orchestrator.studies.accuracy.convergence import convergence
from orchestrator.studies.accuracy.knobs import KNOBS
from orchestrator.studies.accuracy.measured import Error
from orchestrator.studies.accuracy.pictures import work_precision
from orchestrator.studies.accuracy.rows import RECOMMENDED, Row, pareto, recommended
from orchestrator.studies.accuracy.study import Study
from orchestrator.studies.figures import DEFECTS, QUANTITIES
from orchestrator.studies.ladder.tables import SHORT, percent


def write(study: Study, table: Sequence[Row], folder: Path) -> list[Path]:
    """The pictures and the page."""
    plot = work_precision(study, table, folder / "work-precision.png")
    knobs = _knobs(study, folder)
    text = filled(
        "studies/accuracy/page.html",
        title=study.listed.loaded.name,
        level=study.listed.loaded.level,
        study=study,
        rows=sorted((r for r in table if r.measured), key=lambda r: r.measured.processor_s),
        lacking=[row for row in table if row.measured is None],
        front={row.point.name: number for number, row in enumerate(pareto(table), 1)},
        advice=[recommended(table, tolerance) for tolerance in RECOMMENDED],
        names={name: QUANTITIES[name] for name in QUANTITIES if _known(name, table)},
        short=SHORT,
        defects={name: DEFECTS[name] for name in DEFECTS},
        answers={row.what: row for row in study.listed.known},
        titles={name: knob.title for name, knob in KNOBS.items()},
        percent=percent,
        error=_error,
        plot=_embedded(plot),
        knobs=[one | {"picture": _embedded(one["file"])} for one in knobs],
    )
    write_text(folder / "accuracy.html", text)
    return [plot, *(one["file"] for one in knobs if one["file"]), folder / "accuracy.html"]


def _knobs(study: Study, folder: Path) -> list[dict[str, Any]]:
    """Of each axis: its families, and its picture if it has one."""
    found = []
    for axis in study.listed.offer.axes:
        families = [one for one in study.families if one.family.axis == axis]
        file = convergence(families, study.judged_by, folder / f"accuracy-{axis}.png")
        found.append({"title": study.listed.offer.titles[axis], "families": families, "file": file})
    return found


def _known(name: str, table: Sequence[Row]) -> bool:
    return any(name in row.errors for row in table)


def _error(errors: Mapping[str, Error], name: str) -> str:
    """With its uncertainty."""
    one = errors.get(name)
    if one is None:
        return ""
    return percent(one.value) + (f" ± {percent(one.half_width)}" if one.half_width else "")


def _embedded(file: Path | None) -> str:
    return data_uri(file.read_bytes(), "image/png") if file else ""
