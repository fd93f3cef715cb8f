"""The answers known from elsewhere that expected.toml of the hard cases refers to."""

from __future__ import annotations

import math

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

G_M_PER_S2 = 9.81
WIDTH_M, THICKNESS_M = 0.2, 0.004  # of the panel that the lump falls on
C10_PA, C01_PA, PU_KG_PER_M3 = 0.7e6, 2.8e6, 1150.0


def stretched_J_per_m3(stretch: float) -> float:
    """Energy of an incompressible Mooney-Rivlin bar, per volume (Treloar, The Physics of Rubber
    Elasticity, 1975, ch. 5)."""
    first = stretch**2 + 2 / stretch - 3
    second = 2 * stretch + 1 / stretch**2 - 3
    return C10_PA * first + C01_PA * second


def nominal_Pa(stretch: float) -> float:
    """Its force over its area at rest."""
    return 2 * (stretch - stretch**-2) * (C10_PA + C01_PA / stretch)


def vee_J(depth_m: float, length_m: float, span_m: float, area_m2: float) -> float:
    """Least energy of a strip held at both ends whose middle is ``depth_m`` below them: the
    shortest line through the three points is a V; a slack one has none."""
    stretch = 2 * math.hypot(span_m / 2, depth_m) / length_m
    return area_m2 * length_m * stretched_J_per_m3(max(stretch, 1.0))


def deepest_m(
    lump_kg: float,
    speed_m_per_s: float,
    panel: tuple[float, float, float],
    kept: float = 1.0,
    stiffer: float = 1.0,
    contact: tuple[float, float] | None = None,
) -> float:
    """Return how deep a lump can push the middle of a strip by its energy: no shape stores less than a V.

    ``panel``: stress-free length, span, section; ``kept``: share of the kinetic energy that is left
    after the impact; ``stiffer``: factor on the strip's stiffness; ``contact``: radius and E* of
    the contact, whose spring then holds its part, as does the panel's bending.
    """
    length_m, span_m, area_m2 = panel
    panel_kg = PU_KG_PER_M3 * area_m2 * length_m
    bending_N_m2 = 6 * (C10_PA + C01_PA) * area_m2 * THICKNESS_M**2 / 12
    rest_J = stiffer * vee_J(0.0, length_m, span_m, area_m2)

    def missing_J(depth_m: float) -> float:
        fallen_J = (lump_kg + panel_kg) * G_M_PER_S2 * depth_m
        stored_J = stiffer * vee_J(depth_m, length_m, span_m, area_m2)
        push_N = stiffer * vee_J(depth_m + 1e-6, length_m, span_m, area_m2) - stored_J
        pressed_J = hertz_J(push_N / 1e-6, *contact) if contact else 0.0
        bent_J = stiffer * turned_J(depth_m, length_m, span_m, bending_N_m2) if contact else 0.0
        kinetic_J = kept * lump_kg * speed_m_per_s**2 / 2
        return kinetic_J + fallen_J - (stored_J - rest_J) - pressed_J - bent_J

    return float(brentq(missing_J, 1e-4, 0.5))


def hertz_J(push_N: float, radius_m: float, reduced_Pa: float) -> float:
    """Energy in a Hertz contact under a force: 2/5 of force times overlap."""
    overlap_m = (3 * push_N / (4 * reduced_Pa * math.sqrt(radius_m))) ** (2 / 3)
    return 0.4 * push_N * overlap_m


def turned_J(depth_m: float, length_m: float, span_m: float, bending_N_m2: float) -> float:
    """Bending in a V of a tensioned beam that is built in at its ends and smooth in its middle:
    four slopes that fall off as angle exp(-x / sqrt(EI / T)), whose bending and stretching take
    1/2 angle^2 sqrt(EI T)."""
    stretch = 2 * math.hypot(span_m / 2, depth_m) / length_m
    pull_N = nominal_Pa(stretch) * WIDTH_M * THICKNESS_M
    angle = math.atan(2 * depth_m / span_m)
    return 4 * angle**2 / 2 * math.sqrt(bending_N_m2 * max(pull_N, 0.0))


def shared(lump_kg: float, panel_kg: float) -> float:
    """Share of the lump's energy left when it has set a V of a panel moving (a third of its
    mass)."""
    return lump_kg / (lump_kg + panel_kg / 3)


def tangent_N_per_m(stretch: float, area_m2: float, length_m: float) -> float:
    """Stiffness of a stretched strip along itself."""
    small = 1e-6
    slope_Pa = (nominal_Pa(stretch + small) - nominal_Pa(stretch - small)) / (2 * small)
    return slope_Pa * area_m2 / length_m


def swept_m(
    masses_kg: tuple[float, float],
    to_ground: tuple[float, float],
    between: tuple[float, float],
    moment_kg_m: float,
    speed_rad_per_s: float,
    run_up_s: float,
    end_s: float,
    branches: tuple[float, tuple[tuple[float, float], ...]] = (0.0, ()),
) -> float:
    """Largest displacement of the second of two masses whose first is shaken along a line by an
    unbalance that runs up through the resonance: x1, x2 of the linear equations, integrated to
    1e-9.  ``to_ground``, ``between``: stiffness and damping; ``branches``: a stiffness between them
    with the ratios and relaxation times of its Maxwell branches; the unbalance's angle as in
    docs/theory/frames.md, its force minus the second derivative of moment x cos(angle)."""
    kp, maxwell = branches
    ratios, relaxation_s = np.array(maxwell).reshape(-1, 2).T
    (m1, m2), (kg, cg), (ks, cs) = masses_kg, to_ground, between
    rate = math.pi / run_up_s

    def force_N(t: float) -> float:
        rising = min(t, run_up_s)
        angle = speed_rad_per_s / 2 * (rising - math.sin(rate * rising) / rate)
        angle += speed_rad_per_s * (t - rising)
        speed = speed_rad_per_s / 2 * (1 - math.cos(rate * rising))
        growth = speed_rad_per_s / 2 * rate * math.sin(rate * rising)
        return moment_kg_m * (speed**2 * math.cos(angle) + growth * math.sin(angle))

    def rates(t: float, y: np.ndarray) -> list[float]:
        (x1, x2, v1, v2), over_m = y[:4], y[4:]
        shear = ks * (x2 - x1) + cs * (v2 - v1) + kp * float(ratios @ over_m)
        relaxing = v2 - v1 - over_m / relaxation_s
        return [v1, v2, (force_N(t) + shear - kg * x1 - cg * v1) / m1, -shear / m2, *relaxing]

    times_s = np.linspace(0, end_s, 20001)
    solution = solve_ivp(rates, (0, end_s), [0.0] * (4 + len(maxwell)), t_eval=times_s, rtol=1e-9, atol=1e-12)
    return float(np.abs(solution.y[1]).max())
