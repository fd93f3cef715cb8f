"""A bed of equal spheres at rest on a taut panel."""

from __future__ import annotations

import numpy as np

from orchestrator.ports import Array
from tests.cases import contact, grains, polyurethane

LENGTH_M, WIDTH_M, DIAMETER_M, DENSITY_KG_PER_M3 = 0.15, 0.06, 0.0095, 7850.0
ROWS, ABREAST, PITCH_M = 13, 5, 0.0115

CASE = (
    """
title = "a bed at rest"
duration_s = 0.3
domain_m = [[-0.1, -0.1, -0.1], [0.3, 0.2, 0.2]]
"""
    + polyurethane((1.0, 2.0e-3))
    + grains("steel", density_kg_per_m3=DENSITY_KG_PER_M3, youngs_modulus_Pa=2e7)
    + contact("steel", "steel", restitution=0.5, sliding=0.5, rolling=0.3)
    + contact("steel", "PU", restitution=0.5, sliding=0.5, rolling=0.3)
    + f"""
[screen.frames.base]
mass_kg = 0.3
inertia_kg_m2 = [0.001, 0.001, 0.001]
center_of_mass_m = [0.0775, 0.03, 0.0]

[screen.bushings.feet]
between = ["ground", "base"]
stiffness_N_per_m = [2.5e3, 2.5e3, 2.5e3]
damping_N_s_per_m = [14.0, 14.0, 14.0]
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
scheme = "particles-first"
sync_interval_s = 2.5e-5   # not above the panels' own critical step: docs/theory/coupling.md
"""
)

SPAN_M = LENGTH_M + 0.005
X_M = SPAN_M / 2 + PITCH_M * (np.arange(ROWS) - (ROWS - 1) / 2)
Y_M = WIDTH_M / 2 + PITCH_M * (np.arange(ABREAST) - (ABREAST - 1) / 2)
BED = "".join(
    f"[bed.particles.s{i}-{j}]\n"
    f"position_m = [{x}, {y}, {DIAMETER_M / 2 + 2e-4}]\n"
    f'sieve_size_m = {DIAMETER_M}\nmaterial = "steel"\n'
    for i, x in enumerate(X_M)
    for j, y in enumerate(Y_M)
)
WEIGHT_N = np.pi / 6 * DIAMETER_M**3 * DENSITY_KG_PER_M3 * 9.81  # of a sphere


def lowered_m(position_m: Array) -> float:
    """Mean height of the middle of the panel's length under its ends."""
    height_m = position_m[: 17 * 5, 2].reshape(17, 5)  # the surface's 16 x 4 cells
    across = np.array([0.125, 0.25, 0.25, 0.25, 0.125])
    return float(((height_m[0] + height_m[-1]) / 2 - height_m[8]) @ across)
