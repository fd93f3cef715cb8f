"""The findings of a study: whether its best setting was measured as predicted, and what it gains."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orchestrator.studies.design import pictures
from orchestrator.studies.design.campaign import Campaign
from orchestrator.studies.design.findings import ConfidenceInterval, Confirmed, Findings
from orchestrator.studies.design.page import anova_tables, answers, borders, doubts, noise_in_words, rivals
from orchestrator.studies.design.pictures import main_effects, strongest_pair
from orchestrator.studies.design.scales import SCALES
from orchestrator.studies.design.trials import Measured, Outcome, Prediction
from orchestrator.workbench import Picture
from tests.design.campaigns import belt, belt_truth, run_all


def with_confirming_runs(
    whole: Campaign, change: Callable[[Outcome], Mapping[str, Measured]], roles: Sequence[str] = ("best",)
) -> Findings:
    """Return the findings with other responses of the runs that confirm the settings with some roles."""
    whole.outcomes = [
        replace(each, responses=change(each)) if each.trial.role in roles else each for each in whole.outcomes
    ]
    return Findings(whole)


def best_of(findings: Findings) -> Confirmed:
    """Return the measurement of the best setting."""
    return next(each for each in findings.confirmed if each.role == "best")


@pytest.fixture
def whole(tmp_path: Path) -> Campaign:
    """A study that came to its end."""
    return run_all(belt(tmp_path), tmp_path)


def test_a_best_setting_that_was_measured_as_predicted_is_confirmed(whole: Campaign) -> None:
    findings = Findings(whole)
    assert findings.is_confirmed()
    best = best_of(findings)
    runs = [each for each in whole.outcomes if each.trial.role == "best"]
    assert best.runs == len(runs) >= 2
    speeds = [each.responses["speed"].value for each in runs]
    assert best.measured["speed"].value == pytest.approx(np.mean(speeds))
    widened = findings.data.widened[0]
    assert best.measured["speed"].half_width == pytest.approx(widened * 1.96 * 0.01 / len(runs) ** 0.5)
    mean, deviation, *_ = runs[0].trial.predicted["speed"]
    assert best.predicted["speed"].value == pytest.approx(mean)
    assert best.predicted["speed"].half_width == pytest.approx(1.96 * deviation)


def test_a_best_setting_that_is_slower_than_predicted_is_not_confirmed(whole: Campaign) -> None:
    findings = with_confirming_runs(whole, lambda each: {**each.responses, "speed": Measured(1.2, 0.01)})
    assert not findings.is_confirmed()
    assert best_of(findings).why_not.startswith("speed was measured as 1.2")
    assert "NOT as predicted: speed was measured as 1.2" in next(answers(findings))


@pytest.mark.parametrize("confidence", [0.5, 0.9, 0.99])
def test_a_best_setting_that_breaks_its_limit_is_not_confirmed(confidence: float, tmp_path: Path) -> None:
    """The setting is not confirmed however surely the limit was to be kept."""
    whole = run_all(belt(tmp_path, confidence=confidence), tmp_path)
    findings = with_confirming_runs(whole, lambda each: {**each.responses, "share": Measured(59.8, 0.5)})
    assert not findings.is_confirmed()
    assert "share was measured as 59.8" in best_of(findings).why_not
    assert "beyond its limit" in best_of(findings).why_not


def test_a_best_setting_at_its_limit_is_not_beyond_it(tmp_path: Path) -> None:
    """The mean of three numbers 60.3 is 60.3 less a rounding."""
    whole = run_all(belt(tmp_path, limits=["share >= 60.3"]), tmp_path)
    runs = [each for each in whole.outcomes if each.trial.role == "best"]
    third = replace(runs[0], trial=replace(runs[0].trial, number=99))
    whole.outcomes = [each for each in whole.outcomes if each not in runs[2:]] + [third]
    best = best_of(with_confirming_runs(whole, lambda each: {**each.responses, "share": Measured(60.3, 0.5)}))
    assert best.runs == 3
    assert "beyond its limit" not in best.why_not


def test_a_best_setting_whose_limit_was_not_measured_is_not_confirmed(whole: Campaign) -> None:
    findings = with_confirming_runs(whole, lambda each: {"speed": each.responses["speed"]})
    assert not findings.is_confirmed()
    assert "share was not measured" in best_of(findings).why_not


def test_a_mean_is_of_the_runs_that_have_the_response(whole: Campaign) -> None:
    def change(each: Outcome) -> Mapping[str, Measured]:
        both = {"speed": each.responses["speed"], "share": Measured(70.0, 0.5)}
        return both if each.trial.seed == 1000 else {"speed": both["speed"]}

    measured = best_of(with_confirming_runs(whole, change)).measured["share"]
    assert measured.value == pytest.approx(70.0)
    assert measured.half_width == pytest.approx(1.96 * 0.5)


def test_a_difference_is_taken_between_runs_of_equal_seeds(whole: Campaign) -> None:
    """Errors that both runs of a pair have cancel: here 1000 times the difference."""
    gains = {1000: 0.30, 1001: 0.36}

    def change(each: Outcome) -> Mapping[str, Measured]:
        common = 300.0 * (each.trial.seed - 1000)
        own = gains.get(each.trial.seed, 0.32) if each.trial.role == "best" else 0.0
        return {**each.responses, "speed": Measured(1.0 + common + own, 0.01)}

    whole.outcomes = [each for each in whole.outcomes if each.trial.seed != 1002]
    findings = with_confirming_runs(whole, change, ("best", "centre"))
    difference = findings.against("best", "centre", 0)
    assert difference is not None
    assert difference.value == pytest.approx(0.33)
    # Student's t for 95 % and 1 degree of freedom is 12.7062; the standard error is 0.06 / sqrt(2) / sqrt(2)
    assert difference.half_width == pytest.approx(12.7062 * 0.03, rel=1e-5)
    assert "within chance" in next(rivals(findings))
    assert findings.against("best", "simpler", 0) is None


def test_a_response_that_was_added_later_has_no_prediction_but_is_measured(
    whole: Campaign, tmp_path: Path
) -> None:
    later = belt(tmp_path, **{"responses/power": {"result": "results.power"}})
    more = [
        replace(each, responses={**each.responses, "power": Measured(float(each.trial.number), 1.0)})
        for each in whole.outcomes
    ]
    findings = Findings(Campaign(later, whole.evaluator, whole.journal, more, whole.read_trials()))
    assert findings.is_confirmed()
    assert "power" in best_of(findings).measured


@pytest.mark.parametrize("change", [{"scale": "logarithm"}, {"result": "results.pace"}])
def test_a_prediction_of_another_result_or_on_another_scale_is_left_out(
    change: dict[str, str], whole: Campaign, tmp_path: Path
) -> None:
    (key, value), *_ = change.items()
    changed = belt(tmp_path, **{f"responses/speed/{key}": value})
    stored = {each.number: each for each in Campaign(changed, whole.evaluator, whole.journal).read_trials()}
    whole.outcomes = [replace(each, trial=stored[each.trial.number]) for each in whole.outcomes]
    assert {tuple(each.predicted) for each in stored.values()} == {(), ("share",)}
    findings = Findings(Campaign(changed, whole.evaluator, whole.journal, whole.outcomes))
    assert best_of(findings).why_not == "speed was not predicted"


def test_a_prediction_of_an_earlier_version_which_tells_no_scale_is_left_out(whole: Campaign) -> None:
    for trial in whole.journal.read():
        stated = {name: each[:2] for name, each in trial.predicted.items()}
        whole.journal.write(replace(trial, predicted=stated))  # type: ignore[arg-type]
    assert not any(trial.predicted for trial in whole.read_trials())


def test_of_two_goals_the_answer_is_the_best_in_the_first_alone_and_says_so(tmp_path: Path) -> None:
    goals = {"goals": ["maximise speed", "minimise share"], "limits": []}
    answer = next(answers(Findings(run_all(belt(tmp_path, **goals), tmp_path))))
    assert {"speed", "front.csv"} <= {*re.findall(r"[\w.]+", answer)}


def test_the_front_has_no_setting_twice_and_none_beyond_another_limit(tmp_path: Path) -> None:
    """Slow decks are at a corner of the space, which the search for the front meets often."""
    goals = {"goals": ["maximise speed", "maximise share"], "limits": ["pace <= 1.5"]}
    study = belt(tmp_path, **goals, **{"responses/pace": {"result": "results.speed"}})

    def truth(x: Mapping[str, float]) -> dict[str, float]:
        return {**belt_truth(x), "pace": belt_truth(x)["speed"]}

    findings = Findings(run_all(study, tmp_path, truth=truth))
    assert len(np.unique(findings.front, axis=0)) == len(findings.front) > 30
    assert findings.beside.limits == study.aim.limits
    assert max(belt_truth(study.actual(x))["speed"] for x in findings.front) < 1.55


def test_runs_beyond_another_limit_are_open_but_not_those_that_lack_it(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    drawn: list[Any] = []
    monkeypatch.setattr(Picture, "save", lambda picture, file: drawn.append(picture.figure))
    goals = {"goals": ["maximise speed", "maximise share"], "limits": ["pace <= 1.5"]}
    study = belt(
        tmp_path, **goals, **{"responses/pace": {"result": "results.pace"}, "plan/runs": 12, "search/runs": 0}
    )

    def truth(x: Mapping[str, float]) -> dict[str, float]:
        return {**belt_truth(x), "pace": belt_truth(x)["speed"]}

    whole = run_all(study, tmp_path, truth=truth)
    fast = [each for each in whole.outcomes if each.responses["pace"].value > 1.5]
    lacking = {name: value for name, value in fast[0].responses.items() if name != "pace"}
    whole.outcomes[whole.outcomes.index(fast[0])] = replace(fast[0], responses=lacking)
    pictures.draw_all(Findings(whole), tmp_path)
    shown = {each.get_label(): len(each.lines[0].get_xdata()) for each in drawn[0].axes[0].containers}
    assert shown["runs beyond another limit"] == len(fast) - 1
    assert shown["runs"] == len(whole.outcomes) - len(fast) + 1


def test_data_outside_the_ranges_are_told(whole: Campaign) -> None:
    assert not list(doubts(Findings(whole)))
    trial = replace(whole.outcomes[4].trial, setting=(24.0, 0.5))  # 260 deg in place of 26
    whole.outcomes[4] = replace(whole.outcomes[4], trial=trial)
    assert "(0005), farthest 0005 with slope = 260." in next(doubts(Findings(whole)))


def test_an_ordered_factor_does_not_show_the_effects_of_its_chain(tmp_path: Path) -> None:
    """The speed depends on the first slope alone: 0.1 m/s for each degree of it."""
    names = ("b1", "b2", "b3")
    study = belt(
        tmp_path,
        factors={name: {"range": [10.0, 40.0]} for name in names},
        set={f"screen.{name}": name for name in names},
        ordered=[list(names)],
        limits=[],
        responses={"speed": {"result": "results.speed"}},
        **{"plan/runs": 24, "search/runs": 0},
    )
    findings = Findings(run_all(study, tmp_path, truth=lambda x: {"speed": 0.1 * x["b1"]}))
    for factor, slope in enumerate((0.1, 0.0, 0.0)):
        place, mean, _ = main_effects(findings, factor)
        assert np.diff(mean[:, 0]) / np.diff(place) == pytest.approx(np.full(11, slope), abs=0.01)
    assert strongest_pair(findings)[0] == 0  # type: ignore[index]


@pytest.mark.parametrize(("limit", "warns"), [(60.0, False), (94.3, True)])
def test_a_best_setting_that_is_less_sure_than_was_asked_for_is_told(
    limit: float, warns: bool, tmp_path: Path
) -> None:
    """The share is 94 % at best, and the runs make it some tenths more."""
    study = belt(tmp_path, limits=[f"share >= {limit}"], confidence=0.999)
    lines = list(borders(Findings(run_all(study, tmp_path))))
    assert any("as surely as was asked for (99.9 %)" in line for line in lines) is warns


def test_a_setting_that_misses_its_limit_by_a_rounding_is_not_called_unsure(tmp_path: Path) -> None:
    """A quadratic without noise has no error, and SLSQP ends some 1e-9 before or behind the limit."""
    study = belt(tmp_path, **{"search/optimiser": "gradient"})
    whole = run_all(study, tmp_path, noise={}, deviations={"speed": None, "share": None})
    assert not any("surely" in line.split() for line in borders(Findings(whole)))


@pytest.mark.parametrize(("limit", "binds"), [(60, True), (10, False)])
def test_the_ends_of_ranges_and_limits_that_do_not_bind_are_told(
    limit: int, binds: bool, tmp_path: Path
) -> None:
    """Fastest where it is steepest and strongest; a limit of 10 % rules nothing out."""
    lines = list(borders(Findings(run_all(belt(tmp_path, limits=[f"share >= {limit}"]), tmp_path))))
    assert any("do not bind" in line for line in lines) is not binds
    if not binds:
        assert "slope at the upper end, stroke at the upper end" in lines[0]
        assert "wider ranges may have more" in lines[0]


def test_a_response_that_is_neither_goal_nor_limit_refuses_nothing(whole: Campaign, tmp_path: Path) -> None:
    """The cost of runs was predicted far too surely, but it is neither goal nor limit."""
    more = [
        replace(
            each,
            trial=replace(each.trial, predicted={**each.trial.predicted, "power": Prediction(0.0, 1e-9)}),
            responses={**each.responses, "power": Measured(5.0, 1e-9)},
        )
        for each in whole.outcomes
    ]
    for limits, confirmed in ((["share >= 60"], True), (["share >= 60", "power >= 4"], False)):
        asked = belt(tmp_path, **{"responses/power": {"result": "results.power"}, "limits": limits})
        findings = Findings(Campaign(asked, whole.evaluator, whole.journal, more, whole.read_trials()))
        assert findings.is_confirmed() == confirmed


def test_a_surface_of_a_logit_is_not_taken_for_one_of_percents(tmp_path: Path) -> None:
    whole = run_all(belt(tmp_path, **{"responses/share/scale": "percent"}), tmp_path)
    speed, share = (table["words"] for table in anova_tables(Findings(whole)))
    assert "logit" not in speed
    assert share.endswith("All of it is of the logit ln(p / (100 − p)), not of share itself.")


def test_noise_that_was_widened_is_told(whole: Campaign) -> None:
    whole.outcomes = [
        replace(
            each,
            responses={
                name: replace(m, deviation=(m.deviation or 1.0) / 30) for name, m in each.responses.items()
            },
        )
        for each in whole.outcomes
    ]
    findings = Findings(whole)
    assert findings.data.widened.max() > 3
    assert any("times as much as the runs' own intervals say" in line for line in noise_in_words(findings))


@pytest.mark.parametrize(("centres", "count"), [(1, 1), (2, 0)])
def test_noise_of_which_nothing_tells_is_said_to_be_taken_from_a_surface(
    centres: int, count: int, tmp_path: Path
) -> None:
    study = belt(tmp_path, **{"plan/centres": centres, "plan/runs": 12, "search/runs": 0, "goals": []})
    findings = Findings(run_all(study, tmp_path, deviations={"speed": None}))
    assert sum("Nothing tells of the noise" in line for line in noise_in_words(findings)) == count
    assert all("Nothing tells of the noise of speed" in line for line in [*noise_in_words(findings)][:count])


def test_equal_runs_of_one_setting_are_said_to_tell_nothing_of_the_noise(tmp_path: Path) -> None:
    study = belt(tmp_path, **{"plan/runs": 8, "search/runs": 0, "goals": []})
    exact: dict[str, float] = {}
    for noise, warns in (({"speed": 0.01, "share": 0.5}, False), (exact, True)):
        whole = run_all(study, tmp_path, noise=noise, deviations={"speed": None, "share": None})
        lines = list(noise_in_words(Findings(whole)))
        assert any(line.startswith("All runs of one setting have one speed") for line in lines) is warns


def test_a_run_that_stands_out_is_named_and_kept(tmp_path: Path) -> None:
    study = belt(tmp_path, **{"plan/runs": 12, "search/surrogate": "gaussian-process", "search/runs": 0})
    whole = run_all(study, tmp_path)
    number = whole.outcomes[3].trial.number
    wrong = replace(
        whole.outcomes[3], responses={**whole.outcomes[3].responses, "speed": Measured(3.5, 0.01)}
    )
    whole.outcomes[3] = wrong
    findings = Findings(whole)
    assert number in findings.data.numbers
    assert any(f"Run {number} stands out: its speed" in line for line in noise_in_words(findings))


@pytest.mark.parametrize(("scale", "mean", "end"), [("percent", 5.0, 95.435), ("logarithm", 3.0, 142.59)])
def test_an_interval_that_is_not_even_reaches_to_its_farther_end(scale: str, mean: float, end: float) -> None:
    """1 / (1 + exp(1.96 - 5)) is 95.435 %, exp(3 + 1.96) 142.59."""
    interval = ConfidenceInterval.of(SCALES[scale], mean, 1.96)
    assert abs(interval.value - end) == pytest.approx(interval.half_width, rel=1e-3)


@pytest.mark.parametrize(
    ("value", "half_width", "text"),
    [
        (1.69834, 0.0142, "1.698 ± 0.014"),
        (60.03, 0.69, "60.03 ± 0.69"),
        (12345.6, 250.0, "12346 ± 250"),
        (1.5e-5, 2.5e-7, "0.00001500 ± 0.00000025"),
        (1.23456e-5, 0.0, "1.235e-05 ± 0"),
        (np.nan, np.nan, "unknown"),
        (2.0, np.nan, "2 ± unknown"),
    ],
)
def test_an_interval_is_written_with_two_digits_of_its_half_width(
    value: float, half_width: float, text: str
) -> None:
    assert str(ConfidenceInterval(value, half_width)) == text
