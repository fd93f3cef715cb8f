"""Each hand-over turned off changes what it carries, and nothing else."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from adapters.frames import two_mass
from adapters.particles import liggghts
from orchestrator.case.solver_plans import frames_plan, particles_plan
from orchestrator.coupling.schemes.scheme import State
from orchestrator.ports import HermitePath, Load, Motion
from orchestrator.ports.clock import Interval
from tests.cases import load_case
from tests.coupled.machines import opened
from tests.coupled.screen import CASE, EMPTY

pytestmark = pytest.mark.solver
INTERVALS = 200


def end(folder: Path, case: str, *settings: str) -> State:
    with opened(load_case(folder, case, settings)) as run:
        return run.advance(INTERVALS)


def farthest_m(first: Motion, second: Motion) -> float:
    return float(np.abs(first.position_m - second.position_m).max())


@pytest.fixture(scope="module")
def full(tmp_path_factory: pytest.TempPathFactory) -> State:
    """Return a case with every hand-over on."""
    return end(tmp_path_factory.mktemp("full"), CASE)


@pytest.mark.parametrize("scheme", ["particles-first", "serial-staggered"])
def test_without_particle_load_the_machine_moves_as_if_empty(
    tmp_path: Path, full: State, scheme: str
) -> None:
    """Bit for bit; the particles still land on it."""
    on = f"coupling.scheme={scheme}"
    off = end(tmp_path, CASE, on, "exchange.particle_load=false")
    empty = end(tmp_path, EMPTY, on)
    for actual, wanted in ((off.panel.surface, empty.panel.surface), (off.clamps, empty.clamps)):
        np.testing.assert_array_equal(actual.position_m, wanted.position_m)
        np.testing.assert_array_equal(actual.velocity_m_per_s, wanted.velocity_m_per_s)
    np.testing.assert_array_equal(off.panel.reaction.force_N, empty.panel.reaction.force_N)
    assert off.load.force_N.any()
    assert farthest_m(full.panel.surface, empty.panel.surface) > 1e-4


def test_without_panel_reaction_the_frames_move_as_if_bare(tmp_path: Path, full: State) -> None:
    """The frames move as the same frames by themselves, to rounding (the two masses, whose solver is tested
    against closed forms); panels and particles still move with them."""
    settings = ("frames.solver=two-mass", "exchange.panel_reaction=false")
    loaded = load_case(tmp_path, CASE, settings)
    with opened(loaded) as run:
        points_m = run.state.clamps.position_m
        carrier = run.machine.members.panel.mount.frame
        off = run.advance(INTERVALS)
        interval_s = run.interval_s
    bare = two_mass.build(frames_plan(loaded.case, points_m, carrier, np.zeros_like(points_m)))
    still = Load.zero(len(points_m))
    for index in range(INTERVALS):
        motion = bare.advance(Interval(index, interval_s), still)
    assert farthest_m(off.clamps, motion) < 1e-14
    assert farthest_m(off.clamps, full.clamps) > 1e-4
    assert off.load.force_N.any()


def test_without_frame_motion_the_clamps_stand_still(tmp_path: Path) -> None:
    """The clamps stand still exactly; the frames still move, the panels only as their resting shape is
    exact (1e-7)."""
    with opened(load_case(tmp_path, EMPTY, ["exchange.frame_motion=false"])) as run:
        start = run.state
        still = run.advance(INTERVALS)
        clamped = [panel.surface for panel in run.machine.panels]
    assert farthest_m(start.clamps, still.clamps) > 1e-3
    moved_m = still.panel.surface.position_m - start.panel.surface.position_m
    for surface in clamped:
        rows = moved_m[surface].reshape(16, 8, 3)  # 13 cells and both clamps, 7 across
        assert not rows[:2].any()
        assert not rows[-2:].any()
        assert np.abs(rows).max() < 1e-7


def test_without_panel_motion_particles_see_a_still_surface(tmp_path: Path) -> None:
    """The particles move as in LIGGGHTS by itself on the surface of t = 0, bit for bit; the panels still
    move, and feel the particles."""
    loaded = load_case(tmp_path, CASE, ["exchange.panel_motion=false"])
    with opened(loaded) as run:
        surface = run.machine.surface
        off = run.advance(INTERVALS)
        particles = run.particles()
        interval_s = run.interval_s
    plan = particles_plan(loaded.case, surface)
    assert plan is not None
    alone = liggghts.build(plan)
    here = Motion(surface.position_m, np.zeros_like(surface.position_m))
    for index in range(INTERVALS):
        load = alone.advance(Interval(index, interval_s), HermitePath(here, here, interval_s))
    wanted = alone.snapshot()
    alone.close()
    np.testing.assert_array_equal(particles.position_m, wanted.position_m)
    np.testing.assert_array_equal(particles.velocity_m_per_s, wanted.velocity_m_per_s)
    np.testing.assert_array_equal(off.load.force_N, load.force_N)
    assert farthest_m(off.panel.surface, here) > 1e-3
    assert farthest_m(off.panel.surface, end(tmp_path, EMPTY).panel.surface) > 1e-5
