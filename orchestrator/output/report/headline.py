"""The headline figures of a run, each with the data behind it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from orchestrator.output.report.formatting import NONE, interval, number

NOT_STEADY = "not steady yet"
SCREENING = {  # name, unit, and the kind of particles that are counted
    "efficiency_percent": ("screening efficiency η", "%", "particles"),
    "fine_placement_percent": ("undersize recovery", "%", "fine particles"),
    "recovered_percent": ("fines recovered, of what came in", "%", "fine particles"),
    "oversize_yield_percent": ("oversize yield", "%", "particles"),
    "feed_kg_per_s": ("feed", "kg/s", ""),
}


@dataclass(frozen=True)
class Tile:
    """A figure with its unit.

    ``interval`` is the half width of its confidence interval, or empty.  ``over`` names the particles, cycles
    and seconds behind the figure; ``unsteady`` is True if it comes from a transient.
    """

    name: str
    value: str
    interval: str
    unit: str
    over: str
    unsteady: bool

    @property
    def line(self) -> str:
        """The figure in one line, for a terminal."""
        width = f" ± {self.interval}" if self.interval else ""
        basis = f"over {self.over}" + (f"; {NOT_STEADY}" if self.unsteady else "")
        return f"{self.name}: {self.value}{width} {self.unit} ({basis})"


def headline(results: dict[str, Any]) -> list[Tile]:
    """Return a tile for each figure that has a value in the results of a run."""
    tiles = [*_material_tiles(results), *_motion_tiles(results)] if results else []
    return [tile for tile in tiles if tile.value != NONE]


def _material_tiles(results: dict[str, Any]) -> Iterator[Tile]:
    """Yield the figures of screening and bed; masses are scaled to the full width of the deck."""
    whole, state = 1.0 / float(results["share_of_width"]), results.get("steady")
    lasting = _describe_window(state) if state else "the whole run"
    unsteady = not (state and state["is_steady"])
    screening, bed = results.get("screening", {}), results.get("bed")
    for key, (name, unit, kind) in SCREENING.items():
        if key in screening:
            left = f"{screening[kind.replace(' ', '_')]} {kind} that left, " if kind else ""
            scale = whole if unit == "kg/s" else 1.0
            yield _tile(name, screening[key], unit, left + lasting, unsteady, scale)
    if whole_feed := screening.get("whole_feed"):
        over = (
            f"{whole_feed['left_out_percent']:.3g} % of the feed by the continued partition curve, {lasting}"
        )
        yield _tile("efficiency of the whole feed", whole_feed["efficiency_percent"], "%", over, unsteady)
    if bed:
        over = f"{bed['particles']:.3g} particles at {bed['output_times']} output times, {lasting}"
        yield _tile("material velocity", bed["velocity_m_per_s"], "m/s", over, unsteady)
        yield _tile("mass on the deck", bed["on_deck_kg"], "kg", over, unsteady, whole)
        yield _tile("largest bed depth", bed["largest_depth_m"], "mm", over, unsteady, 1e3)


def _motion_tiles(results: dict[str, Any]) -> Iterator[Tile]:
    motion = results.get("motion")
    if motion is None:
        return
    over, unsteady = _describe_window(motion), not motion["is_settled"]
    for name, orbit in motion["relative"].items():
        yield _tile(f"relative amplitude {name}, along", orbit["along_m"], "mm", over, unsteady, 1e3)
    largest = (
        ("peak panel acceleration", "panel_points", "peak_g", "g"),
        ("largest panel stretch", "panels", "stretch_largest_percent", "%"),
    )
    for name, table, key, unit in largest:
        value = max((entry[key] for entry in motion[table].values()), default=None)
        yield Tile(name, number(value), "", unit, over, unsteady)


def _describe_window(window: dict[str, Any]) -> str:
    """Return the length of a window, such as "6 cycles, 0.48 s"; without a drive there are no cycles."""
    cycles, lasting_s = window["cycles"], window["end_s"] - window["start_s"]
    counted = f"{cycles} cycle{'' if cycles == 1 else 's'}, " if cycles else ""
    return f"{counted}{number(lasting_s)} s"


def _tile(
    name: str, estimate: dict[str, Any], unit: str, over: str, unsteady: bool, scale: float = 1.0
) -> Tile:
    value, _, width = interval(estimate, scale).partition(" ± ")
    return Tile(name, value, width, unit, over, unsteady)
