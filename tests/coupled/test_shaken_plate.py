"""A sphere on a plate that a drive shakes, against an integration that knows no coupling.

The sync interval is a 128th of the period.  A surface that is extrapolated from sync point to sync
point is off by a t^2 / 2 in between: with it particles-first and robin conveyed 21 % too slowly (in
LIGGGHTS, the slow case), and lost a sphere at 4.6 mm of amplitude that holds up to 4.75 mm.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from pathlib import Path

import pytest

from orchestrator.coupling.schemes import SCHEMES
from tests.cases import load_case
from tests.coupled.machines import Coupled, opened
from tests.coupled.shaken_plate import CONVEYING, FRICTION, RADIUS_M, Ridden, Shaking, case, ridden

PERIOD_S, INTERVALS = 0.1, 128
SLOW = replace(CONVEYING, phase_rad=2.6)
WORK_J_PER_M2 = 2.0  # the pull-off force is 0.91 of the sphere's weight
LIGGGHTS = pytest.param("liggghts", marks=pytest.mark.solver)
every_scheme = pytest.mark.parametrize("scheme", SCHEMES)


def solved_by(solver: str, scheme: str, step_s: float) -> list[str]:
    return [f"particles.solver={solver}", f"coupling.scheme={scheme}", f"particles.step_s={step_s}"]


@cache
def reference(
    shaking: Shaking, periods: tuple[float, ...], friction: float, work_J_per_m2: float
) -> list[Ridden]:
    return ridden(shaking, [n * PERIOD_S for n in periods], friction, work_J_per_m2)


@every_scheme
@pytest.mark.parametrize(
    ("solver", "shaking", "step_s"), [pytest.param("liggghts", SLOW, 2.5e-5, marks=pytest.mark.solver)]
)
def test_conveying(tmp_path: Path, solver: str, shaking: Shaking, step_s: float, scheme: str) -> None:
    """Mean velocity over three cycles; measured, in every scheme alike, +0.26 %."""
    settings = solved_by(solver, scheme, step_s)
    with opened(load_case(tmp_path, case(shaking, FRICTION), settings)) as run:
        run.advance(2 * INTERVALS)
        first_m = run.particles().position_m[0, 0]
        run.advance(3 * INTERVALS)
        conveyed_m = run.particles().position_m[0, 0] - first_m
    first, last = reference(shaking, (2, 5), FRICTION, 0.0)
    assert conveyed_m == pytest.approx(last.along_m - first.along_m, rel=0.01)


def overlap_m(run: Coupled, shaking: Shaking) -> float:
    _, plate_m, _, _ = shaking.at(run.done * run.interval_s)
    return float(plate_m + RADIUS_M - run.particles().position_m[0, 2])


@every_scheme
@pytest.mark.parametrize("solver", [LIGGGHTS])
def test_overlap_of_a_sticky_sphere_on_a_plate_that_slows_down(
    tmp_path: Path, solver: str, scheme: str
) -> None:
    """The overlap is compared at the plate's middle, top (where 0.66 of the pull-off force is asked of the
    contact), middle and bottom. Measured 0.6 % at the top, below 0.04 % elsewhere."""
    shaking = Shaking(PERIOD_S, 0.0, 4e-3, 0.0, PERIOD_S)
    periods = (1.0, 1.25, 1.5, 1.75)
    overlaps_m = []
    with opened(
        load_case(tmp_path, case(shaking, 0.0, WORK_J_PER_M2), solved_by(solver, scheme, 1e-4))
    ) as run:
        for n in periods:
            run.advance(round(n * INTERVALS) - run.done)
            overlaps_m.append(overlap_m(run, shaking))
    wanted = [row.overlap_m for row in reference(shaking, periods, 0.0, WORK_J_PER_M2)]
    assert overlaps_m == pytest.approx(wanted, rel=0.01)


@pytest.mark.solver
@every_scheme
@pytest.mark.parametrize(("amplitude_m", "holds"), [(4.75e-3, True), (4.9e-3, False)])
def test_pull_off(tmp_path: Path, amplitude_m: float, holds: bool, scheme: str) -> None:
    """The force that is asked for grows with the amplitude; between the two it is the one that the
    neck bears, by the reference, too."""
    shaking = Shaking(PERIOD_S, 0.0, amplitude_m, 0.0, PERIOD_S)
    (wanted,) = reference(shaking, (1.5,), 0.0, WORK_J_PER_M2)
    assert (wanted.overlap_m > 0) is holds
    settings = solved_by("liggghts", scheme, 1e-4)
    with opened(load_case(tmp_path, case(shaking, 0.0, WORK_J_PER_M2), settings)) as run:
        run.advance(3 * INTERVALS // 2)
        assert (overlap_m(run, shaking) > 0) is holds


@every_scheme
def test_the_path_of_what_is_driven_has_no_jumps(tmp_path: Path, scheme: str) -> None:
    """Each begins, bit for bit, where and as fast as the last one ended, and ends where the frames
    then are."""
    settings = solved_by("spheres", scheme, 2e-4)
    with opened(load_case(tmp_path, case(CONVEYING, FRICTION), settings)) as run:
        particles, panel = run.machine.members.particles, run.machine.members.panel
        assert particles is not None
        run.advance(30)
        for _ in range(10):
            before = particles.last[0].end
            state = run.advance(1)
            path = particles.last[0]
            assert (path.start.position_m == before.position_m).all()
            assert (path.start.velocity_m_per_s == before.velocity_m_per_s).all()
            assert (path.end.position_m == state.panel.surface.position_m).all()
            assert (panel.last[0].position_m == state.clamps.position_m).all()
            assert (panel.last[0].velocity_m_per_s == state.clamps.velocity_m_per_s).all()
