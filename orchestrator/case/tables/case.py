"""The case: everything that a run depends on, as frozen tables in SI units.

``case.toml`` describes the physics, and ``levels/<level>.toml`` the numerics; load.py reads and
merges them.  docs/case-format.md lists every key.
"""

from __future__ import annotations

from typing import Annotated, Any, Literal

import numpy as np
from annotated_types import Ge, Gt, Le, Lt
from pydantic import Discriminator, Field, PrivateAttr, Strict, Tag

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
    """A strip in the middle of the width, with its share of masses, bushings, exciters and feeds;
    usually in a level."""

    width_m: Positive
    """Width."""
    sides: Literal["periodic", "walls"] = "periodic"
    """periodic: what leaves at one side returns at the other, without side walls. walls: they stand at
    the slice's sides."""


class MaxwellBranch(Table):
    """A spring and a damper in series."""

    ratio: Positive
    """Modulus over the elastic modulus."""
    relaxation_s: Positive
    """Relaxation time."""


class LossPoint(Table):
    """Loss measured from low to high frequencies; branches are fitted unless ``maxwell`` is given."""

    frequency_Hz: Annotated[float, Strict(), Ge(1e-3), Le(1e6)]
    """Frequency."""
    loss_factor: Annotated[float, Strict(), Ge(1e-4), Le(10)]
    """Loss modulus over storage modulus."""
    storage_ratio: Annotated[float, Strict(), Ge(1), Le(1e3)] | None = None
    """Storage modulus over the elastic one, if measured."""


class Hyperelastic(Table):
    """The two-parameter Mooney-Rivlin material of a panel."""

    c10_Pa: NotNegative
    """Coefficient of the first invariant."""
    c01_Pa: NotNegative
    """Coefficient of the second invariant."""
    bulk_modulus_Pa: Positive
    """K of the volumetric energy K/2 (J - 1)^2."""
    maxwell: tuple[MaxwellBranch, ...] = ()
    """Branches that damp the panel."""
    loss_curve: tuple[LossPoint, ...] = ()
    """Measured loss factor."""


class FatigueLine(Table):
    """Line cycles x (strain_amplitude / amplitude)^slope that only ranks the panels of a run."""

    strain_amplitude: Annotated[float, Strict(), Gt(0), Le(1)]
    """Half the strain range of a cycle."""
    cycles: Annotated[float, Strict(), Ge(1), Le(1e15)]
    """Cycles to failure at this amplitude."""
    slope: Annotated[float, Strict(), Gt(0), Le(50)]
    """Ten times the amplitude divides the cycles by 10^slope."""


class Material(Table):
    """A material of particles, walls or panels; given keys replace the [library's](materials.md), which
    needs no table."""

    like: OneLine | None = None
    """Material of the library with all other keys; by default that of this name."""
    density_kg_per_m3: Positive
    """Density."""
    youngs_modulus_Pa: Positive | None = None
    """In contacts; by default some 6 (C10 + C01)."""
    poisson_ratio: Annotated[float, Strict(), Ge(0), Lt(0.5)] | None = None
    """In contacts; by default from the hyperelastic constants."""
    shape: Literal["round", "rounded", "angular", "flaky"] | None = None
    """Shape class of grains, for the ``rolling_friction`` of contacts ([more](materials.md))."""
    hyperelastic: Hyperelastic | None = None
    """Constants of a panel's material."""
    fatigue: FatigueLine | None = None
    """Line that ranks the panels of this material."""


WORK_OF_ADHESION = "work_of_adhesion_J_per_m2"


class ReboundPoint(Table):
    """A point of the restitution over the speed of impacts."""

    impact_m_per_s: Annotated[float, Strict(), Gt(0), Le(100)]
    """Normal speed at first touch."""
    restitution: Annotated[float, Strict(), Gt(0), Le(1)]
    """Coefficient of such impacts."""


def _branch(restitution: object) -> str:
    return "<points>" if isinstance(restitution, list | tuple | dict) else "<number>"


class Contact(Table):
    """Two materials.  Every pair that can meet must be given, unless the library has it."""

    between: tuple[str, str]
    """The two materials, or one twice."""
    restitution: Annotated[
        Annotated[float, Strict(), Gt(0.05), Le(1), Tag("<number>")]
        | Annotated[tuple[ReboundPoint, ...], Tag("<points>")],
        Discriminator(_branch),
    ]
    """Coefficient, or points over impact speed, linear between them, constant beyond
    (docs/theory/rebound.md)."""
    sliding_friction: NotNegative
    """Coefficient."""
    rolling_friction: NotNegative
    """Largest couple / (normal force x reduced radius); by default that of the grains' ``shape``, or
    their mean."""
    work_of_adhesion_J_per_m2: NotNegative = 0.0
    """Energy to separate the two; for equal materials twice the surface energy."""
    bond_number: Annotated[float, Strict(), Ge(0), Le(1e6)] | None = None
    """Instead of the work: pull-off force over a grain's weight (docs/theory/adhesion.md)."""
    bond_diameter_m: Positive | None = None
    """Grain of ``bond_number``; by default the median by mass of the material's feeds, else blocks, else
    others."""
    moisture: Literal["dry", "moist", "wet", "sticky"] | None = None
    """Instead of the work: 0, 0.192, 0.576 or 1.92 J/m2 (docs/theory/adhesion.md)."""
    specific_wear_m3_per_N_m: NotNegative = 0.0
    """Volume that grains wear off per normal force and sliding distance (docs/theory/wear.md)."""

    @property
    def rebound(self) -> tuple[ReboundPoint, ...]:
        """The points of a restitution over speed; none of a constant one."""
        return self.restitution if isinstance(self.restitution, tuple) else ()

    @property
    def restitutions(self) -> tuple[float, ...]:
        """The restitution of every point, or the one of all impacts."""
        if isinstance(self.restitution, tuple):
            return tuple(point.restitution for point in self.restitution)
        return (self.restitution,)

    @property
    def slow_restitution(self) -> float:
        """The restitution of the slowest impacts."""
        return self.restitutions[0]

    def restitution_at(self, impact_m_per_s: float) -> float:
        """Return the restitution of impacts of this speed."""
        if not self.rebound:
            return self.slow_restitution
        speeds_m_per_s = [point.impact_m_per_s for point in self.rebound]
        return float(np.interp(impact_m_per_s, speeds_m_per_s, self.restitutions))


class Air(Table):
    """Still air, by default none (docs/theory/air.md); an empty table is dry air of 20 degrees Celsius
    at 1013 hPa."""

    density_kg_per_m3: Annotated[float, Strict(), Gt(0), Le(10)] = 1.204
    """Density."""
    viscosity_Pa_s: Annotated[float, Strict(), Ge(1e-6), Le(1e-3)] = 1.82e-5
    """Dynamic viscosity."""


class Probe(Table):
    """A point on a frame (``frame``, ``point_m``) or a panel (``panel``, ``at``), or a particle, whose
    motion is recorded."""

    frame: str | None = None
    """Its frame."""
    point_m: Vector | None = None
    """Place at t = 0, in deck axes."""
    panel: str | None = None
    """Its panel."""
    at: tuple[Share, Share] | None = None
    """Shares of the free length and the width."""
    sensor_kg: NotNegative = 0.0
    """Mass of a sensor on a panel that is not rigid."""
    particle: Annotated[int, Strict(), Ge(1), Lt(2**63)] | None = None
    """Id of the particle."""


class Bulk(Table):
    """A box in which grains are measured as a bulk at output times: mass, density, slope of their free
    surface."""

    box_m: Box
    """Lowest and highest corner, in world axes."""


class Case(Table):
    """A case with one of its levels."""

    title: OneLine
    """One line that says what the case shows."""
    description: Text = ""
    """Sources, assumptions and the like."""
    default_level: str = ""
    """Level of a run that names none."""
    duration_s: Positive
    """Time to simulate."""
    effects: Literal["auto"] | tuple[str, ...] | None = None
    """Exactly these [effects](#effects), or those that may matter; by default all that the case
    describes."""
    effects_for: tuple[str, ...] = ()
    """Short names of results that "auto" must not change by a tenth; by default all."""
    gravity_m_per_s2: Vector = (0.0, 0.0, -9.81)
    """Gravity, in world axes."""
    domain_m: Box
    """Lowest and highest corner, in world axes; particles that leave it beside exits are lost."""
    materials: dict[Name, Material]
    """Materials by name."""
    contacts: tuple[Contact, ...] = ()
    """Contacts of pairs of materials."""
    air: Air | None = None
    """Air that resists the particles."""
    screen: Screen
    """The machine."""
    bed: Bed = Field(default_factory=Bed)
    """The particles."""
    slice: Slice | None = None
    """Strip of the width that is computed."""
    probes: dict[Name, Probe] = Field(default_factory=dict)
    """Probes by name."""
    bulk: dict[Name, Bulk] = Field(default_factory=dict)
    """Boxes in which the bulk is measured, by name."""
    coupling: Coupling = Field(default_factory=Coupling)
    """Exchange between the solvers."""
    exchange: Exchange = Field(default_factory=Exchange)
    """What the solvers exchange."""
    frames: FramesSolver = Field(default_factory=FramesSolver)
    """Solver of the frames."""
    panel: PanelSolver = Field(default_factory=PanelSolver)
    """Solver of the panels."""
    particles: ParticlesSolver = Field(default_factory=ParticlesSolver)
    """Solver of the particles."""
    monitor: MonitorSettings = Field(default_factory=MonitorSettings)
    """Events that the run watches for."""
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
    return has_particles(case) and any(min(row.restitutions) < 1 for row in case.contacts)


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
