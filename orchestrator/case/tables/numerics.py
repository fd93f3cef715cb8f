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
    """The solver of the panels."""

    solver: Annotated[str, SolverName("panel")] = "sheet"
    """Its name."""
    integrator: Literal["explicit", "implicit"] = "explicit"
    """Time integration of "sheet" and "solid"."""
    cells: Cells = (22, 8)
    """Finite elements along and across, with "solid" besides openings."""
    surface_cells: Cells = (22, 8)
    """Cells of the surface that particles touch, along and across, two triangles each."""
    step_s: NotNegative = 0.0
    """Largest time step; 0: the solver's limit with a margin."""

    @property
    def adapter(self) -> PanelAdapter:
        """The adapter of the solver."""
        return cast("PanelAdapter", adapter("panel", self.solver))


class FramesSolver(Table):
    """The solver of the frames."""

    solver: Annotated[str, SolverName("frames")] = "exudyn"
    """Its name."""
    step_s: NotNegative = 0.0
    """Largest time step; 0: the solver's own."""

    @property
    def adapter(self) -> FramesAdapter:
        """The adapter of the solver."""
        return cast("FramesAdapter", adapter("frames", self.solver))


class ParticlesSolver(Table):
    """The solver of the particles."""

    solver: Annotated[str, SolverName("particles")] = "liggghts"
    """Its name; with "none" the machine runs empty."""
    step_s: NotNegative = 0.0
    """Largest time step; 0: by ``rayleigh_fraction``."""
    rayleigh_fraction: Annotated[float, Strict(), Gt(0), Le(1)] = 0.2
    """Largest step over the smallest Rayleigh time, at most 0.2."""
    feed_interval_s: NotNegative = 0.002
    """Time between batches of fed particles, each of which costs seven steps; 0: every sync interval."""
    largest_youngs_modulus_Pa: Positive | None = None
    """Stiffer contacts are softened to it, for longer steps."""
    coarse_graining: Annotated[float, Strict(), Ge(1), Le(10)] = 1.0
    """Factor k on diameters, a particle for k^3; not for particles below four openings
    (docs/theory/feed.md)."""
    softened_adhesion: Literal["sticking", "pull-off"] | None = None
    """What softened contacts keep: the speed below which particles stick, or the force, the default with
    a bond number or moisture."""
    adhesion: Literal["none", "sjkr", "jkr"] | None = None
    """Law (docs/theory/adhesion.md); by default jkr if contacts have a work of adhesion."""
    sjkr_diameter_m: Positive | None = None
    """Real diameter with sjkr's true pull-off force; by default the geometric mean of the extremes."""
    rolling: Literal["none", "cdt", "epsd2"] = "epsd2"
    """Law of rolling friction. cdt: constant torque. epsd2: elastic-plastic."""
    wear: Literal["none", "archard"] = "archard"
    """Law of wear."""
    air_drag: Literal["none", "schiller-naumann"] = "schiller-naumann"
    """Law of drag in ``air``."""

    @property
    def adapter(self) -> ParticlesAdapter | None:
        """The adapter of the solver; None for a machine that runs empty."""
        return None if self.solver == NONE else cast("ParticlesAdapter", adapter("particles", self.solver))


class Coupling(Table):
    """The exchange of motion and load between the solvers."""

    scheme: Literal["particles-first", "robin", "serial-staggered", "aitken", "quasi-newton", "auto"] = "auto"
    """Order of the solvers (docs/theory/coupling.md): robin predicts the panels' motion, aitken and
    quasi-newton repeat intervals; auto: the first safe one of particles-first, robin, aitken."""
    sync_interval_s: Positive = 5e-5
    """Time between two exchanges."""
    tolerance: Annotated[float, Strict(), Gt(0), Le(0.1)] = 1e-3
    """Largest relative difference of the loads in a repeated interval."""
    most_iterations: Annotated[int, Strict(), Gt(0), Le(1000)] = 60
    """Most runs of a repeated interval, else a warning."""


class Exchange(Table):
    """What the solvers exchange; without one, physics is left out, and balances do not close."""

    frame_motion: Switch = True
    """Frames move the panels' clamps."""
    panel_motion: Switch = True
    """Panels and walls move the surface that particles touch."""
    particle_load: Switch = True
    """Particles load the panels."""
    panel_reaction: Switch = True
    """Panels and walls push the frames."""


Then = Literal["warn", "shorten", "stop"]


class ItemSettings(Table):
    """An additional item of an installed package (docs/how-to/add-a-monitor-item.md)."""

    then: Then
    """Reaction above the limit."""
    limit: Annotated[float, Strict(), Ge(-1e12), Le(1e12)]
    """Largest value, in the item's unit."""


class MonitorSettings(Table):
    """Reactions to events that should not happen ([how often it looks](theory/stability.md)): "warn" once;
    "shorten" the sync intervals, up to 64 times, until ``calm_s`` has passed without one; or "stop" the run
    (exit code 4), with its results and the last checkpoint before.  NaN, points faster than 300 m/s and
    particles that their solver has lost always stop it."""

    created_energy: Then = "shorten"
    """The coupling makes or destroys energy within some twenty intervals."""
    largest_created_share: Annotated[float, Strict(), Gt(0), Le(1)] = 0.05
    """This over the energy through the interface."""
    created_in_total: Literal["warn", "stop"] = "warn"
    """The same since t = 0, by the ledger every 5 ms."""
    largest_created_in_total: Annotated[float, Strict(), Gt(0), Le(1)] = 0.01
    """This over the energy through the interface or lost; beyond it a run is
    [doubtful](theory/stability.md)."""
    growing_modes: Then = "shorten"
    """Points of the surface alternate from interval to interval and grow."""
    largest_growing_share: Annotated[float, Strict(), Gt(0), Le(1)] = 0.1
    """Their speed over the largest so far (root mean square)."""
    stretched_panels: Then = "warn"
    """A panel is stretched too far along an edge of a triangle."""
    largest_stretch: Annotated[float, Strict(), Gt(0), Le(10)] = 0.3
    """Elongation over length; constants are measured up to the default."""
    penetrated_surfaces: Literal["warn", "stop"] = "stop"
    """A panel goes through a surface or panel; a beam on which it may lie must be a stop.  At the start
    it is refused."""
    largest_penetration: Annotated[float, Strict(), Ge(0), Le(1000)] = 0.5
    """Distance of its middle beyond, over its thickness."""
    deep_overlaps: Then = "warn"
    """Particles overlap too deeply."""
    largest_overlap: Annotated[float, Strict(), Gt(0), Le(1)] = 0.2
    """Over the smaller radius; the default is twice the limit of Hertz's theory."""
    crossed_surface: Literal["warn", "stop"] = "stop"
    """A particle's centre goes through the surface beside openings: contacts are too soft or steps too
    long; doubtful."""
    most_crossings: Annotated[int, Strict(), Ge(0)] = 0
    """Crossings that are accepted."""
    long_steps: Then = "warn"
    """Particles or points of the surface move too far in a particle step."""
    largest_step_share: Annotated[float, Strict(), Gt(0), Le(1)] = 0.1
    """Over the radius, of points over the smallest."""
    calm_s: NotNegative = 0.0
    """Time without events until intervals lengthen; 0: a cycle, or 100 intervals without a drive."""
    lost_particles: Literal["warn", "stop"] = "warn"
    """Particles leave the domain beside exits."""
    escaped_particles: Literal["warn", "stop"] = "warn"
    """Particles that fit no opening leave with the undersize."""
    folded_panels: Literal["warn", "stop"] = "stop"
    """A panel's middle line is nearer to itself than its thickness."""
    jammed_feed: Literal["warn", "stop"] = "stop"
    """A feed takes less than half of what is due in ``jam_s``."""
    jam_s: Positive = 0.2
    """Time over which a feed is judged."""
    items: dict[Name, ItemSettings] = Field(default_factory=dict)
    """Additional items by name."""


class CheckpointSettings(Table):
    """Checkpoints for ``flipflow resume``, besides those at the end and when interrupted."""

    every_s: NotNegative = 0.0
    """Simulated time between two; 0: none."""
    wall_min: NotNegative = 10.0
    """Wall time between two; 0: none."""


class Output(Table):
    """The output of a run."""

    interval_s: Positive = 0.005
    """Time between snapshots for ParaView, profiles and the ledger; means of the bed need four in a
    cycle."""
    series_s: NotNegative = 0.0
    """Time between rows of probes, frames, bushings and mean panel forces; 0: every sync point.  Orbits
    need 20 in a cycle, accelerations one in 0.9 ms."""
    shapes_s: NotNegative = 0.0
    """Time between rows of panel shapes; 0: none."""
    loads_s: NotNegative = 0.0
    """Time between rows of all loads for ``flipflow loads``; 0: none."""
    pictures: Switch = True
    """Whether pictures are made at the end."""
    cut_size_m: Positive | None = None
    """Size that divides fine from coarse; by default the smaller side of a single deck's largest openings."""
