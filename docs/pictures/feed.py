"""Where material comes from and goes to: feed, deck, exits, and what is lost."""

from drawing import DARK, FRAMES, PANELS, PARTICLES, arrow, ball, bar, canvas, line, np, say


def draw() -> None:
    axes = canvas(7.5, 3.0)
    bar(axes, 0.3, 2.0, 1.1, 0.7, PARTICLES, "#f6e3d7")
    say(axes, 0.85, 2.85, "feed: owes $\\dot m\\,t$", PARTICLES, 9)
    line(axes, [0.7, 6.0], [1.75, 1.05], PANELS, 2.6)
    draws = np.random.default_rng(4)
    for x in np.linspace(0.9, 5.7, 26):
        radius = draws.uniform(0.04, 0.11)
        ball(axes, x, 1.75 - 0.132 * (x - 0.7) + radius + draws.uniform(0.02, 0.3), radius)
    for x, name in ((1.0, "section 1"), (2.7, "section 2"), (4.4, "section 3")):
        bar(axes, x, 0.15, 1.5, 0.45, FRAMES)
        say(axes, x + 0.75, 0.37, name + ": undersize", FRAMES, 8)
        arrow(axes, (x + 0.75, 1.2 if x < 4 else 1.0), (x + 0.75, 0.68), PARTICLES, 1.2)
    bar(axes, 6.2, 0.15, 1.0, 0.9, FRAMES)
    say(axes, 6.7, 0.6, "oversize", FRAMES, 8)
    arrow(axes, (5.9, 1.4), (6.55, 1.1), PARTICLES, 1.2, bend=-0.3)
    arrow(axes, (5.2, 1.7), (6.6, 2.4), PARTICLES, 1.2)
    say(axes, 6.9, 2.5, "lost", PARTICLES, 9)
    say(axes, 3.9, 2.65, "fed = on deck + through the exits + lost", DARK, 11)
    say(axes, 3.9, 2.3, "exactly by number, to rounding by mass", "#666666", 9)
