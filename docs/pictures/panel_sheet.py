"""What a sheet stores and loses: uniaxial stress of the membrane, and the loss factor of Maxwell branches."""

import numpy as np
from drawing import DARK, PANELS, PARTICLES, damper, plt, say, spring


def draw() -> None:
    _, (left, middle, right) = plt.subplots(1, 3, figsize=(9, 2.9), constrained_layout=True)
    stretch = np.linspace(0.8, 2.2, 200)
    for share, style in ((0.0, "-"), (0.5, "--")):
        c10, c01 = (1 - share) / 6, share / 6
        left.plot(
            stretch,
            2 * (stretch - stretch**-2) * (c10 + c01 / stretch),
            style,
            color=PANELS,
            label=f"$C_{{01}}/C$ = {share:g}",
        )
    left.plot(stretch, stretch - 1, ":", color=DARK, label="linear")
    left.set(xlabel=r"stretch $\lambda$", ylabel="uniaxial stress / $E$", ylim=(-0.4, 0.9))
    left.legend(fontsize=8)
    middle.set(xlim=(0, 3), ylim=(0, 3), aspect="equal")
    middle.axis("off")
    spring(middle, (0.6, 0.3), (0.6, 2.7), turns=8)
    say(middle, 0.2, 1.5, "$E$")
    for x in (1.4, 2.3):
        spring(middle, (x, 0.3), (x, 1.5), PANELS)
        damper(middle, (x, 1.5), (x, 2.7), PANELS)
    say(middle, 1.85, 0.75, "$g$", PANELS)
    say(middle, 1.85, 2.1, r"$\tau$", PANELS)
    middle.plot([0.4, 2.5], [2.7, 2.7], color=DARK, lw=3)
    middle.plot([0.4, 2.5], [0.3, 0.3], color=DARK, lw=3)
    w, times = np.logspace(0, 5, 300), np.array([80e-6, 400e-6, 2e-3, 10e-3])
    x = w[:, None] * times
    loss = (0.1 * x / (1 + x**2)).sum(1) / (1 + (0.1 * x**2 / (1 + x**2)).sum(1))
    right.semilogx(w, loss, color=PANELS)
    right.axvline(78.5, color=PARTICLES, lw=0.8, ls=":")
    right.set(xlabel=r"$\omega$ / (rad/s)", ylabel=r"loss factor $\eta$", ylim=(0, 0.12))
    right.set_title("four branches of 0.1", fontsize=9)
