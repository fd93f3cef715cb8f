"""``[screen.panels.<name>.apertures]`` and ``[screen.decks.<name>.apertures]``."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Lt
from pydantic import Strict

from orchestrator.case.tables.quantities import NotNegative, Positive, Table


class Apertures(Table):
    """Equal openings in a regular pattern: as many whole pitches as fit between the margins,
    centred.  Particles fall through them; the panel is as stiff and heavy as what is left
    (docs/theory/perforated_panel.md)."""

    shape: Literal["rectangle", "slot"] = "rectangle"
    """rectangle, or slot with round ends (a circle if length and width are equal)."""
    length_m: Positive
    """Length of an opening along the panel."""
    width_m: Positive
    """Width of an opening across the panel."""
    pitch_along_m: Positive
    """Distance from opening to opening along the panel."""
    pitch_across_m: Positive
    """Distance from opening to opening across the panel."""
    stagger: Annotated[float, Strict(), Ge(0), Lt(1)] = 0.0
    """Shift of every second row of openings across the panel, as a share of the pitch."""
    margin_along_m: NotNegative = 0.0
    """Length without openings before each clamp, at least."""
    margin_across_m: NotNegative = 0.0
    """Width without openings at each side, at least."""
