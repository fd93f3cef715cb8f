"""TOML of any kind becomes a case or a CaseError: never another exception."""

from __future__ import annotations

import tomllib
from contextlib import suppress
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.layers import Layers
from orchestrator.case.load import validate
from orchestrator.preflight.check import find_problems, warnings
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.judgement.catalogue import judge_effects
from tests.case.mutations import ROOT
from tests.cases import BLOCK, CASE, FEED, LEVEL, case_folder

GIVEN = tomllib.loads(CASE)
SCALARS = st.one_of(
    st.booleans(), st.integers(), st.floats(), st.text(max_size=8), st.dates(), st.just("ground")
)
VALUES = st.recursive(
    SCALARS,
    lambda inner: (
        st.lists(inner, max_size=4)
        | st.dictionaries(st.sampled_from(["solver", "deck", "0", "x"]) | st.text(), inner, max_size=4)
    ),
    max_leaves=8,
)


def keys(table: Any, path: tuple[str, ...] = ()) -> list[tuple[str, ...]]:
    """All keys of the test case, elements of lists by number."""
    if isinstance(table, list):
        table = {str(number): value for number, value in enumerate(table)}
    if not isinstance(table, dict):
        return [path]
    return [path, *(key for name, value in table.items() for key in keys(value, (*path, name)))]


KEYS = keys(GIVEN)[1:] + [(port, "solver") for port in ("panel", "frames", "particles")]
KEYS += [("slice", "width_m"), ("bed", "feeds", "x"), ("screen", "exits", "x")]


def nested(key: tuple[str, ...], value: Any) -> dict[str, Any]:
    for name in reversed(key):
        value = {name: value}
    return dict(value)


@settings(deadline=None, suppress_health_check=list(HealthCheck))
@given(st.dictionaries(st.text(), VALUES, max_size=5))
def test_any_dictionary_is_a_case_or_a_case_error(table: dict[str, Any]) -> None:
    with suppress(CaseError):
        validate(Layers(table, "case.toml"), Path("."))


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(key=st.sampled_from(KEYS), value=VALUES)
def test_any_value_anywhere_in_a_case_is_checked(key: tuple[str, ...], value: Any, tmp_path: Path) -> None:
    """The bare case is good; one key of it gets any value."""
    folder = case_folder(tmp_path, draft=LEVEL)
    bare = load_judged(folder, "draft")
    with suppress(CaseError):
        bare.layers.lay(nested(key, value), "--set")
        problems = find_problems(replace(bare, case=validate(bare.layers, bare.folder)))
        assert all(mistake.what and mistake.file for mistake in problems)


@pytest.mark.parametrize("value", [0, -1, 1e-308, 1e308, [1e308, 1e308, 1e308]])
def test_extreme_numbers_anywhere_are_checked_without_overflow(value: object, tmp_path: Path) -> None:
    """Warnings are errors in tests, so that an overflow would show."""
    folder = case_folder(tmp_path, draft=LEVEL)
    for key in keys(load_judged(folder, "draft", [BLOCK, FEED]).layers.merged)[1:]:
        judged = load_judged(folder, "draft", [BLOCK, FEED])
        with suppress(CaseError):
            judged.layers.lay(nested(key, value), "--set")
            spoilt = replace(judged, case=validate(judged.layers, judged.folder))
            if not find_problems(spoilt):
                warnings(spoilt)
                judge_effects(spoilt.case)


@pytest.mark.parametrize("value", [1e300, -1e300, 5e-324])
def test_a_deck_is_not_laid_out_of_extreme_numbers(value: float) -> None:
    folder = ROOT / "cases" / "ffs0827-effects"
    deck = load_judged(folder, "draft").layers.merged["screen"]["decks"]["deck"]
    for key in keys(deck, ("screen", "decks", "deck"))[1:]:
        judged = load_judged(folder, "draft")
        with suppress(CaseError):
            judged.layers.lay(nested(key, value), "--set")
            find_problems(replace(judged, case=validate(judged.layers, judged.folder)))


@settings(deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(text=st.text(), override=st.text())
def test_any_text_in_a_file_and_on_the_command_line(text: str, override: str, tmp_path: Path) -> None:
    for case, overrides in ((text, ()), (CASE, (override,))):
        with suppress(CaseError):
            load_judged(case_folder(tmp_path, case.encode("utf-8", "ignore").decode()), None, overrides)
