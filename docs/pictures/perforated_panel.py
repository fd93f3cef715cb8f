"""Openings as particles meet them, the periodic cell, and the sheet that bends."""

from drawing import DARK, PANELS, PARTICLES, arrow, ball, bar, canvas, line, say


def draw() -> None:
    axes = canvas(8.5, 2.7)
    bar(axes, 0.2, 0.5, 2.6, 1.6, PANELS, "#cfe0e6")
    for row in range(3):
        for column in range(4):
            bar(axes, 0.4 + 0.8 * row, 0.68 + 0.34 * column, 0.6, 0.17, PANELS, "white")
    for x, y, radius in ((0.65, 1.1, 0.07), (1.5, 1.45, 0.06), (2.3, 1.8, 0.14), (1.1, 1.78, 0.05)):
        ball(axes, x, y, radius)
    say(axes, 1.5, 2.35, "particles meet every opening", PARTICLES, 9)
    arrow(axes, (2.95, 1.3), (3.45, 1.3))
    bar(axes, 3.6, 0.8, 1.6, 1.0, PANELS, "#cfe0e6")
    bar(axes, 3.8, 1.05, 1.2, 0.5, PANELS, "white")
    arrow(axes, (3.6, 0.65), (5.2, 0.65), DARK, 1, "<|-|>")
    say(axes, 4.4, 0.48, "$p$")
    arrow(axes, (3.8, 1.3), (5.0, 1.3), DARK, 1, "<|-|>")
    say(axes, 4.4, 1.42, "$a$", size=9)
    arrow(axes, (5.32, 0.8), (5.32, 1.8), DARK, 1, "<|-|>")
    say(axes, 5.45, 1.3, "$q$")
    arrow(axes, (4.15, 1.05), (4.15, 1.55), DARK, 1, "<|-|>")
    say(axes, 4.05, 1.18, "$b$", size=9)
    say(axes, 4.4, 2.35, "one periodic cell: $A$, $D$", PANELS, 9)
    arrow(axes, (5.6, 1.3), (6.1, 1.3))
    bar(axes, 6.2, 0.5, 2.1, 1.6, PANELS, "#e6eff2")
    for k in range(1, 4):
        line(axes, [6.2 + 0.525 * k] * 2, [0.5, 2.1], PANELS, 0.7)
        line(axes, [6.2, 8.3], [0.5 + 0.4 * k] * 2, PANELS, 0.7)
    say(axes, 7.25, 2.35, "a sheet as stiff and heavy", PANELS, 9)
    say(axes, 4.25, 0.15, r"loads and motions cross by one matrix $\mathbf{H}$", "#666666", 9)
