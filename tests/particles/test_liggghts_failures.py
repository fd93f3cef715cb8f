"""Errors of LIGGGHTS become Python exceptions, and the process lives on."""

from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import SolverFailed
from tests.particles.liggghts_plans import flat, make_plan, spheres, still, travel

pytest.importorskip("adapters.particles._liggghts")
from adapters.particles import liggghts

pytestmark = pytest.mark.solver


def falling(**changes):
    return make_plan(flat(), spheres([[0.0, 0.0, 0.01], [0.01, 0.0, 0.01]]), **changes)


def works():
    with closing(liggghts.build(falling())) as solver:
        travel(solver, lambda t: still(flat()), range(2))
        return len(solver.snapshot().id) == 2


def test_a_refused_input_names_the_reason():
    with pytest.raises(SolverFailed, match="coefficientRestitution"):
        liggghts.build(falling(restitution=1.5))
    assert works()


def test_a_triangle_without_its_point_is_refused():
    surface = flat()
    surface.triangles[3, 1] = len(surface.position_m)
    with pytest.raises(ValueError, match="triangle 3"):
        liggghts.build(replace(falling(), surface=surface, folder=None))
    assert works()


def test_without_triangles_particles_fly_freely():
    nothing = TriangleSurface(np.zeros((0, 3)), np.zeros((0, 3), np.int64), np.zeros(0, np.int64))
    with closing(liggghts.build(replace(falling(), surface=nothing))) as solver:
        solver.arrays()["v"][0, 2] = -1.0
        travel(solver, lambda t: still(nothing), range(4))
        assert solver.snapshot().position_m[0, 2] == pytest.approx(0.01 - 2e-4, rel=1e-12)


def test_a_bad_command_is_an_exception():
    solver = liggghts.build(falling())
    with closing(solver), pytest.raises(RuntimeError, match="nonsense"):
        solver._engine.command("nonsense 1 2")
    assert works()


def test_an_error_within_a_run_names_the_time():
    # LIGGGHTS meets the NaN when it sorts the particles
    with closing(liggghts.build(falling())) as solver:
        travel(solver, lambda t: still(flat()), range(3))
        solver.arrays()["v"][0, 2] = np.nan
        with pytest.raises(SolverFailed, match=r"t = 0\.0002"):
            travel(solver, lambda t: still(flat()), range(3, 4))
    assert works()


def test_lost_particles_are_noticed():
    with closing(liggghts.build(falling())) as solver:
        solver._engine.store_history()
        solver._engine.command("group first id 1")
        solver._engine.command("delete_atoms group first compress no")
        solver._engine.prepare()
        with pytest.raises(SolverFailed, match=r"\b1\b.*\b2\b"):
            travel(solver, lambda t: still(flat()), range(1))


def test_a_particle_that_shoots_out_of_the_box_is_removed_not_lost():
    with closing(liggghts.build(falling())) as solver:
        solver.arrays()["v"][0] = (0.0, 5e4, 0.0)  # 2.5 m in one interval of a 0.2 m domain
        travel(solver, lambda t: still(flat()), range(2))
        assert solver.snapshot().id.tolist() == [2]


def test_arrays_alias_the_memory_of_liggghts():
    with closing(liggghts.build(falling())) as solver:
        arrays = solver.arrays()
        assert not arrays["v"].flags.owndata
        arrays["v"][1] = (0.0, 0.0, 2.0)
        travel(solver, lambda t: still(flat()), range(2))
        assert solver.snapshot().position_m[1, 2] == pytest.approx(0.01 + 2.0 * 1e-4, rel=1e-12)
        assert np.shares_memory(arrays["x"], solver.arrays()["x"])
        np.testing.assert_array_equal(arrays["x"], solver.snapshot().position_m)
