"""The lines of ``flipflow check`` about a machine's mats."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.cli.overview import overview
from orchestrator.ports.plans import SolverFailed, SolverMissing
from orchestrator.preflight.check import warnings
from orchestrator.preflight.mats import mats
from orchestrator.preflight.mats.mats import find_mats, mat_lines, mat_tables, trials_of
from orchestrator.preflight.mats.trial import SETTLING_TURNS
from orchestrator.preflight.scene.scene import scene
from orchestrator.views.mats import draw_mats
from tests.cases import CASE, load_case

DRIVEN = (
    CASE.split("[screen.frames.driving]")[0]
    + """
[screen.frames.driving.drive]
speed_rad_per_s = 78.54
amplitude_m = [0.006, 0.0, 0.0]
run_up_s = 0.3

[screen.panels.deck]
material = "PU"
frames = ["driving", "ground"]
corner_m = [0.0, 0.0, 0.0]
length_m = 0.3
width_m = 0.2
thickness_m = 0.006
clamp_m = 0.019
tension_m = 0.0
count = 2
pitch_m = 0.36
"""
)
HANGING = ("screen.panels.deck.clamp_angle_deg=20.0", "screen.panels.deck.tension_m=-0.003")
DAMPED = "materials.PU.hyperelastic.maxwell=[{ratio=0.2, relaxation_s=2e-3}, {ratio=0.2, relaxation_s=4e-4}]"


def test_a_mat_that_arches_up_is_a_warning_with_its_turns_and_what_helps(tmp_path: Path) -> None:
    loaded = load_case(tmp_path, DRIVEN, [DAMPED])
    (warning,) = [line for line in warnings(loaded) if line.startswith("mat ")]
    assert warning.split()[:2] == ["mat", "deck-1"]
    assert "(clamp_angle_deg)" in warning
    assert any(line.split()[:2] == ["mat", "deck-1"] for line in overview(loaded))


def test_a_mat_that_hangs_is_none(tmp_path: Path) -> None:
    loaded = load_case(tmp_path, DRIVEN, [DAMPED, *HANGING])
    assert not [line for line in warnings(loaded) if line.startswith("mat ")]
    (line,) = mat_lines(scene(loaded.case))
    assert "hangs down in all of 24 turns" in line
    (table,) = mat_tables(scene(loaded.case)) or []
    assert table["panels"] == ["deck-1", "deck-2"]
    assert table["empty"]["side"] == "down"
    assert table["empty"]["turns_up"] == 0
    assert 0 < table["empty"]["cycle_peak_100_Hz_g"] < table["empty"]["cycle_peak_g"]


def test_neighbours_on_two_frames_are_two_kinds_of_mats(tmp_path: Path) -> None:
    """The stroke and the lift are a quarter of a turn apart, as of an unbalance; without a lift the
    neighbours are alike."""
    drive = "screen.frames.driving.drive."
    lifted = (f"{drive}amplitude_m=[0.006, 0, 0.005]", f"{drive}phase_rad=[0, 0, 1.5707963267948966]")
    both = load_case(tmp_path / "both", DRIVEN, [DAMPED, *lifted])
    assert [names for names, _ in trials_of(scene(both.case))] == [("deck-1",), ("deck-2",)]
    flat = load_case(tmp_path / "flat", DRIVEN, [DAMPED])
    assert [names for names, _ in trials_of(scene(flat.case))] == [("deck-1", "deck-2")]


def test_a_trial_starts_as_its_case_does(tmp_path: Path) -> None:
    """Clamps grow over the case's own run-up of 0.3 s, 3.75 turns, as half a cosine, and go on steadily; a
    run-up of 40 turns is shortened to 24."""
    ((_, trial),) = trials_of(scene(load_case(tmp_path / "case", DRIVEN).case))
    assert trial.turns_before == 4 + SETTLING_TURNS
    time_s = np.array([0.0, 0.1, 0.2, 0.31, 0.5])
    grown = (1 - np.cos(np.pi * np.minimum(time_s / 0.3, 1.0))) / 2
    moved_m, _ = trial.clamps_at(time_s)
    assert moved_m[:, 0, 0] == pytest.approx(0.006 * grown * np.sin(78.54 * time_s), abs=1e-7)
    assert not moved_m[:, 1].any()
    slow = load_case(tmp_path / "slow", DRIVEN, ["screen.frames.driving.drive.run_up_s=3.2"])
    ((_, trial),) = trials_of(scene(slow.case))
    assert trial.turns_before == 24 + SETTLING_TURNS


def test_mats_that_nothing_moves_or_whose_trial_is_long_are_not_tried(tmp_path: Path) -> None:
    still = load_case(tmp_path / "still", DRIVEN, ["screen.frames.driving.drive.amplitude_m=[0, 0, 0]"])
    assert find_mats(scene(still.case)) == ()
    steel = "materials.PU.hyperelastic={c10_Pa=2e10, c01_Pa=1e10, bulk_modulus_Pa=1e12}"
    stiff = load_case(tmp_path / "stiff", DRIVEN, [steel])
    assert find_mats(scene(stiff.case)) == ()


@pytest.mark.parametrize(
    ("error", "why"),
    [
        (MemoryError("Unable to allocate 8.00 PiB"), "Unable to allocate 8.00 PiB"),
        (MemoryError(), "out of memory"),
        (SolverFailed("no shape at rest"), "no shape at rest"),
        (SolverMissing("no strip"), "no strip"),
    ],
)
def test_a_trial_that_fails_stops_no_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, error: Exception, why: str
) -> None:
    """The failure of the solver is told where the regime would stand, and is no warning."""

    def fail(shaken: object) -> None:
        raise error

    monkeypatch.setattr(mats, "find_mats", fail)
    loaded = load_case(tmp_path, DRIVEN, [DAMPED])
    assert [*mat_lines(scene(loaded.case))] == [f"mats: how they flip is not known: {why}"]
    assert mat_tables(scene(loaded.case)) is None
    assert not [line for line in warnings(loaded) if line.startswith("mat")]


def test_a_mistake_of_the_program_is_not_taken_for_a_trial_that_fails(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fail(shaken: object) -> None:
        raise TypeError("a mistake")

    monkeypatch.setattr(mats, "find_mats", fail)
    with pytest.raises(TypeError, match="mistake"):
        [*mat_lines(scene(load_case(tmp_path, DRIVEN, [DAMPED]).case))]


def test_the_picture_has_the_figures_of_check_at_the_case_s_own_place(tmp_path: Path) -> None:
    """The chart's trials are coarser: 75 of them, and the fine one in the middle of the middle part."""
    described = scene(load_case(tmp_path, DRIVEN, list(HANGING)).case)
    ((_, fig),) = draw_mats(described)
    (mat,) = find_mats(described)
    own = f"{mat.empty.mean_peak_g:.0f}\n{mat.empty.mean_quoted_peak_g:.0f}"
    middle = [text.get_text() for axes in fig.axes for text in axes.texts if text.get_position() == (2, 2)]
    assert len(middle) == 3
    assert middle[1] == own
