"""Bodies of spheres in LIGGGHTS: what a rigid body keeps for a long time, and what a single sphere is."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from contextlib import closing
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from orchestrator.case import solvers
from orchestrator.ports.clock import Interval
from orchestrator.ports.grains import ShapeTable
from tests.particles.clump_bed import clump_plan
from tests.particles.contract import LIGGGHTS_ALONE, WEIGHTLESS, particles, plan, plate, solver_adapter
from tests.particles.liggghts_bed import PERIODIC, WET, counted, wave
from tests.particles.liggghts_plans import INTERVAL_S, travel
from tests.particles.restored_bed import OPEN_END, astray, resumed
from tests.particles.test_clumps import DUMBBELL, Build, dumbbells
from tests.particles.test_saved import AIRY
from tests.saved_states import differences

ASKED = LIGGGHTS_ALONE


def test_a_free_stone_keeps_energy_and_momentum_for_1e5_steps(build: Build) -> None:
    """Three different moments; 16 turns, a hundred times as long as the steps of 2e-5 s are."""
    stone = solvers.shape("stone")
    given = particles([0, 0, 0.3], [0.01, 0, 0], [30.0, 35.0, 20.0])
    run = build(dumbbells(stone, plan(plate(0.01, 1), given, gravity_m_per_s2=WEIGHTLESS)))
    before, largest = run.solver.account(), 0.0
    for _ in range(20):
        run.advance(100)
        now = run.solver.account()
        gained = now.stored_J["kinetic"] / before.stored_J["kinetic"] - 1
        largest = max(largest, abs(gained))
    assert largest < 1e-6
    assert before.angular is not None
    assert now.angular is not None
    own = before.angular.momentum_kg_m2_per_s
    np.testing.assert_allclose(
        now.angular.momentum_kg_m2_per_s, own, atol=1e-12 * np.linalg.norm(own), rtol=0
    )
    np.testing.assert_allclose(now.momentum_kg_m_per_s, before.momentum_kg_m_per_s, rtol=1e-14)


def test_bodies_of_one_sphere_are_spheres(build: Build) -> None:
    """Two balls that hit a plate and each other go the same way as bodies and as LIGGGHTS's own spheres."""
    place_m = [[0, 0, 0.0052], [0.002, 0.001, 0.016], [-0.012, 0, 0.0051]]
    given = particles(place_m, [0.3, 0.1, -0.5], [5.0, -90.0, 3.0], diameter_m=[0.01, 0.01, 0.008])
    alone = plan(plate(0.05, 3), given)
    shapes = (*alone.shapes, DUMBBELL)
    grains = replace(given.grains, shapes=ShapeTable.of(shapes))
    among = replace(alone, shapes=shapes, particles=replace(given, grains=grains), largest_radius_m=0.01)
    spheres, bodies = build(alone), build(among)
    for run in (spheres, bodies):
        run.advance(60)
    wanted, got = spheres.solver.snapshot(), bodies.solver.snapshot()
    for name in ("position_m", "velocity_m_per_s", "spin_rad_per_s"):
        want = getattr(wanted, name)
        np.testing.assert_allclose(getattr(got, name), want, atol=1e-12 * np.abs(want).max(), rtol=0)
    energy_J = [run.solver.account().stored_J["kinetic"] for run in (spheres, bodies)]
    assert energy_J[1] == pytest.approx(energy_J[0], rel=1e-11)


def test_two_bodies_are_one_contact(build: Build) -> None:
    """Two upright dumbbells touch with both of their spheres, and one of them a ball, too."""
    given = particles([[0, 0, 0.3], [0.00999, 0, 0.3], [0, 0, 0.31999 - 0.00501]])
    shapes = (DUMBBELL, *plan(plate(0.01, 1), given).shapes)
    grains = replace(given.grains, shapes=ShapeTable.of(shapes), shape=np.array([0, 0, 1]))
    changes = {"particles": replace(given, grains=grains), "shapes": shapes, "largest_radius_m": 0.01}
    run = build(replace(plan(plate(0.01, 1), given, gravity_m_per_s2=WEIGHTLESS), **changes))
    assert run.solver.snapshot().contacts.tolist() == [2, 1, 1]


CHANGES: dict[str, dict[str, Any]] = {
    "dry": {},
    "periodic, wet, counted": {**PERIODIC, **WET, "exits": (OPEN_END,), **counted()},
    "airy": AIRY,
}


@pytest.mark.parametrize("changes", CHANGES.values(), ids=CHANGES)
def test_a_bed_of_clumps_goes_on_bit_for_bit(changes: dict[str, Any]) -> None:
    assert resumed("liggghts", clump_plan(**changes), 37, 60) == []


@pytest.mark.parametrize("changes", CHANGES.values(), ids=CHANGES)
def test_a_bed_of_clumps_steps_back_bit_for_bit(changes: dict[str, Any]) -> None:
    """Astray in each interval: neighbours are listed anew on the way, and particles leave or come."""
    straight, hesitant = (solver_adapter("liggghts").build(clump_plan(**changes)) for _ in range(2))
    with closing(straight), closing(hesitant):
        for index in range(40):
            saved = hesitant.save()
            hesitant.advance(Interval(index, INTERVAL_S), astray(Interval(index, INTERVAL_S)))
            hesitant.restore(saved)
            loads = [travel(each, wave, range(index, index + 1)) for each in (straight, hesitant)]
            np.testing.assert_array_equal(*loads)
        assert differences(straight.save(), hesitant.save(), "state") == []


def ranks(n: int, *words: str) -> Any:
    command = ["mpirun", "-n", str(n), "--oversubscribe", "--allow-run-as-root", sys.executable]
    command += ["-m", "tests.particles.clump_bed", *words]
    own = ("OMPI_", "PMIX_", "ORTE_", "PMI_")  # this process has started MPI itself
    environment = {name: value for name, value in os.environ.items() if not name.startswith(own)}
    done = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=300, env=environment)
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout)


def test_two_ranks_move_clumps_as_one_does() -> None:
    """Bodies cross the border between ranks, which is moved now and then; the order of sums differs."""
    single, double = ranks(1), ranks(2)
    assert min(double["owned"]) > 50
    for name in ("ids", "shapes", "contacts", "removed"):
        assert double[name] == single[name], name
    assert len(single["removed"]) > 0
    for name in ("impulse", "momentum", "stored", "angular"):
        np.testing.assert_allclose(double[name], single[name], rtol=1e-8, atol=1e-11, err_msg=name)
    for books in (single, double):  # of all that came, left and met the sheet
        gained = np.subtract(books["momentum"], books["before"]) - books["outside"] + books["impulse"]
        np.testing.assert_allclose(gained, 0.0, atol=1e-12 * books["moved"])
        np.testing.assert_allclose(books["turned"], 0.0, atol=1e-13 * books["moved"])


def test_two_ranks_of_clumps_go_on_bit_for_bit() -> None:
    assert ranks(2, "resumed") == [[], []]


def test_a_smooth_rod_wears_by_force_times_way(build: Build) -> None:
    """k F s as for a sphere (test_wear.py), however many of its spheres share the force."""
    rod = solvers.shape("rod")
    half = np.sqrt(0.5)
    lying = replace(particles([0, 0, 0.00499]), orientation=np.array([[half, half, 0.0, 0.0]]))
    smooth = plan(plate(0.05, 7), lying, sliding_friction=np.zeros((1, 1)))
    rate_m3_per_N_m = 3e-10
    run = build(replace(dumbbells(rod, smooth), wear_m3_per_N_m=np.full((1, 1), rate_m3_per_N_m)))
    run.velocity_m_per_s = np.array([-0.4, 0.0, 0.0])  # the rod stays, the surface goes below it
    run.advance(60)
    way_N_m = 0.4 * float(-run.given_N_s[2])
    assert run.solver.worn_m3().sum() == pytest.approx(rate_m3_per_N_m * way_N_m, rel=1e-9)
    weight_N = 9.81 * float(rod.volume * 1430.0 * 0.01**3)
    assert way_N_m == pytest.approx(0.4 * 0.06 * weight_N, rel=0.05)
