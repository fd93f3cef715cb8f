"""A card in words: for ``flipflow check``, a run's log and its summary."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from orchestrator.stability.bound import Bound, Card


def lines(card: Card) -> Iterator[str]:
    """All of it: numbers, bounds from the least up, and what follows."""
    if card.why:
        yield f"  scheme: {card.scheme}, taken by the program: {card.why}"
    for name, text in card.facts.items():
        yield f"  {name}: {text}"
    for step in card.steps:
        yield f"  {step.name}: {step.step_s:.3g} s, at most {step.limit_s:.3g} s ({step.why})"
    for bound in sorted(card.bounds, key=lambda bound: bound.interval_s):
        yield f"  {_shown(bound.interval_s)} for {bound.kind}, {bound.name}: {bound.why}"
    yield f"  {verdict(card)}"


def verdict(card: Card) -> str:
    """The largest safe interval, and where the case is."""
    if card.stable is None:
        return f"nothing limits the sync interval of {card.interval_s:.3g} s ({card.scheme})"
    if card.safe_s == 0:
        return f"no sync interval is short enough ({card.scheme}, {card.stable.name})"
    share = card.interval_s / card.safe_s
    return (
        f"largest safe sync interval {card.safe_s:.3g} s ({card.scheme}, {card.stable.name}); "
        f"the case takes {card.interval_s:.3g} s, {share:.2g} of it"
    )


def warnings(card: Card) -> Iterator[str]:
    """Where the case is beyond a bound: one line for stability, one for accuracy."""
    interval_s, stable, accurate = card.interval_s, card.stable, card.accurate
    if stable is not None and interval_s > stable.interval_s:
        yield f"coupling.sync_interval_s = {interval_s:.3g} s: {_too_long(card, stable)}"
    if accurate is not None and interval_s > accurate.interval_s:
        yield (
            f"coupling.sync_interval_s = {interval_s:.3g} s: the {accurate.name} wants "
            f"{accurate.interval_s:.2g} s for accuracy ({accurate.why})"
        )


def _too_long(card: Card, stable: Bound) -> str:
    if stable.interval_s == 0:
        return f"no interval is short enough for {card.scheme} ({stable.name}: {stable.why})"
    return (
        f"{card.interval_s / stable.interval_s:.2g} times what is sure to be stable, "
        f"{stable.interval_s:.2g} s ({stable.name}: {stable.why}; {stable.source})"
    )


def figures(card: Card) -> dict[str, Any]:
    """For ``summary.json``: bounds in s (None: no limit), and the one that limits."""
    return {
        "scheme": card.scheme,
        "taken_because": card.why or None,
        "safe_interval_s": card.safe_s if math.isfinite(card.safe_s) else None,
        "limited_by": card.stable.name if card.stable else None,
        "bounds_s": {
            bound.name: bound.interval_s if math.isfinite(bound.interval_s) else None
            for bound in card.bounds
        },
    }


def _shown(interval_s: float) -> str:
    return f"{interval_s:.3g} s" if math.isfinite(interval_s) else "no limit"
