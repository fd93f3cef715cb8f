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
    """The panels' solver."""

    solver: Annotated[str, SolverName("panel")] = "sheet"
    """[Name](#solvers)."""
    integrator: Literal["explicit", "implicit"] = "explicit"
    """Of "sheet" and "solid"."""
    cells: Cells = (22, 8)
    """Finite elements along, across; of "solid" beside openings."""
    surface_cells: Cells = (22, 8)
    """Of the touched surface, two triangles each."""
    step_s: NotNegative = 0.0
    """Largest step; 0: the solver's limit."""

    @property
    def adapter(self) -> PanelAdapter:
        """The adapter of the solver."""
        return cast("PanelAdapter", adapter("panel", self.solver))


class FramesSolver(Table):
    """The frames' solver."""

    solver: Annotated[str, SolverName("frames")] = "exudyn"
    """[Name](#solvers)."""
    step_s: NotNegative = 0.0
    """Largest step; 0: the solver's."""

    @property
    def adapter(self) -> FramesAdapter:
        """The adapter of the solver."""
        return cast("FramesAdapter", adapter("frames", self.solver))


class ParticlesSolver(Table):
    """The particles' solver."""

    solver: Annotated[str, SolverName("particles")] = "liggghts"
    """[Name](#solvers); "none": an empty machine."""
    step_s: NotNegative = 0.0
    """Largest step; 0: by ``rayleigh_fraction``."""
    rayleigh_fraction: Annotated[float, Strict(), Gt(0), Le(1)] = 0.2
    """Largest step over the smallest Rayleigh time, at most 0.2."""
    feed_interval_s: NotNegative = 0.002
    """Between batches, which cost seven steps; 0: the sync interval."""
    largest_youngs_modulus_Pa: Positive | None = None
    """Softens stiffer contacts, for longer steps."""
    coarse_graining: Annotated[float, Strict(), Ge(1), Le(10)] = 1.0
    """Factor k on diameters, one particle for k^3; none below four openings (docs/theory/feed.md)."""
    softened_adhesion: Literal["sticking", "pull-off"] | None = None
    """Of softened contacts: kept speed of sticking, or kept force, the default with a bond number or
    moisture."""
    adhesion: Literal["none", "sjkr", "jkr"] | None = None
    """Law (docs/theory/adhesion.md); else jkr, if there is adhesion."""
    sjkr_diameter_m: Positive | None = None
    """Diameter with the true pull-off force; else the geometric mean of the extremes."""
    rolling: Literal["none", "cdt", "epsd2"] = "epsd2"
    """Law. cdt: constant torque. epsd2: elastic-plastic."""
    wear: Literal["none", "archard"] = "archard"
    """Law."""
    air_drag: Literal["none", "schiller-naumann"] = "schiller-naumann"
    """Law in ``air``."""

    @property
    def adapter(self) -> ParticlesAdapter | None:
        """The adapter of the solver; None for a machine that runs empty."""
        return None if self.solver == NONE else cast("ParticlesAdapter", adapter("particles", self.solver))


class Coupling(Table):
    """The exchange between the solvers."""

    scheme: Literal["particles-first", "robin", "serial-staggered", "aitken", "quasi-newton", "auto"] = "auto"
    """Order of solvers (docs/theory/coupling.md); auto: the first safe of particles-first, robin, aitken."""
    sync_interval_s: Positive = 5e-5
    """Between exchanges."""
    tolerance: Annotated[float, Strict(), Gt(0), Le(0.1)] = 1e-3
    """Relative, of the loads in repeated intervals."""
    most_iterations: Annotated[int, Strict(), Gt(0), Le(1000)] = 60
    """Runs of an interval, else a warning."""


class Exchange(Table):
    """What the solvers exchange; without one, balances do not close."""

    frame_motion: Switch = True
    """Frames move the panels' clamps."""
    panel_motion: Switch = True
    """Panels and walls move the touched surface."""
    particle_load: Switch = True
    """Particles load the panels."""
    panel_reaction: Switch = True
    """Panels and walls push the frames."""


Then = Literal["warn", "shorten", "stop"]


class ItemSettings(Table):
    """An item of an installed package (docs/how-to/add-a-monitor-item.md)."""

    then: Then
    """Reaction."""
    limit: Annotated[float, Strict(), Ge(-1e12), Le(1e12)]
    """Largest value."""


class MonitorSettings(Table):
    """Reactions to [events](theory/stability.md): "warn" once, "shorten" the sync intervals, up to 64
    times, until ``calm_s`` has passed without one, or "stop" (exit code 4).  NaN, points faster than 300 m/s
    and lost particles always stop.  A `largest_` or `most_` is the limit of the key above it."""

    created_energy: Then = "shorten"
    """The coupling makes or destroys energy, in some twenty intervals."""
    largest_created_share: Annotated[float, Strict(), Gt(0), Le(1)] = 0.05
    """Over energy exchanged."""
    created_in_total: Literal["warn", "stop"] = "warn"
    """Since t = 0, by the ledger."""
    largest_created_in_total: Annotated[float, Strict(), Gt(0), Le(1)] = 0.01
    """Over energy exchanged or lost; beyond it a run is doubtful."""
    growing_modes: Then = "shorten"
    """Points of the surface alternate and grow."""
    largest_growing_share: Annotated[float, Strict(), Gt(0), Le(1)] = 0.1
    """Their rms speed over the largest so far."""
    stretched_panels: Then = "warn"
    """A panel stretches too far."""
    largest_stretch: Annotated[float, Strict(), Gt(0), Le(10)] = 0.3
    """Elongation over length."""
    penetrated_surfaces: Literal["warn", "stop"] = "stop"
    """A panel goes through a surface or panel; a beam under it is a stop. Refused at the start."""
    largest_penetration: Annotated[float, Strict(), Ge(0), Le(1000)] = 0.5
    """Depth of its middle over thickness."""
    deep_overlaps: Then = "warn"
    """Particles overlap too deeply."""
    largest_overlap: Annotated[float, Strict(), Gt(0), Le(1)] = 0.2
    """Over the smaller radius; Hertz's limit is 0.1."""
    crossed_surface: Literal["warn", "stop"] = "stop"
    """A centre passes the surface beside openings: too soft, steps too long."""
    most_crossings: Annotated[int, Strict(), Ge(0)] = 0
    """Crossings."""
    long_steps: Then = "warn"
    """Particles or points move too far in a step."""
    largest_step_share: Annotated[float, Strict(), Gt(0), Le(1)] = 0.1
    """Over the (smallest) radius."""
    calm_s: NotNegative = 0.0
    """Quiet time until intervals lengthen; 0: a cycle or 100 intervals."""
    lost_particles: Literal["warn", "stop"] = "warn"
    """Particles leave the domain beside exits."""
    escaped_particles: Literal["warn", "stop"] = "warn"
    """Undersize has particles that fit no opening."""
    folded_panels: Literal["warn", "stop"] = "stop"
    """A panel's middle line nears itself to its thickness."""
    jammed_feed: Literal["warn", "stop"] = "stop"
    """A feed brings less than half in ``jam_s``."""
    jam_s: Positive = 0.2
    """Time that judges a feed."""
    items: dict[Name, ItemSettings] = Field(default_factory=dict)
    """Additional items by name."""


class CheckpointSettings(Table):
    """More checkpoints than at the end and when interrupted."""

    every_s: NotNegative = 0.0
    """Simulated time between; 0: none."""
    wall_min: NotNegative = 10.0
    """Wall time between; 0: none."""


class Output(Table):
    """Output: times between rows, 0 for none."""

    interval_s: Positive = 0.005
    """Snapshots, profiles, ledger; means of the bed need four in a cycle."""
    series_s: NotNegative = 0.0
    """Probes, frames, bushings, panel forces; 0: every sync point. Orbits need 20 in a cycle, accelerations
    one in 0.9 ms."""
    shapes_s: NotNegative = 0.0
    """Panel shapes."""
    loads_s: NotNegative = 0.0
    """Loads, for ``flipflow loads``."""
    pictures: Switch = True
    """At the end."""
    cut_size_m: Positive | None = None
    """Fine from coarse; else the openings' smaller side."""
