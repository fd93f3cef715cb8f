"""All results of a run: the table ``results`` of ``summary.json``."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from pydantic import TypeAdapter, ValidationError

from orchestrator.figures.figure import Figure, every_figure, figure, figure_along, scaled
from orchestrator.figures.machine import Course, Motion, PointRange, Power, Wear
from orchestrator.figures.material import Bed, BulkMean, Contacts, Held, Screening, Steady, Transport

Summary = Mapping[str, Any]
"""The table of ``summary.json``."""
WHOLE_FEED = "whole feed"
"""The entry of ``missing`` that says why the sizes that a feed leaves out could not be completed."""
COHORT = "cohort"
"""The entry of ``missing`` that says why a run that is not steady does not tell the separation."""
BATCH = "nothing is fed: a batch is never steady"
"""The reason of a bed that is not fed."""


@dataclass(kw_only=True)
class Results:
    """The results that a screen's designer needs; a part that the run cannot have is None."""

    missing: dict[str, str] = field(
        default_factory=dict,
        metadata={"figure": Figure("what could not be computed, by name with the reason")},
    )
    failed: dict[str, str] = field(
        default_factory=dict,
        metadata={
            "figure": Figure(
                "parts whose computation failed, by name with the error; the run is then `incomplete`"
            )
        },
    )
    share_of_width: float = field(
        default_factory=lambda: 1.0,
        metadata={
            "figure": Figure(
                "share of the machine's width that was computed",
                ("the summary has the slice's masses, rates, numbers and forces, the page the whole width's"),
            )
        },
    )
    slice_width_m: float | None = figure("width of the slice", optional=True)
    steady: Steady | None = figure("averaged cycles", optional=True)
    screening: Screening | None = figure(
        "feed and the products", "with exits", optional=True, part="particles"
    )
    contacts: Contacts | None = figure(
        "why so much of the fines passes",
        "with exits, below a deck with openings",
        optional=True,
        part="particles",
        is_of_cut=True,
    )
    transport: Transport | None = figure(
        "stay of the oversize, passing of the undersize", optional=True, part="particles"
    )
    bed: Bed | None = figure("bed on the deck", optional=True, part="particles")
    held: Held | None = figure("what the openings hold", optional=True, part="particles")
    bulk: dict[str, BulkMean] | None = figure(
        "grains in each box of `[bulk]`",
        "means over the second half of the run",
        optional=True,
        part="particles",
    )
    wear: Wear | None = figure(
        "wear of the panels", "where contacts have specific wear", optional=True, part="panels"
    )
    power: Power | None = figure(
        "power of the drives and of the losses", "with a drive", optional=True, part="frames"
    )
    motion: Motion | None = figure("motion of the machine", optional=True)
    course: Course | None = figure("stroke and load over the whole run", optional=True)

    @property
    def of_the_whole_width(self) -> Results:
        """The results with masses, rates, numbers, forces and powers multiplied to the full width."""
        whole: Results = scaled(self, 1.0 / self.share_of_width)
        return whole


_PARSED = TypeAdapter(Results)
FIGURES = {each.path: each for each in every_figure(Results, "results")}
"""The records of all figures of results, by path with * for names and numbers."""


def parse_results(summary: Summary) -> Results:
    """Return the results in a summary; empty ones if it has none.  Raises ValueError for a damaged table."""
    try:
        return _PARSED.validate_python(summary.get("results") or {})
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, first["loc"]))
        raise ValueError(f"results.{where}: {first['msg']} ({error.error_count()} such places)") from None


def entry_at(table: Any, path: str) -> Any:
    """Return the entry at a path of keys with dots; None where there is no such entry.  The last key may have
    dots of its own."""
    word, _, rest = path.partition(".")
    if isinstance(table, Mapping):
        inner = table.get(path, table.get(word) if rest else None)
        return inner if path in table or not rest else entry_at(inner, rest)
    if isinstance(table, list) and word.isdecimal() and int(word) < len(table):
        return entry_at(table[int(word)], rest) if rest else table[int(word)]
    return None


def why_transient(summary: Summary) -> tuple[str, str]:
    """Return why a bed that is fed is not steady, and why a machine has not settled; empty if they are."""
    unsteady, unsettled = (
        str(entry_at(summary, f"results.{part}.reason") or "") for part in ("steady", "motion")
    )
    return "" if unsteady == BATCH else unsteady, unsettled  # a batch never could be steady


def orbit_places(summary: Summary) -> dict[str, str]:
    """Return the paths of the first harmonics of frames, of probes on frames, and of pairs of frames, by
    name."""
    return {
        name: f"results.motion.{kind}.{name}"
        for kind in ("frames", "relative")
        for name in entry_at(summary, f"results.motion.{kind}") or {}
    }


def why_no_orbits(summary: Summary) -> str:
    """Return why a run has no first harmonics."""
    places = ("missing.everything", "missing.orbits", "failed.motion")
    reasons = (entry_at(summary, f"results.{place}") for place in places)
    return next(filter(None, reasons), "it has no results")


def figure_at(path: str) -> Figure | None:
    """Return the record of the figure at a path of keys of ``summary.json``; None for what is no figure of
    ``results`` or of a probe."""
    table, *words = path.split(".")
    if table == "results":
        return figure_along(Results, words, table)
    if table == "probes" and len(words) > 1:
        found = figure_along(PointRange, words[1:], table)
        return found and replace(found, path=path)
    return None
