"""Checks of the open panels before anything is computed: how they hang, and what is there."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import pytest

from orchestrator.case.deck.openings import openings_m
from orchestrator.case.file.errors import CaseError
from orchestrator.coupling.build import build, find_problems_when_open
from orchestrator.coupling.metered import Stopwatch
from orchestrator.preflight.check import find_problems
from tests.cases import FEED, LEVEL, case_folder, keys_and_kinds, loaded
from tests.runs.outside import QUICK, flipflow, run_words

pytestmark = pytest.mark.solver

TAUT_STRIP = ("panel.solver=strip", "particles.solver=spheres", "frames.solver=two-mass")
# 0.3 m of panel between clamps 0.27 m apart: it hangs 59 mm deep
SLACK = ("screen.panels.deck.tension_m=-0.03", *TAUT_STRIP)
BALL = ("bed.particles.ball.sieve_size_m=0.03", "panel.surface_cells=[22, 4]")
PLATE = (
    'screen.surfaces.plate={frame="ground", material="PU", corner_m=[0.05, 0.05, HEIGHT], '
    "edges_m=[[0.2, 0, 0], [0, 0.1, 0]]}"
)


def plate(height_m: float) -> str:
    return PLATE.replace("HEIGHT", str(height_m))


def problems_of(folder: Path, overrides: Sequence[str]) -> list[str]:
    """Return the problems found when the solvers are open, which a check found before, too; no other
    problem exists."""
    given = loaded(folder, overrides)
    assert find_problems(given) == []
    checked = [str(mistake) for mistake in find_problems_when_open(given)]
    try:
        build(given, folder, None, Stopwatch()).close()
        opened = []
    except CaseError as error:
        opened = [str(mistake) for mistake in error.problems]
    assert opened == checked
    return opened


def ball_at(height_m: float) -> str:
    return f"bed.particles.ball.position_m=[0.135, 0.1, {height_m}]"


def test_a_slack_panel_in_an_exit_is_refused(tmp_path: Path) -> None:
    exit_ = 'screen.exits.under={product="undersize", box_m=[[-0.5, -0.5, -0.5], [0.5, 0.5, TOP]]}'
    problems = problems_of(tmp_path, [*SLACK, exit_.replace("TOP", "-0.03")])
    assert len(problems) == 1
    assert "screen.exits.under.box_m: panel deck as it hangs at rest reaches into it" in problems[0]
    assert problems_of(tmp_path, [*SLACK, exit_.replace("TOP", "-0.07")]) == []


def test_a_ball_inside_a_slack_panel_is_refused(tmp_path: Path) -> None:
    """A ball inside a slack panel would leave it at 10 m/s. In the middle the panel is 59 mm below its
    clamps."""
    problems = problems_of(tmp_path, [*SLACK, *BALL, ball_at(-0.06)])
    assert len(problems) == 1
    assert "bed.particles.ball.position_m: " in problems[0]
    assert '"ball" is 0.01' in problems[0]
    assert "m inside panel deck as it hangs at rest" in problems[0]


@pytest.mark.parametrize("height_m", [0.0, -0.03, -0.08])
def test_a_ball_in_the_hollow_or_below_a_slack_panel_is_not(tmp_path: Path, height_m: float) -> None:
    """The ball has room in the place of the flat panel."""
    assert problems_of(tmp_path, [*SLACK, *BALL, ball_at(height_m)]) == []


def test_a_ball_inside_a_taut_panel_is_refused_before_any_solver_is_open(tmp_path: Path) -> None:
    given = loaded(tmp_path, [*TAUT_STRIP, ball_at(0.005)])
    assert keys_and_kinds(find_problems(given)) == ["bed.particles.ball.position_m: misplaced"]


OPENINGS = (
    "screen.panels.deck.apertures={length_m=0.01, width_m=0.01, pitch_along_m=0.03, pitch_across_m=0.03, "
    "margin_along_m=0.03, margin_across_m=0.02}"
)


def test_a_ball_in_an_opening_is_clear_of_the_panel(tmp_path: Path) -> None:
    """A ball of 12 mm on the rim of an opening of 10 x 10 mm has its centre sqrt(6^2 - 5^2) = 3.32 mm
    high."""
    x, y, _ = openings_m(loaded(tmp_path, [*TAUT_STRIP, OPENINGS]).case)[0]

    def problems(along_m: float, height_m: float) -> int:
        place = f"bed.particles.ball.position_m=[{along_m}, {y}, {height_m}]"
        sets = [*TAUT_STRIP, OPENINGS, "bed.particles.ball.sieve_size_m=0.012", place]
        return len(find_problems(loaded(tmp_path, sets)))

    assert problems(x, 0.00335) == 0
    assert problems(x, 0.0031) == 1
    assert problems(x + 0.015, 0.00335) == 1


def test_a_feed_into_which_a_slack_panel_hangs_is_refused(tmp_path: Path) -> None:
    low = FEED.replace("[[0, 0, 0.1], [0.1, 0.1, 0.2]]", "[[0.1, 0, -0.08], [0.2, 0.2, -0.02]]")
    problems = problems_of(tmp_path, [*SLACK, low])
    assert len(problems) == 1
    assert "bed.feeds.chute.box_m: panel deck as it hangs at rest reaches into it" in problems[0]


def test_a_panel_that_hangs_through_a_plate_is_refused(tmp_path: Path) -> None:
    """20 mm below the flat panel, 39 mm above where that hangs."""
    problems = problems_of(tmp_path, [*SLACK, plate(-0.02)])
    assert len(problems) == 1
    assert "screen.panels.deck: panel deck hangs 0.0387 m through plate before any" in problems[0]
    assert "give the panel a stop" in problems[0]
    assert problems_of(tmp_path, [*SLACK, plate(-0.02), "monitor.penetrated_surfaces=warn"]) == []


@pytest.mark.parametrize("height_m", [-0.06, 0.02])
def test_a_plate_below_or_above_it_is_none_of_its_business(tmp_path: Path, height_m: float) -> None:
    assert problems_of(tmp_path, [*SLACK, plate(height_m)]) == []


def test_a_slack_panel_on_its_stop_is_refused(tmp_path: Path) -> None:
    """The stop is 20 mm below the flat panel, which hangs 59 mm deep."""
    stop = 'screen.panels.deck.stops.beam={frame="ground", from_m=0.1, to_m=0.2, gap_m=0.02}'
    problems = problems_of(tmp_path, [*SLACK, stop])
    assert len(problems) == 1
    assert "panel deck lies on its stop beam before anything moves" in problems[0]


def test_nothing_is_left_behind(tmp_path: Path) -> None:
    """The command has exit code 2, prints one message and leaves no folder; a check says the same."""
    case = case_folder(tmp_path / "case", draft=LEVEL)
    sets = [*QUICK, *SLACK, *BALL, ball_at(-0.06), plate(-0.02)]
    run = run_words(str(case), tmp_path / "run", sets)
    for words in (
        run,
        ["check", *(word for word in run[1:] if word not in ("--out", str(tmp_path / "run")))],
    ):
        done = flipflow(*words)
        assert done.returncode == 2, done.stderr
        assert "2 problems in the case:" in done.stderr
        assert "inside panel deck as it hangs at rest" in done.stderr
        assert "through plate before anything moves" in done.stderr
    assert not (tmp_path / "run").exists()


def test_a_panel_that_sags_through_a_plate_during_the_run_stops_it(tmp_path: Path) -> None:
    """The clamps of ``panel-cycle`` close and the panel sags by 26 mm, the plate is 12 mm below."""
    sets = [*QUICK, plate(-0.012), "duration_s=0.12"]
    done = flipflow(*run_words("panel-cycle", tmp_path / "run", sets))
    assert done.returncode == 4, done.stderr
    assert "stopped by the monitor at t = " in done.stderr
    assert "panel deck has gone through plate by " in done.stderr
    assert "of its thickness, and nothing holds it there" in done.stderr
    stop = (
        'screen.panels.deck.stops.beam={frame="ground", from_m=0.02, to_m=0.28, gap_m=0.0115, '
        "stiffness_Pa_per_m=2e7, damping_ratio=0.2}"
    )
    held = flipflow(*run_words("panel-cycle", tmp_path / "held", [*sets, stop]))
    assert "has gone through" not in held.stderr
    assert held.returncode == 0, held.stderr
