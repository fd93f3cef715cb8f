"""A bed in a shaken box: an elastic panel for its floor and four walls, on one driven frame."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

from tests.cases import contact, grains, polyurethane

SPEED_RAD_S, AMPLITUDE_M = 78.5, 0.0035  # throw intensity 2.2
LENGTH_M, WIDTH_M, HEIGHT_M = 0.15, 0.10, 0.25

CASE = (
    """
title = "a bed in a shaken box"
duration_s = 1.0
domain_m = [[-0.05, -0.05, -0.1], [0.2, 0.15, 0.4]]
"""
    + polyurethane((0.2, 2.0e-3))
    + grains("coal", density_kg_per_m3=1430.0, youngs_modulus_Pa=4e6)
    + contact("coal", "coal", restitution=0.3, sliding=0.36, rolling=0.05)
    + contact("coal", "PU", restitution=0.3, sliding=0.47, rolling=0.05)
    + f"""
[screen.frames.shaker.drive]
speed_rad_per_s = {SPEED_RAD_S}
amplitude_m = [0.0, 0.0, {AMPLITUDE_M}]
run_up_s = 0.1

[screen.panels.floor]
material = "PU"
frames = ["shaker", "shaker"]
corner_m = [0.0, 0.0, 0.0]
length_m = {LENGTH_M}
width_m = {WIDTH_M}
thickness_m = 0.004
clamp_m = 0.0
tension_m = 0.003

[screen.surfaces.walls]
stl = "walls.stl"
frame = "shaker"
material = "PU"

[bed.blocks.coal]
material = "coal"
box_m = [[0.008, 0.008, 0.01], [0.142, 0.092, 0.24]]
count = 1200
sizes = [{{ smallest_m = 0.007, largest_m = 0.009, mass_fraction = 1.0 }}]

[frames]
solver = "prescribed"

[panel]
solver = "strip"
cells = [12, 1]
surface_cells = [12, 4]

[coupling]
scheme = "particles-first"
sync_interval_s = 2e-4
"""
)


def write_walls(file: Path) -> None:
    """Four sides, facing in."""
    x, y = LENGTH_M, WIDTH_M
    corners = [(0.0, 0.0), (x, 0.0), (x, y), (0.0, y), (0.0, 0.0)]
    facets = []
    for (x1, y1), (x2, y2) in pairwise(corners):
        a, b = f"{x1} {y1} -0.02", f"{x2} {y2} -0.02"
        c, d = f"{x2} {y2} {HEIGHT_M}", f"{x1} {y1} {HEIGHT_M}"
        facets += [(a, b, c), (a, c, d)]
    rows = "".join(
        "facet normal 0 0 0\nouter loop\n"
        + "".join(f"vertex {place}\n" for place in facet)
        + "endloop\nendfacet\n"
        for facet in facets
    )
    file.write_text(f"solid walls\n{rows}endsolid walls\n")
