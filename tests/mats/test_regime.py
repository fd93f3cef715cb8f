"""The regime of a mat, against an independent chain of links, and what is read from its motion."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from orchestrator.ports import Array
from orchestrator.preflight.mats.regime import PHASES, Regime
from orchestrator.preflight.mats.trial import SETTLING_TURNS, WATCHED_TURNS, Trial, regimes
from orchestrator.preflight.scene.starting import STEPS
from tests.mats.links import Mat, Turns, flip
from tests.panel.elastic_plans import plan

SPEED_RAD_PER_S = 78.54
BRANCHES = ((0.2, 1e-2), (0.2, 2e-3), (0.2, 4e-4))
MOUNTINGS = {  # thickness, clamps' angle, slack, stroke, m and degrees, and turns of the run-up
    "clamps at 20 degrees": (0.006, 20.0, 0.0, 0.006, 4),
    "clamps at 20 degrees, slack": (0.006, 20.0, 0.003, 0.006, 4),
    "clamps at 20 degrees, slack, 5 mm": (0.006, 20.0, 0.003, 0.005, 4),
    "clamps at 15 degrees, slack": (0.005, 15.0, 0.002, 0.005, 4),
    "clamps at 20 degrees, slack, 4 mm": (0.006, 20.0, 0.002, 0.004, 4),
    "flat, slack, up in every turn": (0.006, 0.0, 0.003, 0.006, 4),
    "flat, slack, down after a longer run-up": (0.006, 0.0, 0.003, 0.006, 6),
    "flat, slack, 5 mm, up in every turn": (0.005, 0.0, 0.002, 0.005, 4),
    "flat, slack, 5 mm, down after a shorter run-up": (0.005, 0.0, 0.002, 0.005, 1),
    "flat": (0.004, 0.0, 0.0, 0.006, 4),
}
MOST_RUN_UP_TURNS = 6


def trial(
    thickness_m: float, angle_deg: float, slack_m: float, stroke_m: float, run_up_turns: int = 4
) -> Trial:
    """A mat of 300 x 500 mm whose second clamp moves along it."""
    given = plan(
        length_m=0.3,
        span_m=0.3 - slack_m,
        thickness_m=thickness_m,
        width_m=0.5,
        density_kg_per_m3=1150.0,
        branches=BRANCHES,
        clamp_angle_deg=angle_deg,
    )
    amplitude_m = np.array([[0.0, 0.0, 0.0], [stroke_m, 0.0, 0.0]], dtype=complex)
    return Trial(given, amplitude_m, SPEED_RAD_PER_S, growing_m(amplitude_m, run_up_turns))


def growing_m(amplitude_m: Array, turns: int) -> Array:
    """The transient of clamps whose motion grows over some turns as half a cosine."""
    turn = np.arange(STEPS * (turns + SETTLING_TURNS) + 1) / STEPS
    lacking = (1 + np.cos(math.pi * np.minimum(turn / turns, 1.0))) / 2 * np.exp(2j * math.pi * turn)
    return -np.multiply.outer(lacking, amplitude_m).real


def links(of: Trial) -> Mat:
    """The same mat for each metre of width."""
    given, at = of.plan, of.plan.rectangle
    youngs_Pa = given.material.youngs_modulus_Pa
    return Mat(
        length_m=at.length_m,
        span_m=at.span_m,
        mass_kg_per_m2=given.material.density_kg_per_m3 * given.thickness_m,
        stretching_N_per_m=youngs_Pa * given.thickness_m,
        bending_N_m=youngs_Pa * given.thickness_m**3 / 12,
        branches=given.material.branches,
        clamp_angle_deg=at.clamp_angle_deg,
        stroke_m=of.stroke_m,
        speed_rad_per_s=of.speed_rad_per_s,
        run_up_turns=of.turns_before - SETTLING_TURNS,
    )


@cache
def both() -> dict[str, tuple[Regime, Turns]]:
    """The regime of each mounting, and the turns of the independent chain."""
    trials = [trial(*mounting) for mounting in MOUNTINGS.values()]
    settling = MOST_RUN_UP_TURNS + SETTLING_TURNS
    chains = flip([links(each) for each in trials], settling + WATCHED_TURNS, settling)
    return dict(zip(MOUNTINGS, zip(regimes(trials), chains, strict=True), strict=True))


@pytest.mark.parametrize("mounting", [name for name in MOUNTINGS if name != "flat"])
def test_a_mat_that_repeats_itself_flips_as_an_independent_chain_does(mounting: str) -> None:
    """The mat is on the same side in every turn, as far within 5 %, with the same mean peak within 15 %."""
    regime, chain = both()[mounting]
    up = mounting.endswith("up in every turn")
    assert regime.side == ("up" if up else "down")
    assert set(np.sign(chain.farthest_m)) == {1.0 if up else -1.0}
    assert regime.farthest_m.mean() == pytest.approx(chain.farthest_m.mean(), rel=0.05)
    assert regime.mean_peak_g == pytest.approx(chain.peak_g.mean(), rel=0.15)


def test_a_thin_flat_mat_changes_sides_in_both() -> None:
    """The turns that are up are between a third and two thirds of all. Its peaks, which depend on how it
    came to a turn, are alike within 30 %."""
    regime, chain = both()["flat"]
    for farthest_m in (regime.farthest_m, chain.farthest_m):
        assert 1 / 3 <= np.mean(farthest_m > 0) <= 2 / 3
    assert regime.side == "both"
    assert regime.mean_peak_g == pytest.approx(chain.peak_g.mean(), rel=0.3)


def test_a_mat_turned_round_flips_as_before_and_one_that_is_lifted_the_other_way_does_not() -> None:
    """The mats agree to rounding, and are not alike: of two neighbours on two frames, one opens while it is
    lifted."""
    moved_m = np.array([[0.001, 0.0, 0.003j], [0.006, 0.0, 0.004j]])
    mirrored_m, lowered_m = moved_m[::-1] * [-1.0, 1.0, 1.0], moved_m * [1.0, 1.0, -1.0]
    given = trial(0.005, 20.0, 0.002, 0.005)
    ways = (moved_m, mirrored_m, lowered_m)
    plain, turned, other = (
        replace(given, amplitude_m=way_m, transient_m=growing_m(way_m, 4)) for way_m in ways
    )
    assert plain.moves_as(turned)
    assert not plain.moves_as(other)
    results = regimes([plain, turned, other], watched_turns=4)
    assert results[0].height_m == pytest.approx(results[1].height_m, abs=1e-6)
    assert np.ptp(results[0].height_m - results[2].height_m) > 1e-3


def turning(*heights_m: float) -> Regime:
    """A mat of 0.3 m whose half waves reach these heights, one in each turn."""
    wave = np.sin(math.pi * np.arange(PHASES) / PHASES)
    peaks_g = np.abs(1e3 * np.array(heights_m))
    return Regime(0.3, np.outer(heights_m, wave), peaks_g, peaks_g / 2)


def test_sides_and_turns_after_which_a_motion_repeats_itself() -> None:
    down = turning(*[-0.03] * 12)
    assert (down.side, down.turns_up, down.repeats_after) == ("down", 0, 1)
    assert "hangs down in all of 12 turns, repeats every turn, mean peak 30 g (15 g below" in down.in_words
    other = turning(*[0.03, -0.02] * 6)
    assert (other.side, other.turns_up, other.repeats_after) == ("both", 6, 2)
    assert "arches up in 6 of 12 turns, repeats every 2 turns" in other.in_words
    taut = turning(*[0.005, -0.005] * 6)
    assert (taut.side, taut.turns_up) == ("taut", 0)
    never = turning(*np.linspace(0.01, 0.06, 12))
    assert (never.side, never.repeats_after) == ("up", None)


def test_a_load_that_moves_with_a_mat_is_as_a_denser_mat() -> None:
    """The mats agree to rounding: only the load's mass counts."""
    light = trial(0.005, 15.0, 0.002, 0.005)
    own_kg_per_m2 = 1150.0 * 0.005
    material = replace(light.plan.material, density_kg_per_m3=2 * 1150.0)
    denser = replace(light, plan=replace(light.plan, material=material))
    loaded = replace(light, added_kg_per_m2=own_kg_per_m2)
    first, second = regimes([loaded, denser], watched_turns=4)
    assert first.height_m == pytest.approx(second.height_m, abs=1e-9)
    assert first.mean_peak_g != pytest.approx(regimes([light], watched_turns=4)[0].mean_peak_g, rel=0.01)
