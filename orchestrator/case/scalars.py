"""The scalar results of a run: one table defines the meaning of each short name.

A name with dots that is not in the table is a path of keys in ``summary.json``, such as
``results.screening.feed_kg_per_s``.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from statistics import fmean
from typing import TYPE_CHECKING, Any

from orchestrator.case.tables.quantities import unit_along

if TYPE_CHECKING:
    from orchestrator.case.tables.case import Case

Summary = Mapping[str, Any]
WHOLE_FEED = "whole feed"
"""The entry of ``results.missing`` that says why the sizes that a feed leaves out could not be completed."""
COHORT = "cohort"
"""The entry of ``results.missing`` that says why a run that is not steady does not tell the separation."""


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


@dataclass(frozen=True)
class Scalar:
    """A result of a run.

    ``words`` describe it and give its unit.  A run does not resolve values below ``floor``.  ``of``
    takes the value from a summary and returns None where the run does not have it.  ``part`` is the
    part of the machine that the result describes; "" if its path does not tell.
    """

    words: str
    floor: float
    of: Callable[[Summary], Value | None]
    part: str = ""

    @property
    def unit(self) -> str:
        """Its unit; "1" of a pure number."""
        _, told, unit = self.words.rpartition(" / ")
        return unit.strip("()") if told else unit_along(self.words.split("."))


def _inner(table: Any, path: str) -> Any:
    """Return the entry at a path of keys with dots; None where there is no such entry."""
    for word in path.split("."):
        if isinstance(table, Mapping):
            table = table.get(word)
        elif isinstance(table, list) and word.isdecimal() and int(word) < len(table):
            table = table[int(word)]
        else:
            return None
    return table


def _number(entry: Any) -> Value | None:
    """Return the value of a number or of an estimate, {"value", "half_width", ...}; else None."""
    told: Mapping[str, float | None] = {}
    if isinstance(entry, Mapping) and "value" in entry:
        told, entry = entry, entry["value"]
    if isinstance(entry, bool) or not isinstance(entry, int | float) or not math.isfinite(entry):
        return None
    return Value(float(entry), told.get("half_width"), told.get("counting"), told.get("standard_error"))


def _at(path: str) -> Callable[[Summary], Value | None]:
    """Return a function that takes the number at a path from a summary."""
    return lambda summary: _number(_inner(summary, path))


def _all(summary: Summary, table: str, key: str) -> list[Value]:
    """Return the numbers that the entries of a table have at ``key``."""
    numbers = [_number(_inner(entry, key)) for entry in (_inner(summary, table) or {}).values()]
    return [number for number in numbers if number is not None]


def _largest(table: str, key: str) -> Callable[[Summary], Value | None]:
    """Return a function that takes the largest number of the entries of a table from a summary."""
    return lambda summary: max(_all(summary, table, key), key=lambda number: number.value, default=None)


def _mean(table: str, key: str) -> Callable[[Summary], Value | None]:
    """Return a function that takes the mean number of the entries of a table from a summary.

    The half width of the mean is the mean of their half widths, which is an upper bound.
    """

    def mean(summary: Summary) -> Value | None:
        values = _all(summary, table, key)
        if not values:
            return None
        widths = [number.half_width for number in values if number.half_width is not None]
        half_width = fmean(widths) if len(widths) == len(values) else None
        return Value(fmean(number.value for number in values), half_width)

    return mean


def _of_the_whole_width(take: Callable[[Summary], Value | None]) -> Callable[[Summary], Value | None]:
    """Return a function that scales a number of a slice to the whole width, as the report does."""

    def scaled(summary: Summary) -> Value | None:
        value, share = take(summary), _inner(summary, "results.share_of_width")
        if value is None or not share:
            return value
        sizes = (value.half_width, value.counting, value.standard_error)
        return Value(value.value / share, *(size and size / share for size in sizes))

    return scaled


def _stroke(summary: Summary) -> Value | None:
    """Return the stroke of two frames against each other; for a single frame, its own amplitude."""
    relative = _largest("results.motion.relative", "along_m")(summary)
    return relative or _largest("results.motion.frames", "amplitude_m.0")(summary)


def _efficiency(summary: Summary) -> Value | None:
    """Return the efficiency of the whole feed; None where sizes are left out that no curve completes."""
    if _inner(summary, "results.screening.whole_feed") is not None:
        return _at("results.screening.whole_feed.efficiency_percent")(summary)
    if {WHOLE_FEED, COHORT} & {*(_inner(summary, "results.missing") or {})}:
        return None
    return _computed_efficiency(summary)


def _computed_efficiency(summary: Summary) -> Value | None:
    """Return the efficiency of the sizes that are computed: of a run that is not steady, that of the grains
    that were fed so early that nearly all have left; None if there are none."""
    if COHORT in (_inner(summary, "results.missing") or {}):
        return None
    cohort = _at("results.screening.cohort.efficiency_percent")(summary)
    return cohort or _at("results.screening.efficiency_percent")(summary)


def _middle(summary: Summary) -> Value | None:
    """Return the half range of the probe that moves most of all probes on panels."""
    names = _inner(summary, "results.motion.panel_points") or {}
    half_ranges_m = [_inner(summary, f"probes.{name}.half_range_m") for name in names]
    sizes_m = [math.hypot(*vector) for vector in half_ranges_m if vector and None not in vector]
    return Value(max(sizes_m)) if sizes_m else None


_FRAMES, _PANELS, _POINTS = (f"results.motion.{table}" for table in ("frames", "panels", "panel_points"))
_ROWS: dict[str, dict[str, tuple[str, float, Callable[[Summary], Value | None]]]] = {
    "frames": {
        "stroke": ("amplitude of the frames against each other along the deck / m", 1e-6, _stroke),
        "frame_amplitude": (
            "largest amplitude of a frame or a probe on it, in the plane of the deck's length / m",
            1e-6,
            _largest(_FRAMES, "major_m"),
        ),
        "power": (
            "mean power of the drives, of the whole width / W",
            1e-3,
            _of_the_whole_width(_at("results.power.drives_W")),
        ),
        "work_per_feed": (
            "work of the drives over the mass fed / (J/kg)",
            1e-3,
            _at("results.power.drives_J_per_kg"),
        ),
    },
    "panels": {
        "middle_half_range": (
            "largest half range of a probe on a panel, its clamps' motion included / m",
            1e-6,
            _middle,
        ),
        "rms_g": (
            "acceleration, mean of the probes on panels, root mean square / g",
            1e-3,
            _mean(_POINTS, "rms_g"),
        ),
        "cycle_peak_g": (
            "acceleration, mean of the probes on panels, peak in a cycle / g",
            1e-2,
            _mean(_POINTS, "cycle_peak_g"),
        ),
        "cycle_peak_100_Hz_g": (
            "acceleration below 100 Hz, mean of the probes on panels, peak in a cycle / g",
            1e-2,
            _mean(_POINTS, "cycle_peak_100_Hz_g"),
        ),
        "turns_up": (
            "largest share of turns in which a panel arches up",
            1e-2,
            _largest(_PANELS, "turns_up_share"),
        ),
        "tension": (
            "mean pull of the panels on their clamps, of the whole width / N",
            1e-2,
            _of_the_whole_width(_mean(_PANELS, "tension_mean_N")),
        ),
        "peak_tension": (
            "largest pull of a panel on its clamps, of the whole width / N",
            1e-1,
            _of_the_whole_width(_largest(_PANELS, "tension_largest_N")),
        ),
        "wear": (
            "largest depth worn off a panel / (m/h)",
            1e-12,
            _largest("results.wear.panels", "largest_m_per_h"),
        ),
        "stretch": ("largest stretch of a panel / %", 1e-3, _largest(_PANELS, "stretch_largest_percent")),
    },
    "particles": {
        "efficiency": ("screening efficiency of the whole feed / %", 0.1, _efficiency),
        "computed_efficiency": (
            "screening efficiency of the sizes that are computed / %",
            0.1,
            _computed_efficiency,
        ),
        "recovery": (
            "fines that passed, of those that came / %",
            0.1,
            _at("results.screening.recovered_percent"),
        ),
        "undersize": (
            "undersize of the whole width / (kg/s)",
            1e-6,
            _of_the_whole_width(_at("results.screening.undersize_kg_per_s")),
        ),
        "oversize": (
            "oversize of the whole width / (kg/s)",
            1e-6,
            _of_the_whole_width(_at("results.screening.oversize_kg_per_s")),
        ),
        "fines_stay": (
            "time over the deck of the fines that go over its end / s",
            1e-3,
            _at("results.contacts.stay_s"),
        ),
        "contact_rate": (
            "contacts of a fine particle with the open mat / (1/s)",
            1e-2,
            _at("results.contacts.contacts_per_s"),
        ),
        "within_reach": (
            "time of the fines within reach of the mat / %",
            1e-2,
            _at("results.contacts.within_reach_percent"),
        ),
        "contact_chance": (
            "chance of a fine particle to pass in a contact / %",
            0.1,
            _at("results.contacts.chance_percent"),
        ),
        "passing_rate": ("rate at which fines pass / (1/s)", 1e-3, _at("results.contacts.rate_per_s")),
        "velocity": ("speed of the bed along the deck / (m/s)", 1e-3, _at("results.bed.velocity_m_per_s")),
        "on_deck": (
            "mass on the deck, of the whole width / kg",
            1e-6,
            _of_the_whole_width(_at("results.bed.on_deck_kg")),
        ),
        "depth": ("largest depth of the bed / m", 1e-4, _at("results.bed.largest_depth_m")),
    },
}
SCALARS = {name: Scalar(*row, part) for part, rows in _ROWS.items() for name, row in rows.items()}


def value_at(summary: Summary, name: str) -> Value | None:
    """Return a number of a run's summary by its short name or its path; None if the run does not have it."""
    return (SCALARS[name].of if name in SCALARS else _at(name))(summary)


def is_of_separation(name: str) -> bool:
    """Return whether a result describes how the screen separates the feed into its products."""
    separated = ("efficiency", "recovery", "undersize", "oversize", "passing_rate", "contact_chance")
    return name in separated or name.startswith(("results.screening.", "results.contacts."))


def is_peak(name: str) -> bool:
    """Return whether a result is a largest value, which a run-up may decide."""
    return name == "stretch" or "peak" in name or "largest" in name


_PARTS = {
    "particles": (
        "material.",
        *(f"results.{table}." for table in ("screening", "contacts", "transport", "bed", "held")),
    ),
    "frames": ("results.motion.frames.", "results.motion.relative.", "results.power."),
    "panels": ("results.motion.panels.", "results.motion.panel_points.", "results.wear."),
}


def part_of(name: str, case: Case) -> str:
    """Return the part of the machine that a result describes: "particles", "panels" or "frames".

    A probe belongs to the part that it is fixed to.  Returns "" if the name does not tell the part.
    """
    if name in SCALARS:
        return SCALARS[name].part
    words = name.split(".")
    if words[0] == "probes" and words[1] in case.probes:
        probe = case.probes[words[1]]
        return "panels" if probe.panel else "frames" if probe.frame else "particles"
    return next((part for part, paths in _PARTS.items() if name.startswith(paths)), "")


def is_of_particles(name: str) -> bool:
    """Return whether a result describes the particles, which differ from run to run by chance."""
    return (name in SCALARS and SCALARS[name].part == "particles") or name.startswith(_PARTS["particles"])


def scalar(name: str) -> Scalar:
    """Return the result with a short name or a path.  Raises KeyError, which suggests a similar name."""
    if name in SCALARS:
        return SCALARS[name]
    if "." in name:
        return Scalar(name, 1e-12, _at(name))
    near = get_close_matches(name, SCALARS, 1)
    hint = f'; did you mean "{near[0]}"?' if near else "."
    raise KeyError(f'no result "{name}"{hint} There are: {", ".join(SCALARS)}')
