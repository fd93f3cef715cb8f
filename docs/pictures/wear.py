"""A grain that slides on a panel: what its friction takes from the tangential spring wears the surface."""

from drawing import DARK, PANELS, PARTICLES, arrow, ball, canvas, line, np, say, spring


def draw() -> None:
    axes = canvas(7.0, 2.6)
    x = np.linspace(0.3, 6.7, 300)
    line(axes, x, 0.8 - 0.18 * np.exp(-(((x - 2.3) / 0.9) ** 2)), PANELS, 2.4)
    line(axes, x, 0.8 + 0 * x, "#aaaaaa", 0.8, "--")
    ball(axes, 3.4, 1.45, 0.68)
    arrow(axes, (3.4, 2.35), (3.4, 1.75), PARTICLES)
    say(axes, 3.62, 2.25, "$F$", PARTICLES)
    arrow(axes, (4.2, 1.6), (5.1, 1.6), PARTICLES)
    say(axes, 5.3, 1.6, "$v_t$", PARTICLES)
    spring(axes, (2.2, 1.0), (3.25, 0.86), DARK, 4, 0.07)
    say(axes, 1.75, 1.2, "tangential spring:\nstretch is not sliding", size=9)
    arrow(axes, (2.2, 0.45), (3.4, 0.45), DARK, 1.2, "<|-|>")
    say(axes, 2.8, 0.25, "slid: $ds$")
    say(axes, 5.3, 0.4, r"$dV = k\,|F|\,ds$", PANELS, 12)
