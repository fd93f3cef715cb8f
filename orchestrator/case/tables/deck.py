"""``[screen.decks.<name>]``: a deck by its parameters, from which panels and surfaces are made."""

from __future__ import annotations

from typing import Annotated, Any

from annotated_types import Ge, Le
from pydantic import BeforeValidator, Field, Strict

from orchestrator.case.tables.apertures import Apertures
from orchestrator.case.tables.quantities import Few, Name, NotNegative, Number, Positive, Table, Vector
from orchestrator.case.tables.stop import Stop


def _listed(value: Any) -> Any:
    return (value,) if isinstance(value, int | float) else value


Slope = Annotated[float, Strict(), Ge(0), Le(60)]


class SidePlates(Table):
    """A plate along each side of the deck."""

    frame: str
    """The frame that carries them, or "ground"."""
    material: str
    """Their material."""
    height_m: Positive
    """Height above the line of the panels, normal to the deck axes."""
    depth_m: NotNegative = 0.0
    """How far they reach below it."""
    gap_m: NotNegative = 0.0
    """Distance from the panels' edges."""


class FeedChute(Table):
    """A plate, as wide as the deck, that ends above the first cross beam."""

    frame: str = "ground"
    """The frame that carries it."""
    material: str
    """Its material."""
    length_m: Positive
    """Its length."""
    slope_deg: Slope
    """How steeply it slopes down to the deck, against the horizontal."""
    drop_m: NotNegative
    """Height of its end above the first cross beam."""


class CrossBeams(Table):
    """The beams' tops where they show between the clamps of neighbouring panels."""

    material: str
    """Their material."""


class Deck(Table):
    """Panels end to end between cross beams that belong to two frames in turn.

    Panels are named <name>-1, <name>-2 and so on from the upper end, surfaces <name>-left-1,
    <name>-right-1, <name>-beam-1, <name>-chute.  Instead of a deck, panels and surfaces may be
    given one by one.
    """

    material: str
    """The panels' material, with ``hyperelastic``."""
    frames: tuple[str, str]
    """Frames that carry the first cross beam and the second; they alternate from there."""
    corner_m: Vector
    """Middle of the first cross beam's top at the side from which the width points in."""
    panels: Few
    """Number of panels."""
    pitch_m: Positive
    """Distance between the middles of neighbouring cross beams."""
    length_m: Positive
    """Stress-free length of a panel between its clamps' inner edges."""
    width_m: Positive
    """Width of the panels."""
    thickness_m: Positive
    """Thickness of the panels."""
    clamp_m: NotNegative = 0.0
    """Length held under each clamp: the panel is built in there.  0 is a hinge, for every solver:
    the panel's end cannot move but can turn."""
    tension_m: Annotated[tuple[Number, ...], BeforeValidator(_listed)] = (0.0,)
    """Distance between a panel's clamps less ``length_m``, positive is taut, negative slack: one
    number for all panels, or a list with one for each."""
    slopes_deg: tuple[Slope, ...] = ()
    """Slope of each segment against the horizontal, from the upper end; all segments have equally
    many panels.  None: one segment along the deck axes (``screen.inclination_deg``)."""
    apertures: Apertures | None = None
    """The panels' openings."""
    stops: dict[Name, Stop] = Field(default_factory=dict)
    """Beams below each panel that it may come to lie on, by name."""
    side_plates: SidePlates | None = None
    """Plates along both sides."""
    feed_chute: FeedChute | None = None
    """A chute onto the upper end."""
    cross_beams: CrossBeams | None = None
    """Close the gaps between the clamps of neighbouring panels."""
