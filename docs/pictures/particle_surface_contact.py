"""A sphere in a valley of two facets, and the force of both contacts over the angle of the fold."""

import numpy as np
from drawing import PANELS, PARTICLES, arrow, ball, line, plt, say


def separation(angle: np.ndarray) -> np.ndarray:
    """s of two normals: 0 is one contact, 1 is two (theory/particle_surface_contact.md)."""
    smooth, sharp = np.cos(np.radians([15.0, 45.0]))
    t = np.clip((smooth - np.cos(angle)) / (smooth - sharp), 0, 1)
    return 1 - (1 + np.log2(np.cos(angle / 2))) * (1 - 3 * t**2 + 2 * t**3)


def draw() -> None:
    _, (left, right) = plt.subplots(1, 2, figsize=(8, 2.9), constrained_layout=True)
    left.set(xlim=(0, 4), ylim=(0, 2.8), aspect="equal")
    left.axis("off")
    tilt, middle = np.radians(28), np.array([2.0, 0.6])
    side = np.array([np.cos(tilt), np.sin(tilt)])
    for sign in (-1, 1):
        end = middle + 1.9 * side * [sign, 1]
        line(left, [middle[0], end[0]], [middle[1], end[1]], PANELS, 2.2)
    center = middle + np.array([0, 0.93 / np.cos(tilt)])
    ball(left, *center, 1.0)
    for sign, name in ((-1, "j"), (1, "i")):
        normal = np.array([-sign * np.sin(tilt), np.cos(tilt)])
        foot = center - 0.93 * normal
        arrow(left, foot, foot + 0.6 * normal, PARTICLES)
        say(left, *(foot + 0.75 * normal), f"$n_{name}$", PARTICLES)
        say(left, *(foot - 0.22 * normal), f"$U_{name}$", PANELS)
    angle = np.radians(np.linspace(0.01, 90, 400))
    force = 2 ** separation(angle) * np.cos(angle / 2)
    right.plot(np.degrees(angle), force, color=PARTICLES, label="shared by the p-norm")
    right.plot(np.degrees(angle), 2 * np.cos(angle / 2), ":", color="#888888", label="both in full")
    right.set(xlabel="angle of the valley / °", ylabel="force in its middle / one contact", ylim=(0.9, 2.1))
    right.legend(fontsize=8, loc="lower right")
