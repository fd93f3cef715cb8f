"""The predicted time on several ranks, against counts by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from typer.testing import CliRunner

from orchestrator.case.solver_plans import particle_step_s
from orchestrator.cli.main import app
from orchestrator.ports.clock import steps_in
from orchestrator.ports.decomposition import grids
from orchestrator.preflight.cost import predicted_parts_s
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.scaling import Network, RankTime, last_worth, rank_time, rank_times, scaling_lines
from tests.runs.outside import ROOT

FREE = Network(0.0, math.inf)
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
    assert time.messages_s == 0.0


def test_what_is_divided_among_ranks_and_what_is_not(slice_case) -> None:
    """Eight panels: four each on two ranks, one each on eight, and no less on sixteen.  The particles' own
    work is halved by two ranks, but for the steps' own time, the borders and uneven parts."""
    one, two, eight, sixteen = (rank_time(slice_case, PARTICLES, ranks, FREE) for ranks in (1, 2, 8, 16))
    assert two.panels_s == pytest.approx(one.panels_s / 2)
    assert eight.panels_s == pytest.approx(one.panels_s / 8)
    assert sixteen.panels_s == eight.panels_s
    assert 0.5 < two.particles_s / one.particles_s < 0.75
    assert sixteen.particles_s < eight.particles_s < two.particles_s
    # only openings of panels on this rank are not counted by the others
    assert 0.9 * one.undivided_s < sixteen.undivided_s <= one.undivided_s
    assert {time.messages_s for time in (one, two, eight, sixteen)} == {0.0}


def test_messages_take_their_latency_and_their_length(slice_case) -> None:
    slow, slower = (
        rank_time(slice_case, PARTICLES, 4, Network(latency_s, math.inf)) for latency_s in (1e-5, 2e-5)
    )
    assert slower.messages_s == pytest.approx(2 * slow.messages_s)
    narrow, wide = (rank_time(slice_case, PARTICLES, 4, Network(0.0, bandwidth)) for bandwidth in (1e8, 2e8))
    assert narrow.messages_s == pytest.approx(2 * wide.messages_s)
    assert slow.particles_s == narrow.particles_s


def test_a_case_without_panels_has_ranks_too(slice_case) -> None:
    """Frames alone gain nothing by ranks; the particles of a chute without a deck do."""
    frames = load_judged(ROOT / "cases/double-deck", "draft", []).case
    alone, shared = (rank_time(frames, 0, ranks, FREE) for ranks in (1, 2))
    assert shared.run_s == alone.run_s
    assert shared.panels_s == shared.particles_s == 0.0
    screen = slice_case.screen.model_copy(update={"panels": {}, "decks": {}})
    chute = slice_case.model_copy(update={"screen": screen, "slice": None})
    one, two = (rank_time(chute, PARTICLES, ranks, FREE) for ranks in (1, 2))
    assert 0.5 < two.particles_s / one.particles_s < 0.75


def test_intervals_that_are_tried_again_send_their_messages_again(slice_case) -> None:
    """By quasi-newton the particles run an interval twice and the panels three times.  On two ranks a step
    has two messages, and a tried interval six of two latencies."""
    coupling = slice_case.coupling.model_copy(update={"scheme": "quasi-newton"})
    tried = slice_case.model_copy(update={"coupling": coupling})
    interval_s, latency_s = slice_case.coupling.sync_interval_s, 1e-3
    steps = steps_in(interval_s, particle_step_s(slice_case))
    intervals = slice_case.duration_s / interval_s
    for case, runs, panel_runs in ((slice_case, 1, 1), (tried, 2, 3)):
        messages = intervals * (runs * steps * 2 + panel_runs * 6 * 2)
        found = rank_time(case, PARTICLES, 2, Network(latency_s, math.inf))
        assert found.messages_s == pytest.approx(latency_s * messages)


def test_where_more_ranks_no_longer_pay(slice_case) -> None:
    """Where a message takes a tenth of a second, two ranks are slower than one.  Without messages, ranks
    pay while the particles' part is the larger one."""
    assert last_worth(rank_times(slice_case, PARTICLES, 8, Network(0.1, 1e9))).ranks == 1
    times = rank_times(slice_case, 100 * PARTICLES, 64, FREE)
    assert [time.ranks for time in times] == [1, 2, 4, 8, 16, 32, 64]
    assert last_worth(times).ranks >= 16
    halved = [RankTime(ranks, 1.0 / ranks, 0.0, 0.0, 0.0) for ranks in (1, 2, 4, 6)]
    assert last_worth(halved) is halved[-1]
    amdahl = [replace(time, undivided_s=0.5) for time in halved]  # 1.5, 1.0, 0.75, 0.67
    assert last_worth(amdahl).ranks == 4


def test_lines_name_the_limit_and_its_cause(slice_case) -> None:
    lines = list(scaling_lines(slice_case, 1000, 8, Network(1e-3, 1e9)))
    assert "messages of 1000 us and 1 GB/s" in lines[0]
    assert [line.split()[0] for line in lines[2:-1]] == ["1", "2", "4", "8"]
    assert "more than 1 ranks do not pay" in lines[-1]
    assert "messages" in lines[-1]


def test_steps_that_every_rank_makes_are_named_as_the_limit(slice_case) -> None:
    """Few particles in very small steps: neither they nor the frames take the most of the time."""
    particles = slice_case.particles.model_copy(update={"step_s": 1e-6})
    small_steps = slice_case.model_copy(update={"particles": particles})
    assert "every rank makes all of LIGGGHTS's steps" in list(scaling_lines(small_steps, 1000, 64, FREE))[-1]
    assert "frames, mapping" in list(scaling_lines(slice_case, 1000, 64, FREE))[-1]


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
    assert call.invoke(app, [*words, "2", "--bandwidth", "0"]).exit_code == 2
    assert call.invoke(app, [*words, "2", "--json"]).exit_code == 2
    assert "--ranks" in call.invoke(app, ["check", "--help"]).output
