"""A card in the theory's words and numbers: for ``flipflow check --detail``, a run's log and its
summary; in a designer's: ``plain.py``."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from orchestrator.preflight.stability import plain
from orchestrator.preflight.stability.bound import Card


def lines(card: Card) -> Iterator[str]:
    """All of it: numbers, bounds from the least up, and what follows."""
    if card.why:
        yield f"  scheme: {card.scheme}, taken by the program: {card.why}"
    for name, text in card.facts.items():
        yield f"  {name}: {text}"
    for step in card.steps:
        yield f"  {step.name}: {step.step_s:.3g} s, at most {step.limit_s:.3g} s ({step.why})"
    for bound in sorted(card.bounds, key=lambda bound: bound.interval_s):
        said = f"{bound.why} ({bound.source})"
        yield f"  {_shown(bound.interval_s)} for {bound.kind}, {bound.name}: {said}"
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


def figures(card: Card) -> dict[str, Any]:
    """For ``summary.json``: bounds in s (None: no limit), the one that limits, and what to do where
    the case is beyond it."""
    return {
        "scheme": card.scheme,
        "taken_because": card.why or None,
        "safe_interval_s": card.safe_s if math.isfinite(card.safe_s) else None,
        "limited_by": card.stable.name if card.stable else None,
        "advice": plain.advice(card) if plain.beyond(card) else None,
        "bounds_s": {
            bound.name: bound.interval_s if math.isfinite(bound.interval_s) else None for bound in card.bounds
        },
    }


def _shown(interval_s: float) -> str:
    return f"{interval_s:.3g} s" if math.isfinite(interval_s) else "no limit"
