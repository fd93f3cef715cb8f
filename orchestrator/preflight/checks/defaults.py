"""The defaults that decide about the physics of a case and that the case takes without a word."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def taken_defaults(given: Mapping[str, Any]) -> Iterator[str]:
    """Yield a sentence for each default in the tables ``given`` that a user should know to be taken.

    Keys that have no safe default are required instead; these defaults are usual, but not always meant.
    """
    screen = given.get("screen", {})
    sheets = {**screen.get("panels", {}), **screen.get("decks", {})}
    sloped = all("slopes_deg" in deck for deck in screen.get("decks", {}).values()) and not screen.get(
        "panels"
    )
    if sheets and "inclination_deg" not in screen and not sloped:
        yield "screen.inclination_deg = 0: the deck is level"
    if hinged := [name for name, row in sheets.items() if "clamp_m" not in row]:
        yield f"clamp_m = 0 of {', '.join(hinged)}: the panels' ends are hinges"
    if untensioned := [name for name, row in screen.get("decks", {}).items() if "tension_m" not in row]:
        yield f"tension_m = 0 of {', '.join(untensioned)}: the panels are neither taut nor slack at rest"
    for name, exciter in screen.get("exciters", {}).items():
        if "axis" not in exciter:
            sense = "on its upper side the unbalance moves down the deck"
            yield f"screen.exciters.{name}.axis = [0, 1, 0]: {sense}"
