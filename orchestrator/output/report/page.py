"""The command ``flipflow report``: it writes the page of a run from its folder."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from typing import Any

from jinja2 import UndefinedError

from orchestrator.case.deck.stl import UnreadableSurface
from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.folder import FolderUnusable, admit
from orchestrator.case.file.whole import write_text
from orchestrator.case.tables.case import Case
from orchestrator.coupling.ledger import share_created
from orchestrator.figures.estimate import Estimate
from orchestrator.figures.machine import Orbit
from orchestrator.figures.results import FIGURES, Results
from orchestrator.output import checkpoints
from orchestrator.output.records.run_folder import HISTORY, PAGE, SUMMARY, is_at_work
from orchestrator.output.report import facts
from orchestrator.output.report.corners import range_lines
from orchestrator.output.report.errors import about_errors, error_of
from orchestrator.output.report.formatting import duration, interval, number, whole_number
from orchestrator.output.report.headline import NOT_STEADY, headline
from orchestrator.output.report.pictures import draw_cost, draw_machine, draw_results
from orchestrator.output.results.compute import compute_results
from orchestrator.output.results.run_reader import RunReader, cut_size_m
from orchestrator.output.subprocesses import python
from orchestrator.preflight.scene.scene import scene
from orchestrator.preflight.sheet.sheet import RULE
from orchestrator.views.drawings import SIDE, draw_view
from orchestrator.views.mats import draw_mats
from orchestrator.views.outline import outline
from orchestrator.views.style import data_uri, embed, fill_template
from orchestrator.views.worker import worker

FILM_CYCLES = 3
MATS = "mats-"  # before the names of pictures of how mats flip
NEEDED = ("case.toml", SUMMARY, "provenance.json", HISTORY)
DAMAGED = (ValueError, TypeError, IndexError, AttributeError, RuntimeError, UndefinedError)


def report(folder: Path) -> Path:
    """Write the page of a run and return its path.

    Raises FolderUnusable if ``folder`` holds no run, or a run that cannot be read.
    """
    missing = [name for name in NEEDED if not (folder / name).is_file()]
    if not folder.is_dir():
        raise FolderUnusable(f"{folder}: no such folder")
    admit(folder)
    if missing == [SUMMARY]:
        raise FolderUnusable(f"{folder}: {why_open(folder)}")
    if missing:
        raise FolderUnusable(f"{folder}: no run, or a damaged one: it has no {', '.join(missing)}")
    with worker() as apart:  # HDF5 crashes on some damaged files
        try:
            return apart.submit(_write_page, folder).result()
        except BrokenProcessPool:
            raise FolderUnusable(
                f"{folder}: reading history.h5 crashed: it is damaged, or memory ran out"
            ) from None


def why_open(folder: Path) -> str:
    """Return a message about why the run has no summary, with advice."""
    if is_at_work(folder):
        return "the run is still going on"
    killed = "the run was killed before it could close its books"
    save = checkpoints.find_newest(folder)
    if save is None:
        return f"{killed}, and nothing had been saved; run the case again"
    return (
        f"{killed}; `flipflow resume {folder}` goes on from t = {save.simulated_s:g} s, where it "
        f"was saved, or closes them there with --set duration_s={save.simulated_s:.12g}"
    )


def _write_page(folder: Path) -> Path:
    """Write the page and return its path.  Raises FolderUnusable if a file of the run cannot be used."""
    try:
        write_text(folder / PAGE, page(folder, compute_results(folder), make_film))
    except CaseError as error:
        raise FolderUnusable(f"{folder}: its case cannot be read\n{error}") from None
    except KeyError as error:
        raise FolderUnusable(
            f"{folder}: there is no {error} in its files: the run was made by another version of "
            "flipflow; run the case again"
        ) from error
    except DAMAGED as error:
        raise FolderUnusable(
            f"{folder}: something in its files is damaged, or of another version of flipflow "
            f"({type(error).__name__}: {error})"
        ) from error
    except OSError as error:
        raise FolderUnusable(f"{folder}: {error}") from None
    return folder / PAGE


def _draw_side(case: Case, folder: Path) -> Iterator[tuple[str, Any]]:
    """Yield the side view of the whole machine; nothing if the run's folder lacks a surface's file."""
    with suppress(UnreadableSurface):
        yield "side", draw_view(outline(case.whole_machine, folder), SIDE)


@dataclass(frozen=True)
class Film:
    """An animated WebP of ``frames`` pictures; it is empty, with the ``reason``, if rendering failed."""

    content: bytes
    frames: int = 0
    start_s: float = 0.0
    end_s: float = 0.0
    reason: str = ""


def make_film(folder: Path, lasting_s: float) -> Film:
    """Return the film of the last ``lasting_s`` seconds of the run.

    A process of its own renders the film, so that a crash of the renderer loses nothing.
    """
    with tempfile.TemporaryDirectory() as place:
        file = Path(place) / "film.webp"
        words = ("orchestrator.output.report.rendering", str(folder), str(lasting_s), str(file))
        process = python("-m", *words, alone=True, capture_output=True)
        if process.returncode or not file.is_file():
            why = process.stderr.strip().splitlines()[-1:] or ["the renderer ended without a word"]
            return Film(b"", reason=why[0])
        frames, start_s, end_s = process.stdout.split()
        return Film(file.read_bytes(), int(frames), float(start_s), float(end_s))


def label(path: str) -> str:
    """Return the words and the shown unit of a figure by its path below ``results``."""
    return FIGURES[f"results.{path}"].label


def shown(path: str, value: Any) -> str:
    """Return a figure as people read it, by its path below ``results``: a number or an estimate."""
    scale = FIGURES[f"results.{path}"].shown_scale
    return interval(value, scale) if isinstance(value, Estimate) else number(value, scale)


def columns(place: str, names: Sequence[str]) -> list[str]:
    """Return the labels of figures of a table by its path below ``results``, which ends with a dot."""
    return [label(f"{place}{name}") for name in names]


def amplitude_of(orbit: Orbit, axis: int) -> str:
    """Return the amplitude of an orbit along an axis, in mm."""
    width_m = None if orbit.half_width_m is None else float(orbit.half_width_m[axis])
    return interval(Estimate(float(orbit.amplitude_m[axis]), width_m), 1e3)


def page(folder: Path, results: Results, film: Callable[[Path, float], Film]) -> str:
    """Return the HTML of a run's report from its ``results``; the function ``film`` makes the film."""
    whole = results.of_the_whole_width
    with RunReader(folder) as run:
        summary = run.summary
        animation = film(folder, FILM_CYCLES * run.cycle_s if run.is_driven else run.end_s)
        cost = ("cost", draw_cost(summary["wall_by_part_s"]))
        drawings = chain(
            [cost],
            draw_results(whole),
            draw_machine(run),
            _draw_side(run.case, folder),
            ((f"{MATS}{name}", fig) for name, fig in draw_mats(scene(run.case.whole_machine))),
        )
        return fill_template(
            "output/report/template.html",
            case=run.case,
            summary=summary,
            provenance=run.provenance,
            results=whole,
            label=label,
            shown=shown,
            columns=columns,
            amplitude_of=amplitude_of,
            machine=list(facts.machine_facts(run)),
            sheet=facts.sheet_lines(run),
            rule=RULE,
            describe_sizes=facts.describe_sizes,
            cut_size_m=results.screening.cut_size_m if results.screening else cut_size_m(run.case),
            headline=headline(results),
            error_of=lambda tile: error_of(summary, tile.path),
            about_errors=about_errors(summary),
            not_steady=NOT_STEADY,
            driven=run.is_driven,
            ranges=range_lines(folder, run.judged, results),
            warnings=facts.collect_warnings(folder, summary, results),
            pictures={name: embed(fig) for name, fig in drawings},
            mats=MATS,
            film=animation,
            film_uri=data_uri(animation.content, "image/webp"),
            left_out=list(facts.left_out_facts(summary)),
            share_created=share_created,
            duration=duration,
            interval=interval,
            number=number,
            whole_number=whole_number,
        )
