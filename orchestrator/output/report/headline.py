"""The figures that a reader looks for first, each with what it was taken from."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from orchestrator.output.report.formatting import NONE, interval, number

NOT_STEADY = "not steady yet"


@dataclass(frozen=True)
class Tile:
    """A figure with its unit.  ``interval`` is its half width, or empty; ``over`` says over how
    many particles, cycles and seconds it was taken, ``unsteady`` that it is no lasting value."""

    name: str
    value: str
    interval: str
    unit: str
    over: str
    unsteady: bool

    @property
    def basis(self) -> str:
        """What it was taken from, and whether it will last."""
        return f"over {self.over}" + (f"; {NOT_STEADY}" if self.unsteady else "")

    @property
    def line(self) -> str:
        """All of it in one line, for a terminal."""
        width = f" ± {self.interval}" if self.interval else ""
        return f"{self.name}: {self.value}{width} {self.unit} ({self.basis})"


def headline(results: dict[str, Any]) -> list[Tile]:
    """Returns a tile for each figure for which the results of a run have a value."""
    tiles = [*_screening(results), *_bed(results), *_motion(results)]
    return [tile for tile in tiles if tile.value != NONE]


def _screening(results: dict[str, Any]) -> Iterator[Tile]:
    screening = results.get("screening", {})
    kinds = {
        "efficiency_percent": ("screening efficiency η", "%", "particles"),
        "fine_placement_percent": ("undersize recovery", "%", "fine_particles"),
        "recovered_percent": ("fines recovered, of what came in", "%", "fine_particles"),
        "oversize_yield_percent": ("oversize yield", "%", "particles"),
        "feed_kg_per_s": ("feed", "kg/s", ""),
    }
    for key, (name, unit, counted) in kinds.items():
        if key in screening:
            scale = _whole(results) if unit == "kg/s" else 1.0
            kind = "fine particles" if counted == "fine_particles" else "particles"
            left = f"{screening[counted]} {kind} that left, " if counted else ""
            yield _tile(name, screening[key], unit, *_balanced(results, left), scale)


def _bed(results: dict[str, Any]) -> Iterator[Tile]:
    if "bed" not in results:
        return
    bed = results["bed"]
    there = f"{bed['particles']:.3g} particles at {bed['output_times']} output times, "
    basis = _balanced(results, there)
    yield _tile("material velocity", bed["velocity_m_per_s"], "m/s", *basis)
    yield _tile("mass on the deck", bed["on_deck_kg"], "kg", *basis, _whole(results))
    yield _tile("largest bed depth", bed["largest_depth_m"], "mm", *basis, 1e3)


def _motion(results: dict[str, Any]) -> Iterator[Tile]:
    motion = results.get("motion")
    if motion is None:
        return
    over = _lasting(motion["cycles"], motion["end_s"] - motion["start_s"])
    basis = over, not motion["is_settled"]
    for name, orbit in motion["relative"].items():
        yield _tile(f"relative amplitude {name}, along", orbit["along_m"], "mm", *basis, 1e3)
    peaks = [point["peak_g"] for point in motion["panel_points"].values()]
    if peaks:
        yield Tile("peak panel acceleration", number(max(peaks)), "", "g", *basis)
    stretches = [panel["stretch_largest_percent"] for panel in motion["panels"].values()]
    if stretches:
        yield Tile("largest panel stretch", number(max(stretches)), "", "%", *basis)


def _balanced(results: dict[str, Any], counted: str) -> tuple[str, bool]:
    """What a figure of the bed was taken from, and whether it was not steady."""
    state = results.get("steady")
    if state is None:
        return f"{counted}the whole run", True
    lasting = _lasting(state["cycles"], state["end_s"] - state["start_s"])
    return counted + lasting, not state["is_steady"]


def _lasting(cycles: int, seconds: float) -> str:
    """ "6 cycles, 0.48 s"; a machine that nothing drives has no cycles."""
    counted = f"{cycles} cycle{'' if cycles == 1 else 's'}, " if cycles else ""
    return f"{counted}{number(seconds)} s"


def _whole(results: dict[str, Any]) -> float:
    """Full width over that of the slice."""
    return 1.0 / float(results["share_of_width"])


def _tile(
    name: str, estimate: dict[str, Any], unit: str, over: str, unsteady: bool, scale: float = 1.0
) -> Tile:
    value, _, width = interval(estimate, scale).partition(" ± ")
    return Tile(name, value, width, unit, over, unsteady)
