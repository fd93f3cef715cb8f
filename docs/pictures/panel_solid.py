"""Quadratic hexahedra through the thickness, and what a clamp and a hinge hold."""

from drawing import FRAMES, PANELS, ball, bar, canvas, line, say


def draw() -> None:
    axes = canvas(8.0, 2.3)
    for left, hinge in ((0.4, False), (4.4, True)):
        start = left if hinge else left + 0.6
        for k in range(4):
            bar(axes, start + 0.7 * k, 0.9, 0.7, 0.5, PANELS)
        if not hinge:
            bar(axes, left, 0.9, 0.6, 0.5, FRAMES, "#cfd4d8")
            bar(axes, left, 0.65, 0.6, 0.25)
            bar(axes, left, 1.4, 0.6, 0.25)
        first = left if not hinge else start
        x = first
        while x < start + 2.81:
            for z in (0.9, 1.15, 1.4):
                held = x <= start + 0.01 and (not hinge or z == 1.15)
                ball(axes, x, z, 0.05, FRAMES if held else PANELS, FRAMES if held else "white")
            x += 0.35 if x >= start - 0.01 else 0.3
        line(axes, [start, start + 2.8], [1.15, 1.15], PANELS, 0.8, ":")
        say(
            axes,
            left + 1.7,
            2.0,
            "hinge: the edge of the mid-surface" if hinge else "clamp with depth: built in",
            FRAMES,
            10,
        )
    say(
        axes,
        4.0,
        0.25,
        "filled: held by the frame.  Dotted: the mid-surface, which particles touch",
        "#666666",
        9,
    )
