"""``[screen]``: the machine.  Frames on bushings, what drives them, panels and walls.

Everything in it is given in deck axes: x along the deck and downhill, y across, z normal to the
deck and up.  ``inclination_deg`` turns them about y into the world's axes.
"""

from __future__ import annotations

from typing import Literal

from pydantic import Field

from orchestrator.case.tables.deck import Deck, PanelSheet
from orchestrator.case.tables.frames import Bushing, Exciter, Frame
from orchestrator.case.tables.quantities import Box, Few, Name, Number, Positive, Switch, Table, Vector


class PanelTable(PanelSheet):
    """A rectangular panel clamped at both ends, or a row of ``count`` of them.

    A row's panels are ``pitch_m`` apart along ``along``; their frames alternate, so that
    neighbours share a cross beam.  Panels of a row are named <name>-1, <name>-2 and so on.
    """

    frames: tuple[str, str]
    """Frames (or "ground") that hold the first and the second clamp."""
    corner_m: Vector
    """First clamp's inner edge, at the side from which ``across`` points into the panel."""
    along: Vector = (1.0, 0.0, 0.0)
    """Direction from the first clamp to the second."""
    across: Vector = (0.0, 1.0, 0.0)
    """Direction of the width; along x across points to the particles."""
    tension_m: Number | None = None
    """Distance between the clamps less ``length_m``: positive is taut, negative slack."""
    span_m: Positive | None = None
    """Distance between the clamps' inner edges; instead of ``tension_m``."""
    count: Few = 1
    """Number of panels in the row."""
    pitch_m: Positive | None = None
    """Distance from panel to panel of a row."""


class Surface(Table):
    """A rigid surface that particles touch from both sides: a side wall, a chute.  Either an STL
    file, or a plate: a corner and two edges that start there."""

    stl: str | None = None
    """STL file in the case's folder, in m and deck axes."""
    corner_m: Vector | None = None
    """A corner of the plate; with ``edges_m``."""
    edges_m: tuple[Vector, Vector] | None = None
    """The plate's edges from there; the first x the second points to its upper side."""
    frame: str
    """The frame that carries it, or "ground"."""
    material: str
    """Its material."""


class Exit(Table):
    """A box that takes particles out and counts them: the undersize below a section of the deck,
    the oversize behind its end."""

    product: Literal["undersize", "oversize"]
    """What leaves here."""
    box_m: Box
    """Lowest and highest corner: a particle is taken out when its centre is in the box."""


class Screen(Table):
    """The machine, in deck axes."""

    inclination_deg: Number = 0.0
    """Angle by which the deck slopes down along its x axis."""
    drawn_at_rest: Switch = True
    """True: bushings are preloaded so that nothing moves before an exciter or drive starts.
    False: the frames drop onto their unloaded bushings at t = 0."""
    frames: dict[Name, Frame] = Field(default_factory=dict)
    """Frames by name."""
    bushings: dict[Name, Bushing] = Field(default_factory=dict)
    """Bushings by name."""
    exciters: dict[Name, Exciter] = Field(default_factory=dict)
    """Exciters by name."""
    decks: dict[Name, Deck] = Field(default_factory=dict)
    """Decks by name: each stands for panels and surfaces."""
    panels: dict[Name, PanelTable] = Field(default_factory=dict)
    """Panels, or rows of panels, by name."""
    surfaces: dict[Name, Surface] = Field(default_factory=dict)
    """Rigid surfaces by name."""
    exits: dict[Name, Exit] = Field(default_factory=dict)
    """Exits by name."""
