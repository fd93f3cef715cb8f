"""``[screen.decks.<name>]``, from which panels and surfaces are made, and the tables that a deck
and a panel share: ``apertures`` and ``stops``."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from annotated_types import Ge, Le, Lt
from pydantic import BeforeValidator, Field, Strict

from orchestrator.case.tables.quantities import Few, Name, NotNegative, Number, Positive, Share, Table, Vector


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


class Stop(Table):
    """The flat top of a beam below a panel, which the panel may come to lie on: the cross beam's
    own flange beside its clamp, or a bar in between (docs/theory/panel_stops.md)."""

    frame: str | None = None
    """The frame that carries it, or "ground"; without, the one that holds the nearer clamp."""
    from_m: NotNegative
    """Where it begins, along the free length from the first clamp's inner edge."""
    to_m: Positive
    """Where it ends."""
    gap_m: Positive
    """How far it lies below the panel as it is mounted straight between its clamps."""
    stiffness_Pa_per_m: Positive | None = None
    """Pressure on its layer of rubber over the depth pressed in; without, a tenth of the panel's
    mass per area over the sync interval squared, ten times less than the most allowed."""
    damping_ratio: Share = 0.2
    """Damping of the panel's mass on the layer over the critical one."""


class PanelSheet(Table):
    """The sheet of a panel and what belongs to it, as panels and decks have it."""

    material: str
    """Material of a panel, with ``hyperelastic``."""
    length_m: Positive
    """Stress-free length of a panel between its clamps' inner edges."""
    width_m: Positive
    """Width of a panel."""
    thickness_m: Positive
    """Thickness of a panel."""
    clamp_m: NotNegative = 0.0
    """Length held under each clamp: the panel is built in there.  0 is a hinge, for every solver:
    the panel's end cannot move but can turn."""
    apertures: Apertures | None = None
    """Openings of a panel."""
    stops: dict[Name, Stop] = Field(default_factory=dict)
    """Beams below a panel that it may come to lie on, by name."""


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


def _as_list(value: Any) -> Any:
    return (value,) if isinstance(value, int | float) else value


class Deck(PanelSheet):
    """Panels end to end between cross beams that belong to two frames in turn.

    Panels are named <name>-1, <name>-2 and so on from the upper end, surfaces <name>-left-1,
    <name>-right-1, <name>-beam-1, <name>-chute.  Instead of a deck, panels and surfaces may be
    given one by one.
    """

    frames: tuple[str, str]
    """Frames that carry the first cross beam and the second; they alternate from there."""
    corner_m: Vector
    """Middle of the first cross beam's top at the side from which the width points in."""
    panels: Few
    """Number of panels."""
    pitch_m: Positive
    """Distance between the middles of neighbouring cross beams."""
    tension_m: Annotated[tuple[Number, ...], BeforeValidator(_as_list)] = (0.0,)
    """Distance between a panel's clamps less ``length_m``, positive is taut, negative slack: one
    number for all panels, or a list with one for each."""
    slopes_deg: tuple[Slope, ...] = ()
    """Slope of each segment against the horizontal, from the upper end; all segments have equally
    many panels.  None: one segment along the deck axes (``screen.inclination_deg``)."""
    side_plates: SidePlates | None = None
    """Plates along both sides."""
    feed_chute: FeedChute | None = None
    """A chute onto the upper end."""
    cross_beams: CrossBeams | None = None
    """Close the gaps between the clamps of neighbouring panels."""
