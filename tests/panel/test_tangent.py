"""The stiffness that Newton's iteration keeps is that of the present positions and step: a stale one
converges to the same motion, only slowly, so that no other test would notice."""

from __future__ import annotations

from contextlib import closing

import numpy as np
import pytest

from orchestrator.ports import Load
from orchestrator.ports.clock import Interval
from tests.panel.elastic_plans import BRANCHES, difference, plan, shaken

pytestmark = pytest.mark.solver


def opened(solver):
    """The structure of a small panel."""
    from adapters.panel.finite_element.sheet_forms import sheet
    from adapters.panel.finite_element.solid_forms import solid

    small = plan(length_m=0.12, cells=(4, 2), branches=BRANCHES)
    return (sheet if solver == "sheet" else solid)(small)[0]


@pytest.mark.parametrize("solver", ["sheet", "solid"])
def test_each_factorisation_is_of_the_present_positions_and_factors(solver):
    """The factorisation solves for a random move of the free nodes, given the change of the force along it,
    within a step with Maxwell branches, at three shapes one after the other."""
    from adapters.panel.finite_element.tangent import Tangent

    rng = np.random.default_rng(4)
    with closing(opened(solver)) as structure, closing(Tangent(structure)) as tangent:
        for crumple_m, mass_factor_1_s2, step_s in ((0.0, 1e6, 1e-4), (1e-4, 4e6, 1e-4), (3e-4, 1e7, 1e-5)):
            shape_m = structure.material_m + rng.normal(scale=crumple_m, size=structure.material_m.shape)
            structure.rest(shape_m)
            structure.begin_step(step_s)
            move_m = rng.normal(scale=1e-8, size=shape_m.shape)
            move_m[structure.held] = 0.0
            change_N = structure.force_N(shape_m + move_m) - structure.force_N(shape_m - move_m)
            inertia_N = mass_factor_1_s2 * structure.mass_kg[:, None] * move_m
            structure.force_N(shape_m)
            tangent.factorise(mass_factor_1_s2, 1.0)
            assert difference(tangent.solve(inertia_N + change_N / 2), move_m) < 1e-5


def test_newton_s_iteration_stays_quick_when_steps_and_shapes_change(monkeypatch):
    """Few solutions in each step of a slack panel that is shaken, in intervals of two lengths, and all
    with a tangent of the step's own length."""
    from adapters.panel import sheet
    from adapters.panel.finite_element.integrators import ALPHA_M, BETA, GeneralizedAlpha
    from adapters.panel.finite_element.tangent import Tangent

    solutions, lengths_s, made_for = [], [], {}
    solve, step, factorise = Tangent.solve, GeneralizedAlpha._step, Tangent.factorise

    def counted_factorise(self, mass_factor_1_s2, stiffness_factor):
        made_for[self] = ((1 - ALPHA_M) / BETA / mass_factor_1_s2) ** 0.5
        factorise(self, mass_factor_1_s2, stiffness_factor)

    def counted_solve(self, force_N):
        solutions[-1] += 1
        assert made_for[self] == pytest.approx(lengths_s[-1])
        return solve(self, force_N)

    def counted_step(self, path, outside_N, start, end, on_held):
        solutions.append(0)
        lengths_s.append((end - start) * path.length_s)
        return step(self, path, outside_N, start, end, on_held)

    wanted = plan(length_m=0.12, span_m=0.117, cells=(6, 1), integrator="implicit", step_s=1e-3)
    with closing(sheet.build(wanted)) as panel, monkeypatch.context() as patch:
        patch.setattr(Tangent, "factorise", counted_factorise)
        patch.setattr(Tangent, "solve", counted_solve)
        patch.setattr(GeneralizedAlpha, "_step", counted_step)
        unloaded, end_s = Load.zero(len(panel.initial().surface)), 0.0
        for number in range(120):
            length_s = (1e-3, 2e-4)[number // 5 % 2]
            end_s += length_s
            panel.advance(Interval(number, length_s), shaken(panel, end_s, 0.004), unloaded)
    assert len(solutions) == 120  # none was halved
    assert np.mean(solutions) < 4
    assert max(solutions) <= 8


def test_newton_s_iteration_factorises_no_more_than_it_must(monkeypatch):
    """A panel that hardly moves is factorised once for each length of a step, and again as soon as it
    bends: a tangent that is kept for ever would need fewer, one that is never kept one for each iteration."""
    from adapters.panel import sheet
    from adapters.panel.finite_element.tangent import Tangent

    counts, factorise = [], Tangent.factorise

    def counted(self, mass_factor_1_s2, stiffness_factor):
        counts[-1] += 1
        factorise(self, mass_factor_1_s2, stiffness_factor)

    wanted = plan(length_m=0.12, span_m=0.117, cells=(6, 1), integrator="implicit", step_s=1e-3)
    with closing(sheet.build(wanted)) as panel, monkeypatch.context() as patch:
        patch.setattr(Tangent, "factorise", counted)
        unloaded = Load.zero(len(panel.initial().surface))
        for length_s, amplitude_m in ((1e-3, 1e-7), (2e-4, 1e-7), (1e-3, 0.004)):
            counts.append(0)
            for number in range(20):
                clamps = shaken(panel, (number + 1) * length_s, amplitude_m)
                panel.advance(Interval(number, length_s), clamps, unloaded)
    assert counts[:2] == [1, 1]
    assert 2 < counts[2] < 40, counts
