"""The deck seen from the side: a line of panels, with a station along it and heights over it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array

UP = np.array([0.0, 0.0, 1.0])
LARGEST_OVERLAP = 0.2  # of the shortest panel: clamps may overlap a little, decks do wholly


@dataclass(frozen=True)
class DeckLine:
    """Panels one behind the other, as they lie at t = 0.

    ``panels``: their order along the deck and whether each centre line runs along it;
    ``along`` (3,) the horizontal direction of flow; ``over_m`` (points,) places along it at t = 0,
    rising, ``level_m`` (points,) the height there, and ``station_m`` (points,) the distance along
    the deck, 0 at its first point.
    """

    panels: tuple[tuple[int, bool], ...]
    along: Array
    over_m: Array
    level_m: Array
    station_m: Array

    @property
    def length_m(self) -> float:
        """From the first panel's first point to the last one's last, along the deck."""
        return float(self.station_m[-1])


def deck_line(centre_lines: Sequence[Array]) -> DeckLine | None:
    """The line of a deck, from the panels' centre lines (points, 3) at t = 0.

    None where panels do not follow one another when seen from above: decks above each other,
    a panel that stands upright, no panel at all.
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
    return DeckLine(panels, along, over_m, level_m, np.concatenate([[0.0], np.cumsum(steps)]))


def join_lines(panels: tuple[tuple[int, bool], ...], lines: Sequence[Any]) -> Any:
    """One line from all panels' centre lines (arrays with a row for each point), in the order of
    ``DeckLine.panels``."""
    return np.concatenate([lines[i] if forth else lines[i][::-1] for i, forth in panels])


def _flow(centre_lines: Sequence[Array], middles: list[Array]) -> Array | None:
    """Horizontal unit vector along which the panels follow one another, downhill if they slope."""
    if len(middles) > 1:
        spread = np.array(middles) - np.mean(middles, axis=0)
        chord = np.linalg.svd(spread[:, :2])[2][0]
        chord = np.array([chord[0], chord[1], 0.0])
    else:
        chord = centre_lines[0][-1] - centre_lines[0][0]
        chord = chord - (chord @ UP) * UP
    if (size := float(np.linalg.norm(chord))) < 1e-9:
        return None
    along = np.asarray(chord / size)
    first, last = centre_lines[0][0], centre_lines[-1][-1]
    down = (last - first) @ along * -(last - first)[2]  # > 0: towards ``along`` is downhill
    ahead = (last - first) @ along if abs((last - first)[2]) < 1e-9 else down
    return along if ahead > 0 else -along


@dataclass(frozen=True)
class Over:
    """Points seen from the deck as it is at one moment.

    ``station_m`` (n,) in the panels' material, ``height_m`` (n,) normal to the surface, negative
    below; ``rise_m_per_s`` (n,) the surface's own speed along its normal; ``inside`` (n,) whether
    the point is between the deck's two ends.
    """

    station_m: Array
    height_m: Array
    rise_m_per_s: Array
    inside: npt.NDArray[np.bool_]


def over(deck: DeckLine, line_m: Array, velocity_m_per_s: Array, position_m: Array) -> Over:
    """``line_m``, ``velocity_m_per_s`` (points, 3): the joined line now; ``position_m`` (n, 3)."""
    u = np.maximum.accumulate(line_m @ deck.along)  # where a panel folds, its upper part counts
    z = line_m[:, 2]
    at = position_m @ deck.along
    piece = np.clip(np.searchsorted(u, at) - 1, 0, len(u) - 2)
    run, climb = np.diff(u)[piece], np.diff(z)[piece]
    cosine = run / np.maximum(np.hypot(run, climb), 1e-12)
    sine = climb / np.maximum(np.hypot(run, climb), 1e-12)
    speed_u = np.interp(at, u, velocity_m_per_s @ deck.along)
    speed_z = np.interp(at, u, velocity_m_per_s[:, 2])
    return Over(
        np.interp(at, u, deck.station_m),
        (position_m[:, 2] - np.interp(at, u, z)) * cosine,
        speed_z * cosine - speed_u * sine,
        (at >= u[0]) & (at <= u[-1]),
    )
