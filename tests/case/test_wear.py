"""Wear in the case: absent unless contacts have a rate; what is asked of them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from orchestrator.case.solver_plans import particles_plan
from orchestrator.case.tables.case import Case
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import ParticlesPlan
from orchestrator.preflight.judgement.catalogue import find_left_out
from tests.cases import loaded, only_complaint, problems

WEARS = "contacts.0.specific_wear_m3_per_N_m=2e-12"


def plan(case: Case) -> ParticlesPlan:
    nothing = np.empty(0, dtype=np.int64)
    made = particles_plan(case, TriangleSurface(np.zeros((0, 3)), nothing, nothing))
    assert made is not None
    return made


def test_without_a_rate_nothing_is_planned(tmp_path: Path) -> None:
    assert plan(loaded(tmp_path).case).wear_m3_per_N_m is None


def test_rates_by_pair_of_materials(tmp_path: Path) -> None:
    rates = plan(loaded(tmp_path, [WEARS]).case).wear_m3_per_N_m
    assert rates is not None
    np.testing.assert_array_equal(rates, [[0.0, 2e-12], [2e-12, 0.0]])  # PU, coal


def test_a_level_can_leave_it_out(tmp_path: Path) -> None:
    case = loaded(tmp_path, [WEARS, "particles.wear=none"]).case
    assert plan(case).wear_m3_per_N_m is None
    assert find_left_out(case)["wear"]
    assert "wear" not in find_left_out(loaded(tmp_path, [WEARS]).case)
    assert "wear" not in find_left_out(loaded(tmp_path, ["particles.wear=none"]).case)


def test_particles_do_not_wear_each_other(tmp_path: Path) -> None:
    complaint = only_complaint(tmp_path, "contacts.1.specific_wear_m3_per_N_m=1e-12")
    assert "contacts.1.specific_wear_m3_per_N_m" in complaint
    assert "panel" in complaint


def test_the_unit_is_guessed(tmp_path: Path) -> None:
    (problem,) = problems(tmp_path, "contacts.0.specific_wear_m3_per_N_m=1e-3")
    assert problem.guesses_unit
    assert "mm3/(N" in problem.hint
