"""The closed form of two masses on springs, solved for the springs and the unbalance of a wanted stroke.

Along one axis, the driving frame 1 stands on ground springs and the driven frame 2 on shear springs.  Without
damping, both amplitudes are in phase, and docs/theory/machine.md derives

    a2 / a1 = k_s / (k_s - M2 w^2),        (M1 - K_g / w^2) a1 + M2 a2 = -u .

The functions take the ratio a2 / a1 as given, because it decides how far the machine works from resonance.
"""

from __future__ import annotations


def amplitudes_m(stroke_m: float, ratio: float) -> tuple[float, float]:
    """Return a1 and a2, whose difference is ``stroke_m`` and whose quotient a2 / a1 is ``ratio`` > 1."""
    driving_m = stroke_m / (ratio - 1)
    return driving_m, ratio * driving_m


def shear_stiffness_N_per_m(driven_kg: float, speed_rad_per_s: float, ratio: float) -> float:
    """Return k_s, at which the driven frame moves ``ratio`` > 1 times as far as the driving frame."""
    return driven_kg * speed_rad_per_s**2 * ratio / (ratio - 1)


def mass_moment_kg_m(
    driving_kg: float,
    driven_kg: float,
    ground_N_per_m: float,
    speed_rad_per_s: float,
    amplitudes_m: tuple[float, float],
) -> float:
    """Return the size of the exciter's mass moment u that moves the two frames by these amplitudes."""
    sprung_kg = driving_kg - ground_N_per_m / speed_rad_per_s**2
    return sprung_kg * amplitudes_m[0] + driven_kg * amplitudes_m[1]
