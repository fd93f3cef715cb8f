"""Any solver of one port runs with any of the others, and momentum crosses to rounding."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestrator.ports.state import as_arrays
from orchestrator.preflight.check import find_problems
from tests.cases import load_case
from tests.coupled.machines import opened
from tests.coupled.screen import BED, EXCITER, MACHINE
from tests.saved_states import differences

pytestmark = pytest.mark.solver
FRAMES = ("prescribed", "two-mass", "exudyn", "exudyn driven")
PANELS = ("rigid", "strip", "sheet", "sheet implicit", "solid implicit")
PARTICLES = ("none", "spheres", "liggghts")
DRIVE = """
[screen.frames.driving.drive]
speed_rad_per_s = 150.0
amplitude_m = [0.004, 0.0, 0.001]
rotation_rad = [0.0, 0.01, 0.0]
center_m = [0.0, 0.0, 0.0]
"""


def run(folder: Path, frames: str, panel: str, particles: str, intervals: int) -> None:
    solver, _, integrator = panel.partition(" ")
    case = MACHINE + (DRIVE if frames in ("prescribed", "exudyn driven") else EXCITER)
    settings = [f"frames.solver={frames.split()[0]}", f"panel.solver={solver}"]
    if integrator:
        settings.append(f"panel.integrator={integrator}")
    if particles != "none":
        case += BED
        settings.append(f"particles.solver={particles}")
    loaded = load_case(folder, case, settings)
    problems = [str(mistake) for mistake in find_problems(loaded)]
    assert problems == [], problems
    with opened(loaded) as machine:
        machine.advance(intervals)
        residuals = machine.momentum_residual()
        assert max(residuals.values()) < 1e-11, residuals
        assert ("particles" in residuals) == (particles != "none")
        assert machine.machine.members.frames.received.impulse_N_s.any()


@pytest.mark.parametrize("particles", PARTICLES)
@pytest.mark.parametrize("panel", PANELS)
@pytest.mark.parametrize("frames", FRAMES)
def test_any_combination_runs(tmp_path: Path, frames: str, panel: str, particles: str) -> None:
    """Long enough for the bed to land (2 ms at 0.5 m/s)."""
    run(tmp_path, frames, panel, particles, 60)


def test_explicit_solid_panels_run(tmp_path: Path) -> None:
    run(tmp_path, "exudyn", "solid", "liggghts", 60)


def test_robin_on_rigid_panels_is_particles_first(tmp_path: Path) -> None:
    """The runs are equal to the last bit: no mass behind the surface is known."""
    ends = []
    for scheme in ("robin", "particles-first"):
        settings = ["panel.solver=rigid", f"coupling.scheme={scheme}"]
        with opened(load_case(tmp_path, MACHINE + EXCITER + BED, settings)) as machine:
            ends.append(as_arrays(machine.advance(60)))
    assert ends[0]["load"]["force_N"].any()
    assert differences(*ends) == []
