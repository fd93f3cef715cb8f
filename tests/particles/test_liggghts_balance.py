"""Momentum and energy of many particles, particles that come and go, one and two ranks."""

import json
import os
import subprocess
import sys
from contextlib import closing

import numpy as np
import pytest

from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import ParticleList
from tests.particles.liggghts_bed import WET, bed, bed_plan, impulse_N_s, wave
from tests.particles.liggghts_plans import INTERVAL_S, flat, make_plan, spheres, still, travel

pytest.importorskip("adapters.particles._liggghts")
from adapters.particles import liggghts

pytestmark = pytest.mark.solver


def defect(before, after, impulse_on_surface):
    """Change of momentum that neither gravity, feed, removal nor the surface explains."""
    change = after.momentum_kg_m_per_s - before.momentum_kg_m_per_s
    outside = after.outside_impulse_N_s - before.outside_impulse_N_s
    return change - outside + impulse_on_surface


@pytest.mark.parametrize("changes", [{}, WET], ids=["dry", "wet"])
def test_momentum_is_kept_to_rounding(changes):
    # 360 particles with friction on a moving, bending sheet, some fed, some leaving:
    # 1e-12 of the momentum they carry
    with closing(liggghts.build(bed_plan(**changes))) as solver:
        before = solver.account()
        forces = travel(solver, wave, range(200))
        after = solver.account()
        carried = np.abs(solver.arrays()["v"] * solver.arrays()["rmass"][:, None]).sum()
    assert after.moved_N_s > 0.1 * carried
    impulse = impulse_N_s(forces)
    assert np.linalg.norm(impulse) > 0.1 * carried
    assert np.abs(defect(before, after, impulse)).max() < 1e-12 * carried


def test_a_snapshot_tells_how_many_others_each_particle_touches():
    """A dry bed: as many as overlap it by their places and diameters."""
    with closing(liggghts.build(bed_plan())) as solver:
        travel(solver, wave, range(100))
        snapshot = solver.snapshot()
    apart_m = np.linalg.norm(snapshot.position_m[:, None] - snapshot.position_m, axis=2)
    touching_m = (snapshot.grains.sieve_size_m[:, None] + snapshot.grains.sieve_size_m) / 2
    wanted = (apart_m < touching_m).sum(axis=1) - 1  # each one touches itself
    assert wanted.max() >= 3
    assert snapshot.contacts.tolist() == wanted.tolist()


def test_elastic_particles_lose_no_energy_on_a_moving_sheet():
    # what the ledger calls dissipation is what remains of the balance: for elastic, smooth
    # particles it is the integrator's error, here with t_contact / 60
    laws = {"restitution": 1.0, "sliding_friction": 0.0, "rolling_friction": 0.0}
    with closing(liggghts.build(bed_plan(step_s=1e-6, **laws))) as solver:
        travel(solver, wave, range(100))
        account = solver.account()
    assert account.received_J["surface"] > 0.01 * account.stored_J["kinetic"]
    assert abs(account.lost_J["contact_dissipation"]) < 1e-4 * account.stored_J["kinetic"]


def test_a_bounce_dissipates_what_restitution_says():
    plan = make_plan(flat(), spheres([1e-3, 2e-3, 2.6e-3], (0.0, 0.0, -1.0)), restitution=0.8)
    with closing(liggghts.build(plan)) as solver:
        travel(solver, lambda t: still(plan.surface), range(10))
        account, v = solver.account(), solver.arrays()["v"][0, 2]
        mass = solver.arrays()["rmass"][0]
    assert account.lost_J["contact_dissipation"] == pytest.approx(0.5 * mass * (1 - v**2), rel=1e-12)


def test_a_correction_of_the_surface_is_received_work():
    # the path starts 1 um above where the last one ended: the mean of Hertz's forces there and
    # here does that work
    plan = make_plan(flat(), spheres([1e-3, 2e-3, 2.49e-3]))
    up = still(plan.surface)
    up.position_m[:, 2] += 1e-6
    with closing(liggghts.build(plan)) as solver:
        force_N = -solver.initial().force_N.sum(axis=0)[2]
        travel(solver, lambda t: up, range(1))
        account = solver.account()
    mass = np.pi / 6 * plan.particles.grains.sieve_size_m[0] ** 3 * 2500.0
    mean_N = force_N * (1.0 + 1.1**1.5) / 2.0  # 10 um deep, and 11
    assert account.received_J["surface"] == pytest.approx(mean_N * 1e-6, rel=1e-9)
    assert account.stored_J["kinetic"] > 0.5 * (force_N * INTERVAL_S) ** 2 / mass * 0.1


class Rain:
    """Three particles every other millisecond, one of them where there is no room."""

    def __init__(self):
        self.answers = []

    def due(self, interval: Interval) -> ParticleList:
        if interval.index % 40 != 10:
            return spheres(np.zeros((0, 3)))
        return spheres([[0.0, 0.0, 0.05], [0.01, 0.0, 0.0], [0.02, 0.0, 0.05]], (0.0, 0.0, -3.0))

    def settle(self, accepted):
        self.answers.append(accepted.tolist())


def test_particles_come_and_go():
    # one sits where the rain wants to start, one flies out at once, the rain falls past the sheet
    rain = Rain()
    seated = spheres([[0.01, 0.0, 0.001], [0.09, 0.0, 0.02]], [[0.0, 0.0, 0.0], [50.0, 0.0, 0.0]])
    sheet_away = flat()
    sheet_away.position_m[:, 0] += 0.05
    gravity = np.array([0.0, 0.0, -9.81])
    domain = np.array([[-0.1, -0.1, -0.03], [0.1, 0.1, 0.1]])
    plan = make_plan(sheet_away, seated, feed=rain, gravity_m_per_s2=gravity, domain_m=domain)
    with closing(liggghts.build(plan)) as solver:
        before = solver.account()
        forces = travel(solver, lambda t: still(sheet_away), range(31))
        assert rain.answers == [[True, False, True]]
        first = solver.snapshot()
        forces += travel(solver, lambda t: still(sheet_away), range(31, 1200))
        after, late = solver.account(), solver.snapshot()
    assert first.id.tolist() == [1, 3, 4]
    fall = 21 * INTERVAL_S
    np.testing.assert_allclose(first.position_m[1], [0.0, 0.0, 0.05 - 3.0 * fall - 4.905 * fall**2])
    assert len(rain.answers) == 30
    assert late.id.min() > 30  # the rain has left below, too
    # 1e-12 of the momentum of the 58 particles fed at 3 m/s (60 000 steps)
    passed = 58 * 3.0 * np.pi / 6 * 5e-3**3 * 2500.0
    assert np.abs(defect(before, after, impulse_N_s(forces))).max() < 1e-12 * passed
    assert after.lost_J["contact_dissipation"] == pytest.approx(0.0, abs=1e-6 * after.supplied_J["feed"])


def test_removal_keeps_the_others_contact_history():
    # two stuck pairs sheared under load; a third pair leaves: nothing may change for them
    def run(with_leaver):
        x = [[0.0, 0.0, 2.49e-3], [4.97e-3, 0.0, 2.49e-3]] + [[0.0999, 0.0, 0.05]] * with_leaver
        v = [[0.01, 0.02, 0.0], [-0.01, -0.02, 0.0]] + [[30.0, 0.0, 0.0]] * with_leaver
        plan = make_plan(flat(), spheres(x, v), sliding_friction=0.5, restitution=0.5)
        with closing(liggghts.build(plan)) as solver:
            travel(solver, lambda t: still(plan.surface), range(6))
            return solver.snapshot()

    alone, left = run(False), run(True)
    assert left.id.tolist() == [1, 2]
    # removal evaluates the forces anew with whole-step velocities: a step's worth of damping
    np.testing.assert_allclose(left.velocity_m_per_s, alone.velocity_m_per_s, atol=2e-4)
    np.testing.assert_allclose(left.spin_rad_per_s, alone.spin_rad_per_s, atol=0.1)


def ranks(n, *words):
    command = ["mpirun", "-n", str(n), "--oversubscribe", "--allow-run-as-root", sys.executable]
    command += ["-m", "tests.particles.liggghts_bed", *words]
    # this process has started MPI itself; mpirun must not take it for one of its own
    own = ("OMPI_", "PMIX_", "ORTE_", "PMI_")
    environment = {name: value for name, value in os.environ.items() if not name.startswith(own)}
    done = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=300, env=environment)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


@pytest.mark.parametrize(
    "words", [(), ("wet",), ("soft",), ("wet", "cut")], ids=["dry", "wet", "soft", "wet, cut anew"]
)
def test_two_ranks_give_the_same_as_one(words):
    # the sheet straddles the border x = 0 and the bed drifts over it by 6 mm; the order of sums
    # differs, and collisions amplify that: 1e-9 for 10 ms
    single, double = ranks(1, *words), ranks(2, *words)
    first, last = np.array(double["owned"]).T
    assert abs(first[0] - first[1]) <= 0.02 * first.sum() + 14  # equal but for one row of the bed
    if "cut" in words:  # the border follows the bed
        assert abs(last[0] - last[1]) <= 0.05 * last.sum()
        assert double["cuts"][1] != ranks(2, "wet")["cuts"][1]
    else:  # particles cross it
        assert abs(last[0] - first[0]) >= 10
    assert max(single["ids"]) > len(bed())  # some were fed,
    assert len(single["ids"]) < max(single["ids"])  # some have left
    assert (single["crossings"][0] > 3) is ("soft" in words)
    compare(single, double)


def test_four_ranks_whose_parts_are_cut_anew_give_the_same_as_one():
    # cuts between parts that have neighbours on both sides
    single, four = ranks(1, "wet", "cut"), ranks(4, "wet", "cut")
    _, last = np.array(four["owned"]).T
    assert np.ptp(last) <= 0.1 * last.mean()
    assert len(four["cuts"]) == 5
    compare(single, four)


def compare(single, several):
    assert several["ids"] == single["ids"]
    assert several["crossings"] == single["crossings"]
    assert several["contacts"] == single["contacts"]
    sums = ("impulse", "momentum", "angular", "given", "stored", "work", "supplied", "removed")
    for name in (*sums, "worn", "overlaps"):
        np.testing.assert_allclose(several[name], single[name], rtol=1e-9, atol=1e-12, err_msg=name)
