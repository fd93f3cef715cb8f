"""A mat between turned clamps, and the stress-free shape of a moulded one."""

import numpy as np
from drawing import DARK, FRAMES, PANELS, canvas, line, say


def wave(length: float, steepest: float) -> tuple[np.ndarray, np.ndarray]:
    """Return places along and up of a mat whose slope angle is a full wave."""
    s = np.linspace(0, length, 201)
    turn = -steepest * np.sin(2 * np.pi * s / length)
    steps = np.diff(s)
    x = np.concatenate([[0], np.cumsum(steps * np.cos(turn[:-1] / 2 + turn[1:] / 2))])
    z = np.concatenate([[0], np.cumsum(steps * np.sin(turn[:-1] / 2 + turn[1:] / 2))])
    return x, z


def draw() -> None:
    axes = canvas(8, 2.3)
    angle, clamp, span = np.radians(20), 0.55, 2.6
    left, level = 1.0, 1.5
    x = np.linspace(0, span, 101)
    line(axes, left + x, level - np.tan(angle) * x * (span - x) / span, PANELS, 2.4)
    for end, out in ((left, -1), (left + span, 1)):
        outer = end + out * clamp * np.cos(angle), level + clamp * np.sin(angle)
        line(axes, [end, outer[0]], [level, outer[1]], FRAMES, 6)
        line(axes, [end, end + out * clamp], [level, level], DARK, 0.8)
        say(axes, end + out * 0.75, level + 0.1, r"$\alpha$")
    say(axes, left + span / 2, 0.35, "turned clamps: both ends point down", PANELS)
    first = 4.95
    along, up = wave(2.8, 0.62)
    line(axes, first + along, level + up, PANELS, 2.4)
    line(axes, first + along[[0, -1]], [level, level], DARK, 0.8)
    middle = first + along[100]
    line(axes, [middle, middle], [level, level + up[100]], DARK, 0.8)
    say(axes, middle + 0.15, level + up[100] / 2, "$h$")
    say(axes, middle, 0.35, "moulded: free of stress with a sag", PANELS)
