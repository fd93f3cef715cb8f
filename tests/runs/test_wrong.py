"""Exit code 2: the case or the output folder is wrong; all is said at once, nothing is written."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cases import case_folder
from tests.runs.outside import QUICK, flipflow, run_words, said_plainly


def test_all_mistakes_in_one_message_and_nothing_written(tmp_path: Path) -> None:
    sets = ["duration_s=-1", "panel.solver=rigd", "coupling.sync_interval=1e-4"]
    done = flipflow(*run_words("quickstart", tmp_path / "run", sets))
    assert done.returncode == 2
    said_plainly(done)
    assert done.stderr.startswith("3 problems in the case:\n")
    for text in (
        "duration_s: must be greater than 0, not -1",
        'did you mean "rigid"',
        'did you mean "sync_interval_s"',
    ):
        assert text in done.stderr
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_is_there_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "notes.txt").write_text("mine")
    done = flipflow(*run_words("quickstart", tmp_path))
    assert done.returncode == 2
    assert done.stderr.startswith(f"{tmp_path}: exists already; nothing was written.")
    assert [path.name for path in tmp_path.iterdir()] == ["notes.txt"]


@pytest.mark.parametrize("out", ["file/run", "/proc/flipflow/run"])
def test_a_folder_that_cannot_be_made(tmp_path: Path, out: str) -> None:
    (tmp_path / "file").write_text("in the way")
    done = flipflow(*run_words("quickstart", tmp_path / out))
    assert done.returncode == 2
    said_plainly(done)
    assert "run: cannot be made: " in done.stderr


def test_a_disk_without_room_for_the_case(tmp_path: Path) -> None:
    before = "import resource; resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))"
    done = flipflow(*run_words("quickstart", tmp_path / "run"), before=before)
    assert done.returncode == 2
    assert done.stderr == f"{tmp_path / 'run'}: cannot be written: File too large\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.solver
def test_what_a_solver_refuses_when_it_is_opened(tmp_path: Path) -> None:
    """The check before asks each panel's solver for its limit; here it does not tell."""
    case = case_folder(tmp_path / "case")
    before = (
        "from adapters.panel.strip import panel as strip\n"
        "def build(plan):\n"
        "    raise ValueError(f'panel {plan.name}: step_s = 3 is above 2')\n"
        "strip.build = build"
    )
    sets = [*QUICK, "frames.solver=two-mass", "panel.solver=strip", "particles.solver=spheres"]
    done = flipflow(*run_words(str(case), tmp_path / "run", sets), before=before)
    assert done.returncode == 2, done.stderr
    said_plainly(done)
    assert "panel: strip cannot take this case; panel deck: step_s = 3 is above 2" in done.stderr
    assert not (tmp_path / "run").exists()


TOO_LARGE = """
from adapters.panel.finite_element import panel_at_rest
def at_rest(plan, make_structure):
    raise MemoryError("std::bad_alloc")
panel_at_rest.at_rest = at_rest
"""


@pytest.mark.solver
@pytest.mark.parametrize("word", ["run", "check"])
def test_a_mesh_that_does_not_fit_into_memory(tmp_path: Path, word: str) -> None:
    """DOLFINx says std::bad_alloc of a thousand times a thousand cells, after half a minute."""
    folder = tmp_path / "run"
    words = run_words("quickstart", folder, [*QUICK, "panel.solver=sheet", "panel.cells=[8,3]"])
    if word == "check":
        words = ["check", *(each for each in words[1:] if each not in ("--out", str(folder)))]
    done = flipflow(*words, before=TOO_LARGE)
    assert done.returncode == 2, done.stderr
    said_plainly(done)
    assert done.stderr.splitlines()[-1].startswith("out of memory: the case is too large for this")
    assert "panel.cells" in done.stderr
    assert not folder.exists()
