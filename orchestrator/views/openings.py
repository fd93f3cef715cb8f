"""The openings' pattern of each kind of panel, to scale, with a particle of each size."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from matplotlib.collections import PolyCollection
from matplotlib.patches import Circle, Polygon

from orchestrator.case.bed.size_distribution import classes
from orchestrator.case.deck.panels import SinglePanel, perforated_panels
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.ports import Array
from orchestrator.ports.geometry import AperturePattern
from orchestrator.views.style import LINES, figure

PITCHES = 4.6  # of the pattern along the panel that are shown
ACROSS = 0.4  # of the length shown: the width shown, but at least as many pitches
WIDTH_IN, LARGEST_ROWS = 9.0, 8
PANEL, EDGE, CLAMP = "#dcb84a", "#8f6a0f", "#333333"


def draw_openings(case: Case) -> Iterator[tuple[str, Any]]:
    """Yield the name and the figure of each kind of panel that has openings."""
    for panel, *others in perforated_panels(case):
        yield panel.name, _draw(case, panel, len(others) + 1)


def sizes_m(case: Case) -> list[float]:
    """Return single sizes and the limits of all size classes and of carried particles, in order of size.

    At most ``LARGEST_ROWS`` of them are left, among them the smallest and the largest.
    """
    if not has_particles(case):
        return []
    limits = {row.sieve_size_m for row in case.bed.particles.values()}
    for source in case.bed.sources:
        for size in classes(source):
            limits |= {size.smallest_m, size.largest_m}
    if (carried := case.bed.carried) is not None and len(carried):
        own_m = carried.grains.sieve_size_m
        limits |= {float(own_m.min()), float(own_m.max())}
    ordered = sorted(limits)
    if len(ordered) <= LARGEST_ROWS:
        return ordered
    return [ordered[i] for i in np.unique(np.linspace(0, len(ordered) - 1, LARGEST_ROWS).round().astype(int))]


def _draw(case: Case, panel: SinglePanel, count: int) -> Any:
    """Return the figure of a corner of the panel with some openings, and the particles beside it."""
    pattern, at = panel.apertures, panel.rectangle
    assert pattern is not None, "only panels with apertures are perforated"
    centres_m = pattern.centres_m(at)
    first_m = centres_m.min(axis=0)
    along_m = min(at.length_m, first_m[0] + PITCHES * pattern.pitch_along_m)
    across_m = min(at.width_m, first_m[1] + max(ACROSS * along_m, PITCHES * pattern.pitch_across_m))
    if pattern.drawn:  # which has more than a corner tells
        along_m, across_m = at.length_m, min(at.width_m, at.length_m)
    shown_sizes_m = sizes_m(case)
    gap_m = 0.06 * along_m
    room_m = (max(shown_sizes_m) + 2 * gap_m) if shown_sizes_m else gap_m
    shown_m = np.array([along_m + at.clamp_m, across_m])
    rows_m = _rows(shown_sizes_m, gap_m)
    tall_m = max(across_m, rows_m[-1][1] + gap_m if rows_m else 0.0) + 0.16 * across_m
    wide_m = shown_m[0] + room_m + 0.35 * along_m
    fig, ((axes,),) = figure(width=WIDTH_IN, height=min(8.0, max(3.0, WIDTH_IN * tall_m / wide_m + 1.0)))
    mm = 1e3
    axes.add_patch(_rectangle(0, along_m, 0, across_m, PANEL))
    if at.clamp_m:
        axes.add_patch(_rectangle(-at.clamp_m, 0, 0, across_m, CLAMP))
        axes.text(
            -at.clamp_m / 2 * mm,
            across_m / 2 * mm,
            "clamp",
            color="white",
            rotation=90,
            ha="center",
            va="center",
            fontsize=8,
        )
    corner_m = [along_m, across_m]
    outlines = [mm * hole_m for hole_m in pattern.outlines_m(at) if (hole_m.min(axis=0) < corner_m).all()]
    openings = PolyCollection(outlines, facecolors="white", edgecolors=EDGE, lw=0.8, zorder=3)
    axes.add_collection(openings)
    shown = _rectangle(0, along_m, 0, across_m, "none")
    axes.add_patch(shown)
    openings.set_clip_path(shown)
    _, limit_m = pattern.spheres_m
    left_m = along_m + gap_m
    for size_m, bottom_m in rows_m:
        passes = size_m < limit_m
        color = LINES[2] if passes else LINES[1]
        middle = (left_m + max(shown_sizes_m) / 2, bottom_m + size_m / 2)
        axes.add_patch(
            Circle((middle[0] * mm, middle[1] * mm), size_m / 2 * mm, fc=color, ec="none", alpha=0.8)
        )
        word = "passes" if passes else "stays"
        axes.text(
            (left_m + max(shown_sizes_m) + gap_m / 2) * mm,
            middle[1] * mm,
            f"{mm * size_m:.3g} mm, {word}",
            va="center",
            fontsize=8.5,
            color=color,
        )
    if not pattern.drawn:
        _dimensions(axes, pattern, first_m, across_m)
    who = f"{panel.name} and {count - 1} more" if count > 1 else panel.name
    open_share = len(centres_m) * pattern.opening_m2 / (at.length_m * at.width_m)
    axes.set_title(f"{who}: {len(centres_m)} {_kind(pattern)}, {open_share:.0%} of the free panel is open")
    axes.set(
        xlim=(-at.clamp_m * mm - 0.02 * wide_m * mm, wide_m * mm - at.clamp_m * mm),
        ylim=(-0.04 * tall_m * mm, tall_m * mm),
        aspect="equal",
        xlabel="along the panel / mm",
        ylabel="across / mm",
    )
    axes.grid(visible=False)
    return fig


def _kind(pattern: AperturePattern) -> str:
    """Return the openings of a pattern in words."""
    if pattern.drawn:
        return f"openings of a drawing, the widest for {1e3 * pattern.spheres_m[1]:.3g} mm"
    return f"{pattern.shape}s of {1e3 * pattern.length_m:g} × {1e3 * pattern.width_m:g} mm"


def _rows(shown_sizes_m: list[float], gap_m: float) -> list[tuple[float, float]]:
    """Return each size with the lower end of its place in a column, from the largest up."""
    rows, bottom_m, line_m = [], 0.0, 0.55 * gap_m
    for size_m in shown_sizes_m[::-1]:
        high_m = max(size_m, line_m)
        rows.append((size_m, bottom_m + (high_m - size_m) / 2))
        bottom_m += high_m + gap_m / 4
    return rows


def _rectangle(x0: float, x1: float, y0: float, y1: float, color: str) -> Polygon:
    corners = 1e3 * np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    return Polygon(corners, fc=color, ec="none", zorder=1)


def _dimensions(axes: Any, pattern: Any, first_m: Array, across_m: float) -> None:
    """Draw the pitch along above the pattern, and the pitch across inside it."""
    mm = 1e3
    props = {"arrowstyle": "<|-|>", "lw": 0.8, "color": "#222222", "shrinkA": 0, "shrinkB": 0}
    top = 1.05 * across_m * mm
    ends = first_m[0] * mm, (first_m[0] + pattern.pitch_along_m) * mm
    axes.annotate("", (ends[1], top), xytext=(ends[0], top), arrowprops=props)
    for x in ends:
        axes.plot([x, x], [first_m[1] * mm, top * 1.01], color="#222222", lw=0.5, zorder=4)
    axes.text(
        sum(ends) / 2,
        top * 1.02,
        f"pitch {mm * pattern.pitch_along_m:g} mm",
        ha="center",
        va="bottom",
        fontsize=8.5,
    )
    edge = (first_m[0] - pattern.length_m / 2) * mm
    x = edge - 0.2 * pattern.pitch_along_m * mm
    rows = first_m[1] * mm, (first_m[1] + pattern.pitch_across_m) * mm
    axes.annotate("", (x, rows[1]), xytext=(x, rows[0]), arrowprops=props, zorder=6)
    for y in rows:
        axes.plot([x, edge], [y, y], color="#222222", lw=0.5, zorder=4)
    axes.text(
        x,
        sum(rows) / 2,
        f"pitch {mm * pattern.pitch_across_m:g} mm  ",
        ha="right",
        va="center",
        fontsize=8.5,
        zorder=7,
    )
