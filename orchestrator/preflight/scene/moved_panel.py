"""A panel whose ends move against each other.

Closed forms give its sag, strain, frequency and stiffness (docs/theory/effects.md).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchestrator.case.deck.panels import SinglePanel
from orchestrator.case.file.loss_curve import moduli
from orchestrator.ports.geometry import AperturePattern, Rectangle
from orchestrator.ports.plans import HyperelasticPlan
from orchestrator.preflight.scene.observed import Shape


@dataclass(frozen=True)
class MovedPanel:
    """A panel whose clamps move against each other.

    ``stroke_m`` is the amplitude of one clamp against the other along the panel.  ``shape`` is the
    panel's shape in a run, None if it is to be estimated.
    """

    panel: SinglePanel
    material: HyperelasticPlan
    stroke_m: float
    shape: Shape | None = None

    @property
    def length_m(self) -> float:
        """The free length between the clamps, unstretched."""
        return self.panel.rectangle.length_m

    @property
    def tension_m(self) -> float:
        """The stretch in which the panel is mounted; positive if taut, negative if slack."""
        return self.panel.rectangle.span_m - self.length_m

    @property
    def sag_m(self) -> float:
        """The largest height of the panel's arch."""
        if self.shape is not None:
            return self.shape.sag_m
        return sine_arch_m(self.length_m, self.stroke_m - self.tension_m)

    @property
    def travel_m(self) -> float:
        """The range of the middle's motion if the panel does not snap from one side to the other."""
        if self.shape is not None:
            return self.shape.travel_m
        return self.sag_m - sine_arch_m(self.length_m, -self.stroke_m - self.tension_m)

    @property
    def strain(self) -> float:
        """The strain when the panel is most taut; 0 if it is never taut."""
        if self.shape is not None:
            return self.shape.strain
        return max(0.0, self.tension_m + self.stroke_m) / self.length_m

    @property
    def mass_kg_per_m2(self) -> float:
        """The mass per area of the free panel, including the area of its openings."""
        thickness_m = self.panel.table.thickness_m
        return self.material.density_kg_per_m3 * thickness_m * self.panel.material_share

    @property
    def free_mass_kg(self) -> float:
        """The mass between the clamps."""
        return self.mass_kg_per_m2 * self.length_m * self.panel.rectangle.width_m

    @property
    def whole_mass_kg(self) -> float:
        """The mass of the panel including the parts under the clamps."""
        clamps_m2 = 2 * self.panel.rectangle.clamp_m * self.panel.rectangle.width_m
        return self.free_mass_kg + self.material.density_kg_per_m3 * self.panel.table.thickness_m * clamps_m2

    @property
    def frequency_rad_per_s(self) -> float:
        """The lowest angular frequency, by bending and, if the panel is mounted taut, by its tension."""
        law, thickness_m = self.material, self.panel.table.thickness_m
        plate_N_m = law.youngs_modulus_Pa * thickness_m**3 / 9  # E t^3 / (12 (1 - 1/4))
        areal_kg_per_m2 = law.density_kg_per_m3 * thickness_m
        bending = 22.37 * math.sqrt(plate_N_m / areal_kg_per_m2) / self.length_m**2
        strain = max(0.0, self.tension_m) / self.length_m
        wave_m_per_s = math.sqrt(law.youngs_modulus_Pa * strain / law.density_kg_per_m3)
        return math.hypot(bending, math.pi / self.length_m * wave_m_per_s)

    @property
    def taut_stiffness_N_per_m(self) -> float:
        """The stiffness along the taut panel at small strain."""
        area_m2 = self.panel.rectangle.width_m * self.panel.table.thickness_m
        whole_N_per_m = self.material.youngs_modulus_Pa * area_m2 / self.length_m
        return whole_N_per_m * stiffness_share(self.panel.mean_apertures, self.panel.rectangle)

    @property
    def stiffening(self) -> float:
        """The ratio of the stiffness against fast changes to the stiffness against slow ones.

        Maxwell branches respond to fast changes like springs.
        """
        return 1.0 + sum(ratio for ratio, _ in self.material.branches)

    @property
    def spring_N_per_m(self) -> float:
        """The stiffness of a spring whose force is the first harmonic of the panel's pull.

        The panel pulls only while it is taut.
        """
        ratio = self.tension_m / self.stroke_m if self.stroke_m else math.copysign(2, self.tension_m)
        return self.taut_stiffness_N_per_m * one_sided_share(ratio)


def sine_arch_m(length_m: float, approach_m: float) -> float:
    """Return the height of a sine arch of a length whose ends approach each other; 0 if it is taut."""
    return 2 / math.pi * math.sqrt(length_m * max(0.0, approach_m))


def one_sided_share(ratio: float) -> float:
    """Return the share of a one-sided spring's stiffness in the first harmonic of its force.

    Its stretch is tension + amplitude * sin, and ``ratio`` is tension / amplitude.  Gelb, A. and Vander
    Velde, W. E., Multiple-Input Describing Functions, 1968, ch. 2.
    """
    r = min(1.0, max(-1.0, ratio))
    return 0.5 + (math.asin(r) + r * math.sqrt(1 - r * r)) / math.pi


def stiffness_share(pattern: AperturePattern | None, rectangle: Rectangle) -> float:
    """Return an upper bound of a perforated panel's stiffness along itself over the closed panel's.

    Net sections act in series, as if every section stayed straight.
    """
    if pattern is None:
        return 1.0
    (low, high) = pattern.region_m(rectangle)
    along, across = (high - low) / (rectangle.length_m, rectangle.width_m)
    net = 1 - across * pattern.width_m / pattern.pitch_across_m
    cut = along * pattern.length_m / pattern.pitch_along_m
    return float(1 / (1 - cut + cut / net))


def softest_share(pattern: AperturePattern | None, rectangle: Rectangle) -> float:
    """Return a lower bound of a perforated panel's stiffness along itself over the closed panel's.

    Besides its net section, each row of openings gives way like a row of collinear cracks as long as
    the openings are wide, by (4 W / pi) ln sec(pi a / W) for cracks 2 a at the pitch W.  Rows near each
    other shield each other and are stiffer.  Tada, H., Paris, P. C. and Irwin, G. R., The Stress
    Analysis of Cracks Handbook, 3rd ed., 2000, section 7.
    """
    if pattern is None:
        return 1.0
    (low, high) = pattern.region_m(rectangle)
    along, across = (high - low) / (rectangle.length_m, rectangle.width_m)
    rows = along * rectangle.length_m / pattern.pitch_along_m
    opened = min(0.999, pattern.width_m / pattern.pitch_across_m)
    crack_m = 4 * pattern.pitch_across_m / math.pi * math.log(1 / math.cos(math.pi / 2 * opened))
    gives = across * rows * crack_m / rectangle.length_m
    return float(1 / (1 / stiffness_share(pattern, rectangle) + gives))


def clamp_response(ratio: float) -> float:
    """Return the amplitude of a panel's middle against its clamps over the clamps' own normal amplitude.

    The clamps shake at ``ratio`` r times the panel's lowest frequency, without damping.  The result is
    the sine's share of a uniform load, 4/pi, times r^2 / |1 - r^2|; it is infinite at resonance.
    """
    square = ratio**2
    return math.inf if square == 1.0 else 4 / math.pi * square / abs(1 - square)


def change_of_response(ratio: float, loss_factor: float, mass_ratio: float) -> float:
    """Return the relative change of the amplitude of a panel's middle without a loss factor and a mass on it.

    The mass is ``mass_ratio`` times the panel's own; it moves with the panel and lowers its frequency.
    The amplitude includes the motion of the clamps, which shake at ``ratio`` times the lowest frequency
    of the empty panel.
    """

    def amplitude(square: float, loss: float) -> float:
        against_clamps = square / complex(1 - square, loss) if square != 1.0 or loss else math.inf
        return abs(1 + 4 / math.pi * against_clamps)

    as_it_is = amplitude(ratio**2 * (1 + mass_ratio), loss_factor)
    without = amplitude(ratio**2, 0.0)
    return 0.0 if without == as_it_is else abs(without / as_it_is - 1)


def mooney_ratio(law: HyperelasticPlan, strain: float) -> float:
    """Return the nominal stress of a uniaxially stretched bar over Young's modulus times strain.

    The bar is incompressible and has the two-parameter law of Mooney and Rivlin.  Treloar, L. R. G.,
    The Physics of Rubber Elasticity, 1975, ch. 5.
    """
    if strain <= 0.0:
        return 1.0
    stretch = 1 + strain
    stress_Pa = 2 * (stretch - stretch**-2) * (law.c10_Pa + law.c01_Pa / stretch)
    return stress_Pa / (law.youngs_modulus_Pa * strain)


def loss_factor(law: HyperelasticPlan, speed_rad_per_s: float) -> float:
    """Return the loss factor of a material with its Maxwell branches at an angular frequency."""
    return float(moduli(law.branches, np.array([speed_rad_per_s]))[1][0])
