"""Scalar results of a run by short names: the one table that says what each name means.

A name with dots that is not in the table is taken as a path of keys in ``summary.json``, such as
``results.screening.feed_kg_per_s``.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from orchestrator.case.tables.case import Case

Summary = Mapping[str, Any]


@dataclass(frozen=True)
class Value:
    """A number, and half the width of its 95 % confidence interval where the run gives one."""

    value: float
    half_width: float | None = None


@dataclass(frozen=True)
class Scalar:
    """``words`` say what it is, with its unit; ``floor`` is the size below which a value is
    nothing that a run resolves; ``of`` takes it from a summary, None where the run does not have
    it; ``of_particles`` and ``of_panels`` say what a case must have for the question to make
    sense."""

    words: str
    floor: float
    of: Callable[[Summary], Value | None]
    of_particles: bool = False
    of_panels: bool = False


def _inner(table: Any, path: str) -> Any:
    for word in path.split("."):
        if isinstance(table, Mapping):
            table = table.get(word)
        elif isinstance(table, list) and word.isdecimal() and int(word) < len(table):
            table = table[int(word)]
        else:
            return None
    return table


def _number(found: Any) -> Value | None:
    """Of a number or of an estimate, {"value", "half_width", "batches"}."""
    half_width = None
    if isinstance(found, Mapping) and "value" in found:
        found, half_width = found["value"], found.get("half_width")
    if isinstance(found, bool) or not isinstance(found, int | float) or not math.isfinite(found):
        return None
    return Value(float(found), None if half_width is None else float(half_width))


def _at(path: str) -> Callable[[Summary], Value | None]:
    return lambda summary: _number(_inner(summary, path))


def _all(summary: Summary, table: str, key: str) -> Iterator[Value]:
    """A number of every entry of a table."""
    for entry in (_inner(summary, table) or {}).values():
        if (found := _number(_inner(entry, key))) is not None:
            yield found


def _largest(table: str, key: str) -> Callable[[Summary], Value | None]:
    return lambda summary: max(_all(summary, table, key), key=lambda one: one.value, default=None)


def _mean(table: str, key: str) -> Callable[[Summary], Value | None]:
    """Over the entries of a table; its half width is the mean of theirs: an upper bound."""

    def of(summary: Summary) -> Value | None:
        every = list(_all(summary, table, key))
        if not every:
            return None
        widths = [one.half_width for one in every if one.half_width is not None]
        wide = sum(widths) / len(every) if len(widths) == len(every) else None
        return Value(sum(one.value for one in every) / len(every), wide)

    return of


def _stroke(summary: Summary) -> Value | None:
    """Of two frames against each other; of a machine with one frame, its own."""
    found = _largest("results.motion.relative", "along_m")(summary)
    if found is None:
        found = _largest("results.motion.frames", "amplitude_m.0")(summary)
    return found


def _middle(summary: Summary) -> Value | None:
    """Of the probe on a panel that moves most."""
    names = _inner(summary, "results.motion.panel_points") or {}
    found = [_inner(summary, f"probes.{name}.half_range_m") for name in names]
    sizes = [math.hypot(*one) for one in found if one and None not in one]
    return Value(max(sizes)) if sizes else None


SCALARS: dict[str, Scalar] = {
    "stroke": Scalar("amplitude of the frames against each other along the deck / m", 1e-6, _stroke),
    "frame_amplitude": Scalar(
        "largest amplitude of a frame or a probe on it / m",
        1e-6,
        _largest("results.motion.frames", "major_m"),
    ),
    "middle_amplitude": Scalar("largest half range of a probe on a panel / m", 1e-6, _middle, of_panels=True),
    "rms_g": Scalar(
        "acceleration of probes on panels, root mean square / g",
        1e-3,
        _mean("results.motion.panel_points", "rms_g"),
        of_panels=True,
    ),
    "peak_g": Scalar(
        "acceleration of probes on panels, peak in a cycle / g",
        1e-2,
        _mean("results.motion.panel_points", "cycle_peak_g"),
        of_panels=True,
    ),
    "tension": Scalar(
        "mean pull of the panels on their clamps / N",
        1e-2,
        _mean("results.motion.panels", "tension_mean_N"),
        of_panels=True,
    ),
    "peak_tension": Scalar(
        "largest pull of a panel on its clamps / N",
        1e-1,
        _largest("results.motion.panels", "tension_largest_N"),
        of_panels=True,
    ),
    "stretch": Scalar(
        "largest stretch of a panel / %",
        1e-3,
        _largest("results.motion.panels", "stretch_largest_percent"),
        of_panels=True,
    ),
    "efficiency": Scalar("screening efficiency / %", 0.1, _at("results.screening.efficiency_percent"), True),
    "recovery": Scalar(
        "fines that passed, of those that came / %", 0.1, _at("results.screening.recovered_percent"), True
    ),
    "undersize": Scalar("undersize / (kg/s)", 1e-6, _at("results.screening.undersize_kg_per_s"), True),
    "oversize": Scalar("oversize / (kg/s)", 1e-6, _at("results.screening.oversize_kg_per_s"), True),
    "velocity": Scalar(
        "speed of the bed along the deck / (m/s)", 1e-3, _at("results.bed.velocity_m_per_s"), True
    ),
    "on_deck": Scalar("mass on the deck / kg", 1e-6, _at("results.bed.on_deck_kg"), True),
    "depth": Scalar("largest depth of the bed / m", 1e-4, _at("results.bed.largest_depth_m"), True),
}


def value_at(summary: Summary, name: str) -> Value | None:
    """Returns a number of a run's summary by a short name, or by keys with dots; None where the run
    does not have it."""
    return (SCALARS[name].of if name in SCALARS else _at(name))(summary)


def is_of_separation(name: str) -> bool:
    """Whether a result is of what came in and went out."""
    separated = ("efficiency", "recovery", "undersize", "oversize")
    return name in separated or name.startswith("results.screening.")


PARTS_OF_PATHS = {
    "material.": "particles",
    "results.screening.": "particles",
    "results.bed.": "particles",
    "results.motion.frames.": "frames",
    "results.motion.relative.": "frames",
    "results.motion.panels.": "panels",
    "results.motion.panel_points.": "panels",
}


def part_of(name: str, case: Case) -> str:
    """What part of the machine a result is of: "particles", "panels", "frames", or "" where its
    name does not tell.  A probe is of what it is fixed to."""
    if name in SCALARS:
        found = SCALARS[name]
        return "particles" if found.of_particles else "panels" if found.of_panels else "frames"
    words = name.split(".")
    if words[0] == "probes" and words[1] in case.probes:
        probe = case.probes[words[1]]
        return "panels" if probe.panel else "frames" if probe.frame else "particles"
    return next((part for path, part in PARTS_OF_PATHS.items() if name.startswith(path)), "")


def scalar(name: str) -> Scalar:
    """By its short name, or by a path of keys with dots.  Raises KeyError with what is near."""
    if name in SCALARS:
        return SCALARS[name]
    if re.fullmatch(r"probes\..*\.amplitude_m\..*", name):
        new = name.replace(".amplitude_m.", ".half_range_m.")
        raise KeyError(f'"{name}" is half a range, whatever its harmonics, and is called "{new}" now')
    if "." in name:
        return Scalar(name, 1e-12, _at(name))
    near = get_close_matches(name, SCALARS, 1)
    hint = f'; did you mean "{near[0]}"?' if near else ""
    raise KeyError(f'no result "{name}"{hint} There are: {", ".join(SCALARS)}')
