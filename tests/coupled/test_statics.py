"""A bed at rest on a taut panel: what the panel carries, and how far it sags."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.ports import Array
from tests.coupled.machines import opened, written

pytestmark = pytest.mark.solver
LENGTH_M, WIDTH_M, DIAMETER_M, DENSITY_KG_M3 = 0.15, 0.06, 0.0095, 7850.0
ROWS, ABREAST, PITCH_M = 13, 5, 0.0115

CASE = f"""
title = "a bed at rest"
duration_s = 0.3
domain_m = [[-0.1, -0.1, -0.1], [0.3, 0.2, 0.2]]

[materials.PU]
density_kg_m3 = 1150.0
[materials.PU.hyperelastic]
c10_Pa = 0.7e6
c01_Pa = 2.8e6
bulk_modulus_Pa = 2.0e9
maxwell = [{{ ratio = 1.0, relaxation_s = 2.0e-3 }}]

[materials.steel]
density_kg_m3 = {DENSITY_KG_M3}
youngs_modulus_Pa = 2e7
poisson_ratio = 0.3

[[contacts]]
between = ["steel", "steel"]
restitution = 0.5
sliding_friction = 0.5
rolling_friction = 0.3

[[contacts]]
between = ["steel", "PU"]
restitution = 0.5
sliding_friction = 0.5
rolling_friction = 0.3

[screen.frames.base]
mass_kg = 0.3
inertia_kg_m2 = [0.001, 0.001, 0.001]
center_of_mass_m = [0.0775, 0.03, 0.0]

[screen.bushings.feet]
between = ["ground", "base"]
stiffness_N_m = [2.5e3, 2.5e3, 2.5e3]
damping_N_s_m = [14.0, 14.0, 14.0]
positions_m = [[0.0, 0.0, 0.0], [0.155, 0.0, 0.0], [0.0, 0.06, 0.0], [0.155, 0.06, 0.0]]

[screen.panels.deck]
material = "PU"
frames = ["base", "base"]
corner_m = [0.0, 0.0, 0.0]
length_m = {LENGTH_M}
width_m = {WIDTH_M}
thickness_m = 0.003
clamp_m = 0.0            # hinges: no bending at the ends, as in a string
span_m = {LENGTH_M + 0.005}

[probes.middle]
panel = "deck"
at = [0.5, 0.5]

[panel]
cells = [10, 2]
surface_cells = [16, 4]

[particles]
largest_youngs_modulus_Pa = 2e7

[coupling]
sync_interval_s = 2.5e-5   # not above the panels' own critical step: docs/theory/coupling.md
"""


SPAN_M = LENGTH_M + 0.005
X_M = SPAN_M / 2 + PITCH_M * (np.arange(ROWS) - (ROWS - 1) / 2)
Y_M = WIDTH_M / 2 + PITCH_M * (np.arange(ABREAST) - (ABREAST - 1) / 2)
BED = "".join(
    f"[bed.particles.s{i}-{j}]\n"
    f"position_m = [{x}, {y}, {DIAMETER_M / 2 + 2e-4}]\n"
    f'diameter_m = {DIAMETER_M}\nmaterial = "steel"\n'
    for i, x in enumerate(X_M)
    for j, y in enumerate(Y_M)
)
WEIGHT_N = np.pi / 6 * DIAMETER_M**3 * DENSITY_KG_M3 * 9.81  # of a sphere


def lowered_m(position_m: Array) -> float:
    """Mean height of the middle of the panel's length under its ends."""
    height_m = position_m[: 17 * 5, 2].reshape(17, 5)  # the surface's 16 x 4 cells
    across = np.array([0.125, 0.25, 0.25, 0.25, 0.125])
    return float(((height_m[0] + height_m[-1]) / 2 - height_m[8]) @ across)


def test_bed_at_rest(tmp_path: Path) -> None:
    """Mean over two periods of what is left of the swinging (measured: +0.5 % and 0.0 %).

    Wall force: the bed's weight.  Sag: that of a string under the spheres' weights P, in the
    middle  sum of P min(x, span - x) / (2 T),  for many of them q L^2 / (8 T); the panel's
    bending stiffness takes  8 E I / (T L^2) = 0.8 %  off it.
    """
    string_m_N = WEIGHT_N * ABREAST * np.minimum(X_M, SPAN_M - X_M).sum() / 2
    with opened(written(tmp_path, CASE + BED)) as run:
        empty_m = lowered_m(run.state.panel.surface.position_m)
        run.advance(3000)
        wall_N, ratio = np.zeros((2, 3000))
        for n in range(3000):
            state = run.advance(1)
            wall_N[n] = -state.load.force_N[:, 2].sum()
            tension_N = np.abs(state.panel.reaction.force_N[:, 0]).sum() / 2
            sag_m = lowered_m(state.panel.surface.position_m) - empty_m
            ratio[n] = sag_m * tension_N / string_m_N
        at_rest = np.abs(run.particles().velocity_m_s).max()
    assert at_rest < 0.005  # from 0.06 m/s on landing
    assert wall_N.mean() == pytest.approx(ROWS * ABREAST * WEIGHT_N, rel=0.01)
    assert ratio.mean() == pytest.approx(1.0, abs=0.02)
