"""The page: gathers words, tables and figures of a run, and fills the template."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

from orchestrator.output.report import tables
from orchestrator.output.report.drawing import data_uri, embedded, fill_template
from orchestrator.output.report.formatting import duration, interval, number
from orchestrator.output.report.headline import NOT_STEADY, headline
from orchestrator.output.report.pictures import draw_cost, draw_machine, draw_results
from orchestrator.output.report.quality import collect_warnings, quality_rows
from orchestrator.output.results.run_reader import RunReader
from orchestrator.output.subprocesses import python

NAME = "report.html"
FILM_CYCLES = 3


@dataclass(frozen=True)
class Film:
    """An animated WebP of ``frames`` pictures; empty, with the ``reason``, if there is none."""

    content: bytes
    frames: int = 0
    start_s: float = 0.0
    end_s: float = 0.0
    reason: str = ""


def make_film(folder: Path, lasting_s: float) -> Film:
    """Returns the film of the last ``lasting_s`` seconds of the run, made in a process of its own: a
    renderer that crashes loses nothing."""
    with tempfile.TemporaryDirectory() as place:
        made = Path(place) / "film.webp"
        words = ("orchestrator.output.report.rendering", str(folder), str(lasting_s), str(made))
        done = python("-m", *words, capture_output=True)
        if done.returncode or not made.is_file():
            why = done.stderr.strip().splitlines()[-1:] or ["the renderer ended without a word"]
            return Film(b"", reason=why[0])
        return Film(made.read_bytes(), **json.loads(done.stdout))


def page(folder: Path, results: dict[str, Any], film: Callable[[Path, float], Film]) -> str:
    """Returns the HTML of a run's report.  ``results`` are its results, ``film`` makes the animation."""
    with RunReader(folder) as run:
        summary, provenance = run.summary, run.provenance
        shown = film(folder, FILM_CYCLES * run.cycle_s if run.is_driven else run.end_s)
        drawings = chain(
            [("cost", draw_cost(summary["wall_by_part_s"]))], draw_results(results), draw_machine(run)
        )
        return fill_template(
            "output/report/template.html",
            case=run.case,
            summary=summary,
            provenance=provenance,
            results=results,
            facts={
                "machine": list(tables.machine_facts(run)),
                "bed": list(tables.bed_facts(run.case)),
                "how it was computed": list(tables.solver_facts(run.case, summary["stability"]["scheme"])),
            },
            headline=headline(results),
            not_steady=NOT_STEADY,
            driven=run.is_driven,
            warnings=collect_warnings(folder, summary, results),
            sheets=_sheets(results),
            pictures={name: embedded(drawn) for name, drawn in drawings},
            film=shown,
            film_uri=data_uri(shown.content, "image/webp"),
            left_out=list(tables.left_out_rows(summary)),
            quality=quality_rows(summary),
            duration=duration,
            interval=interval,
            number=number,
        )


def _sheets(results: dict[str, Any]) -> dict[str, tables.Sheet]:
    sheets, whole = {}, 1.0 / results["share_of_width"]
    if "screening" in results:
        sheets["screening"] = tables.screening_sheet(results["screening"], whole)
        if results["screening"]["sections"]:
            sheets["sections"] = tables.sections_sheet(results["screening"])
    if "bed" in results:
        sheets["bed"] = tables.bed_sheet(results, whole)
    if "wear" in results:
        sheets["wear"] = tables.wear_sheet(results["wear"])
    motion = results.get("motion", {})
    if motion.get("frames"):
        sheets["frames"] = tables.frames_sheet(motion)
    if motion.get("panels"):
        sheets["panels"] = tables.panels_sheet(motion, whole)
    if motion.get("panel_points"):
        sheets["accelerations"] = tables.accelerations_sheet(motion)
    return sheets
