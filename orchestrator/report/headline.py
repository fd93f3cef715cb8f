"""The figures that a reader looks for first."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from orchestrator.report.words import NONE, interval, number


@dataclass(frozen=True)
class Tile:
    """A figure with its unit; ``interval`` is its half width, or empty."""

    name: str
    value: str
    interval: str
    unit: str


def headline(found: dict[str, Any]) -> list[Tile]:
    """Only what there is."""
    tiles = [*_screening(found), *_bed(found), *_motion(found)]
    return [tile for tile in tiles if tile.value != NONE]


def _screening(found: dict[str, Any]) -> list[Tile]:
    screening = found.get("screening", {})
    kinds = {
        "efficiency_percent": ("screening efficiency η", "%"),
        "fine_placement_percent": ("undersize recovery", "%"),
        "recovered_percent": ("fines recovered, of what came in", "%"),
        "oversize_yield_percent": ("oversize yield", "%"),
        "feed_kg_s": ("feed", "kg/s"),
    }
    return [
        _tile(name, screening[key], unit, _whole(found) if unit == "kg/s" else 1.0)
        for key, (name, unit) in kinds.items()
        if key in screening
    ]


def _bed(found: dict[str, Any]) -> list[Tile]:
    if "bed" not in found:
        return []
    bed = found["bed"]
    return [
        _tile("material velocity", bed["velocity_m_s"], "m/s"),
        _tile("mass on the deck", bed["on_deck_kg"], "kg", _whole(found)),
        _tile("largest bed depth", bed["largest_depth_m"], "mm", 1e3),
    ]


def _motion(found: dict[str, Any]) -> list[Tile]:
    motion = found.get("motion", {})
    tiles = [
        _tile(f"relative amplitude {name}, along", orbit["along_m"], "mm", 1e3)
        for name, orbit in motion.get("relative", {}).items()
    ]
    peaks = [point["peak_g"] for point in motion.get("panel_points", {}).values()]
    if peaks:
        tiles.append(Tile("peak panel acceleration", number(max(peaks)), "", "g"))
    stretches = [panel["stretch_largest_percent"] for panel in motion.get("panels", {}).values()]
    if stretches:
        tiles.append(Tile("largest panel stretch", number(max(stretches)), "", "%"))
    return tiles


def _whole(found: dict[str, Any]) -> float:
    """Full width over that of the slice."""
    return 1.0 / float(found["share_of_width"])


def _tile(name: str, found: dict[str, Any], unit: str, scale: float = 1.0) -> Tile:
    value, _, width = interval(found, scale).partition(" ± ")
    return Tile(name, value, width, unit)
