"""The headline figures of a run, each with the data behind it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from orchestrator.case.scalars import COHORT, WHOLE_FEED
from orchestrator.output.report.formatting import NONE, interval, number

NOT_STEADY = "not steady yet"
HEIGHT = "height below which 95 % of the material lies, mean along the deck"
RECOVERY = "fine_placement_percent"
SAME_POINTS = 0.05  # of per cent: a recovery of undersize this near to the efficiency is the same figure
T_PER_H = 3.6  # in 1 kg/s
EFFICIENCY = "screening efficiency η"
COMPUTED = ", computed sizes alone"
"""The end of the names of figures without the sizes that a feed leaves out."""
UNKNOWN = "unknown"
"""The value of a figure that a run cannot give; its reason is told in its place."""
SCREENING = {  # name, unit, and the kind of particles that are counted
    "efficiency_percent": (EFFICIENCY, "%", "particles"),
    "fine_placement_percent": ("undersize recovery", "%", "fine particles"),
    "recovered_percent": ("fines recovered, of what came in", "%", "fine particles"),
    "oversize_yield_percent": ("oversize yield", "%", "particles"),
}


@dataclass(frozen=True)
class Tile:
    """A figure with its unit.

    ``interval`` is the half width of its confidence interval, or empty.  ``over`` names the particles, cycles
    and seconds behind the figure; ``unsteady`` is True if it comes from a transient.  ``also`` is the value
    in another unit, or empty.  Where the value is ``UNKNOWN``, ``over`` says why.
    """

    name: str
    value: str
    interval: str
    unit: str
    over: str
    unsteady: bool
    also: str = ""

    @property
    def line(self) -> str:
        """The figure in one line, for a terminal."""
        width = f" ± {self.interval}" if self.interval else ""
        if self.value == UNKNOWN:
            return f"{self.name}: {UNKNOWN} ({self.over})"
        also = f" = {self.also}" if self.also else ""
        return f"{self.name}: {self.value}{width} {self.unit}{also} (over {self.over})"


def headline(results: dict[str, Any]) -> list[Tile]:
    """Return a tile for each figure that has a value in the results of a run."""
    tiles = [*_material_tiles(results), *_motion_tiles(results)] if results else []
    return [tile for tile in tiles if tile.value != NONE]


def headline_lines(results: dict[str, Any]) -> Iterator[str]:
    """Yield the headline's figures for a terminal: the steady ones, why others are not, and these."""
    tiles = headline(results)
    yield from (tile.line for tile in tiles if not tile.unsteady)
    yield from reasons_not_steady(results)
    if unsteady := [tile for tile in tiles if tile.unsteady]:
        yield f"{NOT_STEADY}:"
        yield from (f"  {tile.line}" for tile in unsteady)


def reasons_not_steady(results: dict[str, Any]) -> Iterator[str]:
    """Yield a sentence that says why the bed is not steady, and one why the machine has not settled."""
    state, motion = results.get("steady"), results.get("motion")
    if state and not state["is_steady"]:
        yield f"No steady state: {state['reason']}. Bed and screening figures are transient."
    if motion and motion["cycles"] and not motion["is_settled"]:
        yield f"The machine has not settled: {motion['reason']}."


def _material_tiles(results: dict[str, Any]) -> Iterator[Tile]:
    """Yield the figures of screening and bed; masses are scaled to the full width of the deck."""
    (whole, of_width), state = _scale_to_width(results), results.get("steady")
    lasting = _describe_window(state) if state else "the whole run"
    unsteady = not (state and state["is_steady"])
    screening, bed = results.get("screening", {}), results.get("bed")
    whole_feed, missing = screening.get("whole_feed"), results.get("missing", {})
    cohort = screening.get("cohort")
    told_of = _describe_cohort(cohort) if cohort else lasting
    why_not = missing.get(COHORT) or missing.get(WHOLE_FEED, "")
    if whole_feed:
        over = f"{_describe_continuation(whole_feed)}, {told_of}"
        yield _tile(EFFICIENCY, whole_feed["efficiency_percent"], "%", over, unsteady)
    elif why_not:
        yield Tile(EFFICIENCY, UNKNOWN, "", "", why_not, unsteady=False)
    computed = COMPUTED if whole_feed or WHOLE_FEED in missing else ""
    for key in (key for key in SCREENING if key in (cohort or {})):
        title, unit, _ = SCREENING[key]
        yield _tile(title + computed, cohort[key], unit, told_of, unsteady)
    for key, (title, unit, kind) in SCREENING.items() if not (cohort or COHORT in missing) else ():
        if key in screening and not (key == RECOVERY and _is_efficiency(screening)):
            name = title + computed
            left = f"{screening[kind.replace(' ', '_')]} {kind} that left, "
            yield _tile(name, screening[key], unit, left + lasting, unsteady)
    if feed := screening.get("feed_kg_per_s"):
        tile = _tile(f"feed{of_width}", feed, "t/h", lasting, unsteady, T_PER_H * whole)
        yield replace(tile, also=f"{number(feed['value'], whole)} kg/s")
    if bed:
        over = f"{bed['particles']:.3g} particles at {bed['output_times']} output times, {lasting}"
        yield _tile("material velocity", bed["velocity_m_per_s"], "m/s", over, unsteady)
        yield _tile(f"mass on the deck{of_width}", bed["on_deck_kg"], "kg", over, unsteady, whole)
        yield _tile("load per area of the deck", bed["load_kg_per_m2"], "kg/m²", over, unsteady)
        yield _tile(HEIGHT, bed["mean_depth_m"], "mm", over, unsteady, 1e3)


def _describe_cohort(cohort: dict[str, Any]) -> str:
    """Return which grains tell the separation of a run that is not steady."""
    return f"{cohort['particles']} particles that were fed until {number(cohort['fed_until_s'])} s"


def _describe_continuation(whole_feed: dict[str, Any]) -> str:
    """Return what the partition curve adds, how far it is continued, and by what it is wrong there."""
    computed_mm, listed_mm = (1e3 * whole_feed[key] for key in ("smallest_computed_m", "smallest_m"))
    has_interval = whole_feed["efficiency_percent"]["half_width"] is not None
    return (
        f"{whole_feed['left_out_percent']:.3g} % of the feed by the partition curve, continued from "
        f"{computed_mm:.3g} to {listed_mm:.3g} mm; "
        f"{'the interval has the error of that, some' if has_interval else 'the error of that is some'} "
        f"{abs(whole_feed['continuation']['error_percent']):.2g} points"
    )


def _scale_to_width(results: dict[str, Any]) -> tuple[float, str]:
    """Return the full width over that of the slice, and words for what is scaled by it.

    The words are empty without a slice.
    """
    share = float(results["share_of_width"])
    return 1.0 / share, ", of the whole width" if share < 1.0 else ""


def _is_efficiency(screening: dict[str, Any]) -> bool:
    """Return whether the undersize recovery is the efficiency, as it is where no coarse particle passes."""
    recovery, efficiency = (screening[key]["value"] for key in (RECOVERY, "efficiency_percent"))
    return None not in (recovery, efficiency) and abs(recovery - efficiency) <= SAME_POINTS


def _motion_tiles(results: dict[str, Any]) -> Iterator[Tile]:
    """Yield the figures of frames, panels and drives; the power is scaled to the full width of the deck."""
    motion = results.get("motion")
    if motion is None:
        return
    over, unsteady = _describe_window(motion), not motion["is_settled"]
    for name, orbit in motion["relative"].items():
        yield _tile(f"relative amplitude {name}, along", orbit["along_m"], "mm", over, unsteady, 1e3)
    for name, speed_rad_per_s in motion.get("shafts_rad_per_s", {}).items():
        yield Tile(f"speed of the shaft {name}", number(speed_rad_per_s), "", "rad/s", over, unsteady)
    whole, of_width = _scale_to_width(results)
    if ground := motion.get("ground"):
        for axis, name in (("x", "horizontal"), ("z", "vertical")):
            what = f"force of the bushings on the ground, {name} amplitude{of_width}"
            yield _tile(what, ground["amplitude_N"][axis], "kN", over, unsteady, 1e-3 * whole)
    if points := motion["panel_points"]:
        name = max(points, key=lambda name: points[name]["cycle_peak_g"]["value"] or 0.0)
        part = "cycle" if motion["cycles"] else "fiftieth of the run"
        for what, key in (
            (f"mean peak of a {part}", "cycle_peak_g"),
            (f"mean peak of a {part} below 100 Hz", "cycle_peak_100_Hz_g"),
            ("RMS", "rms_g"),
        ):
            yield _tile(f"panel acceleration at {name}, {what}", points[name][key], "g", over, unsteady)
    arched = [panel["turns_up_share"] for panel in motion["panels"].values()]
    if any(arched):
        share = number(max(up for up in arched if up is not None), 100)
        yield Tile("turns in which a mat arches up, at most", share, "", "%", over, unsteady)
    stretched = [panel["stretch_largest_percent"] for panel in motion["panels"].values()]
    yield Tile("largest panel stretch", number(max(stretched, default=None)), "", "%", over, unsteady)
    power = results.get("power")
    if power and "drives_W" in power:
        state = results.get("steady")
        filling = state is not None and not state["is_steady"]
        name = f"power of the drives{of_width}"
        yield _tile(name, power["drives_W"], "kW", over, unsteady or filling, 1e-3 * whole)


def _describe_window(window: dict[str, Any]) -> str:
    """Return the length of a window, such as "6 cycles, 0.48 s"; without a drive there are no cycles."""
    cycles, lasting_s = window["cycles"], window["end_s"] - window["start_s"]
    counted = f"{cycles} cycle{'' if cycles == 1 else 's'}, " if cycles else ""
    return f"{counted}{number(lasting_s)} s"


def _tile(
    name: str, estimate: dict[str, Any], unit: str, over: str, unsteady: bool, scale: float = 1.0
) -> Tile:
    value, _, width = interval(estimate, scale).partition(" ± ")
    if why := estimate.get("reason"):
        over += f"; {why}"
    return Tile(name, value, width, unit, over, unsteady)
