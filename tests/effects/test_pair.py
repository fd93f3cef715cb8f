"""Runs with and without an effect: what counts as a change, the memory, and what is shared."""

from __future__ import annotations

import math
import os
from pathlib import Path
from typing import Any

import pytest
from typer.testing import CliRunner

from orchestrator.cli.main import app
from orchestrator.figures.short_names import SHORT_NAMES, Value, named
from orchestrator.output.subprocesses import python
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.judgement import pair
from orchestrator.preflight.judgement.pair import Pair, compute_change, key_of, recall, remember, share_pairs
from orchestrator.preflight.judgement.weighing import measured_verdict
from orchestrator.preflight.scene.effect import Verdict
from orchestrator.run.trials import pairs
from orchestrator.run.trials.pairs import try_effects
from tests.cases import CASE, case_folder, load_case, loaded

SHORT = "duration_s=0.02"


def summary(**values: float) -> dict[str, Any]:
    """Return the summary of a run whose bed figures are ``values``."""
    bed = {name: {"value": value, "half_width": None} for name, value in values.items()}
    return {"status": "done", "processor_s": 1.0, "results": {"bed": bed}}


@pytest.fixture(autouse=True)
def own_memory(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))


def test_a_change_is_relative_to_the_value_with_the_effect() -> None:
    """1.5 instead of 11.8 mm is 87 % off; 32.5 instead of 3.43 mm is 848 % off."""
    for with_it, without, percent in ((11.8e-3, 1.5e-3, 87), (3.43e-3, 32.5e-3, 848)):
        change = compute_change(Value(with_it), Value(without), 1e-6)
        assert change.relative is not None
        assert round(100 * change.relative) == percent
        assert change.matters is True


def test_what_neither_run_resolves_is_no_change_and_what_one_run_lacks_is_all_of_it() -> None:
    assert compute_change(Value(1e-12), Value(4e-12), 1e-6).relative is None
    assert compute_change(None, None, 1e-6).relative is None
    lost = compute_change(Value(80.0), None, 0.1)
    assert (lost.relative, lost.matters) == (math.inf, True)


def test_chance_makes_a_change_near_the_threshold_unknown() -> None:
    near = compute_change(Value(10.0, 0.5), Value(10.8, 0.5), 0.1)
    assert near.matters is None
    assert compute_change(Value(10.0, 0.01), Value(10.8, 0.01), 0.1).matters is False
    assert compute_change(Value(10.0, 0.5), Value(13.0, 0.5), 0.1).matters is True


def test_a_small_change_of_the_particles_clears_nothing_without_an_interval() -> None:
    """Other seeds change the velocity of the draft by 4 %: nobody knows what chance did of 0.387 and
    0.4 m/s.  The motion of the frames has no chance, and neither have equal runs."""

    def motion(stroke_m: float, velocity_m_per_s: float) -> dict[str, Any]:
        table = summary(velocity_m_per_s=velocity_m_per_s)
        return table | {
            "results": table["results"] | {"motion": {"relative": {"a-b": {"along_m": stroke_m}}}}
        }

    def verdict(stroke_m: float, velocity_m_per_s: float, *asked: str) -> tuple[bool | None, str]:
        sides = motion(0.006, 0.387), motion(stroke_m, velocity_m_per_s)
        tried = Pair("panel-damping", summary_with=sides[0], summary_without=sides[1])
        measured = measured_verdict(Verdict("", None, "", None, ""), tried, asked)
        return measured.matters, measured.why

    unknown = "measured: velocity 0.387 with it, 0.4 without, chance unknown"
    assert verdict(0.006, 0.4, "velocity") == (None, unknown)
    assert verdict(0.0055, 0.4, "stroke", "velocity") == (None, unknown)
    assert verdict(0.0055, 0.4, "stroke")[0] is False
    assert verdict(0.0055, 0.387, "stroke", "velocity")[0] is False
    assert verdict(0.006, 0.5, "velocity")[0] is True
    assert named("results.held.stickers").figure.part == "particles"
    assert named("results.power.drives_W").figure.part == "frames"


def test_results_have_one_table_of_names_and_paths_besides() -> None:
    table = summary(velocity_m_per_s=0.4)
    assert named("velocity").of(table) == Value(0.4)
    assert named("results.bed.velocity_m_per_s").of(table) == Value(0.4)
    assert named("efficiency").of(table) is None
    assert all(quantity.words for quantity in SHORT_NAMES.values())
    with pytest.raises(KeyError, match='did you mean "efficiency"'):
        named("eficiency")
    with pytest.raises(KeyError, match='did you mean "cycle_peak_g"'):
        named("peak_g")


def test_the_stroke_is_of_two_frames_or_of_the_only_one() -> None:
    of_frame = {"results": {"motion": {"frames": {"a": {"amplitude_m": [0.003, 0, 0]}}}}}
    assert named("stroke").of(of_frame) == Value(0.003)
    along = {"value": 0.006, "half_width": 0.001}
    of_pair = {
        "results": {"motion": of_frame["results"]["motion"] | {"relative": {"a-b": {"along_m": along}}}}
    }
    assert named("stroke").of(of_pair) == Value(0.006, 0.001)


def test_a_pair_is_remembered_by_what_the_case_was_read_from(tmp_path: Path) -> None:
    folder = case_folder(tmp_path / "case", CASE)
    read = load_judged(folder).origin.read()
    assert recall(key_of(read, "adhesion")) is None
    remember(key_of(read, "adhesion"), Pair("adhesion", "draft", ("a=1",), "", 2.0))
    assert recall(key_of(read, "adhesion")) == Pair("adhesion", "draft", ("a=1",), "", 2.0)
    other = load_judged(folder, None, ["duration_s=0.04"]).origin.read()
    assert key_of(other, "adhesion") != key_of(read, "adhesion")
    asked = load_judged(folder, None, ["effects=auto"]).origin.read()
    assert key_of(asked, "adhesion") == key_of(read, "adhesion")


def test_the_run_with_everything_is_made_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Two effects take three runs, and none when they are asked for again."""
    made: list[tuple[str, ...]] = []

    def run(path: Path, level: str, sets: tuple[str, ...], *rest: Any) -> dict[str, Any]:
        made.append(sets)
        return summary(velocity_m_per_s=0.4 if len(made) == 1 else 0.2)

    monkeypatch.setattr(pairs, "_run", run)
    case = loaded(tmp_path, (SHORT,))
    for effect in ("sliding-friction", "particle-load"):
        tried = pairs.Pairs().of(case, effect)
        assert tried.refused == ""
    assert len(made) == 4, "two engines share no runs"
    engine = pairs.Pairs(forget=True)
    made.clear()
    for effect in ("sliding-friction", "particle-load"):
        engine.of(case, effect)
    assert len(made) == 3
    assert pairs.Pairs().of(case, "particle-load").change("velocity") is not None
    assert len(made) == 3, "remembered"


def test_a_pair_that_would_take_too_long_is_refused_and_says_why(tmp_path: Path) -> None:
    case = loaded(tmp_path, ("duration_s=4.0",))
    tried = pairs.Pairs(limit_s=0.01).of(case, "particle-load")
    assert "a trial run takes about" in tried.refused
    assert tried.change("velocity") is None


def test_the_budget_holds_also_for_what_was_refused_with_a_smaller_one(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A remembered refusal is asked again with more time, and that costs as much as any run: the
    budget lasts for the run as it is and one without an effect, not for all three."""
    case = loaded(tmp_path, ("duration_s=4.0",))
    names = ("sliding-friction", "particle-load")
    small = pairs.Pairs(limit_s=0.01)
    assert all(small.of(case, name).refused for name in names)
    clock_s = iter(range(0, 1000, 10))
    monkeypatch.setattr(pairs, "_processor_time_of_children_s", lambda: float(next(clock_s)))
    monkeypatch.setattr(pairs, "_run", lambda *_: summary(velocity_m_per_s=0.4))
    monkeypatch.setattr(pairs, "predicted_s", lambda *_: 6.0)
    trials = try_effects(case, names, pairs.Pairs(limit_s=30.0, budget_s=17.0))
    assert (trials.pairs[names[0]].refused, trials.omitted) == ("", names[1:])
    assert trials.spent_s == 20.0


def test_no_run_is_made_that_would_take_more_than_is_left(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(pairs, "_run", lambda *_: pytest.fail("it was run"))
    monkeypatch.setattr(pairs, "predicted_s", lambda *_: 6.0)
    trials = try_effects(loaded(tmp_path), ("particle-load",), pairs.Pairs(limit_s=30.0, budget_s=5.0))
    assert (trials.pairs, trials.omitted) == ({}, ("particle-load",))


@pytest.mark.process
def test_a_run_is_ended_when_the_budget_is_used(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The run is ended however short it was predicted to be: 50 s of simulated time in a second of
    processor time."""
    case = loaded(tmp_path, ("duration_s=50.0",))
    monkeypatch.setattr(pairs, "predicted_s", lambda *_: 0.5)
    trials = try_effects(case, ("particle-load",), pairs.Pairs(limit_s=30.0, budget_s=1.0))
    assert "took more than 1 s of processor time and was ended" in trials.pairs["particle-load"].refused
    assert trials.spent_s < 3.0


@pytest.mark.parametrize(("words", "limit_s"), [((), 75.0), (("--budget", "5"), 1.25)])
def test_a_run_gets_a_quarter_of_the_budget(
    words: tuple[str, ...], limit_s: float, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A run gets no more than that, however little it is."""
    asked: list[pairs.Pairs] = []

    def try_all(case: object, engine: pairs.Pairs) -> pairs.TriedEffects:
        asked.append(engine)
        return pairs.TriedEffects({})

    monkeypatch.setattr(pairs, "try_all_effects", try_all)
    case = str(case_folder(tmp_path / "case", CASE))
    done = CliRunner().invoke(app, ["explain", case, "--for", "velocity", *words])
    assert done.exit_code == 0, done.output
    assert [engine.limit_s for engine in asked] == [limit_s]
    help_text = CliRunner().invoke(app, ["explain", "--help"]).output
    assert "a quarter of it" in " ".join(help_text.replace("│", " ").split())


def test_an_effect_that_the_case_does_not_have_is_refused(tmp_path: Path) -> None:
    tried = pairs.Pairs().of(loaded(tmp_path, (SHORT,)), "adhesion")
    assert "adhesion" in tried.refused
    assert tried.change("velocity") is None


def test_a_trial_of_a_rank_is_a_program_of_one_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """The trial would otherwise wait for the other ranks of the run that asks for it."""
    for name in [name for name in os.environ if name.startswith("OMPI")]:
        monkeypatch.delenv(name)
    monkeypatch.setenv("OMPI_COMM_WORLD_SIZE", "2")
    asks = "import os; print(sorted(name for name in os.environ if name.startswith('OMPI')))"
    assert python("-c", asks, capture_output=True).stdout.strip() == "['OMPI_COMM_WORLD_SIZE']"
    assert python("-c", asks, alone=True, capture_output=True).stdout.strip() == "[]"


def test_ranks_agree_on_what_the_first_one_remembers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The memory of another rank does not count."""
    monkeypatch.setattr(pair, "_AGREED", {})
    read = load_case(tmp_path / "agreed", CASE).origin.read()
    mine, agreed = key_of(read, "wear"), key_of(read, "adhesion")
    remember(mine, Pair("wear"))
    share_pairs({mine: None, agreed: Pair("adhesion")})
    assert recall(mine) is None
    assert recall(agreed) == Pair("adhesion")


def test_explain_for_a_result_gives_its_change(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The cheapest of the effects that an estimate surely leaves out is tried; the rest is by two runs
    each, of which the one with everything is made once; asked again, nothing is run."""
    made: list[tuple[str, ...]] = []

    def run(path: Path, level: str, sets: tuple[str, ...], *rest: Any) -> dict[str, Any]:
        made.append(sets)
        without = "sliding-friction" not in sets[-1]
        return summary(velocity_m_per_s=0.5 if without else 0.4)

    monkeypatch.setattr(pairs, "_run", run)
    words = ["explain", str(case_folder(tmp_path / "case", CASE)), "--for", "velocity"]
    words += ["--set", "contacts.0.work_of_adhesion_J_per_m2=1e-6"]
    done = CliRunner().invoke(app, [*words, "--set", SHORT])
    assert done.exit_code == 0, done.output
    friction = next(line for line in done.output.splitlines() if line.startswith(" sliding-"))
    assert "change of velocity" in friction
    assert "0.25" in friction
    assert "matters: measured: velocity 0.4" in friction
    load_row = next(line for line in done.output.splitlines() if line.startswith(" particle-load"))
    assert "may be left out: measured:" in load_row
    assert len(made) == len(set(made)), "the case as it is, once"
    spare = [line for line in done.output.splitlines() if line.startswith((" adhesion", " frame-rot"))]
    assert sorted("measured:" in line for line in spare) == [False, True], "the cheapest alone"
    once = len(made)
    again = CliRunner().invoke(app, [*words, "--set", SHORT])
    assert again.exit_code == 0, again.output
    assert len(made) == once, "remembered"
    unknown = CliRunner().invoke(app, [*words[:3], "velocty"])
    assert unknown.exit_code == 2
