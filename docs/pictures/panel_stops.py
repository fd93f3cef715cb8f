"""A slack panel on a beam, and the bounce of a mass on the layer below, at and above the limit."""

import numpy as np
from drawing import FRAMES, PANELS, PARTICLES, bar, damper, line, plt, say, spring


def bounce(q: float, count: int = 40) -> np.ndarray:
    """Depths of a mass that is pressed on the layer, by the map of theory/panel_stops.md."""
    x, u, found = 1.0, 0.0, []
    for _ in range(count):
        found.append(x)
        middle = x + u / 2
        x, u = x + u - q / 2 * middle, u - q * middle
    return np.array(found)


def draw() -> None:
    _, (left, right) = plt.subplots(1, 2, figsize=(8, 2.9), constrained_layout=True)
    left.set(xlim=(0, 4.6), ylim=(0, 2.4), aspect="equal")
    left.axis("off")
    bar(left, 0.1, 1.75, 0.7, 0.25)
    bar(left, 3.8, 1.75, 0.7, 0.25)
    bar(left, 1.2, 0.3, 1.4, 0.5)
    say(left, 1.9, 0.55, "stop", FRAMES)
    x = np.array([0.8, 1.1, 1.4, 1.9, 2.4, 2.8, 3.3, 3.8])
    z = np.array([1.87, 1.55, 1.22, 1.12, 1.15, 1.3, 1.65, 1.87])
    fine = np.linspace(0.8, 3.8, 80)
    line(left, fine, np.interp(fine, x, z), PANELS, 2.4)
    for at in (1.5, 2.2):
        spring(left, (at, 0.8), (at, 1.15), PARTICLES, 3, 0.06)
        damper(left, (at + 0.2, 0.8), (at + 0.2, 1.13), PARTICLES, 0.06)
    say(left, 3.35, 0.75, r"$F=A(kg+c\dot g)$", PARTICLES)
    for q, style in ((0.1, "-"), (3.9, "-"), (4.1, "--")):
        right.plot(
            bounce(q, 12 if q > 4 else 40),
            style,
            lw=1.1,
            color={0.1: PANELS, 3.9: FRAMES, 4.1: PARTICLES}[q],
            label=f"$q$ = {q:g}",
        )
    right.set(xlabel="interval", ylabel="depth", ylim=(-4, 5))
    right.legend(fontsize=8, loc="upper left", ncols=3)
