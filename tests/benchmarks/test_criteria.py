"""criteria.toml and the verdicts: what is read, refused, measured and judged; no solver runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import h5py
import numpy as np
import pytest

from orchestrator.case.file.errors import CaseError
from orchestrator.figures.figure import to_json
from orchestrator.output.records.history import HISTORY_FORMAT
from orchestrator.output.records.summary import SUMMARY_FORMAT, write_summary
from orchestrator.output.results.compute import compute_results
from orchestrator.output.results.quantities import Unknown, mean_of_cycles, outcome
from orchestrator.studies.criteria import (
    OVER_VALUES,
    Criterion,
    Runs,
    answer_error,
    evaluate,
    half_width,
    known_answers,
    read_criteria,
)
from orchestrator.studies.points import Point, Vary
from orchestrator.studies.verdicts import CriterionResult, judge, verdict_markdown
from tests.cases import keys_and_kinds
from tests.results.synthetic import BIN_KG, CYCLE_S, VELOCITY_M_S, folder_of

FOLDER = Path(__file__).parents[2] / "cases" / "hard"
HEAD = 'number = 1\nhappens = "a"\nexpected = "b"\n[runs.one]\n[runs.two]\n'
DONE = {"status": "done", "reason": "", "energy_ledger_J": {"lost.a": 1.0}}
ROW = '[[criteria]]\nwhat = "c"\nrun = "one"\nmeasure = "series"\nband = [0.0, 2.0]\nwhy = "d"\n'


def criterion(**given: object) -> Criterion:
    row = {"what": "c", "run": "one", "measure": "series", "band": (0.0, 2.0), "why": "d"}
    return Criterion.model_validate(row | given)


def run_in(folder: Path) -> Runs:
    return Runs((Point("", None, (), folder),))  # type: ignore[arg-type]


@pytest.fixture
def runs(tmp_path: Path) -> dict[str, Runs]:
    """Two runs: x runs from 0 to 4 in the first, and to 8 in the second; energy comes from
    nowhere in the second."""
    for number, name in enumerate(("one", "two"), start=1):
        (tmp_path / name).mkdir()
        time_s = np.arange(5.0)
        with h5py.File(tmp_path / name / "history.h5", "w") as history:
            history.attrs["format_version"] = HISTORY_FORMAT
            history["probes/p/time_s"] = time_s
            history["probes/p/position_m"] = number * time_s[:, None] * [1.0, 0.0, -1.0]
            for book, values in (("stored.a", time_s), ("supplied.b", time_s / number)):
                history[f"energy/{book}_J"] = values
            history["energy/time_s"] = time_s
        ledger = {"created.panel-frames": 0.5 * (number - 1), "lost.panel.b": 1.0}
        figures = {
            "status": "done",
            "reason": "",
            "energy_ledger_J": ledger,
            "energy_exchanged_J": {"panel-frames": 3.0},
            "n": number,
            "results": {"share_percent": {"value": 50.0, "half_width": None}},
        }
        write_summary(tmp_path / name, figures)
    return {name: run_in(tmp_path / name) for name in ("one", "two")}


@pytest.mark.parametrize(
    ("given", "value"),
    [
        ({"axis": "x", "take": "last"}, 4.0),
        ({"axis": "z", "take": "lowest"}, -4.0),
        ({"axis": "size", "take": "highest"}, 4.0 * np.sqrt(2)),
        ({"axis": "x", "take": "range", "between_s": (1.0, 3.0)}, 2.0),
        ({"axis": "x", "take": "mean"}, 2.0),
        ({"axis": "x", "take": "impulse"}, 1.0 + 2.0 + 3.0 + 4.0),
        ({"axis": "x", "compare": "ratio", "against": "two"}, 0.5),
        ({"compare": "row-by-row", "against": "two"}, 4.0),
        ({"axis": "x", "compare": "ratio", "between_s": (3, 4), "earlier_s": (0, 1)}, 4.0),
        (
            {"axis": "x", "compare": "difference", "take": "mean", "between_s": (0, 1), "earlier_s": (3, 4)},
            3.0,
        ),
        ({"run": "two", "measure": "unexplained"}, 2.0),
        ({"run": "two", "measure": "share_unexplained"}, 1.0),
        ({"run": "two", "measure": "kept"}, 2.0),
        ({"run": "two", "measure": "created"}, 0.5 / 4.0),
        ({"measure": "result", "of": "energy_ledger_J.lost.panel.b"}, 1.0),
        ({"measure": "result", "of": "energy_ledger_J.lost.panel.c"}, None),
        ({"measure": "result", "of": "n"}, 1.0),
        ({"measure": "result", "of": "results.share_percent"}, 0.5),
        ({"measure": "result", "compare": "ratio", "of": "n", "against": "two"}, 0.5),
        ({"measure": "trusted"}, 1.0),
        ({"measure": "clear"}, 1.0),
    ],
)
def test_measures(runs: dict[str, Runs], given: dict[str, object], value: float | None) -> None:
    row = criterion(**({"of": "probes/p/position_m"} | given))
    if value is None:
        with pytest.raises(Unknown, match="not known"):
            evaluate(row, runs)
        return
    assert evaluate(row, runs) == pytest.approx(value, rel=1e-12)


def test_what_is_not_there_is_unknown(runs: dict[str, Runs], tmp_path: Path) -> None:
    for given in ({"of": "probes/q/position_m"}, {"of": "probes/p/position_m", "run": "three"}):
        with pytest.raises(Unknown):
            evaluate(criterion(**given), runs | {"three": run_in(tmp_path / "three")})


@pytest.mark.parametrize(
    ("state", "trusted", "clear"), [("done", 1.0, 1.0), ("doubtful", 0.0, 0.0), ("failed", 0.0, 1.0)]
)
def test_a_run_that_is_not_to_be_trusted_has_no_number_but_that(
    runs: dict[str, Runs], state: str, trusted: float, clear: float
) -> None:
    folder = runs["one"].points[0].folder
    write_summary(folder, {"status": state, "reason": "", "n": 1})
    assert evaluate(criterion(measure="trusted"), runs) == trusted
    assert evaluate(criterion(measure="clear"), runs) == clear
    result = judge("a", criterion(measure="result", of="n"), runs)
    assert (result.measured, result.verdict) == ((1.0, "met") if state == "done" else (None, "no number"))
    assert result.value_in_words == ("1" if state == "done" else f"one: {state}")


def test_the_error_against_an_answer(runs: dict[str, Runs]) -> None:
    row = criterion(measure="result", of="results.share_percent", unit="%", reference=40.0)
    assert answer_error(row, runs["one"].points[0].folder) == pytest.approx(0.25)
    nothing = criterion(measure="result", of="m", reference=1.0)
    assert answer_error(nothing, runs["one"].points[0].folder) is None


def test_answers_are_exact_and_of_the_case_as_it_is(tmp_path: Path) -> None:
    """The answers are not those of a run that is changed, nor of one that is compared with another."""
    assert known_answers(tmp_path) == ()
    head = '[runs.one]\n[runs.two]\nsets = ["a=1"]\n'
    exact = ROW + "reference = 1.0\nexact = true\n"
    compared = exact + 'compare = "ratio"\nagainst = "two"\n'
    text = head + exact + exact.replace('run = "one"', 'run = "two"') + compared + ROW
    (tmp_path / "criteria.toml").write_text(text)
    assert len(known_answers(tmp_path)) == 1


@pytest.mark.parametrize(
    ("figures", "expected"),
    [
        ({"status": "failed", "reason": "unstable"}, "stopped"),
        ({"status": "failed", "reason": "internal error: x"}, "not run"),
        ({"status": "failed", "reason": "the computer refused: out of memory"}, "not run"),
        ({"status": "interrupted", "reason": "stopped by SIGINT"}, "not run"),
        (DONE, "stable"),
        (DONE | {"status": "doubtful"}, "warned"),
        (DONE | {"status": "incomplete"}, "stable"),
        (DONE | {"monitor": {"figures": {"growing_modes": {"times": 0}}}}, "stable"),
        (DONE | {"monitor": {"figures": {"growing_modes": {"times": 1}}}}, "warned"),
        (DONE | {"monitor": {"figures": {"deep_overlaps": {"times": 1}}}}, "stable"),
    ],
)
def test_outcomes(tmp_path: Path, figures: dict[str, object], expected: str) -> None:
    write_summary(tmp_path, figures)
    assert outcome(tmp_path) == expected
    assert outcome(tmp_path / "nowhere") == "not run"


@pytest.mark.parametrize(
    ("measured", "given", "verdict"),
    [
        (1.0, {}, "met"),
        (3.0, {}, "NOT MET"),
        (3.0, {"band": None, "ratio": (0.0, 2.0), "reference": 2.0}, "met"),
        (3.0, {"ours": "fitted"}, "fitted, OUTSIDE"),
        (3.0, {"band": None}, "not compared"),
        (None, {"band": None}, "no number"),
        (3.0, {"known_failure": "why"}, "known failure"),
        (1.0, {"known_failure": "why"}, "MET, but marked as failing"),
        (None, {}, "no number"),
        (None, {"known_failure": "why"}, "no number"),
        (None, {"ours": "fitted"}, "no number"),
    ],
)
def test_verdicts(measured: float | None, given: dict[str, object], verdict: str) -> None:
    result = CriterionResult("a", criterion(**given), measured, "not run")
    assert result.verdict == verdict
    assert result.is_good == (verdict not in ("NOT MET", "MET, but marked as failing", "no number"))
    assert verdict in verdict_markdown([result])


@pytest.mark.parametrize(
    ("measured", "half_width", "compare", "verdict"),
    [
        (0.30, 0.10, "change", "met"),
        (0.30, 0.35, "change", "chance"),  # zero lies in our interval
        (0.10, 0.15, "change", "chance"),  # outside of the band, which our interval reaches
        (0.10, 0.05, "change", "NOT MET"),
        (-0.04, 0.20, "change", "NOT MET"),  # zero lies in our interval, and nothing of the band
        (-0.04, 0.30, "growth", "chance"),
        (0.30, None, "change", "met"),
        (0.30, 0.35, "", "met"),  # no effect: zero means nothing
    ],
)
def test_an_effect_that_our_runs_cannot_tell_from_none_is_chance(
    measured: float, half_width: float | None, compare: str, verdict: str
) -> None:
    """The reference is 0.33 with an error of 0.11: the band begins at 0.22."""
    row = criterion(band=None, reference=0.33, error=0.11, compare=compare)
    result = CriterionResult("a", row, measured, half_width=half_width)
    assert result.verdict == verdict
    assert result.is_good == (verdict != "NOT MET")


@pytest.mark.parametrize(
    ("text", "kind"),
    [
        (HEAD + ROW.replace("series", "serie"), "criteria.0.measure: unknown-name"),
        (HEAD + ROW.replace('"one"', '"three"'), "criteria.0.run: unknown-name"),
        (HEAD + ROW + "bands = 3\n", "criteria.0.bands: unknown-key"),
        (HEAD, "criteria: missing"),
        (HEAD + ROW.replace("band", "ratio"), "criteria.0.ratio: missing"),
        (HEAD + ROW.replace("band = [0.0, 2.0]", "error = 1.0"), "criteria.0.error: missing"),
        (HEAD + ROW + "reference = 1.0\nerror = 1.0\n", "criteria.0: conflict"),
    ],
)
def test_a_wrong_file_is_refused(tmp_path: Path, text: str, kind: str) -> None:
    (tmp_path / "criteria.toml").write_text(text)
    with pytest.raises(CaseError) as refused:
        read_criteria(tmp_path)
    assert keys_and_kinds(refused.value.problems) == [kind]


def test_every_hard_case_is_read_and_has_its_page() -> None:
    folders = [file.parent for file in FOLDER.glob("*/criteria.toml")]
    numbers = sorted(read_criteria(case).number or 0 for case in folders)
    assert numbers == [*range(1, len(numbers) + 1)]
    for case in folders:
        page = (case / "README.md").read_text()
        assert page.startswith(f"# {case.name}\n")
        assert "**Measured" in page
    assert len(folders) == len([*FOLDER.glob("*/case.toml")])


def test_an_amplitude_is_that_of_the_cycles_it_is_asked_for(tmp_path: Path) -> None:
    """The stroke of 6 mm is halved in the second half of the run."""
    folder = folder_of(tmp_path / "run", particles=False)
    half_s = 30 * CYCLE_S
    with h5py.File(folder / "history.h5", "r+") as file:
        driven, driving = (file[f"frames/{name}/displacement_m"] for name in ("driven", "driving"))
        late = file["frames/driven/time_s"][:] > half_s
        halved_m = driving[:] + 0.5 * (driven[:] - driving[:])
        driven[:] = np.where(late[:, None], halved_m, driven[:])
    write_summary(
        folder, DONE | {"format_version": SUMMARY_FORMAT, "results": to_json(compute_results(folder))}
    )
    stroke = {"measure": "amplitude", "of": "driven-driving", "band": None}
    runs = {"one": run_in(folder)}
    early = criterion(**stroke, between_s=(0.0, half_s))
    assert evaluate(early, runs) == pytest.approx(0.006)
    late_over_early = {"compare": "ratio", "between_s": (half_s, 2 * half_s), "earlier_s": (0.0, half_s)}
    assert evaluate(criterion(**stroke, **late_over_early), runs) == pytest.approx(0.5)
    with pytest.raises(Unknown, match="shorter than a cycle"):
        evaluate(criterion(**stroke, between_s=(0.0, 0.5 * CYCLE_S)), runs)


def test_the_load_and_the_velocity_on_the_deck_are_those_of_the_time_they_are_asked_for(
    tmp_path: Path,
) -> None:
    """A deck of 638 by 200 mm; in the second half of the run its upper half is empty and the rest fast."""
    folder = folder_of(tmp_path / "run")
    half_s = 30 * CYCLE_S
    with h5py.File(folder / "history.h5", "r+") as file:
        late = file["profile/time_s"][:][:, None] > half_s
        upper = np.arange(8) < 4
        for name, then in (("mass_kg", 0.0), ("velocity_m_per_s", np.nan)):
            values = file[f"profile/{name}"]
            values[:] = np.where(late & upper, then, np.where(late & ~upper, 2 * values[:], values[:]))
    write_summary(folder, DONE | {"format_version": SUMMARY_FORMAT})
    runs = {"one": run_in(folder)}
    load = {"measure": "deck_load", "unit": "kg/m2", "band": None}
    velocity = {"measure": "deck_velocity", "unit": "m/s", "band": None}
    all_along = 8 * BIN_KG / (0.638 * 0.2)
    assert evaluate(criterion(**load), runs) == pytest.approx(all_along)
    early, then = (0.0, half_s), (half_s + 0.01, 2 * half_s)
    assert evaluate(criterion(**velocity, between_s=early), runs) == pytest.approx(VELOCITY_M_S)
    assert evaluate(criterion(**load, between_s=then), runs) == pytest.approx(all_along)
    assert evaluate(criterion(**velocity, between_s=then), runs) == pytest.approx(2 * VELOCITY_M_S)
    with pytest.raises(Unknown, match="no output time"):
        evaluate(criterion(**load, between_s=(2 * half_s + 1, 2 * half_s + 2)), runs)


def test_each_part_of_a_series_has_the_scatter_of_its_own_time(runs: dict[str, Runs]) -> None:
    """The value x scatters over the runs by a row's number: not at all in the first row, but in the last
    one."""
    seeds = {"seeds": Runs((*runs["one"].points, *runs["two"].points))}
    given = {"of": "probes/p/position_m", "axis": "x", "scatter": "seeds", "compare": "difference"}
    row = criterion(**given, between_s=(4.0, 4.0), earlier_s=(0.0, 0.0))
    width = 12.706 * np.std([4.0, 8.0], ddof=1)  # Student, one degree of freedom
    assert half_width(row, runs | seeds) == pytest.approx(width, rel=1e-4)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ({"compare": "change", "between": (5.0, 6.0)}, "no run has a value from 5 to 6"),
        ({"between": (5.0, 6.0)}, "no run has a value from 5 to 6"),
        ({"compare": "lowest-at"}, "the least number is at the end of the values, 1"),
    ],
)
def test_too_few_values_of_a_varied_key_are_unknown(
    runs: dict[str, Runs], given: dict[str, object], message: str
) -> None:
    points = [replace(of.points[0], value=value) for of, value in zip(runs.values(), "12", strict=True)]
    varied = {"one": Runs(tuple(points), Vary("n", ("1", "2")))}
    result = judge("a", criterion(measure="result", of="n", **given), varied)
    assert (result.measured, result.verdict) == (None, "no number")
    assert message in result.value_in_words


def test_the_place_of_a_minimum_is_that_of_the_parabola(runs: dict[str, Runs]) -> None:
    """3 + 2 (x - 2.3)^2 at the values 1 to 4 is least at 2.3."""
    (point,) = runs["one"].points
    chosen = Runs(tuple(replace(point, value=value) for value in "1234"))
    numbers = 3.0 + 2.0 * (chosen.values - 2.3) ** 2
    assert OVER_VALUES["lowest-at"](numbers, chosen) == pytest.approx(2.3)


def test_the_mean_of_cycles_counts_the_last_one() -> None:
    """Four cycles of ten rows, with the row at their start; the last one has another peak."""
    time_s, values = np.linspace(1.0, 5.0, 41), np.ones(41)
    values[-3] = 101.0
    assert mean_of_cycles(np.max, values, time_s, 1.0) == pytest.approx(26.0)
