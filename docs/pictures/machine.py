"""Amplitudes of both frames of the published machine over the exciter's speed, without damping."""

import numpy as np
from drawing import DARK, FRAMES, PANELS, PARTICLES, plots

DRIVING_KG, DRIVEN_KG, SHEAR_N_PER_M, GROUND_N_PER_M = 762.0, 287.0, 2.37e6, 0.9e6


def draw() -> None:
    axes = plots(1, 7, 3.1)
    w = np.linspace(40, 125, 1500)
    ratio = SHEAR_N_PER_M / (SHEAR_N_PER_M - DRIVEN_KG * w**2)
    first = 1 / (DRIVING_KG - GROUND_N_PER_M / w**2 + DRIVEN_KG * ratio)  # times minus the moment u
    at = np.argmin(abs(w - 78.5))
    unit = abs(ratio[at] * first[at]) / 7.9  # the driven frame moves by 7.9 mm along the deck
    for values, color, name in (
        (first, FRAMES, "driving frame"),
        (ratio * first, PANELS, "driven frame"),
        ((ratio - 1) * first, PARTICLES, "one against the other"),
    ):
        size = np.abs(values) / unit
        size[size > 30] = np.nan
        axes.plot(w, size, color=color, label=name)
    axes.axvline(78.5, color=DARK, lw=0.8, ls=":")
    axes.text(77.8, 18, "working speed", rotation=90, ha="right", va="top", fontsize=8)
    axes.set(
        xlabel="speed of the exciter / (rad/s)",
        ylabel="amplitude along the deck / mm",
        ylim=(0, 20),
        xlim=(40, 125),
    )
    axes.legend(fontsize=9, loc="upper left")
