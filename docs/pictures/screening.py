"""Where a steady state begins, and the partition curve with d25, d50 and d75 (illustrations, not results)."""

import numpy as np
from drawing import DARK, PANELS, PARTICLES, plots


def draw() -> None:
    left, right = plots(2, 8, 2.8)
    draws = np.random.default_rng(1)
    cycle = np.arange(120)
    held = 1 - np.exp(-cycle / 14) + 0.02 * draws.standard_normal(120)
    left.plot(cycle, held, color=PARTICLES, lw=1.2)
    left.axvspan(40, 119, color=PANELS, alpha=0.15, lw=0)
    left.axhline(held[40:].mean(), color=PANELS, lw=0.8, ls="--")
    for edge in range(40, 120, 4):
        left.axvline(edge, color=PANELS, lw=0.3)
    left.text(80, 0.3, "window:\nbatches of whole cycles", ha="center", color=PANELS, fontsize=9)
    left.set(xlabel="machine cycle", ylabel="hold-up $M$ / its steady mean")
    size = np.linspace(0.3, 2, 200)
    share = 100 / (1 + size**-7.0)
    right.plot(size, share, color=PANELS)
    for percent, name in ((25, "$d_{25}$"), (50, "$d_{50}$"), (75, "$d_{75}$")):
        at = (percent / (100 - percent)) ** (1 / 7)
        right.plot([0.3, at, at], [percent, percent, 0], ":", color=DARK, lw=0.9)
        right.text(at + 0.02, percent - 9, name, fontsize=9)
    right.set(xlabel="diameter / cut size", ylabel="share in the oversize / %", xlim=(0.3, 2), ylim=(0, 100))
