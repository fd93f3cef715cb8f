"""The list of mistakes that the tests must notice: each one still fits the code."""

from __future__ import annotations

import pytest

from tools.mutants.__main__ import ROOT, listed

MUTANTS = listed()


@pytest.mark.parametrize("name", MUTANTS)
def test_a_mistake_fits_the_code_and_its_tests_are_there(name: str) -> None:
    assert [*MUTANTS[name].misfits(ROOT)] == []


def test_rooms_without_equations_have_mistakes_too() -> None:
    files = [mutant.file.split("/") for mutant in MUTANTS.values()]
    places = {room for top, room, *_ in files if top == "orchestrator"}
    assert places >= {"case", "preflight", "output", "run", "studies", "cli"}
