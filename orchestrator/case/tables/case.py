"""The case: everything that a run depends on, as frozen tables in SI units.

``case.toml`` says what (physics), ``levels/<level>.toml`` how finely (numerics); levels.py reads
and merges them.  docs/case-format.md lists every key.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Annotated, Any, Literal

from annotated_types import Ge, Gt, Le, Lt
from pydantic import Field, PrivateAttr, Strict

from orchestrator.case.solvers import NONE, Port
from orchestrator.case.tables.bed import Bed
from orchestrator.case.tables.numerics import (
    CheckpointSettings,
    Coupling,
    Exchange,
    FramesSolver,
    MonitorSettings,
    Output,
    PanelSolver,
    ParticlesSolver,
)
from orchestrator.case.tables.quantities import (
    Box,
    Name,
    NotNegative,
    OneLine,
    Positive,
    Share,
    Table,
    Text,
    Vector,
)
from orchestrator.case.tables.screen import Screen

if TYPE_CHECKING:
    from orchestrator.ports.adapters import Adapter


class Slice(Table):
    """The middle of the machine's width.  The case describes the whole machine; masses, bushings,
    exciters and feeds take their share, so that the frames move as the whole machine's.  Usually
    stands in a level."""

    width_m: Positive
    """Width of the slice."""
    sides: Literal["periodic", "walls"] = "periodic"
    """periodic: what leaves at one side comes back at the other, and walls along the sides are left
    out.  walls: they stand at the sides of the slice."""


class MaxwellBranch(Table):
    """A Maxwell branch: damping that relaxes."""

    ratio: Positive
    """Modulus of the branch over the elastic modulus."""
    relaxation_s: Positive
    """Relaxation time."""


class LossPoint(Table):
    """A point of a measured loss-factor curve."""

    frequency_Hz: Annotated[float, Strict(), Ge(1e-3), Le(1e6)]
    """Frequency."""
    loss_factor: Annotated[float, Strict(), Ge(1e-4), Le(10)]
    """Loss modulus over storage modulus."""
    storage_ratio: Annotated[float, Strict(), Ge(1), Le(1e3)] | None = None
    """Storage modulus over the elastic one, which C10 and C01 give; only if it was measured."""


class Hyperelastic(Table):
    """Two-parameter Mooney-Rivlin material of a panel."""

    c10_Pa: NotNegative
    """Coefficient of the first invariant."""
    c01_Pa: NotNegative
    """Coefficient of the second invariant."""
    bulk_modulus_Pa: Positive
    """Bulk modulus K of the volumetric energy K/2 (J - 1)^2."""
    maxwell: tuple[MaxwellBranch, ...] = ()
    """Branches that damp the panel."""
    loss_curve: tuple[LossPoint, ...] = ()
    """Measured loss factor, from low to high frequencies.  Without ``maxwell``, branches are fitted
    to it."""


class Material(Table):
    """A material of particles, walls or panels."""

    density_kg_per_m3: Positive
    """Density."""
    youngs_modulus_Pa: Positive | None = None
    """Young's modulus in contacts; a hyperelastic material has its own, 6 (C10 + C01)."""
    poisson_ratio: Annotated[float, Strict(), Ge(0), Lt(0.5)] | None = None
    """Poisson's ratio in contacts; a hyperelastic material has its own."""
    hyperelastic: Hyperelastic | None = None
    """What a panel's material needs besides."""


class Contact(Table):
    """How two materials meet.  Every pair that can meet must be given."""

    between: tuple[str, str]
    """The two materials; twice the same for particles among themselves."""
    restitution: Annotated[float, Strict(), Gt(0.05), Le(1)]
    """Coefficient of restitution; LIGGGHTS takes none of 0.05 or less."""
    sliding_friction: NotNegative
    """Coefficient of sliding friction."""
    rolling_friction: NotNegative
    """Coefficient of rolling friction: largest couple / (normal force x reduced radius)."""
    work_of_adhesion_J_per_m2: NotNegative = 0.0
    """Energy to part the two materials, per area: of like ones, twice the surface energy."""
    specific_wear_m3_per_N_m: NotNegative = 0.0
    """Volume that particles of one wear off a panel or surface of the other, per normal force and
    distance slid (docs/theory/wear.md)."""


class Probe(Table):
    """A point whose motion is recorded: on a frame, on a panel, or a particle."""

    frame: str | None = None
    """The frame that carries it; with ``point_m``."""
    point_m: Vector | None = None
    """Where it is on the frame at t = 0, in deck axes."""
    panel: str | None = None
    """The panel it is on; with ``at``."""
    at: tuple[Share, Share] | None = None
    """Where it is on the panel: fractions of the free length and of the width."""
    particle: Annotated[int, Strict(), Ge(1), Lt(2**63)] | None = None
    """The particle's id."""


class Case(Table):
    """One case with its level."""

    title: OneLine
    """One line that says what the case shows."""
    description: Text = ""
    """More about it: sources, assumptions."""
    default_level: str = ""
    """The level taken when none is asked for."""
    duration_s: Positive
    """Time to simulate."""
    effects: Literal["auto"] | tuple[str, ...] | None = None
    """Which effects the case has, of those that can be left out: without, what it describes; a list
    of names, exactly these; "auto", all but what `flipflow explain` says may be left out."""
    effects_for: tuple[str, ...] = ()
    """Results, by their short names, that "auto" must not change by more than a tenth; without,
    all that have one."""
    gravity_m_per_s2: Vector = (0.0, 0.0, -9.81)
    """Gravity, in world axes."""
    domain_m: Box
    """Lowest and highest corner, in world axes.  Particles that leave it elsewhere than through
    an exit are removed and count as lost."""
    materials: dict[Name, Material]
    """Materials by name."""
    contacts: tuple[Contact, ...] = ()
    """Contact properties of pairs of materials."""
    screen: Screen
    """The machine."""
    bed: Bed = Field(default_factory=Bed)
    """The particles."""
    slice: Slice | None = None
    """A strip of the width instead of the whole machine."""
    probes: dict[Name, Probe] = Field(default_factory=dict)
    """Probes by name."""
    coupling: Coupling = Field(default_factory=Coupling)
    """Exchange between the solvers."""
    exchange: Exchange = Field(default_factory=Exchange)
    """What is exchanged."""
    frames: FramesSolver = Field(default_factory=FramesSolver)
    """Solver of the frames."""
    panel: PanelSolver = Field(default_factory=PanelSolver)
    """Solver of the panels."""
    particles: ParticlesSolver = Field(default_factory=ParticlesSolver)
    """Solver of the particles."""
    monitor: MonitorSettings = Field(default_factory=MonitorSettings)
    """What stops a run."""
    checkpoint: CheckpointSettings = Field(default_factory=CheckpointSettings)
    """When the run is saved."""
    output: Output = Field(default_factory=Output)
    """What is written."""

    _whole: Case | None = PrivateAttr(default=None)
    _fine: Case | None = PrivateAttr(default=None)

    @property
    def adapters(self) -> dict[Port, Adapter[Any, Any, Any]]:
        """The adapters of its solvers, by port; an empty machine has none for particles."""
        adapters: dict[Port, Adapter[Any, Any, Any]] = {
            "panel": self.panel.adapter,
            "frames": self.frames.adapter,
        }
        if self.particles.adapter is not None:
            adapters["particles"] = self.particles.adapter
        return adapters

    @property
    def whole(self) -> Case:
        """The case of the whole machine: itself, or what this slice was cut from."""
        return self._whole or self

    @property
    def as_given(self) -> Case:
        """The whole machine with particles as fine as the user gave them."""
        return self.whole._fine or self.whole

    def with_coarse(self, update: dict[str, object]) -> Case:
        """A copy with coarse particles."""
        coarse = self.model_copy(update=update)
        coarse._fine = self
        return coarse

    def cut_to(self, update: dict[str, object]) -> Case:
        """A slice of it: a copy with some tables in the place of its own."""
        part = self.model_copy(update=update)
        part._whole = self
        return part


def has_particles(case: Case) -> bool:
    """Whether there are or will be any."""
    described = case.bed.particles or case.bed.blocks or case.bed.feeds
    return bool(described) and case.particles.solver != NONE


def damped_contacts(case: Case) -> bool:
    """Whether particles lose energy where they touch something."""
    return has_particles(case) and any(row.restitution < 1 for row in case.contacts)


def absent(case: Case) -> dict[str, str]:
    """What this case does not have at all, and another might: name -> why."""
    screen = case.screen
    there = {
        "particles": (has_particles(case), "the bed is empty, or particles.solver none"),
        "exciters": (bool(screen.exciters), "there are none"),
        "bushings": (bool(screen.bushings), "there are none"),
        "surfaces": (bool(screen.surfaces), "there are none"),
        "gravity": (any(case.gravity_m_per_s2), "gravity_m_per_s2 is zero"),
    }
    return {name: why for name, (is_there, why) in there.items() if not is_there}
