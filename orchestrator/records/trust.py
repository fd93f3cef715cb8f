"""Whether a run that came to its end can be trusted: one definition for the console, the exit
code, studies and reports.

A run ends with one of these states in ``summary.json``:

``done``
    It came to its end, and nothing in its own figures speaks against it.
``doubtful``
    It came to its end, and its own figures say that it cannot be trusted; ``doubts`` says why.
``incomplete``
    It came to its end, but some of its results could not be made.
``interrupted``, ``failed``
    It did not come to its end.

Each ground for doubt is a small function of the summary in ``GROUNDS``, and nowhere else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from orchestrator.records.summary import LARGEST_SHARE_CREATED, share_created

DONE, DOUBTFUL, INCOMPLETE = "done", "doubtful", "incomplete"
AT_THE_END = (DONE, DOUBTFUL, INCOMPLETE)
EXIT_CODES = {DONE: 0, DOUBTFUL: 5, INCOMPLETE: 6}

Summary = Mapping[str, Any]


def doubts(summary: Summary) -> list[str]:
    """Returns the reasons why the run behind ``summary`` (the table of ``summary.json``) is not to
    be trusted, a whole sentence each; none for a run that can be."""
    return [sentence for ground in GROUNDS for sentence in ground(summary)]


def state_at_end(summary: Summary) -> str:
    """Returns the state of a run that came to its end, from its ``doubts`` and its results."""
    if summary.get("doubts"):
        return DOUBTFUL
    results = summary.get("results")
    return INCOMPLETE if results is None or results.get("failed") else DONE


def came_to_its_end(state: str) -> bool:
    """Returns whether a run of this state need not be run again."""
    return state in AT_THE_END


def is_trusted(state: str) -> bool:
    """Returns whether figures of a run of this state may be taken as data."""
    return state == DONE


def _energy_created(summary: Summary) -> Iterator[str]:
    """The coupling must not make more than a small share of the energy that goes through it."""
    share = share_created(summary.get("energy_ledger_J", {}))
    if abs(share) > LARGEST_SHARE_CREATED:
        advice = summary.get("stability", {}).get("advice") or "Shorten coupling.sync_interval_s."
        yield (
            f"The coupling created {100 * share:+.2g} % of the energy supplied and lost, more than "
            f"{100 * LARGEST_SHARE_CREATED:g} %. {advice}"
        )


def _effects_crossed(summary: Summary) -> Iterator[str]:
    """Nothing may be left out by an estimate that the run itself contradicts."""
    for name, entry in summary.get("effects", {}).items():
        after = entry.get("after") or {}
        if entry.get("left_out") and entry.get("crossed") and after.get("matters"):
            yield (
                f"{name} is left out, and by the run it matters: {after['number']} is "
                f"{_rounded(after['value'])}, threshold {after['threshold']}; do not leave it out."
            )


def _surfaces_penetrated(summary: Summary) -> Iterator[str]:
    """No panel may have gone through a surface that would have held it."""
    seen = summary.get("watch", {}).get("figures", {}).get("penetrated_surfaces", {})
    if seen.get("times"):
        yield (
            f"From t = {seen['first_s']:g} s on a panel went through a surface, by up to "
            f"{seen['worst']:.3g} of its thickness, and nothing held it there; tighten it, move "
            "one of them, or give the panel a stop."
        )


def _rounded(value: float | None) -> str:
    return "infinite" if value is None else f"{value:.3g}"


GROUNDS: tuple[Callable[[Summary], Iterator[str]], ...] = (
    _energy_created,
    _effects_crossed,
    _surfaces_penetrated,
)
