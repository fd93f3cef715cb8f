"""The table ``[screen]``, which describes the machine: frames, bushings, exciters, panels and walls.

All of it is given in deck axes: x along the deck and downhill, y across, z normal to the deck and up.
A rotation by ``inclination_deg`` about y turns the deck axes into the world axes.
"""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Gt, Le
from pydantic import Field, Strict

from orchestrator.case.tables.deck import Deck, PanelSheet
from orchestrator.case.tables.frames import Bushing, Exciter, Frame
from orchestrator.case.tables.quantities import Box, Few, Name, Number, Positive, Switch, Table, Vector


class PanelTable(PanelSheet):
    """A panel clamped at both ends, or a row ``<name>-1`` and so on, with shared cross beams."""

    frames: tuple[str, str]
    """Of the first and the second clamp; a row alternates."""
    corner_m: Vector
    """End of the first clamp's inner edge, from which ``across`` points inwards."""
    along: Vector = (1.0, 0.0, 0.0)
    """From the first clamp to the second."""
    across: Vector = (0.0, 1.0, 0.0)
    """Along the width; ``along`` x ``across`` points to the particles."""
    tension_m: Number | None = None
    """Distance of the clamps less ``length_m``: positive if taut."""
    span_m: Positive | None = None
    """Instead: distance of the clamps."""
    count: Few = 1
    """Panels in the row."""
    pitch_m: Positive | None = None
    """Distance of their corners."""


class Surface(Table):
    """A rigid surface with two sides: a file, or a plate of a corner and two edges."""

    file: str | None = None
    """STEP, IGES, or with ``unit`` STL, OBJ, PLY, VTK, MSH; it is healed."""
    stl: str | None = None
    """Instead: STL in m or ``unit``."""
    unit: Literal["m", "cm", "mm", "in", "ft"] | None = None
    """Unit of the coordinates."""
    scale: Positive | None = None
    """Factor; else 1."""
    rotation_deg: Vector | None = None
    """Turn about x, then y, then z."""
    move_m: Vector | None = None
    """Shift after the turn."""
    tolerance_m: Positive | None = None
    """Of triangles from curved faces; else 1e-4."""
    corner_m: Vector | None = None
    """Corner of the plate."""
    edges_m: tuple[Vector, Vector] | None = None
    """Its edges; their vector product points up."""
    frame: str
    """Frame or "ground"."""
    material: str
    """Material."""


class Exit(Table):
    """A box that removes and counts particles."""

    product: Literal["undersize", "oversize"]
    """What leaves: below the deck, or behind it."""
    box_m: Box
    """Corners, at least 0.55 largest diameters apart. Centres inside leave, unless on a panel."""


class Screen(Table):
    """The machine, in deck axes."""

    inclination_deg: Number = 0.0
    """Slope, down along x."""
    drawn_at_rest: Switch = True
    """true: bushings carry the weight at t = 0. false: frames drop onto them."""
    largest_acceleration_m_per_s2: Annotated[float, Strict(), Gt(0), Le(1e7)] = 392.0
    """Refuses frames that move harder."""
    frames: dict[Name, Frame] = Field(default_factory=dict)
    """Frames by name."""
    bushings: dict[Name, Bushing] = Field(default_factory=dict)
    """Bushings by name."""
    exciters: dict[Name, Exciter] = Field(default_factory=dict)
    """Exciters by name."""
    decks: dict[Name, Deck] = Field(default_factory=dict)
    """Decks by name."""
    panels: dict[Name, PanelTable] = Field(default_factory=dict)
    """Panels, or rows of panels, by name."""
    surfaces: dict[Name, Surface] = Field(default_factory=dict)
    """Rigid surfaces by name."""
    exits: dict[Name, Exit] = Field(default_factory=dict)
    """Exits by name."""
