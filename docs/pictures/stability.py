"""A light point under a held sphere, interval by interval, below and above the limit of the plain scheme."""

import numpy as np
from drawing import DARK, PANELS, PARTICLES, plots


def places(share: float, count: int) -> np.ndarray:
    """Places of a free point under a spring contact at ``share`` of the limit 2 sqrt(M/k), by the map of
    theory/stability.md with k = M = 1 and no damper."""
    h, x, v, found = 2 * share, 1.0, 0.0, []
    for _ in range(count):
        found.append(x)
        after = v - h * (x + h * v / 2)
        x, v = x + h * (v + after) / 2, after
    return np.array(found)


def draw() -> None:
    left, right = plots(2, 8.0, 2.8)
    for share, color in ((0.5, PANELS), (0.9, DARK), (1.02, PARTICLES)):
        left.plot(places(share, 14), "o-", ms=3, lw=1.2, color=color, label=f"{share:g} of the limit")
    left.set(xlabel="sync point", ylabel="place of the light point", ylim=(-4, 7))
    left.legend(fontsize=8, loc="upper left", ncols=2)
    ratio = np.linspace(0, 3, 200)
    right.plot(ratio, (np.sqrt(ratio**2 + 4) - ratio) / 2, color=PANELS)
    right.fill_between(ratio, 0, (np.sqrt(ratio**2 + 4) - ratio) / 2, color=PANELS, alpha=0.15, lw=0)
    right.text(0.5, 0.3, "stable", color=PANELS)
    right.set(xlabel=r"damping $g/\sqrt{kM}$", ylabel=r"limit $H/(2\sqrt{M/k})$", xlim=(0, 3), ylim=(0, 1.1))
