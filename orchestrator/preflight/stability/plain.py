"""A card in a designer's words: for ``flipflow check``, for warnings, and for a run that stopped.

The theory's own terms and numbers are in ``words.py``.
"""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.preflight.stability.bound import Bound, Card

BECAUSE = {
    "light points": "{where} knocks a light spot of the panel to and fro between exchanges",
    "lasting contacts, panels' modes": "{where} lies there and feeds the panel's fastest vibration",
    "lasting contacts, light points": "{where} lies there and rocks on a light spot of the panel",
    "foreseen contacts, panels' modes": "the load of {where} on the panel's fastest vibration is "
    "foreseen wrongly",
    "foreseen contacts, spheres": "the load of {where}, which jumps off light spots of the panel, "
    "is foreseen wrongly",
    "late contacts": "the load of {where} comes an exchange late and feeds the panel's vibration",
    "late contacts, light points": "the load of {where} on a light spot of the panel comes an exchange late",
    "extrapolated clamps": "the frames swing on their panels faster than exchanges can follow",
    "late reaction": "the panels' pull on the frames comes an exchange late and feeds their swing",
    "carried mass": "the panels are too heavy for a frame that carries them",
    "shortest impact": "an impact of {where} should last ten exchanges",
    "moving surface": "between exchanges a surface is taken to go straight on, which {where} feels",
    "driven surface": "the smooth path of a driven surface between exchanges must not leave its "
    "true one by what {where} feels",
}
"""Why no longer interval: a clause for each bound by its name; ``where`` are the particles."""

REMEDIES = {
    "carried mass": "make that frame heavier or its panels lighter",
    "late reaction": 'give the bushings damping, or set coupling.scheme = "auto"',
    "late contacts": 'set a restitution below 1, or coupling.scheme = "auto"',
    "late contacts, light points": 'set a restitution below 1, or coupling.scheme = "auto"',
}
"""What helps where no interval is short enough."""

USUALLY = "A smaller coupling.sync_interval_s or solver step usually helps."


def lines(card: Card) -> Iterator[str]:
    """How often forces are exchanged, how often they should be, and why."""
    scheme = f"scheme {card.scheme}" + (", chosen by the program" if card.why else "")
    yield (
        f"  particles, panels and frames exchange motion and forces every {card.interval_s:.3g} s "
        f"(coupling.sync_interval_s; {scheme})"
    )
    if card.stable is None:
        yield "  stable at any interval"
    elif card.safe_s == 0:
        yield f"  stable at no interval: {because(card.stable)}; {remedy(card.stable)}"
    else:
        yield f"  sure to be stable up to {card.safe_s:.3g} s: {because(card.stable)}"
    if card.accurate is not None:
        yield (
            f"  accurate by the usual rules up to {card.accurate.interval_s:.3g} s: {because(card.accurate)}"
        )
    yield "  (--detail: all limits, and the numbers behind them)"


def warnings(card: Card) -> Iterator[str]:
    """Where the case is beyond a limit: one line for stability, one for accuracy."""
    interval_s, stable, accurate = card.interval_s, card.stable, card.accurate
    if stable is not None and interval_s > stable.interval_s:
        yield f"coupling.sync_interval_s = {interval_s:.3g} s: {_too_long(card, stable)}"
    if accurate is not None and interval_s > accurate.interval_s:
        yield (
            f"coupling.sync_interval_s = {interval_s:.3g} s: accurate by the usual rules is at "
            f"most {accurate.interval_s:.2g} s: {because(accurate)}"
        )


def advice(card: Card) -> str:
    """For a run that became unstable: a sentence."""
    stable = card.stable
    if stable is None or card.interval_s <= stable.interval_s:
        return USUALLY
    if stable.interval_s == 0:
        return f"No shorter interval helps: {because(stable)}; {remedy(stable)}."
    return (
        f"At most coupling.sync_interval_s = {stable.interval_s:.2g} s is sure to be stable: "
        f"{because(stable)}."
    )


def beyond(card: Card) -> bool:
    """Whether the case is beyond what is sure to be stable."""
    return card.interval_s > card.safe_s


def because(bound: Bound) -> str:
    """Why the bound allows no longer interval; what the theory says of a bound that has no words
    here."""
    clause = BECAUSE.get(bound.name)
    return clause.format(where=bound.where) if clause else f"{bound.name} ({bound.why})"


def remedy(bound: Bound) -> str:
    """What helps where the bound allows no interval at all."""
    return REMEDIES.get(bound.name, 'set coupling.scheme = "auto"')


def _too_long(card: Card, stable: Bound) -> str:
    if stable.interval_s == 0:
        return f"no interval is short enough: {because(stable)}; {remedy(stable)}"
    times = card.interval_s / stable.interval_s
    return f"{times:.2g} times what is sure to be stable, {stable.interval_s:.2g} s: {because(stable)}"
