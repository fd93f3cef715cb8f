"""The figures that are watched: their limits, what is done beyond them, and what was seen."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from orchestrator.case.tables.numerics import MonitorSettings, Then
from orchestrator.ports import Saved
from orchestrator.ports.state import put_back, taken

# key of [monitor]: key of its limit, and what there is to say beyond it
WATCHED = {
    "created_energy": (
        "largest_created_share",
        "the coupling creates or destroys energy between {where}: {value:.2g} of what went through "
        "in the last intervals",
    ),
    "created_in_total": (
        "largest_created_in_total",
        "the coupling has created or destroyed energy ({where}): {value:.2g} of all that went "
        "through or was lost there",
    ),
    "growing_modes": (
        "largest_growing_share",
        "a mode of the interface grows: a point alternates from interval to interval with "
        "{value:.2g} of the surface's largest speed so far",
    ),
    "stretched_panels": ("largest_stretch", "panel {where} is stretched by {value:.2g} of its length"),
    "penetrated_surfaces": (
        "largest_penetration",
        "panel {where} by {value:.3g} of its thickness, and nothing holds it there: tighten it, "
        "move one of them, or give the panel a stop",
    ),
    "deep_overlaps": (
        "largest_overlap",
        "particles overlap by {value:.2g} of a radius: contacts too soft or steps too long",
    ),
    "crossed_surface": (
        "most_crossings",
        "{value:.0f} times a particle went through the surface, its centre to the other side, the "
        "first time {where}: contacts too soft (particles.largest_youngs_modulus_Pa) or steps too "
        "long",
    ),
    "long_steps": ("largest_step_share", "{where} moves in a particle step by {value:.2g} of a radius"),
}


@dataclass(frozen=True)
class Alarm:
    """A figure beyond its limit.  ``what`` says it in words, ``new`` if for the first time."""

    then: Then
    what: str
    new: bool


class Figure:
    """``worst`` is its largest value, ``times`` how often it was beyond the limit, ``first_s`` when
    first."""

    def __init__(self, then: Then, limit: float, limit_key: str, words: str) -> None:
        """``words`` have places for ``value`` and ``where``."""
        self._then, self._limit, self._limit_key, self._words = then, limit, limit_key, words
        self._worst, self._times, self._first_s = 0.0, 0, 0.0

    def look(self, value: float, time_s: float, where: str = "") -> Alarm | None:
        """At the figure's value at this moment."""
        self._worst = max(self._worst, value)
        if value <= self._limit:
            return None
        self._times += 1
        if self._times == 1:
            self._first_s = time_s
        said = self._words.format(value=value, where=where)
        what = f"t = {time_s:.6g} s: {said} (monitor.{self._limit_key} = {self._limit:g})"
        return Alarm(self._then, what, self._times == 1)

    def as_json(self) -> dict[str, Any]:
        first_s = self._first_s if self._times else None
        return {"worst": self._worst, "limit": self._limit, "times": self._times, "first_s": first_s}

    def save(self) -> Saved:
        return taken(self, "_worst", "_times", "_first_s")

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, "_worst", "_times", "_first_s")


class Figures:
    """All of them; collects the alarms until they are taken."""

    def __init__(self, wanted: MonitorSettings) -> None:
        self._figures = {
            key: Figure(getattr(wanted, key), getattr(wanted, limit), limit, words)
            for key, (limit, words) in WATCHED.items()
        }
        self._alarms: list[Alarm] = []

    def look(self, key: str, value: float, time_s: float, where: str = "") -> None:
        alarm = self._figures[key].look(value, time_s, where)
        if alarm is not None:
            self._alarms.append(alarm)

    def alarms(self) -> list[Alarm]:
        """Those since this was last asked."""
        since, self._alarms = self._alarms, []
        return since

    def as_json(self) -> dict[str, Any]:
        return {key: figure.as_json() for key, figure in self._figures.items()}

    def save(self) -> Saved:
        return {key: figure.save() for key, figure in self._figures.items()}

    def restore(self, saved: Saved) -> None:
        for key, figure in self._figures.items():
            figure.restore(saved[key])
