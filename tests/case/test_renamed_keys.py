"""Keys and values of earlier versions are refused with the name that they have now."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestrator.case import solvers
from orchestrator.case.file.errors import RENAMED, CaseError
from tests.cases import CASE, load_case


def complaints(folder: Path, text: str) -> list[str]:
    with pytest.raises(CaseError) as refused:
        load_case(folder, text)
    return [str(problem) for problem in refused.value.problems]


@pytest.mark.parametrize(
    ("before", "now"), [("speed_rad_s", "speed_rad_per_s"), ("density_kg_m3", "density_kg_per_m3")]
)
def test_an_old_name_in_a_case(tmp_path: Path, before: str, now: str) -> None:
    assert now in CASE
    said = complaints(tmp_path, CASE.replace(now, before))
    assert len(said) == CASE.count(now)
    for one in said:
        assert f'{before}: the name of an earlier version; it is called "{now}" now' in one


@pytest.mark.parametrize("before", ["hand_over", "watch", "save"])
def test_an_old_name_of_a_table(tmp_path: Path, before: str) -> None:
    (said,) = complaints(tmp_path, CASE + f"\n[{before}]\n")
    assert f'it is called "{RENAMED[before]}" now' in said


def test_a_solver_of_an_earlier_version(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr(solvers, "names", lambda port: ("liggghts",))
    (said,) = complaints(tmp_path, CASE + '\n[particles]\nsolver = "spheres"\n')
    assert "particles.solver: 'spheres' is of an earlier version; use \"liggghts\"" in said
