"""A recorded panel: the flat panel between its clamps, and the shape that is played back on it."""

import numpy as np
from drawing import DARK, FRAMES, PANELS, arrow, ball, bar, canvas, line, say


def draw() -> None:
    axes = canvas(7.5, 2.6)
    start, end = np.array([1.0, 1.4]), np.array([5.2, 1.75])
    s = np.linspace(0, 1, 80)
    chord = start + s[:, None] * (end - start)
    for size, width in ((0.9, 2.2), (0.5, 1.0), (-0.25, 1.0)):
        line(axes, chord[:, 0], chord[:, 1] - size * np.sin(np.pi * s) ** 2, PANELS, width)
    line(axes, *chord.T, FRAMES, 1.2, "--")
    bar(axes, 0.4, 1.25, 0.6, 0.3)
    bar(axes, 5.2, 1.6, 0.6, 0.3)
    at = 40
    arrow(axes, chord[at], chord[at] - [0, 0.9], DARK, 1.3)
    say(axes, 3.65, 1.15, r"$u(s,y,\theta)$", PANELS)
    say(axes, 1.9, 1.75, r"$N\,c(t)$", FRAMES)
    ball(axes, 6.7, 1.0, 0.5, FRAMES, "white")
    arrow(axes, (6.7, 1.0), (7.05, 1.35), PANELS)
    say(axes, 6.7, 0.3, r"$\theta=\omega(t-t_0)$", PANELS, 9)
    say(axes, 3.1, 0.2, r"pull $q$ on both clamps, mass and load by the lever rule", "#666666", 9)
