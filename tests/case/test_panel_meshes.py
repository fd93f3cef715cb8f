"""Panels' meshes that no machine carries, or not this one."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from orchestrator.preflight.check import find_problems, warnings
from orchestrator.preflight.checks import panels
from orchestrator.preflight.cost import predicted_parts_s
from tests.cases import loaded

SHEET = 'panel.solver="sheet"'


def test_a_sheet_of_a_million_cells_is_refused_before_anything_is_made(tmp_path: Path) -> None:
    """The sheet would take all memory of a machine of 23 GiB, and the system would end it without a word."""
    case = loaded(tmp_path, (SHEET, "panel.cells=[1000, 1000]"))
    problems = find_problems(case)
    assert [problem.key for problem in problems] == [("panel", "cells")]
    assert "1000 x 1000 cells" in problems[0].what
    assert "at most 64 GiB are allowed" in problems[0].what
    assert not find_problems(loaded(tmp_path / "fine", (SHEET, "panel.cells=[100, 100]")))


def test_what_this_machine_does_not_carry_is_warned_of(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = loaded(tmp_path, (SHEET, "panel.cells=[100, 100]"))
    monkeypatch.setattr(os, "sysconf", {"SC_PHYS_PAGES": 2**18, "SC_PAGE_SIZE": 4096}.__getitem__)
    needed_GiB = panels.memory_GiB(case.case)
    assert needed_GiB == pytest.approx(3.0 * len(case.case.screen.panels))
    assert any("this machine has 1 GiB" in line for line in warnings(case))


def test_opening_a_strip_of_many_cells_is_foretold(tmp_path: Path) -> None:
    """Measured: 7 s for 200 cells, 70 s for 400."""
    taken_s = {200: 7.0, 400: 70.0}
    for cells, measured_s in taken_s.items():
        case = loaded(tmp_path / str(cells), ('panel.solver="strip"', f"panel.cells=[{cells}, 1]"))
        panels = len(case.case.screen.panels)
        foretold_s = predicted_parts_s(case.case, 1)["rest"] / panels
        assert foretold_s == pytest.approx(measured_s, rel=0.5)
