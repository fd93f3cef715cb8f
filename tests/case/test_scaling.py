"""The predicted time on several ranks, against counts by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from orchestrator.cli.main import app
from orchestrator.ports.decomposition import grids
from orchestrator.preflight.cost import predicted_parts_s
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.scaling import RankTime, last_worth, rank_time, rank_times, scaling_lines
from tests.runs.outside import ROOT

PARTICLES = 50_000


@pytest.fixture(scope="module")
def slice_case():
    """The slice of the machine with cheap solvers; its eight panels carry a wet bed."""
    sets = [
        "panel.solver=strip",
        "frames.solver=two-mass",
        "duration_s=0.1",
        "coupling.scheme=particles-first",
    ]
    return load_judged(ROOT / "cases/ffs0827-slice", "draft", sets).case


def test_one_rank_takes_the_processor_time_of_the_run(slice_case) -> None:
    time = rank_time(slice_case, PARTICLES, 1)
    assert time.run_s == pytest.approx(sum(predicted_parts_s(slice_case, PARTICLES).values()), rel=1e-12)


def test_what_is_divided_among_ranks_and_what_is_not(slice_case) -> None:
    """Eight panels: four each on two ranks, one each on eight, and no less on sixteen.  The particles' own
    work is halved by two ranks, but for the steps' own time, the borders and uneven parts."""
    alone, two, eight, sixteen = (rank_time(slice_case, PARTICLES, ranks) for ranks in (1, 2, 8, 16))
    assert two.panels_s == pytest.approx(alone.panels_s / 2)
    assert eight.panels_s == pytest.approx(alone.panels_s / 8)
    assert sixteen.panels_s == eight.panels_s
    assert 0.5 < two.particles_s / alone.particles_s < 0.75
    assert sixteen.particles_s < eight.particles_s < two.particles_s
    # only openings of panels on this rank are not counted by the others
    assert 0.9 * alone.undivided_s < sixteen.undivided_s <= alone.undivided_s


def test_a_case_without_panels_has_ranks_too(slice_case) -> None:
    """Frames alone gain nothing by ranks; the particles of a chute without a deck do."""
    frames = load_judged(ROOT / "cases/double-deck", "draft", []).case
    alone, shared = (rank_time(frames, 0, ranks) for ranks in (1, 2))
    assert shared.run_s == alone.run_s
    assert shared.panels_s == shared.particles_s == 0.0
    screen = slice_case.screen.model_copy(update={"panels": {}, "decks": {}})
    chute = slice_case.model_copy(update={"screen": screen, "slice": None})
    single, two = (rank_time(chute, PARTICLES, ranks) for ranks in (1, 2))
    assert 0.5 < two.particles_s / single.particles_s < 0.75


def test_where_more_ranks_no_longer_pay(slice_case) -> None:
    """Ranks pay while the particles' part is the larger one."""
    times = rank_times(slice_case, 100 * PARTICLES, 64)
    assert [time.ranks for time in times] == [1, 2, 4, 8, 16, 32, 64]
    assert last_worth(times).ranks >= 16
    halved = [RankTime(ranks, 1.0 / ranks, 0.0, 0.0) for ranks in (1, 2, 4, 6)]
    assert last_worth(halved) is halved[-1]
    amdahl = [replace(time, undivided_s=0.5) for time in halved]  # 1.5, 1.0, 0.75, 0.67
    assert last_worth(amdahl).ranks == 4


def test_lines_name_the_limit_and_its_cause(slice_case) -> None:
    """The limit of few particles is the undivided parts; of very small steps, those that every rank makes."""
    lines = list(scaling_lines(slice_case, 1000, 8))
    assert [line.split()[0] for line in lines[2:-1]] == ["1", "2", "4", "8"]
    assert "ranks do not pay" in lines[-1]
    assert "frames, mapping" in lines[-1]
    particles = slice_case.particles.model_copy(update={"step_s": 1e-6})
    small_steps = slice_case.model_copy(update={"particles": particles})
    assert "every rank makes all of LIGGGHTS's steps" in list(scaling_lines(small_steps, 1000, 64))[-1]


@pytest.mark.parametrize(("ranks", "count"), [(1, 1), (2, 3), (4, 6), (12, 18)])
def test_all_grids_of_so_many_ranks(ranks: int, count: int) -> None:
    every = list(grids(ranks))
    assert len(set(every)) == len(every) == count
    assert {math.prod(grid) for grid in every} == {ranks}


def test_check_predicts_ranks_and_refuses_none() -> None:
    call = CliRunner()
    words = ["check", str(ROOT / "cases/quickstart"), "--level", "draft", "--ranks"]
    done = call.invoke(app, [*words, "6"])
    assert done.exit_code == 0, done.output
    assert "on up to 6 ranks" in done.output
    assert call.invoke(app, [*words, "0"]).exit_code == 2
    assert call.invoke(app, [*words, "65"]).exit_code == 2
    assert call.invoke(app, [*words, "2", "--json"]).exit_code == 2
    assert "--ranks" in call.invoke(app, ["check", "--help"]).output
