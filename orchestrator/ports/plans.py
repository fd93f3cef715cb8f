"""Plans: all that a solver needs to know to be built, checked and in plain records.

``orchestrator/case/solver_plans.py`` makes them from the case; tests make them by hand.  Each field
has its unit and meaning.  At the end stands how much a solver has to do in a run (``...Work``),
from which its adapter predicts the ``Cost``.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal, Protocol

import numpy as np
import numpy.typing as npt

from orchestrator.ports.clock import Interval
from orchestrator.ports.failures import SolverFailed as SolverFailed
from orchestrator.ports.failures import SolverMissing as SolverMissing
from orchestrator.ports.geometry import AperturePattern, Rectangle, TriangleSurface
from orchestrator.ports.grains import Grains, Shape, upright
from orchestrator.ports.interface_records import Array, Indices
from orchestrator.ports.rows import Rows


@dataclass(frozen=True)
class HyperelasticPlan:
    """The two-parameter Mooney-Rivlin law  W = C10 (I1 - 3) + C01 (I2 - 3) + K/2 (J - 1)^2  with the
    isochoric invariants, and Maxwell branches for damping: each a pair (ratio of the branch's
    modulus to the elastic one, relaxation time in s)."""

    density_kg_per_m3: float
    c10_Pa: float
    c01_Pa: float
    bulk_modulus_Pa: float
    branches: tuple[tuple[float, float], ...] = ()

    @property
    def shear_modulus_Pa(self) -> float:
        return 2.0 * (self.c10_Pa + self.c01_Pa)

    @property
    def youngs_modulus_Pa(self) -> float:
        """Young's modulus at small strain, of a material that does not change its volume."""
        return 3.0 * self.shear_modulus_Pa


@dataclass(frozen=True)
class StopPlan:
    """The flat top of a beam under the free length of a panel from ``from_m`` to ``to_m``.

    The beam is carried by ``frame``, ``gap_m`` below the panel as it is mounted straight.  The layer on the
    top has the stiffness ``stiffness_Pa_per_m`` and the damping ``damping_Pa_s_per_m``: pressure per depth
    and per speed.
    """

    name: str
    frame: str
    from_m: float
    to_m: float
    gap_m: float
    stiffness_Pa_per_m: float
    damping_Pa_s_per_m: float


@dataclass(frozen=True)
class PointMass:
    """A mass that is fixed to a panel at a point of its free length, such as a sensor.

    ``along_m`` counts from the inner edge of the first clamp, ``across_m`` from the edge at the corner.
    """

    along_m: float
    across_m: float
    mass_kg: float


@dataclass(frozen=True)
class PanelPlan:
    """A panel: its geometry, its material, and how finely to solve it.

    ``frames`` names the frames that hold the first and the second clamp.  ``cells`` along the
    free length and across; ``step_s`` the largest step (0: the solver's own limit with margin).
    ``apertures``: its openings, if any; only particles see each of them.  ``stops``: beams that it can
    come to lie on (``orchestrator/coupling/stopped_panel.py``, no matter of the solver).
    ``point_masses``: what is fixed to it.  ``joined_sides``: it goes on beyond its sides, along world y,
    as it is between them, so that the two sides move alike.  ``hindered_share``: how much of its
    contraction across the clamps hinder, 0 of a narrow panel to 1 of a very wide one, where nothing
    varies across.  ``moulded_sag_m``: how far the middle of the free length hangs below its ends in the
    stress-free shape, which is a full wave and leaves both ends along the line between them; 0 for a
    panel that is flat where it is free of stress.
    """

    name: str
    rectangle: Rectangle
    frames: tuple[str, str]
    thickness_m: float
    material: HyperelasticPlan
    gravity_m_per_s2: Array
    cells: tuple[int, int]
    step_s: float
    integrator: str
    sync_interval_s: float
    apertures: AperturePattern | None = None
    stops: tuple[StopPlan, ...] = ()
    point_masses: tuple[PointMass, ...] = ()
    joined_sides: bool = False
    hindered_share: float = 0.0
    moulded_sag_m: float = 0.0

    @property
    def mass_kg(self) -> float:
        """The mass of the whole panel without point masses.

        It has its free length without openings, and the parts in the clamps.
        """
        at = self.rectangle
        share = self.apertures.material_share(at) if self.apertures is not None else 1.0
        area_m2 = at.width_m * (share * at.length_m + 2.0 * at.clamp_m)
        return area_m2 * self.thickness_m * self.material.density_kg_per_m3


@dataclass(frozen=True)
class MeshSize:
    """The size of a panel's mesh, before it is made.

    It has the numbers of cells with material and of nodes (each with three unknowns), the memory with the
    factorised stiffness (good to a factor of two), and the mass of the lightest node that particles can
    touch.
    """

    cells: int
    nodes: int
    memory_GiB: float
    lightest_kg: float


LARGEST_MESHES_GIB = 64.0
"""What the panels' meshes may take in all: a large workstation's memory."""


@dataclass(frozen=True)
class BodyPlan:
    """A rigid frame: mass, inertia about the centre of mass in world axes at t = 0."""

    name: str
    mass_kg: float
    inertia_kg_m2: Array  # (3, 3)
    center_of_mass_m: Array  # (3,)


@dataclass(frozen=True)
class HysteresisPlan:
    """The law of a bushing along its axis number ``axis``: a spring, n friction and m Maxwell elements in
    parallel.

    A friction element of stiffness ``friction_N_per_m`` (n,) slips where it is stretched by ``slip_m`` (n,).
    A Maxwell element of stiffness ``maxwell_N_per_m`` (m,) relaxes in ``relaxation_s`` (m,).
    """

    axis: int
    elastic_N_per_m: float
    friction_N_per_m: Array
    slip_m: Array
    maxwell_N_per_m: Array
    relaxation_s: Array


@dataclass(frozen=True)
class CharacteristicPlan:
    """The elastic force F of a bushing along its axis number ``axis``, piecewise linear in its deformation e.

        F(e) = elastic_N_per_m e + sum of  side gap_N_per_m max(side e - gap_m, 0)

    It is that of a spring and n gap springs in parallel.  Each of these acts beyond its gap on its ``side``
    of zero, 1 where e grows and -1 where it falls; ``gap_N_per_m`` is negative where the force grows less
    beyond the gap.  All arrays are (n,).
    """

    axis: int
    elastic_N_per_m: float
    side: Array
    gap_m: Array
    gap_N_per_m: Array

    def gap_force_N(self, deformation_m: Array) -> Array:
        """Return the force of the gap springs, in the shape of ``deformation_m``."""
        beyond_m = np.maximum(np.multiply.outer(deformation_m, self.side) - self.gap_m, 0.0)
        return np.asarray(beyond_m @ (self.side * self.gap_N_per_m))


@dataclass(frozen=True)
class BushingPlan:
    """A linear spring and damper along three axes between two bodies ("ground" is the fixed one).

    ``axes`` (3, 3): its rows are the spring axes in the world at t = 0, ``stiffness_N_per_m`` and
    ``damping_N_s_per_m`` (3,) belong to them; the axes turn with the first body.  Force-free at
    t = 0 but for the preload that holds the bodies' weight when the frames are drawn at rest.
    ``hysteresis`` has the laws that replace spring and damper along some axes, ``characteristics`` those that
    replace the spring alone.
    """

    name: str
    bodies: tuple[str, str]
    position_m: Array
    axes: Array
    stiffness_N_per_m: Array
    damping_N_s_per_m: Array
    hysteresis: tuple[HysteresisPlan, ...] = ()
    characteristics: tuple[CharacteristicPlan, ...] = ()

    def beside_elements(self) -> BushingPlan:
        """Return the springs and dampers that stand beside friction and Maxwell elements and gap springs."""
        if not self.hysteresis and not self.characteristics:
            return self
        stiffness, damping = self.stiffness_N_per_m.copy(), self.damping_N_s_per_m.copy()
        for law in self.hysteresis:
            stiffness[law.axis], damping[law.axis] = law.elastic_N_per_m, 0.0
        for characteristic in self.characteristics:
            stiffness[characteristic.axis] = characteristic.elastic_N_per_m
        return replace(self, stiffness_N_per_m=stiffness, damping_N_s_per_m=damping)


@dataclass(frozen=True)
class MotorPlan:
    """An induction motor, given by its rating.

    The motor lags behind ``synchronous_rad_per_s`` by ``rated_slip`` of it at ``rated_power_W``; its
    breakdown torque is ``breakdown_ratio`` times the rated torque.  ``inertia_kg_m2`` belongs to all that
    turns, the unbalance included; ``bearing_N_m_s`` is the torque lost per speed.
    """

    rated_power_W: float
    synchronous_rad_per_s: float
    rated_slip: float
    breakdown_ratio: float
    inertia_kg_m2: float
    bearing_N_m_s: float


@dataclass(frozen=True)
class ExciterPlan:
    """A rotating unbalance: force of size  mass_moment * speed^2  turning about ``axis``.

    It stands still until ``start_s``.  Then the angle runs up smoothly: with t from there,
    speed(t) = speed_rad_per_s * (1 - cos(pi t / run_up_s)) / 2 until ``run_up_s``, then constant; at
    angle = ``phase_rad`` the force points along ``start`` (a unit vector normal to ``axis``;
    positive rotation about ``axis``).  From ``stop_s`` on, which is not before the end of the run-up, it runs
    down in the same way:  speed(t) = speed_rad_per_s * (1 + cos(pi t / run_down_s)) / 2 with t from there,
    then it stands still.  The force is the unbalance's inertia force:
    mass_moment * (speed^2 radial - d(speed)/dt tangential).  With a ``motor``, where the solver
    knows motors, the speed is what its torque makes of it, and ``run_up_s`` and ``run_down_s`` are those of
    the synchronous speed.
    """

    body: str
    position_m: Array
    axis: Array
    start: Array
    mass_moment_kg_m: float
    speed_rad_per_s: float
    run_up_s: float
    phase_rad: float = 0.0
    start_s: float = 0.0
    stop_s: float = math.inf
    run_down_s: float = 0.0
    motor: MotorPlan | None = None
    name: str = ""


@dataclass(frozen=True)
class DrivePlan:
    """A prescribed harmonic motion of a body about its place at t = 0, with smooth run-up.

    Nothing turns the body from it; one drive per body.  Bodies without one are free, or stand
    still where the frames are prescribed altogether.

    Translation amplitude_m * sin(w t + phase_rad), and rotation by the vector
    rotation_rad * sin(w t + rotation_phase_rad) about ``center_m``; each (3,), component-wise.
    Both are multiplied by (1 - cos(pi t / run_up_s)) / 2 until ``run_up_s``.
    """

    body: str
    center_m: Array
    speed_rad_per_s: float
    amplitude_m: Array
    phase_rad: Array
    rotation_rad: Array
    rotation_phase_rad: Array
    run_up_s: float


@dataclass(frozen=True)
class FramesPlan:
    """The frames and the points they carry.

    ``points_m`` (n, 3) are the places at t = 0, ``carrier`` (n,) the frames' names, and ``reaction_N`` (n, 3)
    the panels' force at t = 0.  With ``drawn_at_rest`` the bushings' preload holds weight and initial
    reaction, so that nothing moves until something drives; otherwise the machine drops onto force-free
    bushings.
    """

    bodies: tuple[BodyPlan, ...]
    bushings: tuple[BushingPlan, ...]
    exciters: tuple[ExciterPlan, ...]
    drives: tuple[DrivePlan, ...]
    gravity_m_per_s2: Array
    points_m: Array
    carrier: tuple[str, ...]
    reaction_N: Array
    drawn_at_rest: bool
    step_s: float
    sync_interval_s: float


@dataclass(frozen=True)
class GrainMaterial:
    """A material that particles are made of, or that they touch."""

    name: str
    youngs_modulus_Pa: float
    poisson_ratio: float


@dataclass(frozen=True)
class ParticleList(Rows):
    """A list of particles to create: positions (n, 3) and velocities (n, 3) of the centres of mass, spins
    (n, 3) in rad/s, what they are, and how they are turned, (n, 4) unit quaternions w, x, y, z from the axes
    of their shapes to the world's; upright, if it is not given.  Ids are given in order."""

    position_m: Array
    velocity_m_per_s: Array
    spin_rad_per_s: Array
    grains: Grains
    orientation: Array = field(default_factory=lambda: upright(0))

    def __post_init__(self) -> None:
        if not len(self.orientation):
            object.__setattr__(self, "orientation", upright(len(self)))

    def __len__(self) -> int:
        return len(self.grains)


class ParticleFeed(Protocol):
    """A source of new particles for each interval, alike on every rank."""

    def due(self, interval: Interval) -> ParticleList:
        """Return the particles wanted at the interval's start; they do not overlap each other."""
        ...

    def settle(self, accepted: npt.NDArray[np.bool_]) -> None:
        """Take note of which particles just offered (bool per particle) had room; the rest is tried again."""
        ...


@dataclass(frozen=True)
class ExitPlan:
    """A box that takes out every particle whose centre is in it.

    An exit of the ``product`` "undersize" is below the deck: where panels reach into it, who is on the upper
    side of the nearest one, or in an opening with a depth, stays.  ``center_m`` (3,) in the world; the rows
    of ``axes`` (3, 3) are the unit vectors along its edges, ``half_m`` (3,) half their lengths.
    """

    name: str
    product: str
    center_m: Array
    axes: Array
    half_m: Array

    def holds(self, position_m: Array) -> npt.NDArray[np.bool_]:
        """Tell which of the positions (n, 3) are in the box, (n,)."""
        along_edges_m = (position_m - self.center_m) @ self.axes.T
        return np.asarray(np.all(np.abs(along_edges_m) <= self.half_m, axis=1))


@dataclass(frozen=True)
class DeckPlan:
    """A deck of panels one after the other, seen from the side, whose contacts with particles are counted.

    ``along`` and ``across`` (3,) are horizontal unit vectors, the former in the direction of flow.
    ``points`` (m,) are the numbers of the surface points of the panels' centre lines, in that direction;
    ``panel`` (m,) is the place along the deck of each point's panel, from 0, and ``station_m`` (m,) its
    distance along the deck in the panels' material.  ``open_m`` (panels, 4) bounds the perforated part of
    each panel: lowest and highest station, then lowest and highest place across in the world; a panel without
    openings has the highest below the lowest.  A particle is within reach of the deck while the gap below it
    is less than ``reach_m``.  The upper and the lower side of each panel are ``half_depth_m`` (panels,) from
    the surface points; None where no panel has a depth.
    """

    along: Array
    across: Array
    points: Indices
    panel: Indices
    station_m: Array
    open_m: Array
    reach_m: float
    half_depth_m: Array | None = None

    @property
    def half_depths_m(self) -> Array:
        """The half depth (panels,) of each panel, 0 of those without one."""
        return np.zeros(self.panels) if self.half_depth_m is None else self.half_depth_m

    @property
    def panels(self) -> int:
        """The number of panels."""
        return len(self.open_m)


@dataclass(frozen=True)
class Jkr:
    """The law of adhesion after Johnson, Kendall and Roberts: ``work_J_per_m2`` (k, k) by material.

    ``largest_stretch``: how far a neck reaches before it snaps, at most, as a share of a radius.
    """

    work_J_per_m2: Array
    largest_stretch: float


@dataclass(frozen=True)
class Sjkr:
    """The law ``sjkr`` of LIGGGHTS: ``energy_density_J_per_m3`` (k, k) times the contact's area."""

    energy_density_J_per_m3: Array


@dataclass(frozen=True)
class Rebound:
    """The restitution of two materials, by number, over the normal speed with which bodies first touch.

    Between the points (n,), whose speeds grow, it is linear, and beyond them constant.  It stays that of the
    first touch as long as the contact lasts.
    """

    materials: tuple[int, int]
    speed_m_per_s: Array
    restitution: Array


@dataclass(frozen=True)
class AirPlan:
    """Still air around the particles, whose drag is that of spheres (``physics.sphere_drag_N``)."""

    density_kg_per_m3: float
    viscosity_Pa_s: float


@dataclass(frozen=True)
class ParticlesPlan:
    """The particles, the surface they touch, and the laws between them.

    ``restitution``, ``sliding_friction``, ``rolling_friction``: (k, k) symmetric, by material.
    ``rebounds``: those over speed; the pair's ``restitution`` is then that of the slowest impacts.
    ``wear_m3_per_N_m``: (k, k) too, volume that particles of one material wear off a surface of the
    other per force and distance slid; None where nothing wears.
    ``air``: the air that resists the particles; None for particles in a vacuum.
    ``predicts_load``: whether the particles are to predict their load (``ports.Predicting``).
    ``rolling``: the law of rolling resistance, where its coefficient is not zero.
    Particles in one of the ``exits``, or outside of ``domain_m`` (2, 3: lowest and highest
    corner), are removed; the first exit that holds one counts.  ``communicator`` is an mpi4py
    communicator or None.
    With ``periodic_y`` everything repeats itself along y with the domain's width, which the
    surface spans; nothing leaves there.
    ``deck``: the deck whose contacts with particles are counted; None counts nothing.
    ``shapes``: those of all particles, in the order of their numbers; ``largest_radius_m``: the largest
    bounding radius of all that there are or that come.
    """

    surface: TriangleSurface
    materials: tuple[GrainMaterial, ...]
    restitution: Array
    sliding_friction: Array
    rolling_friction: Array
    shapes: tuple[Shape, ...]
    particles: ParticleList
    largest_radius_m: float
    domain_m: Array
    gravity_m_per_s2: Array
    step_s: float
    sync_interval_s: float
    adhesion: Jkr | Sjkr | None = None
    rolling: Literal["epsd2", "cdt"] = "epsd2"
    rebounds: tuple[Rebound, ...] = ()
    wear_m3_per_N_m: Array | None = None
    air: AirPlan | None = None
    predicts_load: bool = False
    feed: ParticleFeed | None = None
    exits: tuple[ExitPlan, ...] = ()
    deck: DeckPlan | None = None
    periodic_y: bool = False
    communicator: Any = None
    folder: Path | None = None

    @property
    def counted_panels(self) -> int:
        """The number of panels whose contacts are counted."""
        return 0 if self.deck is None else self.deck.panels


@dataclass(frozen=True)
class Cost:
    """The processor time of a solver: ``opening_s`` until it is open, ``stepping_s`` of all its steps."""

    opening_s: float
    stepping_s: float


@dataclass(frozen=True)
class PanelsWork:
    """The work of ``panels`` equal panels, each of ``cells`` along and across.

    ``resolved_cells`` is the number of cells of all of them together where the mesh follows openings, else 0.
    They are moved over ``runs`` intervals of ``interval_s``; ``step_s`` is the largest step that the case
    allows, or 0 for the solver's own step.
    """

    panels: int
    cells: tuple[int, int]
    resolved_cells: int
    integrator: str
    step_s: float
    interval_s: float
    runs: float


@dataclass(frozen=True)
class FramesWork:
    """The work of ``bodies``, of which ``driven`` follow a drive, on ``bushings`` (each at one place).

    There are ``exciters``, of which ``motors`` lag; the bodies are moved over ``runs`` intervals of
    ``interval_s``.
    """

    bodies: int
    driven: int
    bushings: int
    exciters: int
    motors: int
    interval_s: float
    runs: float


@dataclass(frozen=True)
class ParticlesWork:
    """The work of particles.

    ``particle_steps`` counts the steps of all particles together, ``steps`` those of the solver, in ``runs``
    intervals; particles may touch ``triangles``; ``sticky`` says whether contacts have adhesion, and
    ``thrown`` whether particles fly in a thin layer, where they touch little.  ``spheres_each`` is the mean
    number of spheres of a particle, and 1 only if none is a clump; ``in_air`` says whether air resists them.
    """

    particle_steps: float
    steps: float
    runs: float
    triangles: int
    sticky: bool
    thrown: bool = False
    spheres_each: float = 1.0
    in_air: bool = False
