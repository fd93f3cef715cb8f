"""A spring with friction and Maxwell elements in parallel, and its loops over the amplitude."""

import numpy as np
from drawing import DARK, FRAMES, PANELS, PARTICLES, arrow, bar, damper, ground, plt, say, spring

ELASTIC_N_per_m = 150e3
FRICTION = ((40e3, 3e-4), (30e3, 1.5e-3))  # stiffness in N/m, slip in m
MAXWELL = (20e3, 0.005)  # stiffness in N/m, relaxation time in s
STEPS = 2000


def loop(amplitude_m: float, frequency_Hz: float) -> tuple[np.ndarray, np.ndarray]:
    """Return deformation in mm and force in kN around the third cycle."""
    path_m = amplitude_m * np.sin(2 * np.pi * np.arange(3 * STEPS + 1) / STEPS)
    half = 0.5 / (frequency_Hz * STEPS) / MAXWELL[1]
    sliding, viscous, force_N = np.zeros(2), 0.0, []
    stiffness, slip_m = np.array(FRICTION).T
    for step_m in np.diff(path_m):
        sliding = np.clip(sliding + stiffness * step_m, -stiffness * slip_m, stiffness * slip_m)
        viscous = (viscous * (1 - half) + MAXWELL[0] * step_m) / (1 + half)
        force_N.append(sliding.sum() + viscous)
    force_N = ELASTIC_N_per_m * path_m[1:] + np.array(force_N)
    return 1e3 * path_m[-STEPS:], 1e-3 * force_N[-STEPS:]


def draw() -> None:
    _, (left, right) = plt.subplots(1, 2, figsize=(8, 3.1), width_ratios=(3, 2.4), constrained_layout=True)
    left.set(xlim=(0, 4.6), ylim=(0, 3), aspect="equal")
    left.axis("off")
    ground(left, 0.3, 0.35, 3.6)
    bar(left, 0.3, 2.3, 3.6, 0.3)
    say(left, 2.1, 2.45, "moved plate", FRAMES, 9)
    spring(left, (0.6, 0.35), (0.6, 2.3))
    say(left, 0.6, 0.12, "spring", size=8)
    for x in (1.35, 2.15):
        spring(left, (x, 1.2), (x, 2.3), PANELS)
        left.plot([x - 0.18, x + 0.18], [1.2, 1.2], color=PANELS, lw=2)
        left.plot([x - 0.18, x + 0.18], [1.1, 1.1], color=DARK, lw=2)
        left.plot([x, x], [0.35, 1.1], color=DARK, lw=1)
    say(left, 1.75, 0.12, "friction", PANELS, 8)
    spring(left, (3.2, 1.25), (3.2, 2.3), PARTICLES)
    damper(left, (3.2, 0.35), (3.2, 1.25))
    say(left, 3.2, 0.12, "Maxwell", PARTICLES, 8)
    arrow(left, (3.95, 2.45), (4.5, 2.45), FRAMES, 1.4)
    say(left, 4.25, 2.65, "$x, F$", FRAMES, 9)
    for amplitude_m, color in ((1e-3, PARTICLES), (3e-3, PANELS), (6e-3, FRAMES)):
        place_mm, force_kN = loop(amplitude_m, 12.5)
        turn = force_kN[place_mm.argmax()]
        stiffness = turn / amplitude_m
        right.plot(place_mm, force_kN, color=color, label=f"{stiffness:.0f} kN/m to the tip")
    right.set(xlabel="deformation / mm", ylabel="force / kN")
    right.legend(fontsize=7, loc="upper left")
    right.set_title("loops at 12.5 Hz", fontsize=10)
