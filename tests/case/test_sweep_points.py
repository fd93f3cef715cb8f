"""The finished runs that a study takes for its own; nothing is run here."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from orchestrator.case.file.folder import FolderUnusable
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.output.records.summary import write_summary
from orchestrator.studies.points import CaseStudy, Point
from tests.cases import case_folder
from tests.runs.outside import ROOT

EMPTY = ROOT / "cases/empty-machine"


def done_point(folder: Path, stored: dict[str, Any]) -> Point:
    """A point of the empty machine whose folder holds a finished run of ``stored``."""
    case_folder(folder, stored)
    write_summary(folder, {"status": "done"})
    return CaseStudy(EMPTY, "draft", out=folder.parent).point(folder.name)


@pytest.fixture(scope="module")
def now() -> dict[str, Any]:
    return resolved_case(CaseStudy(EMPTY, "draft").check().judged)


def test_its_own_run_is_not_done_again(tmp_path: Path, now: dict[str, Any]) -> None:
    assert done_point(tmp_path / "run", now).done()


def test_keys_that_came_since_have_their_defaults_in_older_runs(tmp_path: Path, now: dict[str, Any]) -> None:
    """A run of before ``coupling.scheme`` and a whole table, as if either were new."""
    coupling = {key: value for key, value in now["coupling"].items() if key != "scheme"}
    older = {key: value for key, value in now.items() if key != "checkpoint"} | {"coupling": coupling}
    assert done_point(tmp_path / "run", older).done()


def test_a_new_key_that_is_not_at_its_default_is_another_case(tmp_path: Path, now: dict[str, Any]) -> None:
    """The level gives ``panel.cells``; a run without it had the default."""
    panel = {key: value for key, value in now["panel"].items() if key != "cells"}
    with pytest.raises(FolderUnusable, match=r"\bpanel\.cells\b"):
        done_point(tmp_path / "run", now | {"panel": panel}).done()


def test_a_run_with_a_key_that_is_gone_is_another_case(tmp_path: Path, now: dict[str, Any]) -> None:
    older = now | {"coupling": now["coupling"] | {"lag": 1}}
    with pytest.raises(FolderUnusable, match=r"\bcoupling\.lag\b"):
        done_point(tmp_path / "run", older).done()
