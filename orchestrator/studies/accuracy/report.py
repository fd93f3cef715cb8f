"""The output of a study of accuracy: tables for other programs, ``accuracy.json`` for ``flipflow plan``,
pictures, and ``accuracy.html``, which has everything on one page."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from orchestrator.studies.accuracy.combinations import CALIBRATION, REFERENCE, TOGETHER, Combination, Error
from orchestrator.studies.accuracy.layers import FILE, Mark, marks_of
from orchestrator.studies.accuracy.pictures import draw_convergence, draw_costs, draw_layers, draw_models
from orchestrator.studies.accuracy.stored import FORMAT, NAME
from orchestrator.studies.accuracy.study import RECOMMENDED, AccuracyStudy, ComparedSetting
from orchestrator.studies.report import percent
from orchestrator.workbench import Metrics, StudyFolder
from orchestrator.workbench.vocabulary import Cell, align_rows, console_table

AXES_OF_MODELS = ("panel", "frames", "particles", "stiffness", "number")


def write_study(study: AccuracyStudy, folder: Path) -> list[Path]:
    """Write the tables, the pictures and the page of a study, and return their files."""
    lines, into = entries(study), StudyFolder(folder)
    tables = [into.write_csv("accuracy.csv", lines), into.write_parquet("accuracy.parquet", lines)]
    stored = into.write_json(NAME, as_json(study))
    plot = draw_costs(study, folder / "work-precision.png")
    layers = write_layers(marks_of(study, study.loaded.name), folder)
    axes = [_axis(study, axis, folder) for axis in study.offer.titles]
    known = {name: each for name, each in Metrics.quantities.items() if not each.is_defect}
    page = into.write_page(
        "accuracy.html",
        "accuracy/page.html",
        study=study,
        lacking=[row for row in study.rows if row.why],
        front={row.point.name: number for number, row in enumerate(study.front(), 1)},
        advice=[study.recommend(tolerance) for tolerance in RECOMMENDED],
        warnings=[*warnings(study)],
        quantities={k: q for k, q in known.items() if any(k in row.errors for row in study.rows)},
        every=Metrics.quantities,
        defects={name: each for name, each in Metrics.quantities.items() if each.is_defect},
        answers={row.what: row for row in study.known},
        titles=study.offer.parameters,
        percent=percent,
        error=_error_in_words,
        plot=plot,
        layers=layers[-1],
        axes=axes,
    )
    return [*tables, stored, *layers, plot, *(file for each in axes for file in each["files"]), page]


def write_layers(marks: Sequence[Mark], folder: Path) -> list[Path]:
    """Write marks as a table and as a picture of all their scenes, and return the files."""
    table = StudyFolder(folder).write_csv(FILE, [mark.cells for mark in marks])
    return [table, draw_layers(marks, folder / "layers.png")]


def _axis(study: AccuracyStudy, axis: str, folder: Path) -> dict[str, Any]:
    """Return the page's entry for an axis: its series, its models if it has several, and their pictures."""
    series = [one for one in study.measured_series if one.series.axis == axis]
    every = study.compare_settings(axis)
    models = every if len({each.series.variant for each in every}) > 1 else []
    files = [
        draw_convergence(series, study.judged_by, folder / f"accuracy-{axis}.png"),
        draw_models(models, study.judged_by, folder / f"accuracy-{axis}-models.png"),
    ]
    shown = [file for file in files if file is not None]
    return {"title": study.offer.titles[axis], "series": series, "models": models, "files": shown}


def entries(study: AccuracyStudy) -> list[dict[str, Cell]]:
    """Return the rows of the study's table, all with the same columns; unknown cells are None."""
    every = []
    for row in study.rows:
        point = row.point
        entry: dict[str, Cell] = {
            "point": point.name,
            "kind": REFERENCE if point.name == study.reference else point.kind.replace(REFERENCE, TOGETHER),
            "settings": point.label,
            "sets": shlex.join(point.sets),
            "status": row.why or "done",
            "predicted_processor_s": point.predicted_s,
            "predicted_error": row.proposal.error if row.proposal else None,
            "error": row.error.value if row.error else None,
            "error_half_width": row.error.half_width if row.error else None,
            "error_of": row.worst[0] if row.worst else None,
        }
        if point.metrics:
            entry |= {"seeds": len(point.metrics), **point.cost}
        for name in Metrics.quantities:
            if point.values(name):
                entry[name] = point.mean(name)
            if name in row.errors:
                entry[f"{name}_error"] = row.errors[name].value
                entry[f"{name}_error_half_width"] = row.errors[name].half_width
        every.append(entry | {f"against {name}": error for name, error in row.answers.items()})
    return align_rows(every)


def as_json(study: AccuracyStudy) -> dict[str, Any]:
    """Return the content of ``accuracy.json``, which ``flipflow plan`` needs."""
    base, seeds = study.base, len(study.base.metrics)
    chance = (study.spread.half_width(name, (seeds, seeds)) for name in study.judged_by)

    def costs(point: Combination) -> dict[str, Any]:
        simulated_s = point.metrics[0].summary["simulated_s"]
        return {"simulated_s": simulated_s, **point.cost, "processor_by_part_s": point.processor_by_part_s}

    return {
        "format_version": FORMAT,
        "case": study.loaded.name,
        "level": study.loaded.level,
        "read": study.loaded.as_read,
        "sets": list(study.request.study.sets),
        "left_out": study.loaded.left_out,
        "shared": list(study.shared),
        "duration_s": base.metrics[0].summary["simulated_s"],
        "judged_by": study.judged_by,
        "reference": study.reference,
        "seeds": seeds,
        # the largest half width of an error that decides; None where a single seed tells nothing
        "chance": max((width for width in chance if width is not None), default=None),
        "base": costs(base),
        "short": {
            name: costs(one) | {"sets": list(one.sets)}
            for name, one in study.measured.items()
            if one.kind == CALIBRATION
        },
        "remaining": study.remaining_errors,
        "reference_error": study.reference_error,
        "warnings": [*warnings(study)],
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
            for axis, options in study.options().items()
        },
        "models": [row for axis in AXES_OF_MODELS for row in _model_rows(study.compare_settings(axis))],
        "points": entries(study),
    }


def _model_rows(models: Sequence[ComparedSetting]) -> Iterator[dict[str, Any]]:
    best = next((each for each in models if each.is_best), None)
    for each in models:
        assert best is not None  # one of the measured settings is always the best
        yield {
            "axis": each.series.axis,
            "variant": each.series.variant,
            "label": each.setting.label,
            "sets": list(each.setting.sets),
            "error": {name: error.value for name, error in each.errors.items()},
            "half_width": {name: error.half_width for name, error in each.errors.items()},
            "processor_s": each.point.processor_s,
            "reference": best.setting.label,
            "reference_processor_s": best.point.processor_s,
        }


def cost_table(study: AccuracyStudy) -> Table:
    """Return a table of the cost and the error of every point for the console, cheap points first."""
    lines = []
    for row in study.by_cost:
        error = ("reference" if row.point.name == study.reference else "", "")
        if row.error is not None:
            error = (percent(row.error.value), percent(row.error.half_width))
        cost = (f"{row.point.processor_s:.1f}", f"{row.point.cost['peak_memory_MiB']:.0f}")
        lines.append((row.point.label, *cost, *error, row.worst[0] if row.worst else ""))
    head = ("settings", "processor / s", "MiB", "error", "+-", "of")
    return console_table(f"error against {study.reference}", head, lines, left=("of",))


def advice(study: AccuracyStudy) -> Iterator[str]:
    """Yield the recommendation for each tolerance as a line for the console."""
    for each in map(study.recommend, RECOMMENDED):
        if each.row is None:
            why = "no point of this study is so good and no dearer than the reference"
            yield f"{100 * each.tolerance:g} %: {why}"
            continue
        sure = "" if each.is_proven else f" (as far as chance lets one see: {study.would_tell} would tell)"
        if each.row.error is None:
            sure = f" (the reference, by the estimate of its own error, {percent(study.reference_error)})"
        words = " ".join(f"--set {one}" for one in each.row.point.sets) or "the case as it is"
        yield f"{100 * each.tolerance:g} %: {words}, {each.row.point.processor_s:.1f} s{sure}"


def warnings(study: AccuracyStudy) -> Iterator[str]:
    """Yield what the reference lacks, as sentences without a full stop."""
    if lost := [row for row in study.rows if row.point.kind == REFERENCE and row.why]:
        yield f"The proposed reference gave no result, and another point serves as reference ({lost[0].why})"
    if study.reference_error is None:
        yield "How far the reference is itself off is unknown: the parameters do not compare all its settings"
    elif study.reference_error:
        left = percent(study.reference_error)
        yield (
            f"The reference is itself off by an estimated {left}, which is in none of the errors; "
            "recommendations allow for it"
        )
    for row in study.rows:
        for name, error in row.answers.items() if row.point.name == study.reference else ():
            if error > min(RECOMMENDED):
                yield f"The reference is off by {percent(error)} from a known answer: {name}"


def _error_in_words(errors: Mapping[str, Error], name: str) -> str:
    if name not in errors:
        return ""
    width = errors[name].half_width
    return percent(errors[name].value) + (f" ± {percent(width)}" if width else "")
