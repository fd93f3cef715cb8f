"""The course of a study: the order of its stages, its time, its failures, and how it is taken up again."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.file.folder import FolderUnusable
from orchestrator.studies.design.campaign import NEAR_A_FAILURE, Campaign, explained, planned_settings
from orchestrator.studies.design.findings import Findings
from orchestrator.studies.design.page import answers, doubts
from orchestrator.studies.design.study import DesignStudy
from orchestrator.studies.design.study_file import Study
from orchestrator.studies.design.surrogates import TooFewPoints
from orchestrator.studies.design.tables import write_tables
from orchestrator.studies.design.trials import Measured, Outcome, Trial
from orchestrator.studies.points import Crew
from tests.design.campaigns import Killed, NoisyFunction, belt, belt_truth, campaign, run_all

TABLES = ("points.csv", "costs.csv", "fit.json", "front.csv", "best.csv", "effects.csv")


def stages(whole: Campaign) -> list[str]:
    """Return the stages of all outcomes, in the order in which they ended."""
    return [outcome.trial.stage for outcome in whole.outcomes]


def searched(whole: Campaign) -> list[Trial]:
    """Return the trials of the search."""
    return [outcome.trial for outcome in whole.outcomes if outcome.trial.stage == "search"]


def the_answer(whole: Campaign) -> str:
    """Return the only answer of a study."""
    (sentence,) = answers(Findings(whole))
    return sentence


def test_the_centre_is_run_first_then_the_plan_the_search_and_the_best_again(tmp_path: Path) -> None:
    whole = run_all(belt(tmp_path), tmp_path)
    kinds = [*["centre"], *["plan"] * 7, *["plan"], *["search"] * 3]
    assert stages(whole)[: len(kinds)] == kinds
    assert set(stages(whole)[len(kinds) :]) == {"confirm"}
    centres = [each.trial for each in whole.outcomes if not any(each.trial.setting)]
    assert [trial.stage for trial in centres][:2] == ["centre", "plan"]
    assert [each.trial.number for each in whole.outcomes] == list(range(1, len(whole.outcomes) + 1))


def test_design_alone_ends_with_the_plan(tmp_path: Path) -> None:
    whole = campaign(belt(tmp_path), tmp_path)
    list(whole.run(search=False))
    assert stages(whole) == ["centre", *["plan"] * 8]
    assert whole.trials_left(search=False) == 0
    assert (
        whole.trials_left(search=True) == 3 + 4
    )  # of the search, and two runs each of the best and the centre


def test_a_study_without_goals_ends_with_the_plan(tmp_path: Path) -> None:
    whole = run_all(belt(tmp_path, **{"goals": [], "limits": [], "search/runs": 0}), tmp_path)
    assert stages(whole) == ["centre", *["plan"] * 8]


def test_runs_at_the_cheap_level_come_before_the_plan(tmp_path: Path) -> None:
    whole = run_all(belt(tmp_path, cheap={"level": "draft", "runs": 12}), tmp_path)
    assert stages(whole)[:14] == ["centre", *["cheap"] * 12, "plan"]
    assert len(whole.data().x) == len(whole.outcomes) - 12


def test_seeds_differ_from_run_to_run_and_are_equal_for_what_is_compared(tmp_path: Path) -> None:
    whole = run_all(belt(tmp_path, simpler={"stroke": "slope / 5"}), tmp_path)
    before = [each.trial.seed for each in whole.outcomes if each.trial.stage != "confirm"]
    assert len(set(before)) == len(before)
    seeds: dict[str, list[int]] = {}
    for each in whole.outcomes:
        if each.trial.stage == "confirm":
            seeds.setdefault(each.trial.role, []).append(each.trial.seed)
    assert list(seeds) == ["best", "simpler", "centre"]
    assert seeds["best"] == seeds["simpler"] == seeds["centre"]
    assert len(set(seeds["best"])) == len(seeds["best"]) >= 2
    assert not set(seeds["best"]) & set(before)


def test_a_simpler_design_keeps_its_formulas(tmp_path: Path) -> None:
    study = belt(tmp_path, simpler={"stroke": "slope / 5"})
    whole = run_all(study, tmp_path)
    (simpler,) = {each.trial.setting for each in whole.outcomes if each.trial.role == "simpler"}
    actual = study.actual(np.array(simpler))
    assert actual["stroke"] == pytest.approx(actual["slope"] / 5)
    difference = Findings(whole).against("best", "simpler", 0)
    assert difference is not None
    assert difference.value > 0.05


def tables(whole: Campaign, folder: Path) -> dict[str, bytes]:
    """Return the tables of a study as they are written."""
    list(write_tables(Findings(whole), folder))
    return {name: (folder / name).read_bytes() for name in TABLES if (folder / name).is_file()}


FIT = 1e-4
"""Relative tolerance of what a Gaussian process predicts.

Its likelihood is the same to the last digit only where the sums of the libraries are: one of some twenty
fits with all left-out points had a value with another rounding (scikit-learn 1.9, NumPy 1.24, the same
process and data), and the maximum, which is flat, moved predictions by up to 2e-7.
"""


def same_but_for_the_fit(some: bytes, other: bytes) -> bool:
    """Tell whether tables have the same words, and numbers that agree to the tolerance of a fit."""
    number = re.compile(r"(-?\d+\.?\d*(?:e[-+]?\d+)?)")
    parts = zip(number.split(some.decode()), number.split(other.decode()), strict=True)
    return all(
        float(first) == pytest.approx(float(second), rel=FIT, abs=1e-6) if k % 2 else first == second
        for k, (first, second) in enumerate(parts)
    )


def assert_same_trials(some: Campaign, other: Campaign) -> None:
    """Everything is the same to the last digit, but the predictions that were written down beside it."""

    def without_predictions(whole: Campaign) -> list[Outcome]:
        return [replace(each, trial=replace(each.trial, predicted={})) for each in whole.outcomes]

    assert without_predictions(some) == without_predictions(other)
    for first, second in zip(some.outcomes, other.outcomes, strict=True):
        assert list(first.trial.predicted) == list(second.trial.predicted)
        for name, predicted in first.trial.predicted.items():
            assert predicted[:2] == pytest.approx(second.trial.predicted[name][:2], rel=FIT, abs=1e-6)
            assert predicted[2:] == second.trial.predicted[name][2:]


SURROGATES = ["quadratic", pytest.param("gaussian-process", marks=pytest.mark.slow)]


@pytest.mark.parametrize("surrogate", SURROGATES)
def test_a_study_that_is_ended_at_any_moment_goes_on_to_the_same_tables(
    surrogate: str, tmp_path: Path
) -> None:
    """Ten moments: between two runs, and in the middle of a run; some of the studies are ended twice."""
    study = belt(tmp_path, **{"search/surrogate": surrogate, "limits": ["share >= 50, 65"]})
    undisturbed = run_all(study, tmp_path / "undisturbed")
    wanted = tables(undisturbed, tmp_path / "undisturbed")
    assert set(wanted) == set(TABLES)
    rng = np.random.default_rng(5)
    for number, moment in enumerate(rng.choice(len(undisturbed.outcomes) - 1, 10, replace=False) + 1):
        folder, store = tmp_path / str(number), dict[str, Outcome]()
        if number % 2:
            run = campaign(study, folder, store=store).run()
            for _ in range(moment):
                next(run)
            run.close()
        for end in (moment, min(moment + 2, len(undisturbed.outcomes))) if not number % 2 else ():
            with pytest.raises(Killed):
                run_all(study, folder, store=store, killed_in=end)
        again = run_all(study, folder, store=store)
        assert_same_trials(again, undisturbed)
        if number < 2:
            written = tables(again, folder)
            assert set(written) == set(wanted)
            assert all(same_but_for_the_fit(written[name], wanted[name]) for name in wanted)
        assert isinstance(again.evaluator, NoisyFunction)
        assert len(again.evaluator.made) + moment <= len(undisturbed.outcomes) + 1


def test_a_trial_is_written_down_before_its_run_begins(tmp_path: Path) -> None:
    def wall_s(trial: Trial) -> float:
        assert (tmp_path / "runs" / f"{trial.name}.trial.json").is_file()
        return 60.0

    run_all(belt(tmp_path), tmp_path, wall_s=wall_s)


def test_a_finished_study_runs_nothing_more(tmp_path: Path) -> None:
    study, store = belt(tmp_path), dict[str, Outcome]()
    first = run_all(study, tmp_path, store=store)
    again = run_all(study, tmp_path, store=store)
    assert isinstance(again.evaluator, NoisyFunction)
    assert not again.evaluator.made
    assert len(again.outcomes) == len(first.outcomes)


def test_trials_that_another_process_wrote_meanwhile_are_known(tmp_path: Path) -> None:
    """A second study is opened while the first one runs, and runs when that one has ended."""
    study, store = belt(tmp_path), dict[str, Outcome]()
    second = campaign(study, tmp_path, store=store)
    first = run_all(study, tmp_path, store=store)
    list(second.run())
    assert second.outcomes == first.outcomes
    assert isinstance(second.evaluator, NoisyFunction)
    assert not second.evaluator.made


def test_replicates_without_any_scatter_stop_no_study(tmp_path: Path) -> None:
    """A case without random numbers gives the same at each setting, at both levels."""
    study = belt(tmp_path, **{"cheap": {"level": "draft", "runs": 9}, "search/surrogate": "gaussian-process"})
    whole = run_all(study, tmp_path, noise={})
    assert (whole.data().variance < 1e-12).all()
    assert Findings(whole).is_confirmed()


def test_a_search_that_is_made_longer_goes_on_and_measures_its_new_best(tmp_path: Path) -> None:
    store: dict[str, Outcome] = {}
    short = belt(tmp_path, **{"search/runs": 1, "plan/runs": 6, "search/optimiser": "sobol"})
    run_all(short, tmp_path, store=store, noise={"speed": 0.05, "share": 3.0})
    longer = belt(tmp_path, **{"search/runs": 6, "plan/runs": 6, "search/optimiser": "sobol"})
    whole = run_all(longer, tmp_path, store=store, noise={"speed": 0.05, "share": 3.0})
    assert len(searched(whole)) == 6
    best = whole.candidates()["best"]
    measured = [each for each in Findings(whole).confirmed if each.role == "best"]
    assert len(measured) == 1
    assert measured[0].setting == pytest.approx(best)
    assert measured[0].runs >= 2


def test_time_in_which_workers_have_nothing_to_do_counts(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Runs of a minute, of which one is begun in 150 s: 24 of them fit into an hour, not 60."""
    now_s = iter(range(0, 10**9, 150))
    monkeypatch.setattr("orchestrator.studies.design.campaign.time.monotonic", lambda: float(next(now_s)))
    whole = run_all(belt(tmp_path, **{"hours": 1.0, "search/runs": None}), tmp_path)
    assert 20 <= len(whole.outcomes) <= 24


@pytest.mark.parametrize("hours", [0.2, 0.35, 0.6, 1.0])
@pytest.mark.parametrize("spread", [0.0, 0.5])
def test_the_hours_are_kept_within_one_run(hours: float, spread: float, tmp_path: Path) -> None:
    """A run takes 60 s, or 30 to 90 s."""

    def wall_s(trial: Trial) -> float:
        return 60.0 * (1.0 + spread * math.sin(trial.number))

    study = belt(tmp_path, **{"hours": hours, "search/runs": None})
    whole = run_all(study, tmp_path, wall_s=wall_s)
    spent_s = sum(each.wall_s for each in whole.outcomes)
    longest_s = max(each.wall_s for each in whole.outcomes)
    assert spent_s <= 3600 * hours + longest_s
    searched_s = sum(each.wall_s for each in whole.outcomes if each.trial.stage != "confirm")
    assert searched_s <= 0.8 * 3600 * hours + longest_s
    if hours > 0.3:
        assert {"search", "confirm"} <= set(stages(whole))
        again = campaign(study, tmp_path)
        list(again.run(search=False))
        assert whole.planned_left == again.planned_left == 0  # though the latter has no outcome of the search
        assert searched_s >= 0.8 * 3600 * hours - 2 * longest_s


def test_hours_that_do_not_suffice_for_the_plan_end_it(tmp_path: Path) -> None:
    whole = run_all(belt(tmp_path, hours=0.1), tmp_path)
    assert 1 < len(whole.outcomes) <= 6
    assert "search" not in stages(whole)
    assert "support no optimum" in the_answer(whole)


@pytest.mark.parametrize(("goals", "made"), [(["maximise speed"], 5), ([], 6)])
def test_planned_runs_that_do_not_fit_into_the_hours_are_told(
    goals: list[str], made: int, tmp_path: Path
) -> None:
    """Runs of a minute in 396 s, of which a fifth is kept for confirming runs where there is a goal."""
    study = belt(tmp_path, hours=0.11, goals=goals, **{"search/runs": 0})
    whole = campaign(study, tmp_path)
    whole.read_trials()
    assert whole.beyond_hours(60.0) == 9 - made
    list(whole.run(search=False))
    assert len(whole.outcomes) == made
    assert whole.beyond_hours(60.0) == 9 - made
    design = DesignStudy(study, Crew(), tmp_path)
    design.campaign = whole
    assert design._time_left(search=False) == ""
    again = design.campaign = campaign(study, tmp_path)
    assert not any(" left" in design._line(outcome, search=False) for outcome in again.run(search=False))
    doubt = next(doubts(Findings(whole)))
    assert doubt.startswith(f"{9 - made} of 9 planned runs are not made: flipflow study design makes them as")
    assert doubt.endswith("; all need more hours.")


def steep(x: Mapping[str, float]) -> str:
    """Fail where the belt would be best."""
    return "the bed jams" if x["slope"] > 22 and x["stroke"] < 4 else ""


@pytest.mark.parametrize("optimiser", ["expected-improvement", "whale", "gradient", "sobol"])
def test_a_setting_that_failed_is_no_datum_and_nothing_near_it_is_proposed_again(
    optimiser: str, tmp_path: Path
) -> None:
    """The best settings are in a part of the space where all runs fail."""
    study = belt(tmp_path, **{"plan/runs": 12, "search/runs": 8, "search/optimiser": optimiser})
    whole = run_all(study, tmp_path, failing=steep)
    failed = [each.trial for each in whole.outcomes if not each.is_data]
    assert {each.why for each in whole.outcomes if not each.is_data} == {"the bed jams"}
    assert not set(whole.data().numbers) & {trial.number for trial in failed}
    assert any(trial.stage == "plan" for trial in failed)
    for trial in searched(whole):
        before = [each.setting for each in failed if each.number < trial.number]
        distance = np.abs(np.array(before) - trial.setting).max(axis=1).min()
        assert distance > NEAR_A_FAILURE, f"trial {trial.number} of {optimiser}"


def test_a_best_setting_whose_runs_fail_is_not_measured(tmp_path: Path) -> None:
    store: dict[str, Outcome] = {}
    study = belt(tmp_path)
    before = campaign(study, tmp_path, store=store)
    list(zip(range(12), before.run(), strict=False))
    best = study.actual(before.candidates()["best"])
    whole = run_all(study, tmp_path, store=store, failing=lambda x: "jams" if x == best else "")
    assert study.actual(whole.candidates()["best"]) == best
    assert "NOT measured: its runs gave no data (jams)" in the_answer(whole)
    assert not Findings(whole).is_confirmed()


def test_a_study_half_of_whose_runs_failed_states_no_optimum(tmp_path: Path) -> None:
    study = belt(tmp_path, **{"plan/runs": 16})
    whole = run_all(study, tmp_path, failing=lambda x: "jams" if x["slope"] < 22 else "")
    assert whole.candidates() == {}
    assert "confirm" not in stages(whole)
    answer = the_answer(whole)
    assert "support no optimum" in answer
    assert "runs gave no data" in answer
    assert not Findings(whole).is_confirmed()


def test_noise_has_no_optimum_and_it_is_said_what_it_would_take(tmp_path: Path) -> None:
    study = belt(tmp_path, **{"plan/runs": 16, "search/surrogate": "gaussian-process"})
    noise = {"speed": 1.0, "share": 0.5}
    whole = run_all(study, tmp_path, truth=lambda x: belt_truth(x) | {"speed": 5.0}, noise=noise)
    answer = the_answer(whole)
    assert "confirm" not in stages(whole)
    assert "of the variance of speed, and 50 % is needed" in answer
    assert "times as many runs" in answer
    assert np.isfinite(whole.data().y).all()


@pytest.mark.parametrize("deviation", [None, 0.1], ids=["noise unknown", "noise known"])
def test_a_goal_that_nothing_changes_has_no_optimum(deviation: float | None, tmp_path: Path) -> None:
    constant = {"noise": {"speed": 0.0, "share": 0.5}, "deviations": {"speed": deviation}}
    whole = run_all(belt(tmp_path), tmp_path, truth=lambda x: belt_truth(x) | {"speed": 5.0}, **constant)
    assert "confirm" not in stages(whole)
    assert "support no optimum" in the_answer(whole)


def test_a_run_that_keeps_a_limit_by_luck_is_no_proof(tmp_path: Path) -> None:
    """94 % can be reached at most; one run with a noise of 30 points says 130."""
    whole = run_all(belt(tmp_path), tmp_path)
    number = next(i for i, each in enumerate(whole.outcomes) if each.trial.stage == "plan")
    lucky = {**whole.outcomes[number].responses, "share": Measured(130.0, 30.0)}
    whole.outcomes[number] = replace(whole.outcomes[number], responses=lucky)
    study = belt(tmp_path, **{"limits": ["share >= 120"], "search/surrogate": "gaussian-process"})
    asked = Campaign(study, whole.evaluator, whole.journal, whole.outcomes)
    assert asked.why_no_optimum(asked.study.aim)


def test_a_limit_that_is_kept_nowhere_is_named_with_the_nearest_run(tmp_path: Path) -> None:
    whole = run_all(belt(tmp_path, limits=["share >= 99"]), tmp_path)
    assert "confirm" not in stages(whole)
    answer = the_answer(whole)
    assert "no setting is expected to keep all limits" in answer
    data = whole.data()
    assert f"{data.y[:, 1].max():.4g}" in answer


def test_no_longer_runs_are_advised_where_noise_is_not_why_nothing_is_explained(tmp_path: Path) -> None:
    """The speed goes up and down within the ranges more often than there are runs."""

    def truth(x: Mapping[str, float]) -> dict[str, float]:
        return {"speed": float(np.sin(9.0 * x["slope"])), "share": 70.0}

    answer = the_answer(run_all(belt(tmp_path), tmp_path, truth=truth))
    assert "longer" in answer.split()
    assert "times" not in answer.split()  # as many runs


def test_nothing_is_explained_of_a_response_that_is_constant_but_for_rounding() -> None:
    y = np.full(20, 0.1 + 0.2)
    assert y.mean() != y[0]
    assert explained(y, y + 2e-16) == 0.0


def test_several_values_of_a_limit_give_several_best_settings(tmp_path: Path) -> None:
    study = belt(tmp_path, limits=["share >= 50, 60, 70"], confidence=0.99)
    whole = run_all(study, tmp_path)
    best = Findings(whole).best
    assert list(best) == ["share >= 50", "share >= 60", "share >= 70"]
    speeds = [belt_truth(study.actual(setting))["speed"] for setting in best.values()]
    assert speeds == sorted(speeds, reverse=True)
    roles = {each.trial.role for each in whole.outcomes if each.trial.stage == "confirm"}
    assert roles == {"centre", *(f"best, {name}" for name in best)}
    assert len(list(answers(Findings(whole)))) == 3
    assert Findings(whole).is_confirmed()


def test_two_goals_give_a_front(tmp_path: Path) -> None:
    study = belt(
        tmp_path,
        **{
            "goals": ["maximise speed", "maximise share"],
            "limits": [],
            "search/surrogate": "gaussian-process",
        },
    )
    findings = Findings(run_all(study, tmp_path))
    front = [belt_truth(study.actual(setting)) for setting in findings.front]
    speed, share = (np.array([each[name] for each in front]) for name in ("speed", "share"))
    assert len(front) > 10
    assert (np.diff(speed) > -0.02).all()
    assert (np.diff(share) < 2.0).all()
    assert speed[-1] > 2.1
    assert share[0] > 90
    assert "For the largest speed alone (front.csv trades it for the largest share)" in next(
        answers(findings)
    )


def test_a_goal_that_is_turned_round_is_not_answered_by_old_measurements(tmp_path: Path) -> None:
    store: dict[str, Outcome] = {}
    run_all(belt(tmp_path), tmp_path, store=store)
    slow = belt(tmp_path, goals=["minimise speed"])
    fitted = campaign(slow, tmp_path, store=store)
    fitted.outcomes = list(store.values())
    assert "not yet measured" in the_answer(fitted)
    whole = run_all(slow, tmp_path, store=store)
    answer = the_answer(whole)
    assert "For the smallest speed" in answer
    assert "as predicted" in answer
    assert belt_truth(slow.actual(Findings(whole).best[""]))["speed"] < 0.6


def ranges(study: Study, low: float, high: float, folder: Path) -> Study:
    """Return the study with another range of the slope."""
    return belt(folder, **{"factors/slope/range": [low, high]})


@pytest.mark.parametrize(("low", "high"), [(12.0, 22.0), (5.0, 35.0)], ids=["narrower", "wider"])
def test_runs_of_other_ranges_stay_data(low: float, high: float, tmp_path: Path) -> None:
    store: dict[str, Outcome] = {}
    study = belt(tmp_path)
    before = run_all(study, tmp_path, store=store)
    other = ranges(study, low, high, tmp_path)
    whole = run_all(
        belt(tmp_path, **{"factors/slope/range": [low, high], "search/runs": 6}), tmp_path, store=store
    )
    assert len(whole.data().x) > len(before.data().x)
    by_number = {each.trial.number: each for each in whole.outcomes}
    for old in before.outcomes:
        new = by_number[old.trial.number]
        if old.trial.stage != "confirm":
            assert other.actual(np.array(new.trial.setting)) == pytest.approx(
                study.actual(np.array(old.trial.setting))
            )
            assert new.trial.values == old.trial.values
    planned = {tuple(each.trial.setting) for each in whole.outcomes if each.trial.stage == "plan"}
    assert {tuple(setting) for setting in planned_settings(other)} <= planned
    for trial in searched(whole)[3:]:
        assert (np.abs(trial.setting) <= 1.0).all()
    best = other.actual(Findings(whole).best[""])
    assert low - 1e-9 <= best["slope"] <= high + 1e-9
    assert Findings(whole).is_confirmed()


def test_a_folder_with_trials_of_other_factors_is_refused(tmp_path: Path) -> None:
    run_all(belt(tmp_path), tmp_path)
    other = belt(
        tmp_path,
        **{"factors/stroke": None, "factors/mass": {"range": [1.0, 2.0]}, "set/screen.stroke_m": "mass"},
    )
    with pytest.raises(FolderUnusable, match=r"stroke.*mass.*--out"):
        run_all(other, tmp_path)


def test_a_cheap_level_without_data_ends_the_search(tmp_path: Path) -> None:
    study = belt(tmp_path, cheap={"level": "draft", "runs": 4})
    whole = campaign(study, tmp_path)
    cheap = [Outcome(Trial(n, "cheap", (0.0, 0.0), 0), "failed", "on purpose") for n in range(4)]
    whole.outcomes = [Outcome(Trial(9, "plan", (0.0, 0.0), 0), "done", "", {"speed": Measured(1.0)})]
    whole.outcomes += cheap
    with pytest.raises(TooFewPoints, match="cheap"):
        whole.fit()
