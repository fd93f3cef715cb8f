"""The contact law: an impact of a sphere by Hertz's spring and Tsuji's damper, and the elements."""

import numpy as np
from drawing import PARTICLES, arrow, ball, damper, line, plt, say, spring


def impact(restitution: float, steps: int = 4000) -> tuple[np.ndarray, np.ndarray]:
    """Overlap and force of an impact at speed 1 of mass 1 with S_n = 2 E* sqrt(R* overlap), E* = R* = 1."""
    beta = -np.log(restitution) / np.hypot(np.log(restitution), np.pi) if restitution < 1 else 0.0
    step, x, v, rows = 1e-3, 0.0, 1.0, []
    for _ in range(steps):
        stiffness = 2 * np.sqrt(max(x, 0.0))
        force = 2 / 3 * stiffness * x + 2 * np.sqrt(5 / 6) * beta * np.sqrt(stiffness) * v
        rows.append((x, force))
        v -= step * force
        x += step * v
        if x <= 0:
            break
    return np.array(rows).T


def draw() -> None:
    _, (left, right) = plt.subplots(1, 2, figsize=(8, 3), constrained_layout=True)
    for restitution, style in ((1.0, "-"), (0.7, "--"), (0.34, ":")):
        left.plot(*impact(restitution), style, color=PARTICLES, label=f"$e$ = {restitution:g}")
    left.set(xlabel=r"overlap $\delta$", ylabel="normal force $F_n$")
    left.legend()
    right.set(xlim=(0, 4), ylim=(0, 3), aspect="equal")
    right.axis("off")
    ball(right, 1.22, 1.5, 0.85)
    ball(right, 2.78, 1.5, 0.85)
    spring(right, (1.25, 1.75), (2.75, 1.75), turns=6)
    damper(right, (1.25, 1.3), (2.75, 1.3))
    say(right, 2.0, 2.05, r"$\frac{2}{3}S_n\delta$")
    say(right, 2.0, 0.98, r"$2\sqrt{5/6}\,\beta\sqrt{S_n m^*}\,v_n$", size=9)
    arrow(right, (1.0, 2.6), (1.7, 2.6))
    say(right, 0.85, 2.6, r"$\mathbf{n}$")
    line(right, [2, 2], [0.3, 0.7], "#888888", 1)
    say(right, 2.0, 0.15, "across: spring $S_t s$, damper, and friction $\\mu|F_n|$", size=8)
