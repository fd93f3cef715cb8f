"""A real run, small and quick: two sizes of spheres, fed onto two rigid panels with a gap."""

from tests.cases import contact, grains, polyurethane

CASE = (
    """
title = "a deck with a gap that the small pass"
description = "Two rigid panels with a gap of 28 mm between them; 30 mm spheres roll over it."
duration_s = 2.5
domain_m = [[-0.3, -0.05, -0.6], [0.8, 0.15, 0.3]]
"""
    + polyurethane()
    + grains("glass", density_kg_per_m3=2500.0, youngs_modulus_Pa=2e6)
    + contact("glass", "glass", restitution=0.3, sliding=0.3)
    + contact("glass", "PU", restitution=0.3, sliding=0.3)
    + """
[screen]
inclination_deg = 12.0

[screen.frames.frame]
[screen.frames.frame.drive]
speed_rad_per_s = 125.66370614359172
amplitude_m = [0.001, 0.0, 0.0005]
run_up_s = 0.1

[screen.panels.upper]
material = "PU"
frames = ["frame", "frame"]
corner_m = [0.0, 0.0, 0.0]
length_m = 0.2
width_m = 0.1
thickness_m = 0.004
tension_m = 0.0

[screen.panels.lower]
material = "PU"
frames = ["frame", "frame"]
corner_m = [0.228, 0.0, 0.0]
length_m = 0.2
width_m = 0.1
thickness_m = 0.004
tension_m = 0.0

[screen.surfaces.left]
corner_m = [-0.02, 0.0, -0.05]
edges_m = [[0.48, 0.0, 0.0], [0.0, 0.0, 0.25]]
frame = "ground"
material = "PU"

[screen.surfaces.right]
corner_m = [-0.02, 0.1, -0.05]
edges_m = [[0.48, 0.0, 0.0], [0.0, 0.0, 0.25]]
frame = "ground"
material = "PU"

[screen.exits.gap]
product = "undersize"
box_m = [[0.0, -0.05, -0.3], [0.4, 0.15, -0.03]]

[screen.exits.end]
product = "oversize"
box_m = [[0.46, -0.05, -0.5], [0.7, 0.15, 0.1]]

[bed.feeds.chute]
material = "glass"
rate_kg_per_s = 0.12
box_m = [[0.02, 0.02, 0.05], [0.07, 0.08, 0.11]]
velocity_m_per_s = [0.2, 0.0, -0.5]
sizes = [
  { smallest_m = 0.010, largest_m = 0.011, mass_fraction = 0.4 },
  { smallest_m = 0.030, largest_m = 0.031, mass_fraction = 0.6 },
]

[probes.middle]
panel = "upper"
at = [0.5, 0.5]

[probes.corner]
frame = "frame"
point_m = [0.0, 0.0, 0.0]

[coupling]
scheme = "particles-first"
sync_interval_s = 5e-4
[frames]
solver = "prescribed"
[panel]
solver = "rigid"
surface_cells = [2, 1]
[particles]
solver = "liggghts"
[output]
interval_s = 0.02
pictures = false
cut_size_m = 0.02
"""
)
