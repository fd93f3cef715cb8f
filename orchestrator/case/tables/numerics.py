"""How finely: the solver of each port and its settings, the coupling, the output.

These tables usually stand in a level (``levels/<level>.toml``).
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Literal, cast

from annotated_types import Ge, Gt, Le
from pydantic import Field, Strict

from orchestrator.case.solvers import NONE, SolverName, adapter
from orchestrator.case.tables.quantities import Cells, Name, NotNegative, Positive, Switch, Table

if TYPE_CHECKING:
    from orchestrator.ports.adapters import FramesAdapter, PanelAdapter, ParticlesAdapter


class PanelSolver(Table):
    """How the panels are solved."""

    solver: Annotated[str, SolverName("panel")] = "sheet"
    """The solver."""
    recording: str | None = None
    """File made by ``flipflow record``, for solver "recorded": its path from the case's folder,
    and a file in there where the case names it; ``--set`` may name any."""
    integrator: Literal["explicit", "implicit"] = "explicit"
    """Time integration of sheet and solid."""
    cells: Cells = (22, 8)
    """Finite-element cells along the free length and across; around openings the solid takes as
    many more as these need."""
    surface_cells: Cells = (22, 8)
    """Cells of the surface that particles touch; each is cut into two triangles."""
    step_s: NotNegative = 0.0
    """Largest time step; 0 takes the solver's own limit with a margin."""

    @property
    def adapter(self) -> PanelAdapter:
        """What the solver tells of itself."""
        return cast("PanelAdapter", adapter("panel", self.solver))


class FramesSolver(Table):
    """How the frames are solved."""

    solver: Annotated[str, SolverName("frames")] = "exudyn"
    """The solver."""
    step_s: NotNegative = 0.0
    """Largest time step; 0 takes the solver's own."""

    @property
    def adapter(self) -> FramesAdapter:
        """What the solver tells of itself."""
        return cast("FramesAdapter", adapter("frames", self.solver))


class ParticlesSolver(Table):
    """How the particles are solved."""

    solver: Annotated[str, SolverName("particles")] = "liggghts"
    """The solver; "none" lets the machine run empty."""
    step_s: NotNegative = 0.0
    """Largest time step; 0 takes ``rayleigh_fraction`` of the Rayleigh time."""
    rayleigh_fraction: Annotated[float, Strict(), Gt(0), Le(1)] = 0.15
    """Share of the smallest particle's Rayleigh time; above 0.2 is refused."""
    feed_interval_s: NotNegative = 0.002
    """Time between two batches of fed particles (0: every sync interval); new neighbour lists for a
    batch cost as much as seven steps."""
    largest_youngs_modulus_Pa: Positive | None = None
    """Stiffer materials are softened to this in contacts, which allows longer steps."""
    coarse_graining: Annotated[float, Strict(), Ge(1), Le(10)] = 1.0
    """Diameters are this much larger, and each particle stands for the cube of it: for layers that
    load the machine, refused for sizes below four openings (docs/theory/feed.md)."""
    softened_adhesion: Literal["sticking", "pull-off"] = "sticking"
    """What softened contacts keep: the speed below which particles stick, or the pull-off force."""
    adhesion: Literal["none", "sjkr", "jkr"] | None = None
    """Law of adhesion (docs/theory/adhesion.md); without, jkr where contacts have a work of
    adhesion."""
    sjkr_diameter_m: Positive | None = None
    """Diameter at which ``sjkr`` has the true pull-off force; without, the geometric mean of the
    smallest and the largest."""
    rolling: Literal["none", "cdt", "epsd2"] = "epsd2"
    """Law of rolling friction, where contacts have some: constant torque, or elastic-plastic."""
    wear: Literal["none", "archard"] = "archard"
    """Law of wear, where contacts have a specific one."""

    @property
    def adapter(self) -> ParticlesAdapter | None:
        """What the solver tells of itself; None for a machine that runs empty."""
        return None if self.solver == NONE else cast("ParticlesAdapter", adapter("particles", self.solver))


class Coupling(Table):
    """When solvers exchange motion and load."""

    scheme: Literal["particles-first", "robin", "serial-staggered", "aitken", "quasi-newton", "auto"] = "auto"
    """Order of the solvers within a sync interval (docs/theory/coupling.md): robin foretells with
    the contacts where panels go; aitken and quasi-newton repeat it until particles and panels
    agree; auto is particles-first within its safe interval, else robin (docs/theory/stability.md).
    """
    sync_interval_s: Positive = 5e-5
    """Time between two exchanges."""
    tolerance: Annotated[float, Strict(), Gt(0), Le(0.1)] = 1e-3
    """Of a repeated interval: by what share of its size the particles' load may differ from the one
    that the panels moved under."""
    most_iterations: Annotated[int, Strict(), Gt(0), Le(1000)] = 20
    """A repeated interval is run at most so many times; more is a warning."""


class Exchange(Table):
    """What is handed over.  Turning one off leaves out physics, to see what it
    does; momentum and energy then do not close, and the log says so."""

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
    """What is done about an item of the monitor."""

    then: Then
    """What is done beyond the limit."""
    limit: Annotated[float, Strict(), Ge(-1e12), Le(1e12)]
    """The largest value at which nothing is amiss, in the item's own unit."""


class MonitorSettings(Table):
    """What a run does about what should not happen: "warn" says it once and goes on; "shorten"
    runs the next sync intervals in halves, quarters … until nothing has been amiss for ``calm_s``;
    "stop" ends the run with its results kept (exit code 4), and names the last checkpoint from before.
    Looked at at output times; created energy, growing modes and crossings some five sync
    intervals after at the latest (docs/theory/stability.md)."""

    created_energy: Then = "shorten"
    """Energy that the coupling creates or destroys within some twenty intervals."""
    largest_created_share: Annotated[float, Strict(), Gt(0), Le(1)] = 0.05
    """Of the energy that went through the interface in them."""
    created_in_total: Literal["warn", "stop"] = "warn"
    """The same since t = 0, by the ledger; looked at at output times."""
    largest_created_in_total: Annotated[float, Strict(), Gt(0), Le(1)] = 0.01
    """Of the energy that went through the interface or was lost there since then
    (docs/theory/stability.md).  A run that ends beyond it is doubtful."""
    growing_modes: Then = "shorten"
    """Points of the surface that alternate from interval to interval, more and more."""
    largest_growing_share: Annotated[float, Strict(), Gt(0), Le(1)] = 0.1
    """Their speed, of the largest one that the surface had so far (root mean square)."""
    stretched_panels: Then = "warn"
    """Panels that are stretched too far anywhere, along an edge of the surface's triangles."""
    largest_stretch: Annotated[float, Strict(), Gt(0), Le(10)] = 0.3
    """Over the stress-free length: as far as the material's constants were measured.  Panels that
    work are stretched by some hundredths."""
    penetrated_surfaces: Literal["warn", "stop"] = "stop"
    """Panels that have gone through a rigid surface or another panel: none holds the other there (a
    beam that does is a stop of the panel).  One that hangs so at the start is refused."""
    largest_penetration: Annotated[float, Strict(), Ge(0), Le(1000)] = 0.5
    """How far the middle of the panel is beyond the surface, of the panel's thickness."""
    deep_overlaps: Then = "warn"
    """Particles that overlap each other or the surface too deeply."""
    largest_overlap: Annotated[float, Strict(), Gt(0), Le(1)] = 0.2
    """Of the smaller radius: twice what Hertz's theory wants, contacts small against bodies."""
    crossed_surface: Literal["warn", "stop"] = "stop"
    """Particles whose centre goes through the surface elsewhere than through an opening: contacts
    too soft or steps too long.  Looked for in every step of the particles; a run that goes on is
    doubtful."""
    most_crossings: Annotated[int, Strict(), Ge(0)] = 0
    """How often that may happen."""
    long_steps: Then = "warn"
    """Particles, or points of the surface, that move too far in a step of the particles."""
    largest_step_share: Annotated[float, Strict(), Gt(0), Le(1)] = 0.1
    """Of a radius (for the surface the smallest): farther, contacts are found late or never."""
    calm_s: NotNegative = 0.0
    """How long nothing must be amiss before intervals become longer again; 0: a cycle of the
    machine."""
    lost_particles: Literal["warn", "stop"] = "warn"
    """Particles that leave the domain elsewhere than through an exit."""
    escaped_particles: Literal["warn", "stop"] = "warn"
    """Particles that come out with the undersize although they fit through no opening: squeezed
    through (contacts too soft), or out beside the panels."""
    folded_panels: Literal["warn", "stop"] = "stop"
    """Panels whose middle line comes nearer to itself than the panel's thickness."""
    jammed_feed: Literal["warn", "stop"] = "stop"
    """A feed that took less than half of what was due for ``jam_s``."""
    jam_s: Positive = 0.2
    """How long."""
    items: dict[Name, ItemSettings] = Field(default_factory=dict)
    """What else is looked at: items that installed packages bring
    (docs/how-to/add-a-monitor-item.md)."""


class CheckpointSettings(Table):
    """When a run is saved while it goes on, so that ``flipflow resume`` can take it up again.  At
    its end, and where it is interrupted, it is saved in any case."""

    every_s: NotNegative = 0.0
    """Simulated time between two checkpoints; 0: none for that."""
    wall_min: NotNegative = 10.0
    """Wall time between two checkpoints; 0: none for that."""


class Output(Table):
    """What is written how often."""

    interval_s: Positive = 0.005
    """Time between snapshots for ParaView, shapes, the bed's profile and the energy ledger; means
    of the bed need four even phases of the machine's cycle."""
    series_s: NotNegative = 0.0
    """Time between rows of probes, frames, bushings and panel forces (means over it); 0: a row at
    every sync point.  Orbits need 20 in a cycle of the machine, accelerations one every 0.9 ms."""
    shapes_s: NotNegative = 0.0
    """Time between rows of the panels' whole shapes, which ``flipflow record`` needs; 0: none."""
    pictures: Switch = True
    """Make pictures at the end of the run."""
    cut_size_m: Positive | None = None
    """Size that divides fine from coarse in the results; else the openings' smaller side."""
