"""One sync interval of the plain scheme: what crosses between frames, panels and particles."""

from drawing import DARK, FRAMES, PANELS, PARTICLES, arrow, box, canvas, line, say


def draw() -> None:
    axes = canvas(8.0, 3.6)
    rows = ((3.0, "frames", FRAMES), (1.8, "panels", PANELS), (0.6, "particles", PARTICLES))
    for x, words in ((1.6, "sync point $n$"), (7.0, "sync point $n+1$")):
        line(axes, [x, x], [0.1, 3.35], "#999999", 1, "--")
        say(axes, x, 3.48, words, "#666666", 9)
    for y, words, color in rows:
        say(axes, 0.65, y, words, color, 11)
        line(axes, [1.6, 7.0], [y, y], color, 0.8)
    box(axes, 2.85, 0.6, 2.1, 0.42, "1  on the moving surface", PARTICLES)
    box(axes, 4.45, 1.8, 1.5, 0.42, "2  under the load", PANELS)
    box(axes, 6.1, 3.0, 1.5, 0.42, "3  under the pull", FRAMES)
    arrow(axes, (1.75, 3.0), (1.75, 1.85), FRAMES)
    arrow(axes, (1.75, 1.75), (1.75, 0.65), PANELS)
    say(axes, 2.5, 2.42, "clamps: known,\nor extrapolated", FRAMES, 9)
    say(axes, 2.62, 1.25, r"surface: $x_n,\ v_n$ by $\mathbf{H}$", PANELS, 9)
    arrow(axes, (3.7, 0.84), (4.3, 1.56), PARTICLES)
    say(axes, 5.0, 1.1, r"mean load $F$ by $\mathbf{H}^{\mathsf{T}}$", PARTICLES, 9)
    arrow(axes, (5.2, 1.9), (5.95, 2.78), PANELS)
    say(axes, 6.2, 2.3, "mean pull $R$", PANELS, 9)
    say(axes, 7.55, 1.2, "motion\ngoes down", DARK, 9)
    say(axes, 7.55, 2.3, "load\ngoes up", DARK, 9)
