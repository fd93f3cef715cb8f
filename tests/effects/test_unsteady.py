"""Scenes whose machine does not move as the steady harmonic motion says, and what is said of them.

In each of the three scenes the estimate alone is far below its threshold, and a run without the effect shows
that it matters.
"""

from __future__ import annotations

import json
import math
from dataclasses import dataclass
from pathlib import Path

import pytest

from orchestrator.figures.short_names import named, value_at
from orchestrator.preflight.judge import JudgedCase, load_judged
from orchestrator.preflight.judgement.catalogue import EFFECTS, has_effect
from orchestrator.preflight.judgement.weighing import weigh_effects
from orchestrator.preflight.scene.frame_modes import FrameMode, frame_modes
from orchestrator.preflight.scene.scene import Scene, scene
from orchestrator.preflight.scene.steadiness import doubt_of_steady_motion, on_the_way_up
from orchestrator.run.trials.scratch import run_in_scratch
from tests.cases import case_folder, loaded

CASES = Path(__file__).parents[2] / "cases"
FRAME = """
title = "a frame on four bushings"
duration_s = 3.0
domain_m = [[-2.0, -2.0, -2.0], [2.0, 2.0, 2.0]]
gravity_m_per_s2 = [0.0, 0.0, 0.0]
[materials]
[frames]
solver = "exudyn"
[coupling]
sync_interval_s = 1e-3
[output]
interval_s = 0.1
pictures = false
[screen.frames.driving]
mass_kg = 100.0
inertia_kg_m2 = [10.0, 20.0, 20.0]
center_of_mass_m = [0.0, 0.0, 0.0]
[screen.bushings.isolation]
between = ["ground", "driving"]
positions_m = [[-0.5, -0.2, 0.0], [0.5, -0.2, 0.0], [-0.5, 0.2, 0.0], [0.5, 0.2, 0.0]]
"""
SHAFT = """
[screen.exciters.{name}]
frame = "driving"
position_m = [{x_m}, 0.0, {z_m}]
mass_moment_kg_m = {moment_kg_m}
speed_rad_per_s = 78.5
axis = [0, {turns}, 0]
phase_rad = {phase_rad}
run_up_s = 0.3
"""
MOTOR = """
[screen.exciters.{name}.motor]
rated_power_W = 1000.0
synchronous_speed_rad_per_s = 80.0
rated_slip = 0.04
moment_of_inertia_kg_m2 = 0.05
"""
CURVE = """
[[screen.bushings.isolation.curves]]
axes = "xz"
points = [
  { amplitude_m = 0.001, frequency_Hz = 12.5, stiffness_N_per_m = 151.5e3, loss_factor = 0.03 },
  { amplitude_m = 0.008, frequency_Hz = 12.5, stiffness_N_per_m = 148.0e3, loss_factor = 0.03 },
]
"""


def frame(stiffness_N_per_m: float, damping_N_s_per_m: float) -> str:
    rows = {"stiffness_N_per_m": stiffness_N_per_m, "damping_N_s_per_m": damping_N_s_per_m}
    return FRAME + "".join(f"{key} = {[size] * 3}\n" for key, size in rows.items())


def shaft(name: str, x_m: float, z_m: float, moment_kg_m: float, turns: int, phase_rad: float) -> str:
    return SHAFT.format(**locals())


@dataclass(frozen=True)
class Unsteady:
    """A scene: its case or the shipped case that it changes, the effect, and the result that tells."""

    effect: str
    result: str
    number: float
    why: str
    with_it: float
    without: float
    case: str = ""
    sets: tuple[str, ...] = ()

    def load(self, folder: Path, *more: str) -> JudgedCase:
        if not self.case:
            return load_judged(CASES / "empty-machine", "draft", [*self.sets, *more])
        return load_judged(case_folder(folder, self.case), None, [*self.sets, *more])


UNGEARED = Unsteady(  # the second shaft is drawn 86 degrees ahead of where it settles
    "motor-slip", "stroke", 1.6e-4, "no gear couples the shafts", 1.656e-3, 2.334e-3,
    frame(20e3, 200.0)
    + shaft("left", -0.3, 0.2, 0.15, 1, 0.0) + MOTOR.format(name="left")
    + shaft("right", 0.3, 0.2, 0.15, -1, 1.5) + MOTOR.format(name="right"),
)  # fmt: skip
RESONANT = Unsteady(  # 2 % below a mode with a loss factor of 0.03
    "bushing-hysteresis", "stroke", 0.0236, "near a mode small changes matter", 7.839e-3, 6.804e-3,
    frame(148e3, 0.03 * 148e3 / 78.5) + CURVE + shaft("shaft", 0.0, 0.0, 0.03, 1, 0.0),
)  # fmt: skip
TOUCHED = Unsteady(  # a mode at 0.63 of the speed, which the machine passes on its way up
    "beam-contact", "probes.middle-1.peak_m", 0.315, "on its way up", 0.03082, 0.04691,
    sets=(
        "screen.bushings.shear.stiffness_N_per_m=[2e3, 97e3, 97e3]",
        "screen.bushings.shear.damping_N_s_per_m=[5, 124, 124]",
        "screen.exciters.shaft.run_up_s=0.8",
        "screen.panels.deck.width_m=0.05",
        "screen.panels.deck.pitch_m=0.35",
        "screen.panels.deck.tension_m=0.008",
        "screen.panels.deck.stops.beam={from_m=0.12, to_m=0.18, gap_m=0.022}",
        "panel.cells=[22,1]",
        "duration_s=1.0",
    ),
)  # fmt: skip
SCENES = pytest.mark.parametrize("of", [UNGEARED, RESONANT, TOUCHED], ids=["ungeared", "resonant", "touched"])


@SCENES
def test_the_verdict_is_cannot_say_and_auto_keeps_the_effect(of: Unsteady, tmp_path: Path) -> None:
    described = of.load(tmp_path).described
    for asked in ((), (of.result,)):
        verdict = weigh_effects(described, None, asked)[of.effect].verdict
        assert verdict.value == pytest.approx(of.number, rel=0.02)
        assert verdict.matters is None
        assert of.why in verdict.why
    for asked in ([], [of.result]):
        chosen = of.load(tmp_path, "effects=auto", f"effects_for={json.dumps(asked)}")
        assert of.effect not in chosen.left_out


def test_a_run_up_is_of_no_account_where_no_peak_is_asked(tmp_path: Path) -> None:
    row = weigh_effects(TOUCHED.load(tmp_path).described, None, ("stroke",))["beam-contact"]
    assert row.verdict.matters is False


@pytest.mark.slow
@SCENES
def test_brute_force(of: Unsteady, tmp_path: Path) -> None:
    """The same run with and without the effect."""
    described = of.load(tmp_path)
    every = [name for name in EFFECTS if has_effect(described.described, name)]
    for effects, wanted in ((every, of.with_it), ([n for n in every if n != of.effect], of.without)):
        sets = (*of.sets, f"effects={json.dumps(effects)}", "output.pictures=false")
        result = value_at(run_in_scratch(described.folder, described.level, sets), of.result)
        assert result is not None
        assert result.value == pytest.approx(wanted, rel=0.03)


def test_one_shaft_with_a_motor_is_not_ungeared(tmp_path: Path) -> None:
    single = frame(20e3, 200.0) + shaft("left", -0.3, 0.2, 0.15, 1, 0.0) + MOTOR.format(name="left")
    geared = single.replace(MOTOR.format(name="left"), "") + shaft("right", 0.3, 0.2, 0.15, -1, 1.5)
    for case in (single, geared):
        seen = scene(load_judged(case_folder(tmp_path, case)).described)
        assert doubt_of_steady_motion(seen) == ""


def along_the_deck(shaken: Scene) -> FrameMode:
    return next(
        mode for mode in frame_modes(shaken) if mode.shape == "motion along the deck of the driving frame"
    )


@pytest.mark.parametrize(("tension_m", "doubted"), [(0.0, True), (0.05, False)])
@pytest.mark.parametrize(("damping_N_s_per_m", "damped"), [(10.0, False), (1000.0, True)])
def test_panels_that_pull_for_half_of_each_cycle_may_excite_half_the_speed(
    tension_m: float, doubted: bool, damping_N_s_per_m: float, damped: bool, tmp_path: Path
) -> None:
    """A frame that its panel holds along the deck, shaken at twice its frequency there."""
    sets = [
        "screen.bushings.isolation.stiffness_N_per_m=[1e3, 4e5, 4e5]",
        f"screen.bushings.isolation.damping_N_s_per_m={[damping_N_s_per_m] * 3}",
        f"screen.panels.deck.tension_m={tension_m}",
    ]
    along = along_the_deck(scene(loaded(tmp_path, sets).case))
    assert along.panels_share > 0.9
    twice = f"screen.exciters.shaft.speed_rad_per_s={4 * math.pi * along.frequency_Hz}"
    doubt = doubt_of_steady_motion(scene(loaded(tmp_path, [*sets, twice]).case))
    assert ("stiffness varies in each cycle" in doubt) == (doubted and not damped)


def test_the_way_up_passes_each_mode(tmp_path: Path) -> None:
    """A steady stroke is as large as at a mode: u w^2 / (c w) of a mass on a spring with little damping."""
    sets = [
        "screen.bushings.isolation.stiffness_N_per_m=[2e4, 4e5, 4e5]",
        "screen.bushings.isolation.damping_N_s_per_m=[100, 100, 100]",
        "screen.panels.deck.width_m=0.001",  # a panel that hardly pulls
    ]
    steady = scene(loaded(tmp_path, sets).case)
    rising = on_the_way_up(steady)
    assert rising is not None
    passed_rad_per_s = 2 * math.pi * along_the_deck(steady).frequency_Hz
    assert rising.panels[0].stroke_m == pytest.approx(0.35 * passed_rad_per_s / (2 * 100.0), rel=0.02)
    assert rising.panels[0].stroke_m > 2 * steady.panels[0].stroke_m


def test_which_results_are_peaks() -> None:
    peaks = ("cycle_peak_g", "peak_tension", "stretch", "probes.middle.peak_m")
    assert not any(named(name).figure.is_decisive for name in peaks)
    assert all(named(name).figure.is_decisive for name in ("stroke", "rms_g", "tension", "velocity"))
