"""Files of this project's cases, changed in any way: a command ends soon, with an exit code that says who
has to act and words that help; it writes nothing but its run's folder.

Thousands of examples instead of dozens: ``pytest tests/case --hypothesis-profile=long``.
"""

from __future__ import annotations

import shutil
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.case.fuzzing import Ended, flipflow
from tests.case.mutations import DRAFTS, ROOT, SEEDS, lay_out, spoilt_bytes, spoilt_tables

pytestmark = pytest.mark.process
LONG = settings.default is settings.get_profile("long")
CASES = SEEDS if LONG else DRAFTS
FEW = settings(max_examples=3000 if LONG else 30, deadline=None, suppress_health_check=list(HealthCheck))
FEWER = settings(FEW, max_examples=1000 if LONG else 5)
# of a case, and what a run adds: a solver is missing, a solver failed
RIGHT_OR_WRONG, OF_A_RUN = {0, 2}, {0, 2, 3, 4}


def ended_well(done: Ended, codes: set[int]) -> None:
    output = done.out + done.err
    assert done.code in codes, output
    assert "Traceback" not in output, output
    assert "internal error" not in output, output
    assert all(char.isprintable() or char == "\n" for char in output), output
    assert len(output) < 40_000, len(output)
    if done.code:
        assert done.err.strip(), "nothing is said"


def tried(place: Path, words: Sequence[str], codes: set[int]) -> None:
    """``flipflow WORDS`` in ``place``, where the folder "run" may come to be."""
    done = flipflow(words, place)
    ended_well(done, codes)
    assert {name for name in done.written if not name.startswith("run/")} == set()
    shutil.rmtree(place / "run", ignore_errors=True)


def place_of(tmp_path: Path) -> Path:
    (tmp_path / "here").mkdir(exist_ok=True)
    return tmp_path / "here"


@FEW
@given(drawn=spoilt_tables(CASES), command=st.sampled_from(["check", "check", "explain"]))
def test_a_case_with_other_values(drawn: Any, command: str, tmp_path: Path) -> None:
    place = place_of(tmp_path)
    lay_out(place, *drawn)
    tried(place, [command, "case", "--level", drawn[1]], RIGHT_OR_WRONG)


@FEW
@given(data=st.data(), seed=st.sampled_from(CASES), at_level=st.booleans())
def test_a_case_with_other_bytes(data: Any, seed: tuple[str, str], at_level: bool, tmp_path: Path) -> None:
    place, (case, level) = place_of(tmp_path), seed
    folder = ROOT / "cases" / case
    files = [file.read_bytes() for file in (folder / "case.toml", folder / f"levels/{level}.toml")]
    files[at_level] = data.draw(spoilt_bytes(files[at_level]))
    lay_out(place, case, level, *files)
    tried(place, ["check", "case", "--level", level], RIGHT_OR_WRONG)


@FEWER
@given(data=st.data())
def test_a_surface_with_other_bytes(data: Any, tmp_path: Path) -> None:
    place, folder = place_of(tmp_path), ROOT / "cases/quickstart"
    files = [(folder / name).read_bytes() for name in ("case.toml", "levels/draft.toml")]
    case = lay_out(place, "quickstart", "draft", *files)
    (case / "walls.stl").write_bytes(data.draw(spoilt_bytes((case / "walls.stl").read_bytes())))
    tried(place, ["check", "case", "--level", "draft"], RIGHT_OR_WRONG)


@pytest.mark.solver
@FEWER
@given(drawn=spoilt_tables(CASES), command=st.sampled_from(["run", "run", "accuracy"]))
def test_a_run_of_a_case_with_other_values(drawn: Any, command: str, tmp_path: Path) -> None:
    """Values that pass the check do not break what comes after it."""
    place, level = place_of(tmp_path), drawn[1]
    lay_out(place, *drawn)
    words = {
        "run": ["run", "case", "--out", "run", "--level", level],
        "accuracy": ["study", "accuracy", "case", "--dry", "--out", "run", "--level", level],
    }[command]
    tried(place, words, OF_A_RUN)


@pytest.mark.parametrize("name", ["case.toml", "summary.json", "provenance.json", "history.h5"])
@FEWER
@given(data=st.data())
def test_a_report_of_a_run_with_other_bytes(data: Any, name: str, tmp_path: Path) -> None:
    place, whole = place_of(tmp_path), tmp_path / "whole"
    if not whole.exists():
        from tests.results.synthetic import folder_of

        folder_of(whole, True)
    shutil.copytree(whole, place / "run", dirs_exist_ok=True)
    (place / "run" / name).write_bytes(data.draw(spoilt_bytes((whole / name).read_bytes())))
    tried(place, ["report", "run"], RIGHT_OR_WRONG)
