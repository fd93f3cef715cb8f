"""The first harmonic of the pull by which a slack panel ties two frames together."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.file.slice import hindered_share_of
from orchestrator.coupling.build import build
from orchestrator.coupling.metered import Stopwatch
from orchestrator.coupling.schemes import scheme as coupling
from orchestrator.output.results.harmonics import first_harmonic
from orchestrator.ports.clock import intervals
from orchestrator.preflight.judge import load_judged

CASE = Path(__file__).parents[2] / "cases/panel-cycle"
AMPLITUDE_M, SPEED_RAD_S, INTERVAL_S = 5.9e-3, 78.5, 4e-4
SETS = (
    "screen.panels.deck.width_m=0.8",
    f"coupling.sync_interval_s={INTERVAL_S}",
    "panel.cells=[16, 1]",
    "panel.surface_cells=[4, 1]",
    "domain_m=[[-1, -1, -1], [1, 1, 1]]",
)


def pull_N_per_m(tension_m: float, folder: Path) -> float:
    """Real part of (force of the moving clamp) / (its displacement), over four cycles."""
    loaded = load_judged(CASE, "draft", [*SETS, f"screen.panels.deck.tension_m={tension_m}"])
    machine = build(loaded, folder, None, Stopwatch())
    moving = np.array([frame == "moving" for frame in machine.solvers.panel.mount.frame])
    state = coupling.initial_state(machine.solvers)
    times, pulls = [], []
    for interval in intervals(0.48, INTERVAL_S):
        state = machine.scheme.advance(machine.solvers, interval, state)
        times.append(interval.start_s + INTERVAL_S / 2)  # a mean over the interval
        pulls.append(-state.panel.reaction.force_N[moving].sum(axis=0))
    machine.close()
    cycle_s = 2 * np.pi / SPEED_RAD_S
    pull_N = first_harmonic(np.array(times), np.array(pulls), cycle_s, start_s=0.16).phasor[0]
    return float((pull_N / (-1j * AMPLITUDE_M)).real)  # it moves as sin(w t)


@pytest.mark.parametrize("tension_m", [0.0, 0.002, 0.008])
def test_a_panel_that_pulls_only_when_taut(tension_m: float, tmp_path: Path) -> None:
    """A spring E W t / L on one side only, of which the harmonic balance keeps the share
    1/2 + (asin r + r sqrt(1 - r^2)) / pi with r = tension / amplitude, at most 1 (Gelb, Vander
    Velde, Multiple-Input Describing Functions, 1968, ch. 2).  That leaves out weight, inertia and
    that rubber softens when stretched, hence 8 %."""
    stiffening = 1 + hindered_share_of(0.8 / 0.30) / 3  # the clamps hinder contraction across
    full_N_per_m = stiffening * 21e6 * 0.8 * 0.004 / 0.30
    r = min(tension_m / AMPLITUDE_M, 1.0)
    share = 0.5 + (np.arcsin(r) + r * np.sqrt(1 - r**2)) / np.pi
    assert pull_N_per_m(tension_m, tmp_path) == pytest.approx(share * full_N_per_m, rel=0.08)
