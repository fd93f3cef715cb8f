"""The placing of labels in a drawing so that none covers another, a symbol or a line."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import Any

import numpy as np

from orchestrator.ports import Array

DISTANCES = np.array([14.0, 24.0, 36.0, 50.0, 66.0, 84.0, 104.0, 128.0, 156.0])
"""Distances, in points, from the labelled place to the label's near edge."""
TURNS = np.pi / 12 * np.array([(n + 1) // 2 * (1 if n % 2 else -1) for n in range(24)])
"""Turns of the direction from the preferred one, in rad."""
PAD = 3.0  # points kept free around a label
COST_OF_TURN, CROSSED, LEADER, COVERED = 4.0, 4.0, 40.0, 400.0
"""Costs in points of distance: of a turn by 1 rad, of a piece of line below the label, of a piece of a leader
below a label, and of a label or symbol that is covered."""
PIECE = 6.0  # pixels
ALONG_LEADER = np.linspace(0.15, 0.85, 8)[:, None]


class Labels:
    """The labels of one drawing, each placed where it covers least, and as near as possible.

    Places are found one after the other, in the order of the calls; the limits of the axes must be final.
    Boxes are (n, 4): left, lower, right and upper edge in pixels.
    """

    def __init__(self, axes: Any, fontsize: float = 8.0) -> None:
        self._axes = axes
        self._fontsize = fontsize
        self._taken = np.empty((0, 4))
        self._lines = np.empty((0, 2))
        self._leaders = np.empty((0, 2))
        axes.apply_aspect()
        self._renderer = axes.figure.canvas.get_renderer()
        self._points = axes.figure.dpi / 72.0
        self._frame = axes.get_window_extent(self._renderer).extents

    def avoid_points(self, places: Array, radius: float = 7.0) -> None:
        """Keep labels away from symbols at places (n, 2) in data, by a radius in points."""
        at, size = self._axes.transData.transform(np.atleast_2d(places)), radius * self._points
        self._taken = np.vstack([self._taken, np.hstack([at - size, at + size])])

    def avoid_lines(self, lines: Sequence[Array]) -> None:
        """Prefer places off lines, each (n, 2) in data."""
        sampled = [self._lines]
        for line in lines:
            for one, two in pairwise(self._axes.transData.transform(np.asarray(line, dtype=float))):
                count = max(2, int(np.hypot(*(two - one)) / PIECE))
                sampled.append(one + np.linspace(0, 1, count)[:, None] * (two - one))
        pieces = np.concatenate(sampled)
        shown = (pieces > self._frame[:2]) & (pieces < self._frame[2:])
        self._lines = pieces[shown.all(axis=1)]

    def avoid_text(self, text: Any) -> None:
        """Keep labels away from a text that is already drawn."""
        self._taken = np.vstack([self._taken, text.get_window_extent(self._renderer).extents])

    def place(self, text: str, at: Sequence[float], color: str = "black", prefer_deg: float = 60.0) -> Any:
        """Write a label for a place (2,) in data, with a thin line to it, and return the annotation.

        Directions near ``prefer_deg`` come first among equally good places.
        """
        size = self._size(text)
        anchor = self._axes.transData.transform(np.asarray(at, dtype=float))
        angle = np.radians(prefer_deg) + TURNS
        ways = np.column_stack([np.cos(angle), np.sin(angle)])
        reach = DISTANCES[:, None, None] * self._points + size / 2
        middles = (anchor + ways * reach).reshape(-1, 2)
        cost = (DISTANCES[:, None] + COST_OF_TURN * np.abs(TURNS)).ravel() + self._cost(anchor, middles, size)
        middle = middles[cost.argmin()]
        self._taken = np.vstack([self._taken, self._boxes(middle[None], size)])
        self._leaders = np.vstack([self._leaders, anchor + ALONG_LEADER * (middle - anchor)])
        return self._axes.annotate(
            text,
            at,
            xytext=(middle - anchor) / self._points,
            textcoords="offset points",
            ha="center",
            va="center",
            fontsize=self._fontsize,
            color=color,
            zorder=20,
            bbox={"boxstyle": "round,pad=0.15", "fc": "white", "ec": "none", "alpha": 0.85},
            arrowprops={"arrowstyle": "-", "lw": 0.6, "color": color, "shrinkA": 0, "shrinkB": 2},
        )

    def _size(self, text: str) -> Array:
        """Return the width and height (2,) of a text in pixels."""
        probe = self._axes.text(0, 0, text, fontsize=self._fontsize, transform=None)
        extent = probe.get_window_extent(self._renderer)
        probe.remove()
        return np.array([extent.width, extent.height])

    def _boxes(self, middles: Array, size: Array) -> Array:
        half = size / 2 + PAD * self._points
        return np.hstack([middles - half, middles + half])

    def _cost(self, anchor: Array, middles: Array, size: Array) -> Array:
        """Return what places (n, 2) cost beside their distance: all that labels and leaders would cover."""
        boxes = self._boxes(middles, size)
        low, high = boxes[:, None, :2], boxes[:, None, 2:]
        covered = ((low < self._taken[:, 2:]) & (high > self._taken[:, :2])).all(axis=2).sum(axis=1)
        outside = (boxes[:, :2] < self._frame[:2]).any(axis=1) | (boxes[:, 2:] > self._frame[2:]).any(axis=1)
        crossed = ((self._lines > low) & (self._lines < high)).all(axis=2).sum(axis=1)
        hidden = ((self._leaders > low) & (self._leaders < high)).all(axis=2).sum(axis=1)
        leaders = anchor + ALONG_LEADER * (middles - anchor)[:, None]
        others = self._taken[~((self._taken[:, :2] < anchor) & (self._taken[:, 2:] > anchor)).all(axis=1)]
        over = (leaders[:, :, None] > others[:, :2]) & (leaders[:, :, None] < others[:, 2:])
        hidden = hidden + over.all(axis=3).any(axis=2).sum(axis=1)
        return np.asarray(COVERED * (covered + outside) + CROSSED * crossed + LEADER * hidden)
