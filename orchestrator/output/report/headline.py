"""The headline figures of a run, each with the data behind it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

from orchestrator.figures.estimate import Estimate
from orchestrator.figures.machine import Motion
from orchestrator.figures.material import CohortShares, Screening, Steady, WholeFeed
from orchestrator.figures.results import COHORT, FIGURES, WHOLE_FEED, Results
from orchestrator.output.report.formatting import NONE, interval, number

NOT_STEADY = "not steady yet"
RECOVERY = "fine_placement_percent"
SAME_POINTS = 0.05  # of per cent: a recovery of undersize this near to the efficiency is the same figure
EFFICIENCY = FIGURES["results.screening.efficiency_percent"]
COMPUTED = ", computed sizes alone"
"""The end of the names of figures without the sizes that a feed leaves out."""
UNKNOWN = "unknown"
"""The value of a figure that a run cannot give; its reason is told in its place."""
SCREENING = {
    "efficiency_percent": "particles",
    RECOVERY: "fine_particles",
    "recovered_percent": "fine_particles",
    "oversize_yield_percent": "particles",
}
"""Figures of screening, with the number of the particles that are counted."""


@dataclass(frozen=True)
class Tile:
    """A figure with its unit.

    ``interval`` is the half width of its confidence interval, or empty.  ``over`` names the particles, cycles
    and seconds behind the figure; ``unsteady`` is True if it comes from a transient.  ``also`` is the value
    in another unit, or empty.  Where the value is ``UNKNOWN``, ``over`` says why.  ``path`` has the keys of
    the figure in ``summary.json``, with a * for the largest of several, and ``estimate`` its value of the
    whole width in SI units; empty and None for a figure without a value of its own.
    """

    name: str
    value: str
    interval: str
    unit: str
    over: str
    unsteady: bool
    also: str = ""
    path: str = ""
    estimate: Estimate | None = None

    @property
    def line(self) -> str:
        """The figure in one line, for a terminal."""
        width = f" ± {self.interval}" if self.interval else ""
        if self.value == UNKNOWN:
            return f"{self.name}: {UNKNOWN} ({self.over})"
        also = f" = {self.also}" if self.also else ""
        return f"{self.name}: {self.value}{width} {self.unit}{also} (over {self.over})"


def headline(results: Results) -> list[Tile]:
    """Return a tile for each figure that has a value in the results of a run; what a slice has a share of is
    told for the whole width."""
    tiles = [*_bulk_tiles(results), *_material_tiles(results), *_motion_tiles(results)]
    return [tile for tile in tiles if tile.value != NONE]


def headline_lines(results: Results) -> Iterator[str]:
    """Yield the headline's figures for a terminal: the steady ones, why others are not, and these."""
    tiles = headline(results)
    yield from (tile.line for tile in tiles if not tile.unsteady)
    yield from reasons_not_steady(results)
    if unsteady := [tile for tile in tiles if tile.unsteady]:
        yield f"{NOT_STEADY}:"
        yield from (f"  {tile.line}" for tile in unsteady)


def reasons_not_steady(results: Results) -> Iterator[str]:
    """Yield a sentence that says why the bed is not steady, and one why the machine has not settled."""
    state, motion = results.steady, results.motion
    if state and not state.is_steady:
        yield f"No steady state: {state.reason}. Bed and screening figures are transient."
    if motion and motion.cycles and not motion.is_settled:
        yield f"The machine has not settled: {motion.reason}."


@dataclass(frozen=True)
class Teller:
    """The maker of tiles from figures over one window; ``share_of_width`` is that of the run."""

    over: str
    unsteady: bool
    share_of_width: float

    def tile(self, path: str, estimate: Estimate | None, words: str = "", name: str = "*") -> Tile:
        """Return the tile of the figure at a path below ``results``, by words of its own or the figure's.

        ``name`` stands in the path for a *; without it the figure is the largest of several.
        """
        figure, over = FIGURES[f"results.{path}"], self.over
        words = words or figure.words
        if estimate and figure.is_extensive and self.share_of_width < 1.0:
            estimate, words = estimate.times(1.0 / self.share_of_width), f"{words}, of the whole width"
        value, _, width = interval(estimate, figure.shown_scale).partition(" ± ")
        if estimate and estimate.reason:
            over += f"; {estimate.reason}"
        place = figure.path.replace("*", name)
        return Tile(
            words, value, width, figure.shown_unit, over, self.unsteady, path=place, estimate=estimate
        )


def _bulk_tiles(results: Results) -> Iterator[Tile]:
    """Yield the density and the slope of the grains in each box of ``[bulk]``."""
    told = Teller("the second half of the run", unsteady=False, share_of_width=results.share_of_width)
    for name, bulk in (results.bulk or {}).items():
        for key in ("density_kg_per_m3", "slope_deg"):
            value, words = getattr(bulk, key), f"{FIGURES[f'results.bulk.*.{key}'].words}, box {name}"
            yield told.tile(f"bulk.*.{key}", None if value is None else Estimate(value), words, name)


def _material_tiles(results: Results) -> Iterator[Tile]:
    """Yield the figures of screening and bed."""
    state, bed, screening = results.steady, results.bed, results.screening
    lasting = _describe_window(state) if state else "the whole run"
    told = Teller(lasting, not (state and state.is_steady), results.share_of_width)
    if screening:
        yield from _screening_tiles(screening, results.missing, told)
        feed = told.tile("screening.feed_kg_per_s", screening.feed_kg_per_s)
        if screening.feed_kg_per_s.value:
            also_kg_per_s = number(screening.feed_kg_per_s.value / results.share_of_width)
            yield replace(feed, also=f"{also_kg_per_s} kg/s")
    if bed:
        over = f"{bed.particles:.3g} particles at {bed.output_times} output times, {lasting}"
        for name in ("velocity_m_per_s", "on_deck_kg", "load_kg_per_m2", "mean_depth_m"):
            yield replace(told, over=over).tile(f"bed.{name}", getattr(bed, name))


def _screening_tiles(screening: Screening, missing: dict[str, str], told: Teller) -> Iterator[Tile]:
    """Yield the efficiency of the whole feed, and the shares of the sizes that are computed."""
    whole_feed, cohort = screening.whole_feed, screening.cohort
    why_not = missing.get(COHORT) or missing.get(WHOLE_FEED, "")
    if whole_feed:
        over = f"{_describe_continuation(whole_feed)}, {_describe_cohort(cohort) if cohort else told.over}"
        path = "screening.whole_feed.efficiency_percent"
        yield replace(told, over=over).tile(path, whole_feed.efficiency_percent)
    elif why_not:
        yield Tile(EFFICIENCY.words, UNKNOWN, "", "", why_not, unsteady=False)
    if COHORT in missing:
        return
    computed = COMPUTED if whole_feed or WHOLE_FEED in missing else ""
    for name, counted in SCREENING.items():
        words = FIGURES[f"results.screening.{name}"].words + computed
        if cohort:
            estimate = getattr(cohort, name, None)
            over = _describe_cohort(cohort)
        else:
            estimate = None if name == RECOVERY and _is_efficiency(screening) else getattr(screening, name)
            over = f"{getattr(screening, counted)} {counted.replace('_', ' ')} that left, {told.over}"
        tile = replace(told, over=over).tile(f"screening.{name}", estimate, words)
        yield replace(tile, path=f"results.screening.cohort.{name}") if cohort else tile


def _describe_cohort(cohort: CohortShares) -> str:
    """Return which grains tell the separation of a run that is not steady."""
    return f"{cohort.particles} particles that were fed until {number(cohort.fed_until_s)} s"


def _describe_continuation(whole_feed: WholeFeed) -> str:
    """Return what the partition curve adds, how far it is continued, and by what it is wrong there."""
    computed_mm, listed_mm = 1e3 * whole_feed.smallest_computed_m, 1e3 * whole_feed.smallest_m
    has_interval = whole_feed.efficiency_percent.half_width is not None
    return (
        f"{whole_feed.left_out_percent:.3g} % of the feed by the partition curve, continued from "
        f"{computed_mm:.3g} to {listed_mm:.3g} mm; "
        f"{'the interval has the error of that, some' if has_interval else 'the error of that is some'} "
        f"{abs(whole_feed.continuation.error_percent):.2g} points"
    )


def _is_efficiency(screening: Screening) -> bool:
    """Return whether the undersize recovery is the efficiency, as it is where no coarse particle passes."""
    recovery, efficiency = screening.fine_placement_percent, screening.efficiency_percent
    if not (recovery and efficiency) or recovery.value is None or efficiency.value is None:
        return False
    return abs(recovery.value - efficiency.value) <= SAME_POINTS


def _motion_tiles(results: Results) -> Iterator[Tile]:
    """Yield the figures of frames, panels and drives."""
    motion, power, state = results.motion, results.power, results.steady
    if motion is None:
        return
    told = Teller(_describe_window(motion), not motion.is_settled, results.share_of_width)
    for name, orbit in motion.relative.items():
        words = f"relative amplitude {name}, along"
        yield told.tile("motion.relative.*.along_m", orbit.along_m, words, name)
    for name, speed_rad_per_s in motion.shafts_rad_per_s.items():
        speed = Estimate(speed_rad_per_s)
        yield told.tile("motion.shafts_rad_per_s.*", speed, f"speed of the shaft {name}", name)
    if ground := motion.ground:
        for axis, name in (("x", "horizontal"), ("z", "vertical")):
            words = f"force of the bushings on the ground, {name} amplitude"
            yield told.tile("motion.ground.amplitude_N.*", ground.amplitude_N[axis], words, axis)
    if points := motion.panel_points:
        name = max(points, key=lambda name: points[name].cycle_peak_g.value or 0.0)
        part = "cycle" if motion.cycles else "fiftieth of the run"
        for key in ("cycle_peak_g", "cycle_peak_100_Hz_g", "rms_g"):
            words = FIGURES[f"results.motion.panel_points.*.{key}"].words.replace("cycle", part)
            words = f"panel acceleration at {name}, {words}"
            yield told.tile(f"motion.panel_points.*.{key}", getattr(points[name], key), words, name)
    arched = [panel.turns_up_share for panel in motion.panels.values()]
    if any(arched):
        share = number(max(up for up in arched if up is not None), 100)
        yield Tile("turns in which a mat arches up, at most", share, "", "%", told.over, told.unsteady)
    stretched = max((panel.stretch_largest_percent for panel in motion.panels.values()), default=None)
    yield told.tile("motion.panels.*.stretch_largest_percent", Estimate(stretched), "largest panel stretch")
    if power and power.drives_W:
        filling = state is not None and not state.is_steady
        unsteady = told.unsteady or filling
        yield replace(told, unsteady=unsteady).tile("power.drives_W", power.drives_W)


def _describe_window(window: Steady | Motion) -> str:
    """Return the length of a window, such as "6 cycles, 0.48 s"; without a drive there are no cycles."""
    cycles, lasting_s = window.cycles, window.end_s - window.start_s
    counted = f"{cycles} cycle{'' if cycles == 1 else 's'}, " if cycles else ""
    return f"{counted}{number(lasting_s)} s"
