"""The zones of a verdict around its threshold."""

from drawing import DARK, PANELS, PARTICLES, arrow, canvas, line, say


def draw() -> None:
    axes = canvas(8.0, 1.9)
    zones = (
        (0.4, 2.8, "may be left out", PANELS),
        (2.8, 5.2, "cannot say:\na pair of runs decides", "#888888"),
        (5.2, 7.6, "matters", PARTICLES),
    )
    for left, right, words, color in zones:
        axes.axvspan(left, right, 0.45, 0.8, color=color, alpha=0.18, lw=0)
        say(axes, (left + right) / 2, 1.19, words, color if color != "#888888" else DARK, 10)
    arrow(axes, (0.4, 0.8), (7.8, 0.8))
    for x, words in ((2.8, "threshold / 3"), (4.0, "threshold"), (5.2, "3 thresholds")):
        line(axes, [x, x], [0.7, 0.9], DARK, 1.2)
        say(axes, x, 0.55, words, DARK, 9)
    say(axes, 7.2, 0.55, "number", DARK, 9)
    say(axes, 4.0, 1.7, "one dimensionless number for each effect, by a closed form", "#666666", 9)
    say(
        axes,
        4.0,
        0.2,
        "above the threshold: only where results are asked for, or a part could be left out",
        "#666666",
        8,
    )
