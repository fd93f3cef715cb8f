"""Arrays go to the engine by name, and what does not fit its name is refused by that name."""

from __future__ import annotations

from contextlib import closing
from typing import Any

import numpy as np
import pytest

from tests.particles.contract import solver_adapter
from tests.particles.liggghts_plans import flat, make_plan, spheres

pytestmark = pytest.mark.solver

SURFACE = flat()
POINTS = len(SURFACE.position_m)
PATH: dict[str, Any] = {
    "start_m": SURFACE.position_m,
    "start_m_per_s": np.zeros((POINTS, 3)),
    "end_m": SURFACE.position_m,
    "end_m_per_s": np.zeros((POINTS, 3)),
    "length_s": 1e-4,
    "steps": 10,
}
NEW: dict[str, Any] = {
    "position_m": np.full((2, 3), 0.05),
    "velocity_m_per_s": np.zeros((2, 3)),
    "spin_rad_per_s": np.zeros((2, 3)),
    "diameter_m": np.full(2, 1e-3),
    "density_kg_per_m3": np.full(2, 1e3),
    "type": np.ones(2, dtype=np.int32),
    "first_id": 7,
}
EXITS: dict[str, Any] = {
    "center_m": np.zeros((1, 3)),
    "axes": np.zeros((1, 3, 3)),
    "half_m": np.zeros((1, 3)),
    "domain_m": np.zeros((2, 3)),
    "below_deck": np.zeros(1, dtype=np.int32),
    "deck": np.zeros(0, dtype=np.int32),
}
CALLS = {"begin_path": PATH, "create": NEW, "set_exits": EXITS}


@pytest.fixture
def engine() -> Any:
    plan = make_plan(SURFACE, spheres([0.0, 0.0, 0.01]))
    with closing(solver_adapter("liggghts").build(plan)) as solver:
        yield solver._engine


@pytest.mark.parametrize("call", CALLS)
def test_arrays_without_a_name_are_refused(engine: Any, call: str) -> None:
    with pytest.raises(TypeError, match="incompatible"):
        getattr(engine, call)(*CALLS[call].values())


@pytest.mark.parametrize("call", CALLS)
def test_a_name_too_few_or_another_one_is_refused(engine: Any, call: str) -> None:
    for name, value in CALLS[call].items():
        others = {key: other for key, other in CALLS[call].items() if key != name}
        for wrong in (others, others | {name + "s": value}):
            with pytest.raises(TypeError, match="incompatible"):
                getattr(engine, call)(**wrong)


@pytest.mark.parametrize("call", CALLS)
def test_two_arrays_of_other_shapes_that_change_names_are_refused(engine: Any, call: str) -> None:
    arrays = {name: value for name, value in CALLS[call].items() if isinstance(value, np.ndarray)}
    exchanged = 0
    for array in arrays:
        for other in arrays:
            if arrays[array].shape == arrays[other].shape:
                continue
            wrong = CALLS[call] | {array: arrays[other], other: arrays[array]}
            if arrays[array].dtype == arrays[other].dtype:
                with pytest.raises(ValueError, match=r"^(" + "|".join(arrays) + r"): an array of shape"):
                    getattr(engine, call)(**wrong)
            else:
                with pytest.raises(TypeError):
                    getattr(engine, call)(**wrong)
            exchanged += 1
    assert exchanged > 0 or call == "begin_path"


def test_an_array_of_another_size_is_named(engine: Any) -> None:
    for name in ("start_m", "start_m_per_s", "end_m", "end_m_per_s"):
        with pytest.raises(ValueError, match=rf"^{name}:.*\b{POINTS}\b"):
            engine.begin_path(**PATH | {name: np.zeros((POINTS + 1, 3))})


def test_numbers_of_another_kind_are_not_converted(engine: Any) -> None:
    for wrong in (
        np.zeros((POINTS, 3), dtype=np.float32),
        np.zeros((3, POINTS)).T,
        np.zeros((POINTS, 3), int),
    ):
        with pytest.raises(TypeError, match="incompatible"):
            engine.begin_path(**PATH | {"end_m": wrong})
