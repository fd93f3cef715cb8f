"""The tables of the numerics: the solvers and their settings, the coupling, the monitor and the output.

These tables usually stand in a level (``levels/<level>.toml``).
"""

from __future__ import annotations

from typing import Annotated, Literal, cast

from annotated_types import Ge, Gt, Le
from pydantic import Field, Strict

from orchestrator.case.solvers import NONE, SolverName, adapter
from orchestrator.case.tables.quantities import Cells, Name, NotNegative, Positive, Switch, Table
from orchestrator.ports.adapters import FramesAdapter, PanelAdapter, ParticlesAdapter


class PanelSolver(Table):
    """The solver of the panels and its settings."""

    solver: Annotated[str, SolverName("panel")] = "sheet"
    """Name of the solver."""
    integrator: Literal["explicit", "implicit"] = "explicit"
    """Time integration of the solvers "sheet" and "solid"."""
    cells: Cells = (22, 8)
    """Numbers of finite-element cells along the free length and across.  The solver "solid" adds the
    cells that openings need."""
    surface_cells: Cells = (22, 8)
    """Numbers of cells, along the free length and across, of the surface that particles touch; each cell
    is cut into two triangles."""
    step_s: NotNegative = 0.0
    """Largest time step; 0 takes the solver's own limit with a margin."""

    @property
    def adapter(self) -> PanelAdapter:
        """The adapter of the solver."""
        return cast("PanelAdapter", adapter("panel", self.solver))


class FramesSolver(Table):
    """The solver of the frames and its settings."""

    solver: Annotated[str, SolverName("frames")] = "exudyn"
    """Name of the solver."""
    step_s: NotNegative = 0.0
    """Largest time step; 0 takes the solver's own step."""

    @property
    def adapter(self) -> FramesAdapter:
        """The adapter of the solver."""
        return cast("FramesAdapter", adapter("frames", self.solver))


class ParticlesSolver(Table):
    """The solver of the particles and its settings."""

    solver: Annotated[str, SolverName("particles")] = "liggghts"
    """Name of the solver; "none" lets the machine run empty."""
    step_s: NotNegative = 0.0
    """Largest time step; 0 takes ``rayleigh_fraction`` of the Rayleigh time."""
    rayleigh_fraction: Annotated[float, Strict(), Gt(0), Le(1)] = 0.2
    """Largest time step as a share of the smallest particle's Rayleigh time; values above 0.2 are
    refused."""
    feed_interval_s: NotNegative = 0.002
    """Time between two batches of fed particles; 0 feeds in every sync interval.  The new neighbour lists
    for a batch cost as much time as seven steps."""
    largest_youngs_modulus_Pa: Positive | None = None
    """Largest Young's modulus in contacts.  Stiffer materials are softened to it, which allows longer
    steps."""
    coarse_graining: Annotated[float, Strict(), Ge(1), Le(10)] = 1.0
    """Factor k by which diameters are enlarged; each particle then stands for k^3 particles.  It is meant
    for layers that load the machine, and is refused for particles smaller than four openings
    (docs/theory/feed.md)."""
    softened_adhesion: Literal["sticking", "pull-off"] | None = None
    """Property that softened contacts keep.  sticking: the speed below which particles stick.
    pull-off: the pull-off force.  By default, it is pull-off if a contact has a bond_number or a class of
    moisture, and else sticking."""
    adhesion: Literal["none", "sjkr", "jkr"] | None = None
    """Law of adhesion (docs/theory/adhesion.md).  By default, it is jkr if contacts have a work of
    adhesion."""
    sjkr_diameter_m: Positive | None = None
    """Diameter of real particles at which ``sjkr`` has the true pull-off force.  By default, it is the
    geometric mean of the smallest and the largest diameter."""
    rolling: Literal["none", "cdt", "epsd2"] = "epsd2"
    """Law of rolling friction for contacts that have some.  cdt: constant torque.  epsd2:
    elastic-plastic."""
    wear: Literal["none", "archard"] = "archard"
    """Law of wear for contacts that have a specific wear."""
    air_drag: Literal["none", "schiller-naumann"] = "schiller-naumann"
    """Law of the drag of the air, in cases that have ``air``."""

    @property
    def adapter(self) -> ParticlesAdapter | None:
        """The adapter of the solver; None for a machine that runs empty."""
        return None if self.solver == NONE else cast("ParticlesAdapter", adapter("particles", self.solver))


class Coupling(Table):
    """The scheme and the times of the exchange of motion and load between the solvers."""

    scheme: Literal["particles-first", "robin", "serial-staggered", "aitken", "quasi-newton", "auto"] = "auto"
    """Order of the solvers within a sync interval (docs/theory/coupling.md).  robin predicts the motion of
    the panels from the contacts.  aitken and quasi-newton repeat the interval until particles and panels
    agree.  auto is the first of particles-first, robin and aitken for which the interval is safe
    (docs/theory/stability.md)."""
    sync_interval_s: Positive = 5e-5
    """Time between two exchanges."""
    tolerance: Annotated[float, Strict(), Gt(0), Le(0.1)] = 1e-3
    """Largest relative difference, in a repeated interval, between the particles' load and the load under
    which the panels moved."""
    most_iterations: Annotated[int, Strict(), Gt(0), Le(1000)] = 60
    """Largest number of runs of a repeated interval.  A warning appears if they do not suffice."""


class Exchange(Table):
    """The quantities that the solvers exchange.  A quantity that is turned off leaves out physics, which
    shows its influence.  The balances of momentum and energy then do not close, and the log says so."""

    frame_motion: Switch = True
    """Whether frames move the panels' clamps."""
    panel_motion: Switch = True
    """Whether panels and walls move the surface that particles touch."""
    particle_load: Switch = True
    """Whether particles load the panels."""
    panel_reaction: Switch = True
    """Whether panels and walls push the frames."""


Then = Literal["warn", "shorten", "stop"]


class ItemSettings(Table):
    """The settings of an additional item of the monitor."""

    then: Then
    """Reaction to a value above the limit."""
    limit: Annotated[float, Strict(), Ge(-1e12), Le(1e12)]
    """Largest acceptable value, in the unit of the item."""


class MonitorSettings(Table):
    """The reactions of a run to events that should not happen.  "warn" warns once, and the run continues.
    "shorten" runs the next sync intervals in halves, quarters and so on, until no such event has happened
    for ``calm_s``.  "stop" ends the run (exit code 4), keeps its results, and names the last checkpoint
    before the event.  Whatever the output, the run looks at surfaces every millisecond, at bed and
    ledger every five, and at created energy, growing modes and crossings at most some five sync intervals
    after they happen (docs/theory/stability.md)."""

    created_energy: Then = "shorten"
    """Reaction to energy that the coupling creates or destroys within some twenty intervals."""
    largest_created_share: Annotated[float, Strict(), Gt(0), Le(1)] = 0.05
    """Largest acceptable share of created energy in the energy that went through the interface in these
    intervals."""
    created_in_total: Literal["warn", "stop"] = "warn"
    """Reaction to energy that the coupling has created or destroyed since t = 0 according to the energy
    ledger, which is checked every 5 ms."""
    largest_created_in_total: Annotated[float, Strict(), Gt(0), Le(1)] = 0.01
    """Largest acceptable share of created energy in the energy that went through the interface or was lost
    there since t = 0 (docs/theory/stability.md).  A run that ends above it is doubtful."""
    growing_modes: Then = "shorten"
    """Reaction to points of the surface whose motion alternates from interval to interval and grows."""
    largest_growing_share: Annotated[float, Strict(), Gt(0), Le(1)] = 0.1
    """Largest acceptable speed of such points, as a share of the largest speed that the surface has had
    (root mean square)."""
    stretched_panels: Then = "warn"
    """Reaction to a panel that is stretched too far along any edge of the surface's triangles."""
    largest_stretch: Annotated[float, Strict(), Gt(0), Le(10)] = 0.3
    """Largest acceptable elongation, as a share of the stress-free length.  The material's constants were
    measured up to the default; panels at work are stretched by some hundredths."""
    penetrated_surfaces: Literal["warn", "stop"] = "stop"
    """Reaction to a panel that has gone through a rigid surface or another panel.  The simulation does not
    prevent this; a beam on which a panel may lie must be a stop of the panel.  A case in which a panel
    penetrates a surface at the start is refused."""
    largest_penetration: Annotated[float, Strict(), Ge(0), Le(1000)] = 0.5
    """Largest acceptable distance of the panel's middle beyond the surface, as a share of the panel's
    thickness."""
    deep_overlaps: Then = "warn"
    """Reaction to particles that overlap each other or the surface too deeply."""
    largest_overlap: Annotated[float, Strict(), Gt(0), Le(1)] = 0.2
    """Largest acceptable overlap, as a share of the smaller radius.  The default is twice the limit of
    Hertz's theory, which assumes that contacts are small compared to the bodies."""
    crossed_surface: Literal["warn", "stop"] = "stop"
    """Reaction to particles whose centre goes through the surface elsewhere than through an opening,
    because contacts are too soft or steps too long.  Every step of the particles is checked.  A run that
    continues is doubtful."""
    most_crossings: Annotated[int, Strict(), Ge(0)] = 0
    """Largest acceptable number of such crossings."""
    long_steps: Then = "warn"
    """Reaction to particles, or points of the surface, that move too far in a step of the particles."""
    largest_step_share: Annotated[float, Strict(), Gt(0), Le(1)] = 0.1
    """Largest acceptable distance in a step, as a share of the particle's radius; for points of the
    surface, of the smallest radius.  After longer steps, contacts are detected late or never."""
    calm_s: NotNegative = 0.0
    """Time without any such event after which intervals become longer again; 0 takes a cycle of the
    machine, or 100 sync intervals if nothing drives it."""
    lost_particles: Literal["warn", "stop"] = "warn"
    """Reaction to particles that leave the domain elsewhere than through an exit."""
    escaped_particles: Literal["warn", "stop"] = "warn"
    """Reaction to particles that leave with the undersize although they fit through no opening.  They were
    squeezed through because contacts are too soft, or they left beside the panels."""
    folded_panels: Literal["warn", "stop"] = "stop"
    """Reaction to panels whose middle line comes nearer to itself than the panel's thickness."""
    jammed_feed: Literal["warn", "stop"] = "stop"
    """Reaction to a feed that took less than half of the mass that was due in ``jam_s``."""
    jam_s: Positive = 0.2
    """Time over which a feed is judged."""
    items: dict[Name, ItemSettings] = Field(default_factory=dict)
    """Settings of additional items, which installed packages bring (docs/how-to/add-a-monitor-item.md)."""


class CheckpointSettings(Table):
    """The times between checkpoints, from which ``flipflow resume`` can continue a run.  A run always
    writes a checkpoint at its end and when it is interrupted."""

    every_s: NotNegative = 0.0
    """Simulated time between two checkpoints; 0 means that simulated time causes no checkpoints."""
    wall_min: NotNegative = 10.0
    """Wall time between two checkpoints; 0 means that wall time causes no checkpoints."""


class Output(Table):
    """The output of a run and its intervals."""

    interval_s: Positive = 0.005
    """Time between two outputs of snapshots for ParaView, shapes, the bed's profile and the energy ledger.
    Means of the bed need outputs at four evenly spaced phases of the machine's cycle."""
    series_s: NotNegative = 0.0
    """Time between two rows of probes, frames, bushings and panel forces (which are means over it); 0
    writes a row at every sync point.  Orbits need 20 rows in a cycle of the machine, and accelerations
    need a row every 0.9 ms."""
    shapes_s: NotNegative = 0.0
    """Time between two rows of the panels' whole shapes; 0 writes none."""
    loads_s: NotNegative = 0.0
    """Time between two rows of all forces on the frames, which ``flipflow loads`` hands to a program for
    their strength; 0 writes none."""
    pictures: Switch = True
    """Whether pictures are made at the end of the run."""
    cut_size_m: Positive | None = None
    """Size that divides fine from coarse particles in the results.  By default, it is the smaller side of
    the openings."""
