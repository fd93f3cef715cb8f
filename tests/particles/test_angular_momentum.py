"""Angular momentum that particles and surface give each other: each solver closes it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from orchestrator.ports import Account, Array, HermitePath, Motion
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import Jkr, ParticleList, ParticlesPlan
from tests.particles.contract import Run, energy_defect_J, particles, plan, plate, table

Build = Callable[[ParticlesPlan], Run]
SPIN_RAD_S = np.array([1.3, -2.1, 4.0])
RISE_M_S = np.array([0.05, -0.02, 0.1])
INTERVAL_S = 1e-3


@dataclass
class Once:
    """Feeds ``given`` in interval ``index``."""

    index: int
    given: ParticleList

    def due(self, interval: Interval) -> ParticleList:
        everybody = np.full(len(self.given), interval.index == self.index)
        return self.given.part(everybody)

    def settle(self, accepted: np.ndarray) -> None:
        assert accepted.all()


def turned(start_m: Array, time_s: float) -> Motion:
    """The surface as a rigid body that turns and rises, away from the origin."""
    turn = Rotation.from_rotvec(time_s * SPIN_RAD_S).as_matrix()
    around_m = np.array([0.0, 0.0, 0.02])
    arms_m = (start_m - around_m) @ turn.T
    velocity_m_per_s = np.cross(SPIN_RAD_S, arms_m) + RISE_M_S
    return Motion(around_m + arms_m + time_s * RISE_M_S, velocity_m_per_s)


def advance(run: Run, intervals: int) -> None:
    start_m = run.plan.surface.position_m
    for _ in range(intervals):
        now = Interval(run.index, INTERVAL_S)
        path = HermitePath(turned(start_m, now.start_s), turned(start_m, now.end_s), INTERVAL_S)
        run.load_N.append(run.solver.advance(now, path).force_N)
        run.index += 1


def missing_N_m_s(before: Account, after: Account) -> tuple[Array, float]:
    """Change of angular momentum that nothing explains, and the size of what was exchanged."""
    assert before.angular is not None
    assert after.angular is not None
    received = after.angular.received_N_m_s["surface"] - before.angular.received_N_m_s["surface"]
    outside = after.angular.outside_impulse_N_m_s - before.angular.outside_impulse_N_m_s
    change = after.angular.momentum_kg_m2_per_s - before.angular.momentum_kg_m2_per_s
    return change - outside - received, float(np.linalg.norm(received))


def spinning(**changes: Any) -> ParticlesPlan:
    """Nine balls that spin on a plate, one more on their top."""
    place_m = [[x, y, 0.0049] for x in (-0.012, 0.0, 0.012) for y in (-0.011, 0.0, 0.011)]
    given = particles([*place_m, [0.001, 0.002, 0.0145]], [0.1, 0.05, -0.1], [40.0, -60.0, 25.0])
    usual: dict[str, Any] = {"rolling_friction": table(0.1), "sliding_friction": table(0.4)}
    surface = plate(0.02, 4)
    surface.position_m[:, 2] += 1e-4 * np.sin(900.0 * surface.position_m[:, 0])  # small folds
    return plan(surface, given, **usual | changes)


LAWS: dict[str, dict[str, Any]] = {
    "epsd2": {"rolling": "epsd2"},
    "cdt": {"rolling": "cdt"},
    "none": {"rolling_friction": table(0.0)},
    "jkr": {"adhesion": Jkr(table(0.5), 0.5), "step_s": 5e-6},
}


@pytest.mark.parametrize("laws", LAWS)
def test_angular_momentum_is_handed_over_to_rounding(build: Build, laws: str) -> None:
    """The balance holds with friction, with either law of rolling, and with necks."""
    run = build(spinning(**LAWS[laws]))
    before = run.solver.account()
    advance(run, 8)
    missing, exchanged = missing_N_m_s(before, run.solver.account())
    assert exchanged > 1e-6  # N m s
    assert np.abs(missing).max() < 1e-12 * exchanged


def test_with_feed_and_removal(build: Build) -> None:
    """Some balls leave the domain meanwhile, and one is fed."""
    domain_m = np.array([[-1.0, -1.0, -1.0], [0.0123, 1.0, 1.0]])
    feed = Once(2, particles([-0.005, 0.0, 0.04], [0.0, 0.3, -0.1], [9.0, 5.0, -7.0]))
    run = build(spinning(domain_m=domain_m, feed=feed))
    before = run.solver.account()
    advance(run, 12)
    there = run.solver.snapshot().id
    assert 11 in there
    assert 1 < len(there) < 11
    missing, exchanged = missing_N_m_s(before, run.solver.account())
    assert np.abs(missing).max() < 1e-12 * exchanged


@pytest.mark.parametrize("law", ["epsd2", "cdt"])
def test_resistance_to_rolling_sees_the_surface_turn(build: Build, law: str) -> None:
    """A ball that spins with the plate it lies on, about an axis in the plate, feels nothing of it;
    one that does not is taken along."""
    omega, length_s, surface = np.array([0.0, 3.0, 0.0]), 2e-3, plate(0.02, 4)
    rolls = {"rolling_friction": table(0.3), "rolling": law, "sliding_friction": table(0.0)}
    velocity_m_per_s = np.cross(omega, surface.position_m - [0.0, 0.0, 0.005])
    end_m = surface.position_m + length_s * velocity_m_per_s
    path = HermitePath(
        Motion(surface.position_m, velocity_m_per_s), Motion(end_m, velocity_m_per_s), length_s
    )
    spins_rad_per_s = []
    for spin_rad_per_s in (omega, 0.0 * omega):
        falling = particles([0.0, 0.0, 0.0051], [0.0, 0.0, -0.5], spin_rad_per_s)
        # in steps of 10 us the couple of cdt, which does not depend on the spin's size, turns it to and fro
        changes = {"gravity_m_per_s2": np.zeros(3), "sync_interval_s": length_s, "step_s": 4e-6} | rolls
        run = build(plan(surface, falling, **changes))
        run.solver.advance(Interval(0, length_s), path)
        spins_rad_per_s.append(run.solver.snapshot().spin_rad_per_s[0])
    np.testing.assert_allclose(spins_rad_per_s[0], omega, atol=1e-3)
    assert 1.0 < spins_rad_per_s[1][1] < 6.0  # the spring of epsd2 has no damper


def test_a_couple_works_on_a_surface_that_turns(build: Build) -> None:
    """The work of the relative rotation is what resistance to rolling takes on a surface that turns, and
    the books of energy close."""
    run = build(spinning(restitution=table(1.0), step_s=4e-6))
    before = run.solver.account()
    advance(run, 5)
    after = run.solver.account()
    lost_J = after.lost_J["contact_dissipation"] - before.lost_J["contact_dissipation"]
    assert lost_J > 0.0
    assert abs(energy_defect_J(before, after)) < 2e-3 * lost_J
