"""The table ``[screen.decks.<name>]``, from which panels and surfaces are made.

The module also has the tables that decks and panels share: ``apertures`` and ``stops``.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Ge, Le, Lt
from pydantic import BeforeValidator, Discriminator, Field, PrivateAttr, Strict, StringConstraints, Tag

from orchestrator.case.tables.quantities import (
    Few,
    Name,
    NotNegative,
    Number,
    OneLine,
    Positive,
    Share,
    Table,
    Vector,
)
from orchestrator.ports.drawn_openings import Drawing


class Rims(Table):
    """What particles meet at openings, and how much of the panel counts as solid besides."""

    margin_share: Annotated[float, Strict(), Ge(0), Lt(1)] = 0.0
    """Share of the panel's width that counts as solid for its mass and stiffness although particles find
    openings there.  A slice takes its part of the whole panel's margins in this way, in place of
    ``margin_across_m``."""
    rims: Literal["thin", "deep"] = "thin"
    """What particles meet at an opening.  Thin rims are the edges of a surface without thickness; deep ones
    are walls from the upper to the lower side of the mat, which follow its normal and its stretch."""
    depth_m: Positive | None = None
    """Distance between the upper and the lower side of the mat, of deep rims.  By default, it is the panel's
    thickness."""
    relief_deg: Annotated[float, Strict(), Ge(-45), Le(45)] | None = None
    """Angle between the walls of deep rims and the normal, 0 by default: with a positive angle, openings
    widen downwards.  Lengths, widths and outlines are those of the upper side."""


class Apertures(Rims):
    """Equal openings in a regular pattern, through which particles fall.  The pattern is centred and
    has as many whole pitches as fit between the margins.  The panel has the stiffness and the mass of
    the material between the openings (docs/theory/perforated_panel.md)."""

    shape: Literal["rectangle", "slot"] = "rectangle"
    """Shape of an opening.  A slot has round ends; it is a circle if length and width are equal."""
    length_m: Positive
    """Length of an opening along the panel."""
    width_m: Positive
    """Width of an opening across the panel."""
    pitch_along_m: Positive
    """Distance between the centres of neighbouring openings along the panel."""
    pitch_across_m: Positive
    """Distance between the centres of neighbouring openings across the panel."""
    stagger: Annotated[float, Strict(), Ge(0), Lt(1)] = 0.0
    """Shift of every second row of openings across the panel, as a share of the pitch."""
    margin_along_m: NotNegative = 0.0
    """Smallest length without openings before each clamp."""
    margin_across_m: NotNegative = 0.0
    """Smallest width without openings at each side."""

    @property
    def smaller_m(self) -> float:
        """The smaller side of an opening."""
        return min(self.length_m, self.width_m)


class DrawnApertures(Rims):
    """Openings from a drawing, in place of a pattern.  Closed outlines are openings; one around all others
    is that of the panel, with the strips under its clamps, and gives ``length_m`` and ``width_m`` where they
    are not given.  x of the drawing runs along the panel and y across, as seen from above, from the corner
    of that outline, or else from the origin of the drawing (docs/how-to/bring-your-own-geometry.md)."""

    file: Annotated[str, StringConstraints(min_length=1, max_length=200)]
    """DXF file in the case's folder."""
    unit: Literal["m", "cm", "mm", "in", "ft"] | None = None
    """Unit of the drawing.  It is needed where the file does not say it, and stands above what it says."""
    layers: tuple[OneLine, ...] = ()
    """Layers with the outlines.  They must be named if the drawing has outlines on more than one layer."""
    rotation_deg: Literal[0, 90, 180, 270] = 0
    """Angle by which the drawing is turned anticlockwise, as seen from above."""

    _drawing: Drawing | None = PrivateAttr(default=None)

    @property
    def drawing(self) -> Drawing:
        """What stands in the file; a case that has been read has it."""
        assert self._drawing is not None, "drawings are read with the case"
        return self._drawing

    def with_drawing(self, drawing: Drawing) -> DrawnApertures:
        """Return a copy that has what stands in the file."""
        apertures = self.model_copy()
        apertures._drawing = drawing
        return apertures

    @property
    def smaller_m(self) -> float:
        """The largest of the smaller sides of the boxes around the openings."""
        return max(float(np.ptp(np.array(outline), axis=0).min()) for outline in self.drawing.outlines_m)


def _way_of_openings(given: Any) -> str:
    is_drawn = "file" in given if isinstance(given, dict) else isinstance(given, DrawnApertures)
    return "<drawing>" if is_drawn else "<pattern>"


class Stop(Table):
    """The flat top of a beam below a panel, on which the panel may come to lie.  The beam is the flange
    of the cross beam beside its clamp, or a bar between the cross beams (docs/theory/panel_stops.md)."""

    frame: str | None = None
    """Frame that carries the stop, or "ground".  By default, it is the frame that holds the nearer
    clamp."""
    from_m: NotNegative
    """Beginning of the stop, measured along the free length from the first clamp's inner edge."""
    to_m: Positive
    """End of the stop, measured in the same way."""
    gap_m: Positive
    """Distance of the stop below the panel when the panel is straight between its clamps."""
    stiffness_Pa_per_m: Positive | None = None
    """Stiffness of the stop's layer of rubber: pressure divided by the depth pressed in.  By default, it
    is a tenth of the largest value allowed, which is the panel's mass per area divided by the square of
    the sync interval."""
    damping_ratio: Share = 0.2
    """Damping of the panel's mass on the layer, as a share of the critical damping."""


Slope = Annotated[float, Strict(), Ge(0), Le(60)]
ClampAngle = Annotated[float, Strict(), Ge(-45), Le(45)]


class PanelSheet(Table):
    """The common part of panels and decks: the sheet of a panel with its openings and stops."""

    material: str
    """Material of a panel, which must have the table ``hyperelastic``."""
    length_m: Positive
    """Stress-free length of a panel between the inner edges of its clamps."""
    width_m: Positive
    """Width of a panel."""
    thickness_m: Positive
    """Thickness of a panel."""
    clamp_m: NotNegative = 0.0
    """Length of the panel under each clamp, where it is built in.  For every solver 0 means a hinge: the
    panel's end cannot move but can turn."""
    clamp_angle_deg: ClampAngle = 0.0
    """Angle by which both clamps hold the panel turned about their inner edges.  With a positive angle, both
    ends point down into the sag, and the clamps' outer edges are higher than the inner ones."""
    moulded_sag_m: NotNegative = 0.0
    """Depth to which the middle of the free length hangs below its ends where the panel is free of stress.
    The stress-free shape is a full wave along ``length_m``, and leaves the ends along the line between
    them (docs/theory/mats.md)."""
    apertures: (
        Annotated[
            Annotated[Apertures, Tag("<pattern>")] | Annotated[DrawnApertures, Tag("<drawing>")],
            Discriminator(_way_of_openings),
        ]
        | None
    ) = None
    """Openings of a panel: a pattern, or a drawing where ``file`` is given."""
    stops: dict[Name, Stop] = Field(default_factory=dict)
    """Beams below a panel that it may come to lie on, by name."""


class SidePlates(Table):
    """A plate along each side of the deck."""

    frame: str
    """Frame that carries the plates, or "ground"."""
    material: str
    """Material of the plates."""
    height_m: Positive
    """Height of the plates above the line of the panels, along the deck's z axis."""
    depth_m: NotNegative = 0.0
    """Depth of the plates below the line of the panels."""
    gap_m: NotNegative = 0.0
    """Distance of the plates from the panels' edges."""


class FeedChute(Table):
    """A plate, as wide as the deck, that ends above the first cross beam."""

    frame: str = "ground"
    """Frame that carries the chute, or "ground"."""
    material: str
    """Material of the chute."""
    length_m: Positive
    """Length of the chute."""
    slope_deg: Slope
    """Angle by which the chute slopes down to the deck, against the horizontal."""
    drop_m: NotNegative
    """Height of the chute's end above the first cross beam."""


class CrossBeams(Table):
    """The visible tops of the cross beams, between the clamps of neighbouring panels."""

    material: str
    """Material of the cross beams."""


def _as_list(value: Any) -> Any:
    """Return a single number as a list of one."""
    return (value,) if isinstance(value, int | float) else value


class Deck(PanelSheet):
    """A row of panels end to end between cross beams, which belong to two frames in turn.

    Panels are named <name>-1, <name>-2 and so on from the upper end, surfaces <name>-left-1,
    <name>-right-1, <name>-beam-1, <name>-chute.  Instead of a deck, panels and surfaces may be
    given one by one.
    """

    frames: tuple[str, str]
    """Frames that carry the first and the second cross beam; the other cross beams alternate."""
    corner_m: Vector
    """Middle of the first cross beam's top, at the side from which y points into the deck."""
    panels: Few
    """Number of panels."""
    pitch_m: Positive | None = None
    """Distance between the middles of neighbouring cross beams.  By default, it is what panels need:
    ``length_m``, the largest ``tension_m`` and two clamps, and 2 mm between neighbours' clamps.  It then
    follows ``tension_m``."""
    tension_m: Annotated[tuple[Number, ...], BeforeValidator(_as_list)] = (0.0,)
    """Distance between a panel's clamps minus ``length_m``: one number for all panels, or a list with a
    number for each panel.  It is positive for taut panels and negative for slack panels."""
    slopes_deg: tuple[Slope, ...] = ()
    """Slope of each segment against the horizontal, from the upper end; all segments have the same
    number of panels unless ``panels_per_slope`` is given.  By default, the deck is one segment along the
    deck axes (``screen.inclination_deg``)."""
    panels_per_slope: tuple[Few, ...] = ()
    """Number of panels of each segment, from the upper end, where segments are not equally long."""
    side_plates: SidePlates | None = None
    """Plates along both sides."""
    feed_chute: FeedChute | None = None
    """Chute onto the upper end of the deck."""
    cross_beams: CrossBeams | None = None
    """Tops of the cross beams, which close the gaps between the clamps of neighbouring panels."""
