"""The deck seen from the side: a line of panels, with stations along it and heights above it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array

UP = np.array([0.0, 0.0, 1.0])
LARGEST_OVERLAP = 0.2  # Clamps overlap by less than this share of the shortest panel; stacked decks by more.


@dataclass(frozen=True)
class DeckLine:
    """A line of panels one behind the other, as they lie at t = 0.

    ``panels`` lists the panels' numbers in their order along the deck, and whether each centre line
    runs in this direction.  ``along`` (3,) is the horizontal direction of flow.  ``over_m`` (points,)
    are rising places along it, and ``level_m`` (points,) the heights there.  ``station_m`` (points,)
    is the distance along the deck, which is 0 at its first point.  The sides of the panels are
    ``half_depth_m`` (points,) above and below the line.
    """

    panels: tuple[tuple[int, bool], ...]
    along: Array
    over_m: Array
    level_m: Array
    station_m: Array
    half_depth_m: Array

    @property
    def length_m(self) -> float:
        """The length along the deck from the first point of its line to the last point."""
        return float(self.station_m[-1])


def deck_line(centre_lines: Sequence[Array], half_depths_m: Sequence[float] = ()) -> DeckLine | None:
    """Return the line of a deck, given the panels' centre lines (points, 3) at t = 0.

    ``half_depths_m`` (panels,) are half the depths of their openings; by default, none has a depth.
    Returns None unless the panels follow one another when seen from above.  This is the case for decks
    above each other, for a panel that stands upright, and without panels.
    """
    if not centre_lines:
        return None
    middles = [line.mean(axis=0) for line in centre_lines]
    along = _flow(centre_lines, middles)
    if along is None:
        return None
    order = sorted(range(len(middles)), key=lambda i: float(middles[i] @ along))
    forth = [bool((centre_lines[i][-1] - centre_lines[i][0]) @ along > 0) for i in order]
    panels = tuple(zip(order, forth, strict=True))
    line = join_lines(panels, centre_lines)
    over_m, level_m = line @ along, line[:, 2]
    shortest_m = min(abs(float((own[-1] - own[0]) @ along)) for own in centre_lines)
    if (np.diff(over_m) < -LARGEST_OVERLAP * shortest_m).any():
        return None
    over_m = np.maximum.accumulate(over_m)
    steps = np.hypot(np.diff(over_m), np.diff(level_m))
    halves_m = half_depths_m or [0.0] * len(centre_lines)
    half_m = [np.full(len(own), half) for own, half in zip(centre_lines, halves_m, strict=True)]
    station_m = np.concatenate([[0.0], np.cumsum(steps)])
    return DeckLine(panels, along, over_m, level_m, station_m, join_lines(panels, half_m))


def join_lines(panels: tuple[tuple[int, bool], ...], lines: Sequence[Any]) -> Any:
    """Join the panels' lines, arrays with a row for each point, in the order of ``DeckLine.panels``."""
    return np.concatenate([lines[i] if forth else lines[i][::-1] for i, forth in panels])


def _flow(centre_lines: Sequence[Array], middles: list[Array]) -> Array | None:
    """Return the horizontal unit vector along which the panels follow one another, downhill if they slope.

    Returns None for a panel that stands upright.
    """
    if len(middles) > 1:
        spread = np.array(middles) - np.mean(middles, axis=0)
        chord = np.append(np.linalg.svd(spread[:, :2])[2][0], 0.0)
    else:
        chord = centre_lines[0][-1] - centre_lines[0][0]
        chord = chord - (chord @ UP) * UP
    if (size := float(np.linalg.norm(chord))) < 1e-9:
        return None
    along = np.asarray(chord / size)
    first, last = centre_lines[0][0], centre_lines[-1][-1]
    down = (last - first) @ along * -(last - first)[2]  # This is positive if ``along`` points downhill.
    ahead = (last - first) @ along if abs((last - first)[2]) < 1e-9 else down
    return along if ahead > 0 else -along


@dataclass(frozen=True)
class DeckPlaces:
    """The places of points relative to the deck at one moment.

    ``station_m`` (n,) is the station in the panels' material.  ``height_m`` (n,) is measured normal to
    the surface from its upper side, and is negative below it; ``under_m`` (n,) is that from its lower side,
    the same where openings have no depth.  ``normal`` (n, 3) is the surface's normal, and ``rise_m_per_s``
    (n,) its own speed along it.  ``inside`` (n,) says whether the point is between the deck's two ends.
    """

    station_m: Array
    height_m: Array
    under_m: Array
    normal: Array
    rise_m_per_s: Array
    inside: npt.NDArray[np.bool_]


def locate(deck: DeckLine, line_m: Array, velocity_m_per_s: Array, position_m: Array) -> DeckPlaces:
    """Return the places of points (n, 3) relative to the deck.

    ``line_m`` and ``velocity_m_per_s`` (points, 3) are the present positions and velocities of the
    joined line.
    """
    u = np.maximum.accumulate(line_m @ deck.along)  # Where a panel folds, its upper part counts.
    z, at = line_m[:, 2], position_m @ deck.along
    piece = np.clip(np.searchsorted(u, at) - 1, 0, len(u) - 2)
    share = np.clip((at - u[piece]) / np.maximum(np.diff(u), 1e-12)[piece], 0.0, 1.0)

    def on_line(values: Array) -> Array:
        """Return values (points,) of the line between its points, at the places of ``position_m``."""
        return np.asarray(values[piece] + share * np.diff(values)[piece])

    length_m = np.maximum(np.hypot(np.diff(u), np.diff(z)), 1e-12)
    cosine, sine = (np.diff(u) / length_m)[piece], (np.diff(z) / length_m)[piece]
    height_m, half_m = (position_m[:, 2] - on_line(z)) * cosine, deck.half_depth_m[piece]
    speed_u, speed_z = on_line(velocity_m_per_s @ deck.along), on_line(velocity_m_per_s[:, 2])
    return DeckPlaces(
        on_line(deck.station_m),
        height_m - half_m,
        height_m + half_m,
        np.outer(cosine, UP) - np.outer(sine, deck.along),
        speed_z * cosine - speed_u * sine,
        (at >= u[0]) & (at <= u[-1]),
    )
