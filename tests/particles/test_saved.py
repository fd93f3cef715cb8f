"""A solver that is restored goes on, bit for bit, as the one that was saved."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import AirPlan
from tests.particles.contract import solver_adapter
from tests.particles.liggghts_bed import PERIODIC, WET, bed_plan, counted, wave
from tests.particles.liggghts_plans import INTERVAL_S, travel
from tests.particles.restored_bed import OPEN_END, astray, fed, hesitating, resumed
from tests.reference import spheres

SMOOTH = {"sliding_friction": 0.0, "rolling_friction": 0.0}
WEARING = {"wear_m3_per_N_m": np.ones((2, 2))}
AIRY = {"air": AirPlan(1204.0, 0.0182)}
CHANGES: dict[str, dict[str, Any]] = {
    "dry": {},
    "periodic": PERIODIC,
    "wet": WET,
    "smooth": SMOOTH,
    "cdt": {"rolling": "cdt"},
    "exit": {"exits": (OPEN_END,)},
    "wearing": WEARING,
    "airy": AIRY,
    "counted": {"exits": (OPEN_END,), **counted()},
}
OF_SPHERES = {name: CHANGES[name] for name in ("dry", "wet", "cdt", "wearing", "airy", "counted")}


@pytest.mark.solver
@pytest.mark.parametrize("save_at", [1, 37, 70])
@pytest.mark.parametrize("changes", CHANGES.values(), ids=CHANGES)
def test_liggghts_goes_on_bit_for_bit(changes: dict[str, Any], save_at: int) -> None:
    """Particles are fed up to interval 110 (at 5, 25, …) and leave, LIGGGHTS lists neighbours some fifty
    times and sorts its particles twice; at all three points a dozen contacts are open."""
    assert resumed("liggghts", bed_plan(**changes), save_at, 110) == []


@pytest.mark.parametrize(
    ("changes", "save_at"),
    [
        pytest.param({}, 1, id="dry-1"),
        *(pytest.param(plan, 12, id=f"{name}-12") for name, plan in OF_SPHERES.items()),
    ],
)
def test_spheres_go_on_bit_for_bit(changes: dict[str, Any], save_at: int) -> None:
    """Particles are fed at 5 and 25, up to interval 27."""
    assert resumed("spheres", bed_plan(layers=1, **changes), save_at, 27) == []


@pytest.mark.solver
@pytest.mark.parametrize("changes", CHANGES.values(), ids=CHANGES)
def test_liggghts_steps_back_bit_for_bit(changes: dict[str, Any]) -> None:
    """The solver steps back in each of 110 intervals: with and without new neighbours in it, particles fed
    at random or gone, on a surface that first goes another way."""
    assert hesitating("liggghts", bed_plan(**changes), 110) == []


@pytest.mark.parametrize("changes", OF_SPHERES.values(), ids=OF_SPHERES)
def test_spheres_step_back_bit_for_bit(changes: dict[str, Any]) -> None:
    assert hesitating("spheres", bed_plan(layers=1, **changes), 20) == []


def test_the_way_that_is_taken_back_was_another_one() -> None:
    """The tests above could not fail if both ways were the same."""
    solver, interval = fed("spheres", bed_plan(layers=1)), Interval(19, INTERVAL_S)
    travel(solver, wave, range(19))
    before = solver.save()
    (along_N,) = travel(solver, wave, range(19, 20))
    solver.restore(before)
    astray_N = solver.advance(interval, astray(interval)).force_N.sum(axis=0)
    assert np.linalg.norm(astray_N) > 1.5 * np.linalg.norm(along_N) > 0


@pytest.mark.solver
def test_a_state_without_its_arrays_is_refused(tmp_path: Path) -> None:
    solver = solver_adapter("liggghts").build(bed_plan(folder=tmp_path))
    saved = solver.save()
    del saved["engine"]["torque_N_m"]
    with pytest.raises(RuntimeError, match="torque_N_m"):
        solver.restore(saved)


def test_a_save_is_a_copy() -> None:
    solver = spheres.build(bed_plan(layers=1))
    saved = solver.save()
    before = {name: value.copy() for name, value in saved["bodies"].items() if name != "grains"}
    travel(solver, wave, range(2))
    for name, value in before.items():
        np.testing.assert_array_equal(saved["bodies"][name], value)


@pytest.mark.solver
def test_two_ranks_go_on_bit_for_bit() -> None:
    command = ["mpirun", "-n", "2", "--oversubscribe", "--allow-run-as-root", sys.executable]
    command += ["-m", "tests.particles.restored_bed"]
    # this process has started MPI itself; mpirun must not take it for one of its own
    own = ("OMPI_", "PMIX_", "ORTE_", "PMI_")
    environment = {name: value for name, value in os.environ.items() if not name.startswith(own)}
    done = subprocess.run(command, capture_output=True, encoding="utf-8", timeout=300, env=environment)
    assert done.returncode == 0, done.stderr
    assert json.loads(done.stdout) == [[], []]
