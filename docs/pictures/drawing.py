"""What the pictures of docs/theory are drawn with: a canvas without axes, and a few mechanical symbols."""

from __future__ import annotations

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Circle, FancyBboxPatch, Rectangle

PARTICLES, PANELS, FRAMES, DARK, PALE = "#c0561f", "#1f6f8b", "#5b5b66", "#222222", "#e9eef1"
plt.rcParams.update(
    {
        "svg.hashsalt": "flipflow",
        "svg.fonttype": "path",
        "font.size": 10,
        "axes.spines.top": False,
        "axes.spines.right": False,
        "legend.frameon": False,
        "figure.facecolor": "white",
    }
)


def canvas(width: float, height: float) -> Axes:
    """A drawing of ``width`` by ``height`` units, an inch each."""
    figure = plt.figure(figsize=(width, height))
    axes = figure.add_axes((0, 0, 1, 1))
    axes.set(xlim=(0, width), ylim=(0, height), aspect="equal")
    axes.axis("off")
    return axes


def plots(count: int = 1, width: float = 7.0, height: float = 2.8):
    """A row of ``count`` graphs; a single one is returned by itself."""
    _, axes = plt.subplots(1, count, figsize=(width, height), constrained_layout=True)
    return axes


def say(axes: Axes, x: float, y: float, words: str, color: str = DARK, size: float = 10, **more) -> None:
    """Write ``words`` centered on a place."""
    axes.text(x, y, words, color=color, fontsize=size, **({"ha": "center", "va": "center"} | more))


def arrow(
    axes: Axes, tail, head, color: str = DARK, width: float = 1.6, style: str = "-|>", bend: float = 0
) -> None:
    """Draw an arrow between two places; ``bend`` curves it."""
    look = {"arrowstyle": style, "color": color, "lw": width, "shrinkA": 0, "shrinkB": 0}
    look |= {"connectionstyle": f"arc3,rad={bend}", "mutation_scale": 12}
    axes.annotate("", xy=head, xytext=tail, arrowprops=look)


def box(axes: Axes, x: float, y: float, width: float, height: float, words: str, color: str = DARK) -> None:
    """Draw a box with rounded corners around its middle, with ``words`` in it."""
    corner = (x - width / 2, y - height / 2)
    shape = FancyBboxPatch(
        corner,
        width,
        height,
        boxstyle="round,pad=0,rounding_size=0.06",
        fc=PALE,
        ec=color,
        lw=1.5,
        zorder=2.5,
    )
    axes.add_patch(shape)  # above lines that pass behind it
    say(axes, x, y, words, color, zorder=3)


def bar(
    axes: Axes, x: float, y: float, width: float, height: float, color: str = FRAMES, fill: str = PALE
) -> None:
    """Draw a rectangle by its lower left corner."""
    axes.add_patch(Rectangle((x, y), width, height, fc=fill, ec=color, lw=1.4))


def ball(
    axes: Axes, x: float, y: float, radius: float, color: str = PARTICLES, fill: str = "#f6e3d7"
) -> None:
    """Draw a sphere."""
    axes.add_patch(Circle((x, y), radius, fc=fill, ec=color, lw=1.5))


def line(axes: Axes, x, y, color: str = DARK, width: float = 1.6, style: str = "-") -> None:
    """Draw a polyline."""
    axes.plot(x, y, color=color, lw=width, ls=style, solid_capstyle="round")


def spring(axes: Axes, tail, head, color: str = DARK, turns: int = 5, size: float = 0.09) -> None:
    """Draw a coil between two places."""
    tail, head = np.array(tail, float), np.array(head, float)
    along = head - tail
    across = np.array([-along[1], along[0]]) / np.hypot(*along)
    share = np.concatenate([[0, 0.15], np.linspace(0.2, 0.8, 2 * turns), [0.85, 1]])
    side = np.concatenate([[0, 0], size * (-1.0) ** np.arange(2 * turns), [0, 0]])
    places = tail + share[:, None] * along + side[:, None] * across
    line(axes, *places.T, color, 1.3)


def damper(axes: Axes, tail, head, color: str = DARK, size: float = 0.1) -> None:
    """Draw a dashpot between two places."""
    tail, head = np.array(tail, float), np.array(head, float)
    along = head - tail
    across = size * np.array([-along[1], along[0]]) / np.hypot(*along)
    cup, piston = tail + 0.4 * along, tail + 0.55 * along
    end = tail + 0.7 * along
    line(axes, *np.array([tail, cup]).T, color, 1.3)
    line(axes, *np.array([end + across, cup + across, cup - across, end - across]).T, color, 1.3)
    line(axes, *np.array([piston + 0.8 * across, piston - 0.8 * across]).T, color, 1.3)
    line(axes, *np.array([piston, head]).T, color, 1.3)


def ground(axes: Axes, x: float, y: float, width: float) -> None:
    """Draw a fixed support from (x, y) to the right."""
    line(axes, [x, x + width], [y, y], FRAMES, 1.6)
    for start in np.arange(x, x + width - 0.02, 0.13):
        line(axes, [start, start + 0.1], [y - 0.1, y], FRAMES, 0.9)
