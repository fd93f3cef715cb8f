"""Force over overlap of JKR, sjkr and Hertz with the same pull-off force, in units of JKR's."""

import numpy as np
from drawing import DARK, PANELS, PARTICLES, plots


def draw() -> None:
    axes = plots(1, 6.5, 3.2)
    u = np.linspace(1, 2.6, 300)
    overlap, force = (u**4 - 4 * u) / 3, (u**6 - 6 * u**3) / 9
    axes.plot(overlap, force, color=PARTICLES, label="JKR, with a neck")
    axes.plot([-1, -1], [-5 / 9, 0], ":", color=PARTICLES)
    axes.plot([0, 0], [0, -8 / 9], ":", color=PARTICLES)
    axes.annotate("snaps", (-1, -5 / 9), (-1.6, -0.9), fontsize=9)
    axes.annotate("forms", (0, -8 / 9), (0.12, -0.55), fontsize=9)
    # Hertz: F/F_po = 4/3 E* sqrt(R*) |d_c|^1.5 x^1.5 / F_po = x^1.5 / sqrt(3)
    x = np.linspace(0, overlap.max(), 300)
    hertz = x**1.5 / np.sqrt(3)
    axes.plot(x, hertz, color=DARK, lw=1.2, label="Hertz")
    # sjkr: Hertz less c x whose least value is -1, c^3 = 9/4
    axes.plot(x, hertz - (9 / 4) ** (1 / 3) * x, "--", color=PANELS, label="sjkr")
    axes.axhline(0, color="#bbbbbb", lw=0.8)
    axes.axhline(-1, color="#bbbbbb", lw=0.8, ls=":")
    axes.set(
        xlabel=r"overlap $\delta/|\delta_c|$",
        ylabel=r"force $F/F_\mathrm{po}$",
        xlim=(-2, 5),
        ylim=(-1.2, 2.5),
    )
    axes.legend(loc="upper left", fontsize=9)
