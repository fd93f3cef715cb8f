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
    """Share of a slice's width that is solid for mass and stiffness alone."""
    rims: Literal["thin", "deep"] = "thin"
    """thin: edges. deep: walls through the mat, along its normal."""
    depth_m: Positive | None = None
    """Of deep rims; else the thickness."""
    relief_deg: Annotated[float, Strict(), Ge(-45), Le(45)] | None = None
    """Of deep rims to the normal, else 0; positive widens downwards."""


class Apertures(Rims):
    """A centred pattern of openings, as many as fit ([stiffness and mass](theory/perforated_panel.md))."""

    shape: Literal["rectangle", "slot"] = "rectangle"
    """A slot has round ends, or is a circle."""
    length_m: Positive
    """Along the panel."""
    width_m: Positive
    """Across the panel."""
    pitch_along_m: Positive
    """Distance of centres."""
    pitch_across_m: Positive
    """Distance of centres."""
    stagger: Annotated[float, Strict(), Ge(0), Lt(1)] = 0.0
    """Shift of every second row over its pitch."""
    margin_along_m: NotNegative = 0.0
    """Least solid length at clamps."""
    margin_across_m: NotNegative = 0.0
    """Least solid width at sides."""

    @property
    def smaller_m(self) -> float:
        """The smaller side of an opening."""
        return min(self.length_m, self.width_m)


class DrawnApertures(Rims):
    """Openings from a drawing, in the panel's outline if there is one
    (docs/how-to/bring-your-own-geometry.md)."""

    file: Annotated[str, StringConstraints(min_length=1, max_length=200)]
    """DXF file."""
    unit: Literal["m", "cm", "mm", "in", "ft"] | None = None
    """Unit, in place of the file's."""
    layers: tuple[OneLine, ...] = ()
    """Layers of outlines; needed of several."""
    rotation_deg: Literal[0, 90, 180, 270] = 0
    """Anticlockwise from above."""

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
    """The top of a beam that a panel may touch (docs/theory/panel_stops.md)."""

    frame: str | None = None
    """Frame or "ground"; else the nearer clamp's."""
    from_m: NotNegative
    """Begin, along the free length."""
    to_m: Positive
    """End."""
    gap_m: Positive
    """Below the straight panel."""
    stiffness_Pa_per_m: Positive | None = None
    """Pressure over depth of its rubber; else a tenth of mass per area / ``sync_interval_s``^2."""
    damping_ratio: Share = 0.2
    """Share of critical."""


Slope = Annotated[float, Strict(), Ge(0), Le(60)]
ClampAngle = Annotated[float, Strict(), Ge(-45), Le(45)]


class PanelSheet(Table):
    """The common part of panels and decks: the sheet of a panel with its openings and stops."""

    material: str
    """With ``hyperelastic``."""
    length_m: Positive
    """Stress-free, between the clamps."""
    width_m: Positive
    """Width."""
    thickness_m: Positive
    """Thickness."""
    clamp_m: NotNegative = 0.0
    """Built in at each clamp; 0: a hinge."""
    clamp_angle_deg: ClampAngle = 0.0
    """Of both clamps; positive points ends down."""
    moulded_sag_m: NotNegative = 0.0
    """Stress-free sag of the middle ([shape](theory/mats.md))."""
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
    """A plate along each side."""

    frame: str
    """Frame or "ground"."""
    material: str
    """Material."""
    height_m: Positive
    """Above the panels."""
    depth_m: NotNegative = 0.0
    """Below."""
    gap_m: NotNegative = 0.0
    """From the panels."""


class FeedChute(Table):
    """A plate that ends above the first cross beam."""

    frame: str = "ground"
    """Frame or "ground"."""
    material: str
    """Material."""
    length_m: Positive
    """Length."""
    slope_deg: Slope
    """Down to the deck."""
    drop_m: NotNegative
    """Its end above the cross beam."""


class CrossBeams(Table):
    """Their tops, between the clamps."""

    material: str
    """Material."""


def _as_list(value: Any) -> Any:
    """Return a single number as a list of one."""
    return (value,) if isinstance(value, int | float) else value


class Deck(PanelSheet):
    """A row of panels ``<name>-1`` and so on from the upper end; surfaces are ``<name>-left-1``,
    ``-right-1``, ``-beam-1``, ``-chute``."""

    frames: tuple[str, str]
    """Of the cross beams in turn."""
    corner_m: Vector
    """Middle of the first cross beam's top, from which y points inwards."""
    panels: Few
    """Their number."""
    pitch_m: Positive | None = None
    """Of cross beams; else ``length_m``, largest ``tension_m``, two clamps, 2 mm."""
    tension_m: Annotated[tuple[Number, ...], BeforeValidator(_as_list)] = (0.0,)
    """Distance of clamps less ``length_m``, of all or each: positive if taut."""
    slopes_deg: tuple[Slope, ...] = ()
    """Of segments, to the horizontal; else one, along x."""
    panels_per_slope: tuple[Few, ...] = ()
    """Panels of each segment; else equal."""
    side_plates: SidePlates | None = None
    """Plates along both sides."""
    feed_chute: FeedChute | None = None
    """Chute onto the upper end."""
    cross_beams: CrossBeams | None = None
    """Tops of the cross beams."""
