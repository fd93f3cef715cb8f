"""``[screen]``: the machine.  Frames on bushings, what drives them, panels and walls.

Everything in it is given in deck axes: x along the deck and downhill, y across, z normal to the
deck and up.  ``inclination_deg`` turns them about y into the world's axes.
"""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Ge, Gt, Le
from pydantic import Field, Strict

from orchestrator.tables.apertures import Apertures
from orchestrator.tables.deck import Deck
from orchestrator.tables.quantities import (
    Box,
    Few,
    Name,
    NotNegative,
    NotNegativeVector,
    Number,
    Positive,
    Switch,
    Table,
    Vector,
    Vectors,
)
from orchestrator.tables.stop import Stop


class Drive(Table):
    """Prescribed harmonic motion of a frame, component by component:
    amplitude * sin(speed * t + phase), smoothly run up."""

    speed_rad_s: Positive
    """Angular frequency."""
    amplitude_m: Vector = (0.0, 0.0, 0.0)
    """Amplitude of the translation."""
    phase_rad: Vector = (0.0, 0.0, 0.0)
    """Phase of each component of the translation."""
    rotation_rad: Vector = (0.0, 0.0, 0.0)
    """Amplitude of the rotation vector."""
    rotation_phase_rad: Vector = (0.0, 0.0, 0.0)
    """Phase of each component of the rotation."""
    center_m: Vector = (0.0, 0.0, 0.0)
    """Centre of the rotation."""
    run_up_s: NotNegative = 0.0
    """Time in which the motion grows to its full size."""


class Frame(Table):
    """A rigid body: free, moved through its mass by exciters, bushings and panels; or moved as
    prescribed by ``drive``, whatever pushes it.  Both may be in one machine (solvers "planar" and
    "exudyn")."""

    center_of_mass_m: Vector = (0.0, 0.0, 0.0)
    """Centre of mass at t = 0."""
    mass_kg: Positive | None = None
    """Mass without panels and particles."""
    inertia_kg_m2: tuple[Positive, Positive, Positive] | None = None
    """Moments of inertia about the deck axes through the centre of mass."""
    products_of_inertia_kg_m2: Vector = (0.0, 0.0, 0.0)
    """Elements xy, xz and yz of the inertia tensor."""
    drive: Drive | None = None
    """Prescribed motion (not with solver "two-mass"); mass and inertia may then be left
    out, and are without effect on the motion."""


class Bushing(Table):
    """Equal springs and dampers between two frames, one at each position."""

    between: tuple[str, str]
    """The two frames, or a frame and "ground"."""
    positions_m: Vectors
    """Where they are, one row each."""
    stiffness_N_m: NotNegativeVector
    """Stiffness of one, along each of its axes."""
    damping_N_s_m: NotNegativeVector = (0.0, 0.0, 0.0)
    """Viscous damping of one, along each of its axes."""
    rotation_deg: Vector = (0.0, 0.0, 0.0)
    """Turns the bushing's axes from the deck axes: about x, then y, then z."""


class Motor(Table):
    """An induction motor on the ground that turns an exciter's shaft, so that its speed dips under
    load.  Of the solvers, "planar" and "exudyn" know it; the others turn the shaft at
    ``speed_rad_s``."""

    rated_power_W: Positive
    """Rated power, of all motors of the shaft."""
    synchronous_speed_rad_s: Positive
    """Speed of the shaft without any load; gears and belts are already in it."""
    rated_slip: Annotated[float, Strict(), Gt(0), Le(0.2)]
    """Lag behind the synchronous speed at rated power, as a share of it."""
    breakdown_ratio: Annotated[float, Strict(), Ge(1), Le(10)] = 2.5
    """Breakdown torque over rated torque."""
    moment_of_inertia_kg_m2: Positive
    """Of all that turns about the shaft, the unbalance and the rotor included, at its speed."""
    bearing_loss_N_m_s: NotNegative = 0.0
    """Torque that the bearings take, per speed."""


class Exciter(Table):
    """A rotating unbalance on a frame."""

    frame: str
    """The frame it is fixed to."""
    position_m: Vector
    """Where its axis is."""
    mass_moment_kg_m: Positive
    """Unbalanced mass times its eccentricity; the force is this times speed squared."""
    speed_rad_s: Positive
    """Speed once it has run up."""
    axis: Vector = (0.0, 1.0, 0.0)
    """Direction of the shaft; the unbalance turns about it in the positive sense."""
    start: Vector = (0.0, 0.0, 1.0)
    """Direction in which the force points at angle ``phase_rad``; normal to ``axis``."""
    phase_rad: Number = 0.0
    """Angle at t = 0."""
    start_s: NotNegative = 0.0
    """When it starts; until then it stands still, and what was dropped can settle."""
    run_up_s: NotNegative = 0.0
    """Time to reach full speed, from ``start_s``; of a motor, for its synchronous speed."""
    motor: Motor | None = None
    """Turns it; without, its speed is prescribed."""


class Panel(Table):
    """A rectangular panel clamped at both ends, or a row of ``count`` of them.

    A row's panels are ``pitch_m`` apart along ``along``; their frames alternate, so that
    neighbours share a cross beam.  Panels of a row are named <name>-1, <name>-2 and so on.
    """

    material: str
    """A material with ``hyperelastic``."""
    frames: tuple[str, str]
    """Frames (or "ground") that hold the first and the second clamp."""
    corner_m: Vector
    """First clamp's inner edge, at the side from which ``across`` points into the panel."""
    along: Vector = (1.0, 0.0, 0.0)
    """Direction from the first clamp to the second."""
    across: Vector = (0.0, 1.0, 0.0)
    """Direction of the width; along x across points to the particles."""
    length_m: Positive
    """Stress-free length between the clamps' inner edges."""
    width_m: Positive
    """Width."""
    thickness_m: Positive
    """Thickness."""
    clamp_m: NotNegative = 0.0
    """Length held under each clamp."""
    tension_m: Number | None = None
    """Distance between the clamps less ``length_m``: positive is taut, negative slack."""
    span_m: Positive | None = None
    """Distance between the clamps' inner edges; instead of ``tension_m``."""
    count: Few = 1
    """Number of panels in the row."""
    pitch_m: Positive | None = None
    """Distance from panel to panel of a row."""
    apertures: Apertures | None = None
    """Its openings."""
    stops: dict[Name, Stop] = Field(default_factory=dict)
    """Beams below it that it may come to lie on, by name."""


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
    panels: dict[Name, Panel] = Field(default_factory=dict)
    """Panels, or rows of panels, by name."""
    surfaces: dict[Name, Surface] = Field(default_factory=dict)
    """Rigid surfaces by name."""
    exits: dict[Name, Exit] = Field(default_factory=dict)
    """Exits by name."""
