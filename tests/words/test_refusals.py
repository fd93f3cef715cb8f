"""The messages of refused inputs and of doubtful cases, word for word, in ``__snapshots__``.

The inputs are those of tests in other rooms, which ask for keys, kinds and numbers.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from syrupy.assertion import SnapshotAssertion

from orchestrator.case.bed.size_distribution import faults
from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.sieve_analysis import curve_of
from orchestrator.cli.proposal.propose import propose
from orchestrator.cli.proposal.wishes import read_wishes
from orchestrator.preflight.check import warnings
from orchestrator.studies.criteria import read_criteria
from orchestrator.studies.design.study_file import read_study
from orchestrator.studies.points import parse_vary
from orchestrator.studies.sweep_plan import Arrangement, plan_sweep
from tests import test_paper
from tests.benchmarks import test_criteria
from tests.case import (
    test_base,
    test_bushing_curve,
    test_carried_bed,
    test_deck,
    test_levels,
    test_new,
    test_sieve_analysis,
    test_sweep_plan,
    test_units,
)
from tests.cases import CASE, FEED, LEVEL, case_folder, complaints, loaded
from tests.design import test_study_file
from tests.design.campaigns import write_study
from tests.effects import test_choice
from tests.particles import test_size_distribution
from tests.words.test_commands import rows

DOUBTFUL = (
    [FEED.replace("sizes", "smallest_fed_m=0.015, sizes")],
    [FEED.replace("sizes", "sampled_below_m=0.015, sampled_as_m=0.02, sizes")],
    [FEED, "particles.feed_interval_s=0.06"],
    [FEED, "particles.feed_interval_s=7e-5", "coupling.sync_interval_s=5e-5"],
    ["coupling.sync_interval_s=1.3e-4", "output.series_s=7e-4", "output.interval_s=0.0143"],
    ["slice.width_m=0.08"],
    ['slice={width_m=0.15, sides="walls"}'],
)


def refusal(call: Callable[[], Any], here: Path) -> str:
    """Return the message of what a call raises, with the folder of the test as HERE."""
    with pytest.raises((CaseError, ValueError)) as refused:
        call()
    return str(refused.value).replace(str(here), "HERE")


def test_overrides(tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    sets = [
        *([str(row)] for row in rows(test_levels.test_wrong_types_are_said_in_plain_words)),
        *([f"effects={row}"] for row in rows(test_choice.test_names_that_cannot_be)),
        *([*row] for row in rows(test_carried_bed.test_a_wrong_source_is_refused_with_a_reason)),
    ]
    messages = {" ".join(words): complaints(tmp_path, *words) for words in sets}
    assert {
        words: [line.replace(str(tmp_path), "HERE") for line in lines] for words, lines in messages.items()
    } == snapshot


def test_curves_of_bushings(tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    curves = rows(test_bushing_curve.test_a_wrong_curve_is_refused)
    assert [complaints(tmp_path, f"screen.bushings.isolation.curves=[{each}]") for each in curves] == snapshot


def test_decks(tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    overrides = [
        *(f"screen.decks.deck.{row}" for row in rows(test_deck.test_mistakes_in_a_deck_are_said_of_the_deck)),
        *(f"screen.surfaces.plate={row}" for row in rows(test_deck.test_a_surface_is_a_file_or_a_plate)),
    ]
    assert {each: [*map(str, test_deck.deck_problems(tmp_path, each))] for each in overrides} == snapshot


def test_tables_of_beds(tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    texts = []
    for table in rows(test_carried_bed.test_a_wrong_table_is_refused_with_a_reason):
        texts += complaints(tmp_path, test_carried_bed.write_table(tmp_path, table))
    assert [text.replace(str(tmp_path), "HERE") for text in texts] == snapshot


def test_size_distributions(snapshot: SnapshotAssertion) -> None:
    blocks = rows(test_size_distribution.test_what_is_no_distribution_is_refused)
    feeds = rows(test_size_distribution.test_what_cannot_be_sampled_is_refused)
    every = [*blocks, *(test_size_distribution.feed(**given) for given in feeds)]
    assert [[*faults(each)] for each in every] == snapshot


def test_sieve_analyses(tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    texts = rows(test_sieve_analysis.test_a_wrong_table_is_refused)
    assert {text: refusal(lambda text=text: curve_of(text), tmp_path) for text in texts} == snapshot


def test_bases(tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    below = case_folder(tmp_path / "below", CASE, draft=LEVEL)
    test_base.over(below, 'base = "../above"\n', "circle")
    for value in rows(test_base.test_a_wrong_base_is_one_message):
        assert str(test_base.refusal(test_base.over(below, f"base = {value}\n"))) == snapshot(name=str(value))


def test_sweeps(tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    plans = {
        " ".join(vary): refusal(lambda vary=vary, how=how: plan_sweep(vary, Arrangement(how), 3, 1), tmp_path)
        for vary, how, _ in parameters(test_sweep_plan.test_a_wrong_plan_is_refused)
    }
    units = parameters(test_units.test_sweeps_with_wrong_units)
    texts = plans | {text: refusal(lambda text=text: parse_vary(text), tmp_path) for text in units}
    assert texts == snapshot


def test_studies(tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    messages = {}
    for name, (changes, _) in test_study_file.WRONG.items():
        file = write_study(tmp_path, **changes)
        messages[name] = refusal(lambda file=file: read_study(file), tmp_path)
    assert messages == snapshot


def test_wishes(tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    messages = {
        name: refusal(lambda wish=wish: propose(read_wishes(*wish[:2]), "mine"), tmp_path)
        for name, wish in test_new.IMPOSSIBLE.items()
    }
    assert messages == snapshot


def parameters(test: Callable[..., None]) -> list[Any]:
    """Return the rows of a test with many of them."""
    return [*vars(test)["pytestmark"][0].args[1]]


def test_criteria_of_a_case(tmp_path: Path, snapshot: SnapshotAssertion) -> None:
    texts = [
        *rows(test_criteria.test_a_wrong_file_is_refused),
        *(
            test_paper.HEAD + test_paper.ROW.replace(*row)
            for row in rows(test_paper.test_a_wrong_table_is_said)
        ),
    ]
    messages = []
    for text in texts:
        (tmp_path / "criteria.toml").write_text(str(text))
        messages.append(refusal(lambda: read_criteria(tmp_path), tmp_path))
    assert messages == snapshot


@pytest.mark.parametrize("sets", DOUBTFUL, ids=range(len(DOUBTFUL)))
def test_doubtful_cases(tmp_path: Path, sets: list[str], snapshot: SnapshotAssertion) -> None:
    usual = {*warnings(loaded(tmp_path))}
    lines = warnings(loaded(tmp_path, sets))
    assert [line for line in lines if line not in usual and not line.startswith("mat ")] == snapshot
