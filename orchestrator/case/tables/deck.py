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
    """Share of the width that is solid for mass and stiffness alone, of a slice."""
    rims: Literal["thin", "deep"] = "thin"
    """thin: edges of a surface. deep: walls through the mat, which follow its normal and stretch."""
    depth_m: Positive | None = None
    """Depth of deep rims; by default the panel's thickness."""
    relief_deg: Annotated[float, Strict(), Ge(-45), Le(45)] | None = None
    """Angle of deep rims to the normal, 0 by default; positive widens openings downwards."""


class Apertures(Rims):
    """Equal openings in a centred pattern, as many as fit between the margins ([stiffness and
    mass](theory/perforated_panel.md))."""

    shape: Literal["rectangle", "slot"] = "rectangle"
    """A slot has round ends, or is a circle."""
    length_m: Positive
    """Length along the panel."""
    width_m: Positive
    """Width across the panel."""
    pitch_along_m: Positive
    """Distance of centres along the panel."""
    pitch_across_m: Positive
    """Distance of centres across the panel."""
    stagger: Annotated[float, Strict(), Ge(0), Lt(1)] = 0.0
    """Shift of every second row across, as a share of the pitch."""
    margin_along_m: NotNegative = 0.0
    """Least length without openings before each clamp."""
    margin_across_m: NotNegative = 0.0
    """Least width without openings at each side."""

    @property
    def smaller_m(self) -> float:
        """The smaller side of an opening."""
        return min(self.length_m, self.width_m)


class DrawnApertures(Rims):
    """Openings from a drawing; an outline around all others is the panel's
    (docs/how-to/bring-your-own-geometry.md)."""

    file: Annotated[str, StringConstraints(min_length=1, max_length=200)]
    """DXF file in the case's folder."""
    unit: Literal["m", "cm", "mm", "in", "ft"] | None = None
    """Needed where the file does not say it; stands above what it says."""
    layers: tuple[OneLine, ...] = ()
    """Layers with the outlines; needed if there is more than one."""
    rotation_deg: Literal[0, 90, 180, 270] = 0
    """Turn of the drawing anticlockwise, as seen from above."""

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
    """The flat top of a beam on which a panel may come to lie (docs/theory/panel_stops.md)."""

    frame: str | None = None
    """Frame or "ground"; by default that of the nearer clamp."""
    from_m: NotNegative
    """Beginning, along the free length."""
    to_m: Positive
    """End."""
    gap_m: Positive
    """Distance below the straight panel."""
    stiffness_Pa_per_m: Positive | None = None
    """Pressure over depth of its rubber; by default a tenth of the most allowed, mass per area /
    ``sync_interval_s``^2."""
    damping_ratio: Share = 0.2
    """Share of the critical damping."""


Slope = Annotated[float, Strict(), Ge(0), Le(60)]
ClampAngle = Annotated[float, Strict(), Ge(-45), Le(45)]


class PanelSheet(Table):
    """The common part of panels and decks: the sheet of a panel with its openings and stops."""

    material: str
    """Material with ``hyperelastic``."""
    length_m: Positive
    """Stress-free length between the clamps' inner edges."""
    width_m: Positive
    """Width."""
    thickness_m: Positive
    """Thickness."""
    clamp_m: NotNegative = 0.0
    """Length built in under each clamp; 0 is a hinge."""
    clamp_angle_deg: ClampAngle = 0.0
    """Turn of both clamps; positive points the ends down into the sag."""
    moulded_sag_m: NotNegative = 0.0
    """Sag of the middle free of stress, a full wave along ``length_m`` (docs/theory/mats.md)."""
    apertures: (
        Annotated[
            Annotated[Apertures, Tag("<pattern>")] | Annotated[DrawnApertures, Tag("<drawing>")],
            Discriminator(_way_of_openings),
        ]
        | None
    ) = None
    """Openings: a pattern, or a drawing where ``file`` is given."""
    stops: dict[Name, Stop] = Field(default_factory=dict)
    """Beams below the panel, by name."""


class SidePlates(Table):
    """A plate along each side of the deck."""

    frame: str
    """Frame or "ground"."""
    material: str
    """Material."""
    height_m: Positive
    """Above the line of the panels."""
    depth_m: NotNegative = 0.0
    """Below it."""
    gap_m: NotNegative = 0.0
    """From the panels' edges."""


class FeedChute(Table):
    """A plate, as wide as the deck, that ends above the first cross beam."""

    frame: str = "ground"
    """Frame or "ground"."""
    material: str
    """Material."""
    length_m: Positive
    """Length."""
    slope_deg: Slope
    """Slope down to the deck."""
    drop_m: NotNegative
    """Height of its end above the cross beam."""


class CrossBeams(Table):
    """Their tops, which close gaps between clamps."""

    material: str
    """Material."""


def _as_list(value: Any) -> Any:
    """Return a single number as a list of one."""
    return (value,) if isinstance(value, int | float) else value


class Deck(PanelSheet):
    """A row of panels between cross beams: panels ``<name>-1`` and so on from the upper end, surfaces
    ``<name>-left-1``, ``<name>-right-1``, ``<name>-beam-1``, ``<name>-chute``."""

    frames: tuple[str, str]
    """Frames of the cross beams in turn."""
    corner_m: Vector
    """Middle of the first cross beam's top, from which y points into the deck."""
    panels: Few
    """Number of panels."""
    pitch_m: Positive | None = None
    """Distance of neighbouring cross beams; by default ``length_m``, the largest ``tension_m``, two
    clamps and 2 mm."""
    tension_m: Annotated[tuple[Number, ...], BeforeValidator(_as_list)] = (0.0,)
    """Distance between clamps minus ``length_m``, positive if taut, of all or of each."""
    slopes_deg: tuple[Slope, ...] = ()
    """Slope of each segment against the horizontal; by default one, along the deck axes."""
    panels_per_slope: tuple[Few, ...] = ()
    """Number of panels of each segment; equal by default."""
    side_plates: SidePlates | None = None
    """Plates along both sides."""
    feed_chute: FeedChute | None = None
    """Chute onto the upper end."""
    cross_beams: CrossBeams | None = None
    """Tops of the cross beams."""
