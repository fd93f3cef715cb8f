"""A small screen: two frames on bushings, an exciter, two panels between them and a thin bed."""

from __future__ import annotations

from tests.cases import contact, grains, polyurethane

MACHINE = (
    """
title = "a small screen"
duration_s = 0.02
domain_m = [[-0.1, -0.1, -0.2], [0.6, 0.2, 0.3]]
"""
    + polyurethane((0.2, 2.0e-3), (0.2, 4.0e-4))
    + grains("coal", density_kg_per_m3=1430.0, youngs_modulus_Pa=9.9e8)
    + contact("coal", "coal", restitution=0.4, sliding=0.36)
    + contact("coal", "PU", restitution=0.5, sliding=0.47)
    + """
[screen]
inclination_deg = 15.0

[screen.frames.driving]
mass_kg = 12.0
inertia_kg_m2 = [0.2, 0.4, 0.5]
center_of_mass_m = [0.160, 0.05, -0.02]

[screen.frames.driven]
mass_kg = 5.0
inertia_kg_m2 = [0.08, 0.15, 0.2]
center_of_mass_m = [0.160, 0.05, 0.01]

[screen.bushings.isolation]
between = ["ground", "driving"]
stiffness_N_per_m = [4e3, 4e3, 4e3]
damping_N_s_per_m = [15.0, 15.0, 15.0]
positions_m = [[0.0, -0.1, 0.0], [0.34, -0.1, 0.0], [0.0, 0.2, 0.0], [0.34, 0.2, 0.0]]

[screen.bushings.shear]
between = ["driving", "driven"]
stiffness_N_per_m = [6e3, 20e3, 20e3]
damping_N_s_per_m = [8.0, 25.0, 25.0]
positions_m = [[0.0, -0.05, 0.0], [0.34, -0.05, 0.0], [0.0, 0.15, 0.0], [0.34, 0.15, 0.0]]

[screen.panels.deck]
material = "PU"
frames = ["driving", "driven"]
count = 2
pitch_m = 0.1705
corner_m = [0.0, 0.0, 0.0]
length_m = 0.15
width_m = 0.10
thickness_m = 0.003
clamp_m = 0.0095
tension_m = 0.0015

[panel]
cells = [8, 4]
surface_cells = [13, 7]

[particles]
largest_youngs_modulus_Pa = 1e7

[coupling]
scheme = "particles-first"
sync_interval_s = 5e-5
"""
)

EXCITER = """
[screen.exciters.shaft]
frame = "driving"
position_m = [0.15, 0.05, -0.01]
mass_moment_kg_m = 0.08
speed_rad_per_s = 150.0
run_up_s = 0.005
"""

BED = """
[bed.blocks.coal]
material = "coal"
box_m = [[0.01, 0.005, 0.001], [0.31, 0.095, 0.014]]
count = 40
sizes = [{ smallest_m = 0.008, largest_m = 0.011, mass_fraction = 1.0 }]
velocity_m_per_s = [0.2, 0.0, -0.5]
"""

EMPTY = MACHINE + EXCITER
CASE = EMPTY + BED

SMOOTH_AND_ELASTIC = [
    *(f"contacts.{pair}.restitution=1" for pair in (0, 1)),
    *(f"contacts.{pair}.sliding_friction=0" for pair in (0, 1)),
    *(f"screen.bushings.{name}.damping_N_s_per_m=[0, 0, 0]" for name in ("isolation", "shear")),
    "materials.PU.hyperelastic.maxwell=[]",
]
"""Settings that leave nothing to dissipate energy."""
