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
    """A rectangular panel clamped at both ends, or a row of ``count``, ``<name>-1`` and so on, whose
    neighbours share cross beams."""

    frames: tuple[str, str]
    """Frames, or "ground", of the first and the second clamp; in a row they alternate."""
    corner_m: Vector
    """End of the first clamp's inner edge, from which ``across`` points into the panel."""
    along: Vector = (1.0, 0.0, 0.0)
    """Direction from the first clamp to the second."""
    across: Vector = (0.0, 1.0, 0.0)
    """Direction of the width; ``along`` x ``across`` points to the particles."""
    tension_m: Number | None = None
    """Distance between the clamps minus ``length_m``, positive if taut."""
    span_m: Positive | None = None
    """Instead: distance between the clamps' inner edges."""
    count: Few = 1
    """Number of panels in the row."""
    pitch_m: Positive | None = None
    """Distance of neighbours along ``along``, corner to corner."""


class Surface(Table):
    """A rigid surface, touched from both sides: a file, or a plate with a corner and two edges."""

    file: str | None = None
    """STEP or IGES, or with ``unit`` STL, OBJ, PLY, VTK or MSH (Gmsh); faults are healed, and ``check``
    names them."""
    stl: str | None = None
    """Instead of ``file``: STL in m, or in ``unit``."""
    unit: Literal["m", "cm", "mm", "in", "ft"] | None = None
    """Unit of the coordinates."""
    scale: Positive | None = None
    """Factor of the coordinates; 1 by default."""
    rotation_deg: Vector | None = None
    """Turn about the deck's x, then y, then z axis."""
    move_m: Vector | None = None
    """Shift after the turn."""
    tolerance_m: Positive | None = None
    """Largest distance of triangles from curved faces; 1e-4 by default."""
    corner_m: Vector | None = None
    """Corner of the plate."""
    edges_m: tuple[Vector, Vector] | None = None
    """Edges from it; their vector product points up."""
    frame: str
    """Frame or "ground"."""
    material: str
    """Material."""


class Exit(Table):
    """A box that removes and counts particles: undersize below the deck, oversize behind it."""

    product: Literal["undersize", "oversize"]
    """What leaves here."""
    box_m: Box
    """Lowest and highest corner, 0.55 of the largest diameter apart or more.  A particle leaves when its
    centre is inside, unless it lies on a panel."""


class Screen(Table):
    """The machine, in deck axes."""

    inclination_deg: Number = 0.0
    """Slope of the deck, downwards along x."""
    drawn_at_rest: Switch = True
    """true: bushings are preloaded, nothing moves before a start. false: frames drop onto unloaded
    bushings."""
    largest_acceleration_m_per_s2: Annotated[float, Strict(), Gt(0), Le(1e7)] = 392.0
    """Frames that would move harder are refused; 40 g by default."""
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
