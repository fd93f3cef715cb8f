"""The proposed frames, bushings and exciter for a wanted stroke and speed.

Masses per area of the deck, the ratio of both frames' amplitudes and the bushings' places are those of the
published screen FFS0827 (cases/ffs0827-empty); where panels are stiff for the speed, masses are larger.  The
rest follows from the closed form of two masses (two_mass.py) with the panels as springs.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from orchestrator.case.tables.quantities import Vector
from orchestrator.cli.proposal import two_mass
from orchestrator.cli.proposal.layout import Layout

DRIVING_KG_PER_M2, DRIVEN_KG_PER_M2 = 354.0, 133.0
RATIO = 4.0  # a2 / a1: the relative resonance is then some 35 % above the working speed
ISOLATION = 0.37  # of the working speed: the highest speed at which the whole machine swings on the ground
NORMAL = 3.3  # stiffness between the frames, normal to the deck and across, over M2 w^2
LARGEST_PANEL_SHARE = 0.6  # of the stiffness between the frames along the deck
HEAVIEST = 3.0  # largest factor by which stiff panels make the driven frame heavier
GROUND_LOSS, SHEAR_LOSS = 0.3, 0.1  # loss factors of the bushings at the working speed
RUN_UP_CYCLES = 4


@dataclass(frozen=True)
class Frame:
    """A free frame with its centre of mass and its moments of inertia."""

    mass_kg: float
    inertia_kg_m2: Vector
    center_of_mass_m: Vector


@dataclass(frozen=True)
class Bushings:
    """Equal bushings with their positions; the three directions are along, across and normal."""

    stiffness_N_per_m: Vector
    damping_N_s_per_m: Vector
    positions_m: tuple[Vector, ...]

    @property
    def total_N_per_m(self) -> Vector:
        """The stiffness of all bushings together."""
        x, y, z = self.stiffness_N_per_m
        count = len(self.positions_m)
        return count * x, count * y, count * z


@dataclass(frozen=True)
class Machine:
    """Two free frames on bushings and an exciter at the driving frame's centre of mass."""

    driving: Frame
    driven: Frame
    isolation: Bushings
    shear: Bushings
    mass_moment_kg_m: float
    run_up_s: float
    usual_driven_kg: float

    @property
    def is_heavy(self) -> bool:
        """Whether stiff panels made the frames heavier than usual."""
        return self.driven.mass_kg > 1.02 * self.usual_driven_kg


def propose_machine(layout: Layout, panels_N_per_m: float, panels_kg: float, correction: float) -> Machine:
    """Return the machine for a layout whose panels have this stiffness along the deck and this mass.

    The exciter's mass moment is ``correction`` times that of the closed form, which has no damping.
    """
    wishes = layout.wishes
    speed_rad_per_s = wishes.speed_rad_per_s
    driven_kg = round_to(max(usual_driven_kg(layout), least_driven_kg(layout, panels_N_per_m)), 3)
    driving_kg = round_to(DRIVING_KG_PER_M2 / DRIVEN_KG_PER_M2 * driven_kg, 3)
    center_m = (layout.length_m / 2, wishes.width_m / 2, 0.0)
    inertial_N_per_m = (driven_kg + panels_kg / 2) * speed_rad_per_s**2
    along_N_per_m = two_mass.shear_stiffness_N_per_m(driven_kg + panels_kg / 2, speed_rad_per_s, RATIO)
    shear = _bushings(
        layout,
        max(3, math.ceil(layout.length_m / 0.9)),
        (along_N_per_m - panels_N_per_m, NORMAL * inertial_N_per_m, NORMAL * inertial_N_per_m),
        SHEAR_LOSS,
    )
    ground_N_per_m = (driving_kg + driven_kg) * (ISOLATION * speed_rad_per_s) ** 2
    isolation = _bushings(layout, 2, (ground_N_per_m,) * 3, GROUND_LOSS)
    moment_kg_m = two_mass.mass_moment_kg_m(
        driving_kg + panels_kg / 2,
        driven_kg + panels_kg / 2,
        isolation.total_N_per_m[0],
        speed_rad_per_s,
        two_mass.amplitudes_m(wishes.stroke_m, RATIO),
    )
    return Machine(
        driving=Frame(driving_kg, _inertia_kg_m2(layout, driving_kg, 0.5), center_m),
        driven=Frame(driven_kg, _inertia_kg_m2(layout, driven_kg, 0.3), center_m),
        isolation=isolation,
        shear=shear,
        mass_moment_kg_m=round_to(correction * moment_kg_m, 4),
        run_up_s=round_to(RUN_UP_CYCLES * 2 * math.pi / speed_rad_per_s, 3),
        usual_driven_kg=usual_driven_kg(layout),
    )


def usual_driven_kg(layout: Layout) -> float:
    """Return the mass of a driven frame as heavy for its deck as that of the published screen."""
    return DRIVEN_KG_PER_M2 * layout.length_m * layout.wishes.width_m


def least_driven_kg(layout: Layout, panels_N_per_m: float) -> float:
    """Return the mass of the driven frame at which panels have ``LARGEST_PANEL_SHARE`` of the stiffness."""
    per_kg = two_mass.shear_stiffness_N_per_m(1.0, layout.wishes.speed_rad_per_s, RATIO)
    return panels_N_per_m / (LARGEST_PANEL_SHARE * per_kg)


def _bushings(layout: Layout, rows: int, total_N_per_m: Vector, loss_factor: float) -> Bushings:
    """Return bushings in rows on both sides of the deck, from a sixth to five sixths of its length.

    Together they have this stiffness, and this loss factor at the working speed.
    """
    from_m, to_m = (share * layout.length_m for share in (1 / 6, 5 / 6))
    along_m = [from_m + (to_m - from_m) * number / (rows - 1) for number in range(rows)]
    sides_m = (-0.1, layout.wishes.width_m + 0.1)
    positions_m = tuple((round(x, 3), y, 0.0) for y in sides_m for x in along_m)
    x, y, z = (round_to(total / len(positions_m), 3) for total in total_N_per_m)
    c_x, c_y, c_z = (round_to(loss_factor * k / layout.wishes.speed_rad_per_s, 3) for k in (x, y, z))
    return Bushings((x, y, z), (c_x, c_y, c_z), positions_m)


def _inertia_kg_m2(layout: Layout, mass_kg: float, height_m: float) -> Vector:
    """Return the moments of inertia of a uniform block as long and wide as the deck with its side plates.

    They are rounded; the largest of a long or wide flat block stays within the sum of the others.
    """
    a, b, c = layout.length_m + 0.1, layout.wishes.width_m + 0.3, height_m
    x, y, z = (round_to(mass_kg / 12 * square, 3) for square in (b * b + c * c, a * a + c * c, a * a + b * b))
    return min(x, y + z), min(y, x + z), min(z, x + y)


def round_to(value: float, digits: int) -> float:
    """Return a value with so many significant digits."""
    return float(f"{value:.{digits}g}")
