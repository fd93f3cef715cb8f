"""The case: everything that a run depends on, as frozen tables in SI units.

``case.toml`` describes the physics, and ``levels/<level>.toml`` the numerics; load.py reads and
merges them.  docs/case-format.md lists every key.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

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
from orchestrator.ports.adapters import Adapter


class Slice(Table):
    """A strip in the middle of the machine's width.  The case describes the whole machine; the slice
    has its share of masses, bushings, exciters and feeds, so that its frames move as the frames of the
    whole machine do.  This table usually stands in a level."""

    width_m: Positive
    """Width of the slice."""
    sides: Literal["periodic", "walls"] = "periodic"
    """periodic: particles that leave at one side come back at the other, and walls along the sides are
    left out.  walls: the walls along the sides are moved to the sides of the slice."""


class MaxwellBranch(Table):
    """A Maxwell branch: a spring and a damper in series, whose stress relaxes."""

    ratio: Positive
    """Modulus of the branch divided by the elastic modulus."""
    relaxation_s: Positive
    """Relaxation time."""


class LossPoint(Table):
    """A point of a measured loss-factor curve."""

    frequency_Hz: Annotated[float, Strict(), Ge(1e-3), Le(1e6)]
    """Frequency."""
    loss_factor: Annotated[float, Strict(), Ge(1e-4), Le(10)]
    """Loss modulus divided by storage modulus."""
    storage_ratio: Annotated[float, Strict(), Ge(1), Le(1e3)] | None = None
    """Storage modulus divided by the elastic modulus, which follows from C10 and C01.  Give it only if
    it was measured."""


class Hyperelastic(Table):
    """The two-parameter Mooney-Rivlin material of a panel."""

    c10_Pa: NotNegative
    """Coefficient of the first invariant."""
    c01_Pa: NotNegative
    """Coefficient of the second invariant."""
    bulk_modulus_Pa: Positive
    """Bulk modulus K of the volumetric energy K/2 (J - 1)^2."""
    maxwell: tuple[MaxwellBranch, ...] = ()
    """Branches that damp the panel."""
    loss_curve: tuple[LossPoint, ...] = ()
    """Measured loss factor, from low to high frequencies.  If ``maxwell`` is empty, branches are fitted
    to this curve."""


class FatigueLine(Table):
    """The user's own line of a material's life under cycles of strain:
    cycles x (strain_amplitude / amplitude)^slope.  It only ranks the panels of a run."""

    strain_amplitude: Annotated[float, Strict(), Gt(0), Le(1)]
    """Strain amplitude, half of the range of a cycle."""
    cycles: Annotated[float, Strict(), Ge(1), Le(1e15)]
    """Cycles to failure at this amplitude."""
    slope: Annotated[float, Strict(), Gt(0), Le(50)]
    """Slope of the line over logarithms: ten times the amplitude divides the cycles by 10^slope."""


class Material(Table):
    """A material of particles, walls or panels.  A material of the library needs no table: ``material =
    "limestone"`` is enough, and its table may give single keys that replace the library's
    (docs/materials.md)."""

    like: OneLine | None = None
    """Name of a material of the library, which gives all keys that this table does not.  By default, it is
    this material's own name."""
    density_kg_per_m3: Positive
    """Density."""
    youngs_modulus_Pa: Positive | None = None
    """Young's modulus in contacts.  For a hyperelastic material the default is some 6 (C10 + C01)."""
    poisson_ratio: Annotated[float, Strict(), Ge(0), Lt(0.5)] | None = None
    """Poisson's ratio in contacts.  For a hyperelastic material the default follows from its constants."""
    shape: Literal["round", "rounded", "angular", "flaky"] | None = None
    """Shape class of grains.  It gives the ``rolling_friction`` of all their contacts that give none
    (docs/materials.md).  Grains of the library have one."""
    hyperelastic: Hyperelastic | None = None
    """Constants that the material of a panel needs in addition."""
    fatigue: FatigueLine | None = None
    """Line by which the panels of this material are ranked in the results of a run."""


WORK_OF_ADHESION = "work_of_adhesion_J_per_m2"


class Contact(Table):
    """The contact properties of two materials.  Every pair that can meet must be given."""

    between: tuple[str, str]
    """The two materials; they are equal for contacts between particles of one material."""
    restitution: Annotated[float, Strict(), Gt(0.05), Le(1)]
    """Coefficient of restitution.  LIGGGHTS does not accept values of 0.05 or less."""
    sliding_friction: NotNegative
    """Coefficient of sliding friction."""
    rolling_friction: NotNegative
    """Coefficient of rolling friction: largest couple / (normal force x reduced radius).  Where it is not
    given, it is that of the ``shape`` of the grains; two kinds of grains have the mean of both."""
    work_of_adhesion_J_per_m2: NotNegative = 0.0
    """Energy per area to separate the two materials.  For equal materials it is twice the surface
    energy."""
    bond_number: Annotated[float, Strict(), Ge(0), Le(1e6)] | None = None
    """Pull-off force over the weight of a grain, which may be given instead of
    ``work_of_adhesion_J_per_m2`` (docs/theory/adhesion.md).  The resolved case has the work."""
    bond_diameter_m: Positive | None = None
    """Diameter of the grain that ``bond_number`` refers to.  By default, it is the median diameter by mass
    of the material's feeds; without feeds, of its blocks, else of its single particles, else of the
    particles that the case takes over."""
    moisture: Literal["dry", "moist", "wet", "sticky"] | None = None
    """Class of moisture, which may be given instead of ``work_of_adhesion_J_per_m2``.  It stands for a work
    of adhesion: dry 0, moist 0.192, wet 0.576, sticky 1.92 J/m2 (docs/theory/adhesion.md)."""
    specific_wear_m3_per_N_m: NotNegative = 0.0
    """Volume that particles of one material wear off a panel or surface of the other material, per
    normal force and sliding distance (docs/theory/wear.md)."""


class Probe(Table):
    """A point whose motion is recorded.  It is fixed to a frame or a panel, or it is a particle."""

    frame: str | None = None
    """Frame that carries the point; give ``point_m``, too."""
    point_m: Vector | None = None
    """Place of the point on the frame at t = 0, in deck axes."""
    panel: str | None = None
    """Panel that carries the point; give ``at``, too."""
    at: tuple[Share, Share] | None = None
    """Place of the point on the panel, as fractions of the free length and of the width."""
    sensor_kg: NotNegative = 0.0
    """Mass of a sensor that is fixed to the panel at the point.  Rigid panels leave it out."""
    particle: Annotated[int, Strict(), Ge(1), Lt(2**63)] | None = None
    """Id of the particle."""


class Case(Table):
    """A case with one of its levels."""

    title: OneLine
    """One line that says what the case shows."""
    description: Text = ""
    """Further text about the case, such as sources and assumptions."""
    default_level: str = ""
    """Level of a run that asks for no level."""
    duration_s: Positive
    """Time to simulate."""
    effects: Literal["auto"] | tuple[str, ...] | None = None
    """Effects that the case has, among the effects that can be left out.  By default, the case has all
    effects that it describes.  A list of names chooses exactly these effects.  "auto" chooses all
    effects except those that may be left out according to `flipflow explain`."""
    effects_for: tuple[str, ...] = ()
    """Short names of the results that "auto" must not change by more than a tenth.  By default, these
    are all results that have a short name."""
    gravity_m_per_s2: Vector = (0.0, 0.0, -9.81)
    """Gravity, in world axes."""
    domain_m: Box
    """Lowest and highest corner of the domain, in world axes.  Particles that leave it elsewhere than
    through an exit are removed and count as lost."""
    materials: dict[Name, Material]
    """Materials by name."""
    contacts: tuple[Contact, ...] = ()
    """Contact properties of pairs of materials."""
    screen: Screen
    """The machine."""
    bed: Bed = Field(default_factory=Bed)
    """The particles."""
    slice: Slice | None = None
    """A strip of the width that is computed instead of the whole machine."""
    probes: dict[Name, Probe] = Field(default_factory=dict)
    """Probes by name."""
    coupling: Coupling = Field(default_factory=Coupling)
    """Scheme and times of the exchange between the solvers."""
    exchange: Exchange = Field(default_factory=Exchange)
    """Quantities that the solvers exchange."""
    frames: FramesSolver = Field(default_factory=FramesSolver)
    """Solver of the frames."""
    panel: PanelSolver = Field(default_factory=PanelSolver)
    """Solver of the panels."""
    particles: ParticlesSolver = Field(default_factory=ParticlesSolver)
    """Solver of the particles."""
    monitor: MonitorSettings = Field(default_factory=MonitorSettings)
    """Events that the run watches for, and its reactions."""
    checkpoint: CheckpointSettings = Field(default_factory=CheckpointSettings)
    """Times between checkpoints."""
    output: Output = Field(default_factory=Output)
    """Output and its intervals."""

    _whole: Case | None = PrivateAttr(default=None)
    _given: Case | None = PrivateAttr(default=None)

    @property
    def adapters(self) -> dict[Port, Adapter[Any, Any, Any]]:
        """The adapters of the case's solvers, by port; an empty machine has none for particles."""
        adapters: dict[Port, Adapter[Any, Any, Any]] = {
            "panel": self.panel.adapter,
            "frames": self.frames.adapter,
        }
        if self.particles.adapter is not None:
            adapters["particles"] = self.particles.adapter
        return adapters

    @property
    def whole_machine(self) -> Case:
        """The case of the whole machine, from which this slice was cut; else the case itself."""
        return self._whole or self

    @property
    def original(self) -> Case:
        """The case of the whole machine with all particles, as fine as the user gave them."""
        return self.whole_machine._given or self.whole_machine

    def computed_with(self, update: dict[str, object]) -> Case:
        """Return a copy with updated tables for coarse or fewer particles, which knows this case as its
        original."""
        copy = self.model_copy(update=update)
        copy._given = self
        return copy

    def cut_to(self, update: dict[str, object]) -> Case:
        """Return a copy with updated tables for a slice, which knows this case as the whole machine."""
        part = self.model_copy(update=update)
        part._whole = self
        return part


def has_particles(case: Case) -> bool:
    """Return whether the case has or feeds particles."""
    bed = case.bed
    described = bed.particles or bed.blocks or bed.feeds or bed.is_carried
    return bool(described) and case.particles.solver != NONE


def damped_contacts(case: Case) -> bool:
    """Return whether particles lose energy in contacts."""
    return has_particles(case) and any(row.restitution < 1 for row in case.contacts)


def missing_features(case: Case) -> dict[str, str]:
    """Return the features that the case lacks, with the reason for each."""
    screen = case.screen
    features = {
        "particles": (has_particles(case), "the bed is empty, or particles.solver none"),
        "exciters": (bool(screen.exciters), "there are none"),
        "bushings": (bool(screen.bushings), "there are none"),
        "surfaces": (bool(screen.surfaces), "there are none"),
        "gravity": (any(case.gravity_m_per_s2), "gravity_m_per_s2 is zero"),
    }
    return {name: why for name, (is_there, why) in features.items() if not is_there}
