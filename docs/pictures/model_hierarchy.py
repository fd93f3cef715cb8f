"""The models of each part, from cheap to detailed."""

from drawing import FRAMES, PANELS, PARTICLES, arrow, box, canvas, say


def draw() -> None:
    axes = canvas(9.0, 2.8)
    rows = (
        (2.05, "panel", PANELS, ("rigid", "strip", "sheet", "solid")),
        (1.25, "frames", FRAMES, ("prescribed", "two-mass", "exudyn")),
        (0.45, "particles", PARTICLES, ("none", "coarser", "softer", "liggghts", "stiffer")),
    )
    for y, part, color, models in rows:
        say(axes, 0.55, y, part, color, 11)
        for number, model in enumerate(models):
            box(axes, 1.65 + 1.12 * number, y, 1.0, 0.52, model, color)
    arrow(axes, (1.2, 2.48), (8.8, 2.48), "#888888", 1.2)
    say(axes, 2.0, 2.52, "cheap", "#666666", 8, va="bottom", backgroundcolor="none")
    say(axes, 8.2, 2.52, "detailed", "#666666", 8, va="bottom")
