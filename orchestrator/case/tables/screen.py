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
    """A rectangular panel clamped at both ends, or a row of ``count`` of them.

    A row's panels are ``pitch_m`` apart along ``along``; their frames alternate, so that
    neighbours share a cross beam.  Panels of a row are named <name>-1, <name>-2 and so on.
    """

    frames: tuple[str, str]
    """Frames, or "ground", that hold the first and the second clamp."""
    corner_m: Vector
    """End of the first clamp's inner edge, at the side from which ``across`` points into the panel."""
    along: Vector = (1.0, 0.0, 0.0)
    """Direction from the first clamp to the second."""
    across: Vector = (0.0, 1.0, 0.0)
    """Direction of the width; the vector product of ``along`` and ``across`` points to the particles."""
    tension_m: Number | None = None
    """Distance between the clamps minus ``length_m``; it is positive for a taut panel and negative for a
    slack panel."""
    span_m: Positive | None = None
    """Distance between the clamps' inner edges, which may be given instead of ``tension_m``."""
    count: Few = 1
    """Number of panels in the row."""
    pitch_m: Positive | None = None
    """Distance between neighbouring panels of a row, from corner to corner."""


class Surface(Table):
    """A rigid surface that particles touch from both sides, such as a side wall or a chute.  It is either
    a file, or a plate with a corner and the two edges that start there."""

    file: str | None = None
    """File in the case's folder: STEP or IGES, whose units are read, or STL, OBJ, PLY, VTK or MSH (of Gmsh),
    which want ``unit``.  Faults such as double triangles are healed, and `check` says what was."""
    stl: str | None = None
    """STL file in the case's folder, given instead of ``file``; its unit is m unless ``unit`` is given."""
    unit: Literal["m", "cm", "mm", "in", "ft"] | None = None
    """Unit of the file's coordinates.  STEP and IGES say it themselves."""
    scale: Positive | None = None
    """Factor of all the file's coordinates; 1 without it."""
    rotation_deg: Vector | None = None
    """Angles by which the file's geometry is turned about the deck's x, then y, then z axis."""
    move_m: Vector | None = None
    """Distance by which the file's geometry is moved, after turning."""
    tolerance_m: Positive | None = None
    """Largest distance between curved faces of STEP or IGES and their triangles; 1e-4 without it."""
    corner_m: Vector | None = None
    """Corner of the plate; give ``edges_m``, too."""
    edges_m: tuple[Vector, Vector] | None = None
    """Edges of the plate that start at the corner; their vector product points to the upper side."""
    frame: str
    """Frame that carries the surface, or "ground"."""
    material: str
    """Material of the surface."""


class Exit(Table):
    """A box that removes particles and counts them.  The undersize leaves below a section of the deck,
    and the oversize behind the deck's end."""

    product: Literal["undersize", "oversize"]
    """Product that leaves through this exit."""
    box_m: Box
    """Lowest and highest corner of the box.  A particle is removed when its centre is in the box, which must
    not be thinner than 0.55 of the largest diameter.  A particle that lies on a panel which reaches into an
    exit of the undersize stays."""


class Screen(Table):
    """The machine, in deck axes."""

    inclination_deg: Number = 0.0
    """Angle by which the deck slopes down along its x axis."""
    drawn_at_rest: Switch = True
    """true: bushings are preloaded so that nothing moves before an exciter or drive starts.
    false: the frames drop onto their unloaded bushings at t = 0."""
    largest_acceleration_m_per_s2: Annotated[float, Strict(), Gt(0), Le(1e7)] = 392.0
    """Largest acceleration of a frame that is taken as meant, by default 40 g.  A case is refused whose
    frames would move harder, by the estimate that `flipflow check` prints."""
    frames: dict[Name, Frame] = Field(default_factory=dict)
    """Frames by name."""
    bushings: dict[Name, Bushing] = Field(default_factory=dict)
    """Bushings by name."""
    exciters: dict[Name, Exciter] = Field(default_factory=dict)
    """Exciters by name."""
    decks: dict[Name, Deck] = Field(default_factory=dict)
    """Decks by name.  Each deck stands for panels and surfaces."""
    panels: dict[Name, PanelTable] = Field(default_factory=dict)
    """Panels, or rows of panels, by name."""
    surfaces: dict[Name, Surface] = Field(default_factory=dict)
    """Rigid surfaces by name."""
    exits: dict[Name, Exit] = Field(default_factory=dict)
    """Exits by name."""
