"""Effects in the frames: each deciding number against a value worked out by hand, and what
follows from it."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from orchestrator.preflight.judge import load_judged
from tests.cases import CASE, case_folder, load_case
from tests.effects.verdicts import by_name, of_driven, verdict


def test_panels_against_bushings_by_hand(tmp_path: Path) -> None:
    """Two bushings of 20 kN/m along the deck; the panel has 56 kN/m while taut, and at least half
    of that in the first harmonic."""
    judged = verdict(tmp_path, "panel-reaction")
    assert 28 / 40 <= judged.verdict.value <= 56 / 40
    assert (judged.present, judged.verdict.matters) == (True, True)
    assert verdict(tmp_path, "panel-reaction", "exchange.panel_reaction=false").is_lacking


def test_a_panel_always_taut_pulls_with_all_its_stiffness(tmp_path: Path) -> None:
    judged = verdict(tmp_path, "panel-reaction", "screen.panels.deck.tension_m=0.025")
    assert judged.verdict.value == pytest.approx(56 / 40, rel=1e-9)


def test_driven_frames_feel_no_panels(tmp_path: Path) -> None:
    assert of_driven(tmp_path, "panel-reaction").verdict.matters is False
    dynamics = of_driven(tmp_path, "frame-dynamics")
    assert not dynamics.present
    assert (dynamics.verdict.matters, dynamics.verdict.value) == (False, 0.0)


def test_damping_of_one_mass_by_hand(tmp_path: Path) -> None:
    """76 kg and half the panel's 0.276 kg, 40 kN/m along x besides the panel; the frame's stroke is
    |F| / |k - m w^2 + i c w|."""
    taut = "screen.panels.deck.tension_m=0.025"
    damped = "screen.bushings.isolation.damping_N_s_per_m=[900.0, 900.0, 900.0]"
    judged = verdict(tmp_path, "bushing-damping", taut, damped)
    dynamic = 96e3 - 76.138 * 78.5**2
    with_it = abs(dynamic + 1j * 78.5 * 1800)
    assert judged.verdict.value == pytest.approx(with_it / abs(dynamic) - 1, rel=1e-6)
    assert (judged.present, judged.verdict.matters) == (True, None)


def test_without_damping_rubbers_is_tried(tmp_path: Path) -> None:
    taut = "screen.panels.deck.tension_m=0.025"
    judged = verdict(tmp_path, "bushing-damping", taut)
    dynamic = 96e3 - 76.138 * 78.5**2
    assert judged.verdict.value == pytest.approx(1 - abs(dynamic) / abs(dynamic + 4e3j), rel=1e-4)
    assert not judged.present


def test_rotation_of_a_body_on_its_own_by_hand(tmp_path: Path) -> None:
    """The body stands on bushings next to nothing, with an exciter 0.2 m above the centre of mass: theta =
    u h / I (w cancels), translation sqrt(2) u / m of a force that turns: 0.2 * 76 / 6 / sqrt(2) per m of
    lever. It holds no panel, so that the lever is 0.7 m, to the bushing at x = 0.4."""
    soft = "screen.bushings.isolation.stiffness_N_per_m=[10.0, 10.0, 10.0]"
    above = "screen.exciters.shaft.position_m=[-0.3, 0.1, 0.2]"
    centre = "screen.frames.driving.center_of_mass_m=[-0.3, 0.1, 0.0]"
    free = by_name(
        load_judged(
            case_folder(tmp_path, CASE.replace('["driving", "ground"]', '["ground", "ground"]')),
            None,
            [soft, above, centre],
        )
    )["frame-rotation"]
    assert free.verdict.value == pytest.approx(0.7 * 0.2 * 76 / 6 / math.sqrt(2), rel=0.01)
    assert (free.present, free.verdict.matters) == (True, True)


def test_two_mass_frames_lack_the_rotation(tmp_path: Path) -> None:
    above = "screen.exciters.shaft.position_m=[0.0, 0.1, 0.2]"
    aside = "screen.frames.driving.center_of_mass_m=[0.0, 0.0, 0.0]"
    assert verdict(tmp_path, "frame-rotation", above, aside, "frames.solver=two-mass").is_lacking


def test_rotation_needs_moments_of_inertia(tmp_path: Path) -> None:
    without = CASE.replace("inertia_kg_m2 = [2.0, 6.0, 6.0]", "")
    by_effect = by_name(load_case(tmp_path, without, ["frames.solver=two-mass"]))
    assert by_effect["frame-rotation"].verdict.matters is None


@pytest.mark.parametrize(
    ("run_up_s", "matters", "present"), [(0.0, True, False), (0.1, None, True), (0.5, None, True)]
)
def test_cycles_of_the_run_up(tmp_path: Path, run_up_s: float, matters: bool | None, present: bool) -> None:
    given = f"screen.frames.driving.drive.run_up_s={run_up_s}"
    judged = of_driven(tmp_path, "run-up", given)
    assert judged.verdict.value == pytest.approx(run_up_s * 80 / (2 * math.pi))
    assert (judged.verdict.matters, judged.present) == (matters, present)


@pytest.mark.parametrize(("softest", "matters"), [(17e3, True), (19.5e3, False)])
def test_a_bushings_curve_matters_where_its_stiffness_changes(
    tmp_path: Path, softest: float, matters: bool
) -> None:
    """20 kN/m at 1 mm over 17 or 19.5 kN/m at 6 mm."""
    points = ", ".join(
        f"{{amplitude_m={a}, frequency_Hz=12.5, stiffness_N_per_m={k}, loss_factor=0.1}}"
        for a, k in ((1e-3, 20e3), (6e-3, softest))
    )
    curve = f"screen.bushings.isolation.curves=[{{points=[{points}]}}]"
    judged = verdict(tmp_path, "bushing-hysteresis", curve, 'frames.solver="exudyn"')
    assert judged.verdict.value == pytest.approx(20e3 / softest - 1)
    assert (judged.present, judged.verdict.matters) == (True, matters)
