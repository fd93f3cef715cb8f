"""No word of a case gets anywhere but where it is meant to: not into a solver's input, a shell, or
a file outside of the case's folder.  What is run and shown of one that means harm:
tests/runs/test_harmless.py."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path
from typing import Any

import pytest

from orchestrator.case.file.errors import CaseError
from orchestrator.preflight.check import find_table_problems
from orchestrator.preflight.judge import load_judged
from tests.case.mutations import ROOT, Path_, at, lay_out, places
from tests.cases import case_folder

EVIL = "x\nshell touch owned\n"
# free text, which solvers never see; and names of files: below and in test_surfaces.py
FREE = ("title", "description", "stl")
CASES = [("quickstart", "draft"), ("ffs0827-slice", "draft")]
Given = tuple[Path, dict[str, Any]]


@pytest.fixture(scope="module", params=CASES, ids=[name for name, _ in CASES])
def given(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Given:
    """A case's folder and its table, without levels, which would hide some of it."""
    case, level = request.param
    source = ROOT / "cases" / case
    files = [(source / name).read_bytes() for name in ("case.toml", f"levels/{level}.toml")]
    place = tmp_path_factory.mktemp(case)
    folder = lay_out(place, case, level, *files)
    (folder / f"levels/{level}.toml").unlink()
    return folder, tomllib.loads(files[0].decode()) | {"default_level": ""}


def is_refused(given: Given, place: Path_, *, key: bool) -> bool:
    """Return whether the case is refused, with the word at ``place`` (or its key) replaced by an evil one."""
    folder, table = given[0], copy.deepcopy(given[1])
    holder = at(table, place[:-1])
    if key:
        holder[EVIL] = holder.pop(place[-1])
    else:
        holder[place[-1]] = EVIL
    case_folder(folder, table)
    try:
        return bool(find_table_problems(load_judged(folder)))
    except CaseError:
        return True


def test_a_word_that_is_no_name_is_refused_wherever_it_stands(given: Given) -> None:
    words = [
        place
        for place in places(given[1])[1:]
        if isinstance(at(given[1], place), str) and place[-1] not in FREE
    ]
    assert len(words) > 20
    assert [place for place in words if not is_refused(given, place, key=False)] == []


def test_so_is_a_key(given: Given) -> None:
    keys = [place for place in places(given[1])[1:] if isinstance(place[-1], str)]
    assert len(keys) > 100
    assert [place for place in keys if not is_refused(given, place, key=True)] == []
