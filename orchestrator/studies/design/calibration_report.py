"""What a calibration says: a table, sentences and a picture."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from rich.table import Table

from orchestrator.studies.design.calibration import Calibration
from orchestrator.workbench import Picture, StudyFolder
from orchestrator.workbench.vocabulary import Cell, console_table

DRAWN = 3000  # settings, drawn by their probability
BINS = 30


def write_calibration(found: Calibration, folder: Path) -> Iterator[Path]:
    """Write the factors with their intervals, and the picture; yield the files."""
    folder.mkdir(parents=True, exist_ok=True)
    rows: list[dict[str, Cell]] = [
        {
            "factor": each.name,
            "unit": each.unit,
            "likeliest": each.likeliest,
            "low": each.low,
            "high": each.high,
            "is_found": each.is_found,
        }
        for each in found.factors()
    ]
    yield StudyFolder(folder).write_csv("calibration.csv", rows)
    yield _draw(found).save(folder / "calibration.png")


def tell(found: Calibration) -> Iterator[str | Table]:
    """Yield the table of factors, and what the targets do not tell."""
    percent = f"{100 * found.confidence:.0f} %"
    rows = [
        [
            each.name,
            each.unit,
            f"{each.likeliest:.4g}",
            f"{each.low:.4g} to {each.high:.4g}",
            "yes" if each.is_found else "no",
        ]
        for each in found.factors()
    ]
    yield console_table("", ["factor", "unit", "likeliest", percent, "found"], rows, left=["factor", "unit"])
    for first, second, correlation in found.bound_pairs():
        way = "fall" if correlation < 0 else "rise"
        yield (
            f"{first} and {second} are known together: where one rises, the other may {way} "
            f"(correlation {correlation:.2f})"
        )
    for each in found.factors():
        if not each.is_found:
            yield (
                f"{each.name} is not found: the targets leave more than half of its range; measure something "
                "else that it changes"
            )
    if misses := found.missed():
        yield f"no setting within the ranges meets all targets; missed: {', '.join(misses)}"


def _draw(found: Calibration) -> Picture:
    """Return the picture: the probability of each factor, and of each pair, over their ranges."""
    names = found.sought
    pairs = list(itertools.combinations(range(len(names)), 2))
    picture = Picture(len(names) + len(pairs), 3 if len(names) > 1 else 1, 3.4, 2.8)
    rng = np.random.default_rng(1)
    columns = [list(found.ranges).index(name) for name in names]
    x = found.x[rng.choice(len(found.x), DRAWN, p=found.weight)][:, columns]
    ranges = [found.ranges[name] for name in names]
    labels = [f"{name} / {unit}" if unit else name for name, (_, _, unit) in zip(names, ranges, strict=True)]
    ends = [(low, high) for low, high, _ in ranges]
    for part, column in zip(picture.parts, range(len(names)), strict=False):
        part.hist(x[:, column], BINS, ends[column], density=True, color=Picture.colours[0])
        part.axvline(found.likeliest[names[column]], color="black", linewidth=1)
        part.set(xlabel=labels[column], ylabel="probability density", xlim=ends[column])
    for part, (i, j) in zip(picture.parts[len(names) :], pairs, strict=True):
        part.plot(x[:, i], x[:, j], ".", markersize=2, alpha=0.3, color=Picture.colours[0])
        part.plot(*(found.likeliest[names[each]] for each in (i, j)), "k+")
        part.set(xlabel=labels[i], ylabel=labels[j], xlim=ends[i], ylim=ends[j])
    return picture
