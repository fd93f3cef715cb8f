"""A strip: rows, axial springs, bending springs and clamps."""

import numpy as np
from drawing import FRAMES, PANELS, arrow, ball, bar, canvas, say, spring


def draw() -> None:
    axes = canvas(7.5, 2.5)
    s = np.linspace(0, 1, 8)
    x, z = 1.2 + 5.1 * s, 1.5 - 0.75 * np.sin(np.pi * s) ** 2
    bar(axes, 0.2, 1.35, 1.0, 0.3)
    bar(axes, 6.3, 1.35, 1.0, 0.3)
    say(axes, 0.7, 1.83, "clamp", FRAMES, 9)
    say(axes, 6.8, 1.83, "clamp", FRAMES, 9)
    for k in range(7):
        spring(axes, (x[k], z[k]), (x[k + 1], z[k + 1]), PANELS, 4, 0.06)
    for k in range(8):
        ball(axes, x[k], z[k], 0.06, PANELS, PANELS)
    for end in (0.5, 7.0):
        ball(axes, end, 1.5, 0.06, PANELS, PANELS)
    say(axes, 2.1, 0.75, r"$N=A\,P(\lambda)$", PANELS)
    arrow(axes, (3.45, 1.35), (4.05, 1.35), PANELS, 1.3, "<|-|>", -0.6)
    say(axes, 3.75, 1.75, r"$\frac{1}{2}EI\,\Delta s\,|\kappa|^2$", PANELS)
    say(axes, 3.75, 0.3, "row: one point in mid-width, with the mass of its cell", "#666666", 9)
