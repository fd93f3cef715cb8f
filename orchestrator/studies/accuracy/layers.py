"""The layers of a study: what numerics cost in decades, and what no numerics can buy.

Numerics converge inside one model.  How far the model is from a better one, what chance hides, what a longer
run would say and how far known answers are do not change with them.  A ``Mark`` is one place of either kind,
and a row of ``layers.csv``.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from orchestrator.studies.accuracy.combinations import (
    ALONE,
    BASE,
    CALIBRATION,
    Combination,
    Error,
    errors,
    stepping_s_per_s,
    worst_error,
)
from orchestrator.studies.accuracy.study import AccuracyStudy
from orchestrator.studies.recorded import read_rows
from orchestrator.workbench.vocabulary import Cell

FILE = "layers.csv"
NUMERICS, TOGETHER, LOST, MODEL, STATISTICS, CHANCE, ANSWER = (
    "numerics",
    "together",
    "lost",
    "model",
    "statistics",
    "chance",
    "answer",
)
"""The layers: settings of numerics one parameter at a time, several together, and those whose runs are not to
be trusted; bands of models, of what is sampled, of chance, and of answers known from elsewhere."""
NUMBERS = ("s_per_s", "start_s", "error", "half_width")


@dataclass(frozen=True)
class Mark:
    """One place in the picture of a scene.

    ``curve`` joins the marks of one parameter, and ``label`` and ``sets`` are the setting.  ``s_per_s`` is
    the processor time per simulated second in s, without the start, which takes ``start_s``.  ``error`` is
    the relative error of the quantity ``of``, whose 95 % interval has the half width ``half_width``; None
    where it is unknown.  ``status`` is that of the runs.  ``is_own`` says whether it is the case as it is.
    """

    scene: str
    layer: str
    curve: str
    label: str
    sets: str = ""
    status: str = "done"
    s_per_s: float | None = None
    start_s: float | None = None
    error: float | None = None
    half_width: float | None = None
    of: str = ""
    is_own: bool = False

    @property
    def is_chance(self) -> bool:
        """Whether chance explains the error."""
        return self.error is not None and self.half_width is not None and self.error <= self.half_width

    @property
    def cells(self) -> dict[str, Cell]:
        """Its row in a table."""
        return asdict(self)


COLUMNS = tuple(field.name for field in fields(Mark))


def read_marks(file: Path) -> list[Mark]:
    """Return the marks of a table.  Raises CaseError."""
    marks = []
    for row in read_rows(file, COLUMNS, NUMBERS, "docs/theory/accuracy.md"):
        numbers = {name: float(row[name]) if row[name] else None for name in NUMBERS}
        marks.append(Mark(**{**row, **numbers, "is_own": row["is_own"] == "True"}))  # type: ignore[arg-type]
    return marks


def marks_of(study: AccuracyStudy, scene: str) -> list[Mark]:
    """Return the marks of a study, under the name of its ``scene``."""
    return [*_numerics(study, scene), *_together(study, scene), *_lost(study, scene), *_bands(study, scene)]


def _mark(
    scene: str, layer: str, curve: str, label: str, point: Combination, error: tuple[str, Error] | None
) -> Mark:
    of, size = error or ("", Error(0.0))
    return Mark(
        scene,
        layer,
        curve,
        label,
        shlex.join(point.sets),
        s_per_s=point.cost["stepping_s_per_s"],
        start_s=point.cost["start_s"],
        error=size.value if error else None,
        half_width=size.half_width if error else None,
        of=of,
        is_own=point.kind == BASE,
    )


def _numerics(study: AccuracyStudy, scene: str) -> Iterator[Mark]:
    """Yield the settings of numerics, each against the finest one of the best series of its axis."""
    every = [one for one in study.measured_series if one.series.layer == NUMERICS]
    for one in every:
        of_axis = [other for other in every if other.series.axis == one.series.axis]
        reference = max(of_axis, key=lambda other: other.series.rank).points[-1]
        curve = one.series.title + (f": {one.series.variant}" if one is not of_axis[0] else "")
        for setting, point in zip(one.settings, one.points, strict=True):
            if point is not reference:
                worst = worst_error(errors(point, reference, study.spread), study.deciding(reference))
                yield _mark(scene, NUMERICS, curve, setting.label, point, worst)


def _together(study: AccuracyStudy, scene: str) -> Iterator[Mark]:
    """Yield joint settings and the reference, which has the estimate of its own error."""
    for row in study.rows:
        if row.point.metrics and row.point.kind not in (ALONE, BASE):
            own = row.point.name == study.reference and study.reference_error
            worst = ("estimate", Error(own)) if own else row.worst
            yield _mark(scene, TOGETHER, "several together", row.point.label, row.point, worst)


def _lost(study: AccuracyStudy, scene: str) -> Iterator[Mark]:
    """Yield the settings whose runs are doubtful or ended early, at their cost."""
    for point in study.points:
        if point.metrics or point.kind == CALIBRATION:
            continue
        lost = [one.run for one in point.runs if one.run.is_over() and not one.run.is_trusted]
        for run in lost[:1]:
            simulated_s = run.summary.get("simulated_s")
            cost = stepping_s_per_s(run.processor_by_part_s, simulated_s) if simulated_s else None
            sets = shlex.join(point.sets)
            yield Mark(scene, LOST, "no result", point.label, sets, run.status, s_per_s=cost)


def _bands(study: AccuracyStudy, scene: str) -> Iterator[Mark]:
    """Yield what numerics do not change: models, what is sampled, chance, and known answers."""
    for axis in study.offer.titles:
        every = [one for one in study.compare_settings(axis) if one.errors]
        layers = {one.series.layer for one in every} - {NUMERICS}
        finest = {one.series.variant: one for one in every}  # the last one of a series is its finest
        for one in finest.values() if len(finest) > 1 else every:
            for layer in layers if not one.is_best else ():
                worst = worst_error(one.errors, study.judged_by)
                yield _mark(scene, layer, one.series.title, one.setting.label, one.point, worst)
    widths = {
        name: width
        for name in study.judged_by
        if (width := study.spread.half_width(name, (len(study.base.metrics),) * 2))
    }
    for name, width in sorted(widths.items(), key=lambda pair: -pair[1])[:1]:
        yield Mark(scene, CHANCE, "chance", f"{len(study.base.metrics)} seeds", error=width, of=name)
    best = next(row for row in study.rows if row.point.name == study.reference)
    for name, error in best.answers.items():
        yield Mark(scene, ANSWER, "known answer", name, error=error, of=name)


def scenes_of(marks: Sequence[Mark]) -> Mapping[str, list[Mark]]:
    """Return the marks by scene, in the order in which the scenes come."""
    return {
        name: [one for one in marks if one.scene == name] for name in dict.fromkeys(m.scene for m in marks)
    }
