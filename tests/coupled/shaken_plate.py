"""One sphere on a plate that a drive shakes, as a case, and where it goes by another integration.

The plate is a rigid panel on a driven frame; it moves along x and up and down, out of phase, below
the throw, so that it conveys the sphere slowly.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from tests.cases import contact, grains, polyurethane

RADIUS_M, DENSITY_KG_PER_M3, GRAVITY_M_PER_S2 = 0.01, 2500.0, 9.81
MASS_KG = 4 / 3 * math.pi * RADIUS_M**3 * DENSITY_KG_PER_M3
MODULUS_PA, POISSONS_RATIOS = 1e7, (0.3, 0.49825)  # of sphere and plate, both softened
REDUCED_PA = MODULUS_PA / sum(1 - nu**2 for nu in POISSONS_RATIOS)
SHEAR_PA = MODULUS_PA / sum(2 * (2 - nu) * (1 + nu) for nu in POISSONS_RATIOS)


@dataclass(frozen=True)
class Shaking:
    """(1 - cos(pi t / run_up)) / 2 times the amplitudes along x and z; the motion along x is ahead
    by ``phase_rad``."""

    period_s: float
    along_m: float
    up_m: float
    phase_rad: float
    run_up_s: float

    def at(self, time_s: float) -> tuple[float, float, float, float]:
        """Place along x and z, and both velocities."""
        w = 2 * math.pi / self.period_s
        grown, growing_1_s = 1.0, 0.0
        if time_s < self.run_up_s:
            turn = math.pi * time_s / self.run_up_s
            grown, growing_1_s = (1 - math.cos(turn)) / 2, math.pi / 2 / self.run_up_s
            growing_1_s *= math.sin(turn)
        sines = math.sin(w * time_s + self.phase_rad), math.sin(w * time_s)
        cosines = math.cos(w * time_s + self.phase_rad), math.cos(w * time_s)
        x, z = self.along_m * sines[0], self.up_m * sines[1]
        x_1_s, z_1_s = w * self.along_m * cosines[0], w * self.up_m * cosines[1]
        return (grown * x, grown * z, growing_1_s * x + grown * x_1_s, growing_1_s * z + grown * z_1_s)


CONVEYING = Shaking(0.1, 2.5e-3, 1.2e-3, 2.0, 0.1)
FRICTION = 0.3 / 3.5


def case(shaking: Shaking, friction: float = 0.0, work_J_per_m2: float = 0.0) -> str:
    """Return a case with one sphere that touches the plate in the middle."""
    sticky = f"work_of_adhesion_J_per_m2 = {work_J_per_m2}" if work_J_per_m2 else ""
    return (
        f"""
title = "a sphere on a shaken plate"
duration_s = 1.0
domain_m = [[-0.5, -0.5, -0.5], [0.5, 0.5, 0.5]]
gravity_m_per_s2 = [0.0, 0.0, {-GRAVITY_M_PER_S2}]
"""
        + polyurethane()
        + grains("glass", DENSITY_KG_PER_M3, MODULUS_PA)
        + contact("glass", "PU", restitution=0.5, sliding=friction)
        + sticky
        + f"""
[screen.frames.shaker.drive]
speed_rad_per_s = {2 * math.pi / shaking.period_s!r}
amplitude_m = [{shaking.along_m}, 0.0, {shaking.up_m}]
phase_rad = [{shaking.phase_rad}, 0.0, 0.0]
run_up_s = {shaking.run_up_s}

[screen.panels.plate]
material = "PU"
frames = ["shaker", "shaker"]
corner_m = [-0.2, -0.05, 0.0]
length_m = 0.4
width_m = 0.1
thickness_m = 0.004
clamp_m = 0.0
tension_m = 0.0

[bed.particles.one]
material = "glass"
sieve_size_m = {2 * RADIUS_M}
position_m = [0.0, 0.0, {RADIUS_M}]

[frames]
solver = "prescribed"

[panel]
solver = "rigid"
surface_cells = [4, 1]

[particles]
solver = "spheres"
largest_youngs_modulus_Pa = {MODULUS_PA}
softened_adhesion = "pull-off"
step_s = 2e-4

[coupling]
scheme = "particles-first"
sync_interval_s = {shaking.period_s / 128!r}
"""
    )


@dataclass(frozen=True)
class Ridden:
    """Place of the sphere along x, and its depth in the plate, at a time."""

    along_m: float
    overlap_m: float


def ridden(
    shaking: Shaking, times_s: list[float], friction: float = 0.0, work_J_per_m2: float = 0.0
) -> list[Ridden]:
    """The sphere of ``case`` at increasing times, by an integration of its own, which knows no
    coupling, on the plate's true motion.

    Normal force of Johnson, Kendall and Roberts (Proc. R. Soc. Lond. A 324, 1971, 301-313), Hertz's
    without adhesion; Tsuji's damping (Powder Technology 71, 1992, 239-250); Mindlin's tangential
    spring 8 G* a (Journal of Applied Mechanics 16, 1949, 259-268) with a damper, cut by Coulomb's
    friction, which neither has while it slides; a lever of the radius less half the overlap, as in
    LIGGGHTS.  Symplectic Euler in steps of 1/20 000 of a period.
    """
    log_e = math.log(0.5)
    damping = 2 * math.sqrt(5 / 6) * -log_e / math.hypot(log_e, math.pi)
    inertia_kg_m2 = 0.4 * MASS_KG * RADIUS_M**2
    step_s = shaking.period_s / 20_000
    x, z, u, v, spin, shear_m, neck_m = 0.0, RADIUS_M, 0.0, 0.0, 0.0, 0.0, 0.0
    rows: list[Ridden] = []
    step = 0
    while len(rows) < len(times_s):
        x, z, step = x + step_s * u, z + step_s * v, step + 1
        _, plate_m, plate_x_m_per_s, plate_z_m_per_s = shaking.at(step * step_s)
        overlap_m = plate_m + RADIUS_M - z
        neck_m = neck_at_m(overlap_m, work_J_per_m2, neck_m)
        normal_N = tangential_N = 0.0
        lever_m = RADIUS_M - overlap_m / 2
        if neck_m > 0.0:
            S_n, S_t = 2 * REDUCED_PA * neck_m, 8 * SHEAR_PA * neck_m
            normal_N = 4 / 3 * REDUCED_PA * neck_m**3 / RADIUS_M
            normal_N -= math.sqrt(8 * math.pi * work_J_per_m2 * REDUCED_PA * neck_m**3)
            normal_N -= damping * math.sqrt(S_n * MASS_KG) * (v - plate_z_m_per_s)
            slip_m_per_s = u - lever_m * spin - plate_x_m_per_s
            shear_m += step_s * slip_m_per_s
            limit_N = friction * abs(normal_N)
            if S_t * abs(shear_m) > limit_N:
                shear_m = math.copysign(limit_N / S_t, shear_m)
                tangential_N = -S_t * shear_m
            else:
                tangential_N = -S_t * shear_m - damping * math.sqrt(S_t * MASS_KG) * slip_m_per_s
        u += step_s * tangential_N / MASS_KG
        v += step_s * (normal_N / MASS_KG - GRAVITY_M_PER_S2)
        spin -= step_s * lever_m * tangential_N / inertia_kg_m2
        if step * step_s >= times_s[len(rows)] - step_s / 2:
            rows.append(Ridden(x, overlap_m))
    return rows


def neck_at_m(overlap_m: float, work_J_per_m2: float, before_m: float) -> float:
    """Radius of the contact: the largest root of  a^2 / R - sqrt(2 pi w a / E*) = overlap,  by
    Newton's method; 0 where there is no contact.  A neck forms at zero overlap and holds down to
    -3 a^2 / R, where the two roots meet."""
    pull_m = 2 * math.pi * work_J_per_m2 / REDUCED_PA  # sqrt(pull a) is what adhesion adds to Hertz
    snapping_m = (pull_m * RADIUS_M**2 / 16) ** (1 / 3)
    holds = overlap_m > (-3 * snapping_m**2 / RADIUS_M if before_m > 0.0 else 0.0)
    if not holds:
        return 0.0
    neck_m = max(before_m, 2 * snapping_m, math.sqrt(RADIUS_M * max(overlap_m, 0.0)))
    for _ in range(50):
        off_m = neck_m**2 / RADIUS_M - math.sqrt(pull_m * neck_m) - overlap_m
        slope = 2 * neck_m / RADIUS_M - math.sqrt(pull_m / neck_m) / 2
        neck_m -= off_m / slope
        if abs(off_m) < 1e-15:
            break
    return neck_m
