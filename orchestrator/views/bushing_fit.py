"""A picture of the tests of a bushing, and of the elements fitted to them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from orchestrator.case.file.bushing_curve import CurveFit, Point, harmonic_stiffness, steady_loop
from orchestrator.case.file.bushing_loop import Loop
from orchestrator.views.style import FEED, LINES, TALL, WIDE, figure

MOST_LOOPS = 6
IN_A_ROW = 2


def draw_bushing_fit(points: Sequence[Point], loops: Mapping[str, Loop], fit: CurveFit) -> Any:
    """Return the figure: stiffness and loss factor over the amplitude, and each loop with the fitted one."""
    shown = [*loops.items()][:MOST_LOOPS]
    rows = 1 + -(-len(shown) // IN_A_ROW)
    fig, axes = figure(rows, IN_A_ROW, WIDE, TALL * rows)
    _draw_points(axes[0], points, fit)
    for ax, (name, loop) in zip(axes[1:].flat, shown, strict=False):
        ax.plot(1e3 * loop.displacement_m, 1e-3 * loop.force_N, ".", ms=2.5, color=FEED, label="measured")
        ax.plot(1e3 * loop.fitted_m, 1e-3 * loop.fitted_N, "--", lw=1, label="first harmonic")
        deformation_m, force_N = steady_loop(fit.elements, loop.amplitude_m, loop.frequency_Hz)
        ax.plot(1e3 * deformation_m, 1e-3 * force_N, label="fitted elements")
        ax.set(xlabel="deformation / mm", ylabel="force / kN")
        ax.set_title(f"{name}, {loop.frequency_Hz:.3g} Hz: {loop.residual:.1%} beside the harmonic")
        ax.legend(fontsize=7.5)
    for ax in axes[1:].flat[len(shown) :]:
        ax.remove()
    return fig


def _draw_points(axes: Sequence[Any], points: Sequence[Point], fit: CurveFit) -> None:
    """Draw measured stiffness and loss factor as points, and the elements' as lines, one a frequency."""
    amplitude_m, frequency_Hz, stiffness_N_per_m, loss_factor = np.array(points).T
    along_m = np.linspace(amplitude_m.min() / 2, amplitude_m.max() * 1.2, 200)
    frequency_Hz = np.array([float(f"{each:.3g}") for each in frequency_Hz])
    for number, each_Hz in enumerate(np.unique(frequency_Hz).tolist()):
        here, color = frequency_Hz == each_Hz, LINES[number % len(LINES)]
        in_phase, ahead = harmonic_stiffness(fit.elements, along_m, np.full(along_m.shape, each_Hz))
        for ax, measured, line in (
            (axes[0], 1e-3 * stiffness_N_per_m, 1e-3 * in_phase),
            (axes[1], loss_factor, ahead / in_phase),
        ):
            ax.plot(1e3 * amplitude_m[here], measured[here], "o", ms=4, color=color)
            ax.plot(1e3 * along_m, line, color=color, label=f"{each_Hz:.3g} Hz")
            ax.set(xlabel="amplitude / mm")
    axes[0].set(ylabel="stiffness / (kN/m)", title=f"off by {fit.stiffness_error:.1%} at most")
    axes[1].set(ylabel="loss factor", title=f"off by {fit.loss_error:.0%} at most")
    axes[0].legend(fontsize=7.5)
