"""The page of a comparison of runs: tables, overlaid plots, and the runs' pictures side by side."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.folder import FolderUnusable
from orchestrator.output.records.run_folder import write_page
from orchestrator.output.report.formatting import NONE
from orchestrator.output.report.formatting import interval as in_words
from orchestrator.output.results.comparison import Comparison
from orchestrator.output.results.run_reader import RunReader
from orchestrator.output.results.tidy import Result
from orchestrator.views.style import LINES, WIDE, data_uri, embed, figure, fill_template

BESIDE = {
    "The deck at the end": "deck.png",
    "Panels in the last cycle": "panel_shapes.png",
    "Frames": "frame_motion.png",
    "Energy": "energy.png",
}
"""Pictures in the folders of runs that are shown side by side, by their titles on the page."""


def write_comparison(comparison: Comparison, file: Path) -> Path:
    """Write the page of a comparison, and return the file.

    Raises FolderUnusable if a file of a run is damaged or the page cannot be written.
    """
    try:
        write_page(file, comparison_page(comparison))
    except OSError as error:
        raise FolderUnusable(f"{file}: cannot be written: {error.strerror or error}") from None
    return file


def comparison_page(comparison: Comparison) -> str:
    """Return the HTML of a comparison, which needs no other file.  Raises FolderUnusable."""
    with ExitStack() as opened:
        readers = [opened.enter_context(RunReader(run.folder)) for run in comparison.runs]
        try:
            overlaid = {name: embed(fig) for name, fig in _draw(comparison, readers)}
        except (KeyError, ValueError, TypeError, CaseError, OSError) as error:
            names = ", ".join(str(run.folder) for run in comparison.runs)
            raise FolderUnusable(f"{names}: something in their files is damaged ({error})") from None
    return fill_template(
        "output/report/comparison.html",
        comparison=comparison,
        colours=[_colour(number) for number in range(len(comparison.runs))],
        overlaid=overlaid,
        beside=_pictures_beside(comparison),
        interval=interval,
        change=change,
    )


def interval(result: Result | None) -> str:
    """Return a result with its interval as text; "–" for None."""
    return in_words(result)


def change(share: float | None) -> str:
    """Return a relative change in per cent, with its sign; "–" for None."""
    return NONE if share is None else f"{100 * share:+.3g} %".replace("-", "−")


def _colour(number: int) -> str:
    return LINES[number % len(LINES)]


def _pictures_beside(comparison: Comparison) -> dict[str, list[tuple[str, str]]]:
    """Return the pictures that two or more runs have: by title, the name and the picture of each run."""
    beside = {}
    for title, name in BESIDE.items():
        files = [run.folder / name for run in comparison.runs]
        if sum(file.is_file() for file in files) > 1:
            pictures = [data_uri(f.read_bytes(), "image/png") if f.is_file() else "" for f in files]
            beside[title] = [*zip(comparison.names, pictures, strict=True)]
    return beside


def _draw(comparison: Comparison, readers: Sequence[RunReader]) -> Iterator[tuple[str, Any]]:
    """Yield the name and the figure of each overlaid plot for which two or more runs have data."""
    short = [row for row in comparison.results if row.is_short]
    if rows := [row for row in short if any(share is not None for share in row.changes()[1:])]:
        yield "changes", _draw_changes(comparison, rows)
    drawings: dict[str, tuple[Callable[[RunReader], bool], Callable[..., Any]]] = {
        "orbits of the frames in the last cycle": (lambda run: run.has("frames"), _draw_orbits),
        "mass on the deck over time": (lambda run: run.has("bed/mass_kg"), _draw_mass),
        "bed along the deck": (lambda run: run.results.bed is not None, _draw_profile),
    }
    for name, (has, draw) in drawings.items():
        pairs = [
            (number, label, run)
            for number, (label, run) in enumerate(zip(comparison.names, readers, strict=True))
            if has(run)
        ]
        if len(pairs) > 1:
            yield name, draw(pairs)


def _draw_changes(comparison: Comparison, rows: Sequence[Any]) -> Any:
    """Draw the relative changes of ``rows``, results with short names, from the first run, with intervals."""
    fig, ((axes,),) = figure(1, 1, WIDE, 0.9 + 0.3 * len(rows))
    offsets = np.linspace(-0.2, 0.2, len(comparison.runs) - 1) if len(comparison.runs) > 2 else [0.0]
    for run, offset in enumerate(offsets, start=1):
        label: str | None = comparison.names[run]
        for place, row in enumerate(rows):
            share, other, first = row.changes()[run], row.results[run], row.results[0]
            if share is None:
                continue
            widths = [result.half_width or 0.0 for result in (first, other)]
            width = 100 * math.hypot(*widths) / abs(first.value)
            style = {"fmt": "o", "ms": 5, "capsize": 3, "color": _colour(run), "label": label}
            axes.errorbar(100 * share, place + offset, xerr=width or None, **style)
            label = None  # one entry of the legend for each run
    axes.axvline(0, color=_colour(0), lw=1.2)
    axes.set_yticks(range(len(rows)), [row.name for row in rows])
    axes.invert_yaxis()
    axes.set(xlabel=f"change from {comparison.names[0]} / %, with the interval of the difference")
    axes.legend(fontsize=8)
    return fig


def _draw_orbits(runs: Sequence[tuple[int, str, RunReader]]) -> Any:
    """Draw the orbit of each frame in the last cycle, in deck axes, about its mean."""
    frames = dict.fromkeys(name for _, _, run in runs for name in run.names("frames"))
    fig, (row,) = figure(1, len(frames), WIDE, 3.6)
    for axes, frame in zip(row, frames, strict=True):
        for number, label, run in runs:
            if not run.has(f"frames/{frame}"):
                continue
            end_s = float(run.series_s()[-1])
            moved_m = run.read_between(f"frames/{frame}", "displacement_m", end_s - run.cycle_s, end_s)
            orbit_mm = 1e3 * (moved_m - moved_m.mean(axis=0)) @ run.deck_axes
            axes.plot(orbit_mm[:, 0], orbit_mm[:, 2], color=_colour(number), label=label)
        axes.set(title=frame, xlabel="along the deck / mm", ylabel="normal / mm")
        axes.set_aspect("equal", "datalim")
    row[0].legend(fontsize=8)
    return fig


def _draw_mass(runs: Sequence[tuple[int, str, RunReader]]) -> Any:
    fig, ((axes,),) = figure(1, 1, WIDE, 3.0)
    for number, label, run in runs:
        time_s, mass_kg = run.read("bed/time_s"), run.read("bed/mass_kg") / run.share_of_width
        axes.plot(time_s, mass_kg, color=_colour(number), label=label)
    axes.set(
        xlabel="time / s", ylabel="mass of the particles / kg", title="mass of the bed, of the whole width"
    )
    axes.set_ylim(bottom=0)
    axes.legend(fontsize=8)
    return fig


def _draw_profile(runs: Sequence[tuple[int, str, RunReader]]) -> Any:
    fig, ((axes,),) = figure(1, 1, WIDE, 3.0)
    for number, label, run in runs:
        if bed := run.results.bed:
            depth_mm = 1e3 * bed.profile.depth_m
            axes.plot(bed.profile.along_m, depth_mm, "o-", ms=3, color=_colour(number), label=label)
    axes.set(
        xlabel="distance along the deck / m",
        ylabel="95 % lies below / mm",
        title="height of the bed along the deck",
    )
    axes.set_ylim(bottom=0)
    axes.legend(fontsize=8)
    return fig
