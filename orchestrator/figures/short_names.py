"""The short names of results: which figure of which tables each one takes.

A name with dots is a path of keys in ``summary.json``, such as ``results.screening.feed_kg_per_s``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from difflib import get_close_matches
from statistics import fmean
from typing import TYPE_CHECKING, Any

from orchestrator.case.tables.quantities import unit_along
from orchestrator.figures.figure import Figure, Part, in_unit
from orchestrator.figures.results import COHORT, FIGURES, WHOLE_FEED, Summary, entry_at, figure_at

if TYPE_CHECKING:
    from orchestrator.case.tables.case import Case


@dataclass(frozen=True)
class Value:
    """A number with its uncertainty, where the run gives it.

    ``half_width`` is half the width of the 95 % confidence interval over time, and ``standard_error`` the
    standard deviation behind it; ``counting`` is the standard deviation of a share from the number of its
    particles alone.
    """

    value: float
    half_width: float | None = None
    counting: float | None = None
    standard_error: float | None = None

    def times(self, factor: float) -> Value:
        """Return the multiple."""
        sizes = (self.half_width, self.counting, self.standard_error)
        return Value(self.value * factor, *(size and size * factor for size in sizes))


Take = Callable[[Summary], Value | None]


@dataclass(frozen=True)
class Named:
    """A result that has a short name, or a path as its name.

    ``take`` takes the value from a summary as it stands there and returns None where the run does not have
    it.  The value of a slice is scaled to the whole width if it has a short name.
    """

    figure: Figure
    take: Take
    is_short: bool = True

    @property
    def words(self) -> str:
        """What it is, with its unit."""
        whole = ", of the whole width" if self.figure.is_extensive and self.is_short else ""
        return f"{self.figure.words}{whole}{in_unit(self.figure.unit)}"

    def of(self, summary: Summary) -> Value | None:
        """Return the value, with a short name that of the whole width; None where the run has none."""
        value = self.take(summary)
        if value is None or not (self.is_short and self.figure.is_extensive):
            return value
        return value.times(1.0 / (entry_at(summary, "results.share_of_width") or 1.0))


def _number(entry: Any) -> Value | None:
    """Return the value of a number or of an estimate, {"value", "half_width", ...}; else None."""
    told: Mapping[str, float | None] = {}
    if isinstance(entry, Mapping) and "value" in entry:
        told, entry = entry, entry["value"]
    if isinstance(entry, bool) or not isinstance(entry, int | float) or not math.isfinite(entry):
        return None
    return Value(float(entry), told.get("half_width"), told.get("counting"), told.get("standard_error"))


def _at(path: str) -> Take:
    """Return a function that takes the number at a path from a summary."""
    return lambda summary: _number(entry_at(summary, path))


def _all(summary: Summary, path: str) -> list[Value]:
    """Return the numbers at a path in which a * stands for each entry of a table."""
    table, _, key = path.partition(".*.")
    numbers = [_number(entry_at(entry, key)) for entry in (entry_at(summary, table) or {}).values()]
    return [number for number in numbers if number is not None]


def _named(path: str, words: str, take: Take) -> Named:
    """Return the result that is taken from the figures at a path, with words of its own or the figure's."""
    record = FIGURES[f"results.{path}"]
    return Named(replace(record, words=words or record.words), take)


def at(path: str, words: str = "") -> Named:
    """Return the result that is the figure at a path."""
    return _named(path, words, _at(f"results.{path}"))


def largest(path: str, words: str) -> Named:
    """Return the largest of the figures at a path with a *."""

    def take(summary: Summary) -> Value | None:
        return max(_all(summary, f"results.{path}"), key=lambda number: number.value, default=None)

    return _named(path, words, take)


def mean(path: str, words: str) -> Named:
    """Return the mean of the figures at a path with a *.

    Its half width is the mean of their half widths, which is an upper bound.
    """

    def take(summary: Summary) -> Value | None:
        values = _all(summary, f"results.{path}")
        if not values:
            return None
        widths = [number.half_width for number in values if number.half_width is not None]
        half_width = fmean(widths) if len(widths) == len(values) else None
        return Value(fmean(number.value for number in values), half_width)

    return _named(path, words, take)


STROKE = largest("motion.relative.*.along_m", "amplitude of the frames against each other along the deck")


def _stroke(summary: Summary) -> Value | None:
    """Return the stroke of two frames against each other; for a single frame, its own amplitude."""
    if relative := STROKE.take(summary):
        return relative
    return max(
        _all(summary, "results.motion.frames.*.amplitude_m.0"), key=lambda number: number.value, default=None
    )


def _efficiency(summary: Summary) -> Value | None:
    """Return the efficiency of the whole feed; None where sizes are left out that no curve completes."""
    if entry_at(summary, "results.screening.whole_feed") is not None:
        return _at("results.screening.whole_feed.efficiency_percent")(summary)
    if {WHOLE_FEED, COHORT} & {*(entry_at(summary, "results.missing") or {})}:
        return None
    return _computed_efficiency(summary)


def _computed_efficiency(summary: Summary) -> Value | None:
    """Return the efficiency of the sizes that are computed: of a run that is not steady, that of the grains
    that were fed so early that nearly all have left; None if there are none."""
    if COHORT in (entry_at(summary, "results.missing") or {}):
        return None
    cohort = _at("results.screening.cohort.efficiency_percent")(summary)
    return cohort or _at("results.screening.efficiency_percent")(summary)


def _middle(summary: Summary) -> Value | None:
    """Return the half range of the probe that moves most of all probes on panels."""
    names = entry_at(summary, "results.motion.panel_points") or {}
    half_ranges_m = [entry_at(summary, f"probes.{name}.half_range_m") for name in names]
    sizes_m = [math.hypot(*vector) for vector in half_ranges_m if vector and None not in vector]
    return Value(max(sizes_m)) if sizes_m else None


_POINTS = "acceleration, mean of the probes on panels"
SHORT_NAMES = {
    "stroke": replace(STROKE, take=_stroke),
    "frame_amplitude": largest(
        "motion.frames.*.major_m",
        "largest amplitude of a frame or a probe on it, in the plane of the deck's length",
    ),
    "power": at("power.drives_W"),
    "work_per_feed": at("power.drives_J_per_kg"),
    "middle_half_range": Named(
        Figure(
            "largest half range of a probe on a panel, its clamps' motion included",
            resolution=1e-6,
            part="panels",
            path="probes.*.half_range_m",
        ),
        _middle,
    ),
    "rms_g": mean("motion.panel_points.*.rms_g", f"{_POINTS}, root mean square"),
    "cycle_peak_g": mean("motion.panel_points.*.cycle_peak_g", f"{_POINTS}, peak in a cycle"),
    "cycle_peak_100_Hz_g": mean(
        "motion.panel_points.*.cycle_peak_100_Hz_g", f"{_POINTS} below 100 Hz, peak in a cycle"
    ),
    "turns_up": largest(
        "motion.panels.*.turns_up_share", "largest share of turns in which a panel arches up"
    ),
    "tension": mean("motion.panels.*.tension_mean_N", "mean pull of the panels on their clamps"),
    "peak_tension": largest("motion.panels.*.tension_largest_N", "largest pull of a panel on its clamps"),
    "wear": largest("wear.panels.*.largest_m_per_h", "largest depth worn off a panel"),
    "stretch": largest("motion.panels.*.stretch_largest_percent", "largest stretch of a panel"),
    "efficiency": replace(
        at("screening.whole_feed.efficiency_percent", "screening efficiency of the whole feed"),
        take=_efficiency,
    ),
    "computed_efficiency": replace(
        at("screening.efficiency_percent", "screening efficiency of the sizes that are computed"),
        take=_computed_efficiency,
    ),
    "recovery": at("screening.recovered_percent", "fines that passed, of those that came"),
    "undersize": at("screening.undersize_kg_per_s"),
    "oversize": at("screening.oversize_kg_per_s"),
    "fines_stay": at("contacts.stay_s"),
    "contact_rate": at("contacts.contacts_per_s"),
    "within_reach": at("contacts.within_reach_percent"),
    "contact_chance": at("contacts.chance_percent"),
    "passing_rate": at("contacts.rate_per_s"),
    "velocity": at("bed.velocity_m_per_s", "speed of the bed along the deck"),
    "on_deck": at("bed.on_deck_kg"),
    "depth": at("bed.largest_depth_m"),
}


def named(name: str) -> Named:
    """Return the result with a short name or a path.  Raises KeyError, which suggests a similar name."""
    if name in SHORT_NAMES:
        return SHORT_NAMES[name]
    if "." in name:
        record = figure_at(name) or Figure(name, resolution=1e-12, path=name)
        return Named(record, _at(name), is_short=False)
    near = get_close_matches(name, SHORT_NAMES, 1)
    hint = f'; did you mean "{near[0]}"?' if near else "."
    raise KeyError(f'no result "{name}"{hint} There are: {", ".join(SHORT_NAMES)}')


def value_at(summary: Summary, name: str) -> Value | None:
    """Return a number of a run's summary by its short name or its path; None if the run does not have it."""
    return (SHORT_NAMES[name].of if name in SHORT_NAMES else _at(name))(summary)


def unit_at(name: str) -> str:
    """Return the unit of a number of a run's summary by its short name or its path; "1" of a pure number."""
    return SHORT_NAMES[name].figure.unit if name in SHORT_NAMES else unit_along(name.split("."))


def is_of_separation(name: str) -> bool:
    """Return whether a result describes how the screen separates the feed into its products."""
    path = named(name).figure.path
    return path.startswith(("results.screening.", "results.contacts."))


def part_of(name: str, case: Case) -> Part:
    """Return the part of the machine that a result describes.

    A probe belongs to the part that it is fixed to, and what the run counts of its material to the particles.
    Returns "" if the name does not tell the part.
    """
    words = name.split(".")
    if words[0] == "probes" and words[1] in case.probes:
        probe = case.probes[words[1]]
        return "panels" if probe.panel else "frames" if probe.frame else "particles"
    return "particles" if words[0] == "material" else named(name).figure.part
