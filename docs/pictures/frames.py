"""Two frames on bushings with an unbalance, and the torque of a motor over its speed."""

import numpy as np
from drawing import DARK, FRAMES, PANELS, PARTICLES, arrow, ball, bar, damper, ground, plt, say, spring


def draw() -> None:
    _, (left, right) = plt.subplots(1, 2, figsize=(8, 3.1), width_ratios=(3, 2), constrained_layout=True)
    left.set(xlim=(0, 4.6), ylim=(0, 3), aspect="equal")
    left.axis("off")
    ground(left, 0.3, 0.3, 4.0)
    bar(left, 0.6, 1.0, 3.3, 0.4)
    say(left, 1.3, 1.2, "driving frame", FRAMES, 9)
    bar(left, 1.1, 2.1, 2.3, 0.35)
    say(left, 2.25, 2.27, "driven frame", FRAMES, 9)
    for x in (0.9, 3.4):
        spring(left, (x, 0.3), (x, 1.0))
        damper(left, (x + 0.25, 0.3), (x + 0.25, 1.0))
    for x in (1.3, 3.0):
        spring(left, (x, 1.4), (x, 2.1), PANELS)
    say(left, 3.75, 1.75, "shear\nbushings", PANELS, 8)
    ball(left, 2.7, 1.2, 0.17, DARK, "white")
    ball(left, 2.8, 1.27, 0.05, PARTICLES, PARTICLES)
    arrow(left, (2.8, 1.27), (3.45, 1.75), PARTICLES, 1.4)
    say(left, 2.3, 0.72, r"$F=u(\varphi'^2\mathbf{r}-\varphi''\mathbf{t})$", PARTICLES, 9)
    arrow(left, (0.2, 2.4), (0.2, 2.9))
    say(left, 0.33, 2.85, "$z$", size=9)
    arrow(left, (0.2, 2.4), (0.7, 2.4))
    say(left, 0.75, 2.52, "$x$", size=9)
    speed, breakdown, rated = np.linspace(0, 1, 300), 2.5, 0.04
    lag, lag_breakdown = 1 - speed, rated * (breakdown + np.sqrt(breakdown**2 - 1))
    right.plot(speed, 2 * breakdown * lag * lag_breakdown / (lag**2 + lag_breakdown**2), color=FRAMES)
    right.plot([1 - rated], [1], "o", color=PARTICLES)
    right.annotate("rated", (1 - rated, 1), (0.62, 0.95), fontsize=9, color=PARTICLES)
    right.set(
        xlabel=r"$\varphi'$ / synchronous speed",
        ylabel="torque / rated torque",
        xlim=(0, 1.02),
        ylim=(0, 2.7),
    )
    right.set_title("Kloss", fontsize=10)
