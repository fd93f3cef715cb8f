"""A ball that strikes the middle of a simply supported beam: the case, its run and the answer.

Timoshenko, S. P., Zur Frage nach der Wirkung eines Stosses auf einen Balken, Zeitschrift fuer
Mathematik und Physik 62, 1913, 198-209: Hertz contact with the ball, Bernoulli-Euler beam.

The sheet is a plate of Poisson's ratio 1/2; as its long edges are free, it bends like a beam
the better, the narrower it is.  So the beam is made ``narrowness`` times narrower, of a material
that much stiffer and denser: for the ball it stays the same beam.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from orchestrator.ports import Array
from tests.cases import contact, load_case
from tests.coupled.machines import opened

CASE = (
    """
title = "Timoshenko's ball on a beam"
duration_s = 3.52e-4
gravity_m_per_s2 = [0.0, 0.0, 0.0]
domain_m = [[-0.1, -0.1, -0.1], [0.3, 0.1, 0.1]]

[materials.ball]
density_kg_per_m3 = 7960.0
youngs_modulus_Pa = 215.82e9
poisson_ratio = 0.289

[materials.beam]                  # E = 6 (C10 + C01)
density_kg_per_m3 = 7960.0
youngs_modulus_Pa = 215.82e9
poisson_ratio = 0.289
hyperelastic = { c10_Pa = 35.97e9, c01_Pa = 0.0, bulk_modulus_Pa = 1e12 }
"""
    + contact("ball", "ball", restitution=1.0, sliding=0.0)
    + contact("ball", "beam", restitution=1.0, sliding=0.0)
    + """
[screen.frames.foundation]
mass_kg = 1000.0
inertia_kg_m2 = [10.0, 10.0, 10.0]
center_of_mass_m = [0.07675, 0.005, -0.05]

[screen.bushings.soft]
between = ["ground", "foundation"]
positions_m = [[-0.2, 0.2, -0.05], [-0.2, -0.2, -0.05], [0.3, 0.2, -0.05], [0.3, -0.2, -0.05]]
stiffness_N_per_m = [1e4, 1e4, 1e4]

[screen.panels.beam]
material = "beam"
frames = ["foundation", "foundation"]
corner_m = [0.0, 0.0, 0.0]
length_m = 0.1535
width_m = 0.010
thickness_m = 0.010
clamp_m = 0.0                     # held at its edges only: hinges
tension_m = 0.0

[bed.particles.ball]
position_m = [0.07675, 0.005, 0.01]
velocity_m_per_s = [0.0, 0.0, -0.010]
sieve_size_m = 0.020
material = "ball"

[probes.middle]
panel = "beam"
at = [0.5, 0.5]

[panel]
cells = [48, 1]
surface_cells = [72, 2]

[particles]
step_s = 2.5e-7

[coupling]
scheme = "particles-first"
sync_interval_s = 1e-6
"""
)


LENGTH_M, SIDE_M, RADIUS_M, SPEED_M_S = 0.1535, 0.010, 0.010, 0.010
YOUNGS_PA, POISSON, DENSITY_KG_PER_M3 = 215.82e9, 0.289, 7960.0
BALL_KG = 4 / 3 * np.pi * RADIUS_M**3 * DENSITY_KG_PER_M3


@dataclass(frozen=True)
class Impact:
    """Quantities that are compared: largest force, end of the contact, largest deflection of the middle and
    when, the ball's speed upwards in the end, in units in which they are about one."""

    force_N: float
    contact_us: float
    deflection_um: float
    deepest_us: float
    rebound_mm_per_s: float

    @staticmethod
    def of(time_s: Array, force_N: Array, deflection_m: Array, ball_m_per_s: Array) -> Impact:
        """Return the impact of time series (n,)."""
        return Impact(
            float(force_N.max()),
            1e6 * float(time_s[np.flatnonzero(force_N > 0)[-1]]),
            1e6 * float(deflection_m.max()),
            1e6 * float(time_s[deflection_m.argmax()]),
            1e3 * float(ball_m_per_s[-1]),
        )


def exact() -> Impact:
    """The ball and 41 odd modes of the beam, integrated to 1e-8."""
    modes = np.arange(1, 83, 2)
    middle, half_beam_kg = np.sin(modes * np.pi / 2), DENSITY_KG_PER_M3 * SIDE_M**2 * LENGTH_M / 2
    bending = YOUNGS_PA * SIDE_M**4 / 12
    square = (modes * np.pi / LENGTH_M) ** 4 * bending / (DENSITY_KG_PER_M3 * SIDE_M**2)
    hertz = 4 / 3 * YOUNGS_PA / (2 * (1 - POISSON**2)) * RADIUS_M**0.5

    def force_N(ball: Array, beam: Array) -> Array:
        return hertz * np.maximum(0.0, ball - middle @ beam) ** 1.5

    def rate(_: float, y: Array) -> Array:
        (ball, speed), (beam, rates) = y[:2], np.split(y[2:], 2)
        push = force_N(ball, beam)
        rates_s = push * middle / half_beam_kg - square * beam
        return np.concatenate([[speed, -push / BALL_KG], rates, rates_s])

    start = np.zeros(2 + 2 * len(modes))
    start[1] = SPEED_M_S
    times = np.linspace(0.0, 3.52e-4, 3521)
    y = solve_ivp(rate, (0, times[-1]), start, "DOP853", times, rtol=1e-8, atol=1e-14, max_step=1e-6).y
    beam = y[2 : 2 + len(modes)]
    return Impact.of(times, force_N(y[0], beam), middle @ beam, -y[1])


def narrower(times: float) -> list[str]:
    """Return the settings that make the beam narrower and leave it the same for the ball."""
    return [
        f"materials.beam.density_kg_per_m3={times * DENSITY_KG_PER_M3}",
        f"materials.beam.hyperelastic.c10_Pa={times * YOUNGS_PA / 6}",
        f"screen.panels.beam.width_m={SIDE_M / times}",
        f"bed.particles.ball.position_m=[{LENGTH_M / 2}, {SIDE_M / times / 2}, {RADIUS_M}]",
    ]


@dataclass(frozen=True)
class Outcome:
    """An impact as the solvers saw it, and the books in the end."""

    impact: Impact
    momentum_residual: dict[str, float]
    energy_J: dict[str, float]


def run(folder: Path, overrides: Sequence[str] = (), until_s: float = 3.52e-4) -> Outcome:
    """The case is not checked; that a panel is of steel would be a warning."""
    with opened(load_case(folder, CASE, overrides)) as machine:
        intervals = round(until_s / machine.interval_s)
        force_N, deflection_m, ball_m_per_s = np.zeros((3, intervals))
        (middle,) = (p.index for p in machine.machine.probes if p.name == "middle")
        for n in range(intervals):
            state = machine.advance(1)
            force_N[n] = -state.load.force_N[:, 2].sum()
            deflection_m[n] = -state.panel.surface.position_m[middle, 2]
            ball_m_per_s[n] = machine.particles().velocity_m_per_s[0, 2]
        time_s = machine.interval_s * np.arange(1, intervals + 1)
        return Outcome(
            Impact.of(time_s, force_N, deflection_m, ball_m_per_s),
            machine.momentum_residual(),
            machine.energy_J(),
        )
