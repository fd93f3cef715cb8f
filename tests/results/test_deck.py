"""The bed seen from the deck: heights, depth and velocity in bins, particles that are stuck."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from orchestrator.case.deck.line import DeckLine, deck_line, join_lines, locate
from orchestrator.case.deck.openings import openings_m
from orchestrator.case.deck.panels import axes
from orchestrator.figures.material import Held
from orchestrator.output.records.deck_record import HELD_CYCLES, RetainedParticles, bins_m, compute_profile
from orchestrator.output.results import bed
from orchestrator.output.results.bed import deck_area_m2, retained_metrics
from orchestrator.output.results.estimate import chance
from orchestrator.output.results.run_reader import cut_size_m
from orchestrator.ports import Array, ParticleSnapshot
from orchestrator.preflight.judge import load_judged
from tests.grains import spheres
from tests.results.synthetic import ROOT

ACROSS = np.array([0.0, 1.0, 0.0])
CYCLE_S = 0.08


def straight(slope_deg: float, panels: int = 2, length_m: float = 0.3) -> list[Array]:
    """Panels end to end down a slope, 0.3 m each, ten points a panel."""
    turn = np.radians(slope_deg)
    down = np.array([np.cos(turn), 0.0, -np.sin(turn)])
    along = np.linspace(0.0, length_m, 10)
    return [np.outer(along + i * length_m, down) + 0.05 * ACROSS for i in range(panels)]


def deck_of(lines: list[Array]) -> tuple[DeckLine, Array]:
    deck = deck_line(lines)
    assert deck is not None
    return deck, join_lines(deck.panels, lines)


def snapshot(position: Array, diameter: Array, velocity: Array | None = None) -> ParticleSnapshot:
    n = len(position)
    still = np.zeros((n, 3))
    return ParticleSnapshot(
        np.arange(1, n + 1), position, still if velocity is None else velocity, still, spheres(diameter)
    )


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1)])
@pytest.mark.parametrize("backwards", [False, True])
def test_panels_are_joined_downhill(order: tuple[int, ...], backwards: bool) -> None:
    lines = straight(20.0, 3)
    deck, line = deck_of([lines[i][::-1] if backwards else lines[i] for i in order])
    assert deck.length_m == pytest.approx(0.9, rel=1e-12)
    assert deck.along == pytest.approx([1.0, 0.0, 0.0])
    assert (np.diff(line[:, 2]) <= 1e-12).all()


def test_decks_above_each_other_are_none() -> None:
    lines = straight(20.0, 1)
    assert deck_line([*lines, lines[0] + [0.0, 0.0, 0.5]]) is None


@pytest.mark.parametrize("slope_deg", [0.0, 15.0, 40.0])
def test_heights_are_normal_to_the_slope(slope_deg: float) -> None:
    deck, line = deck_of(straight(slope_deg))
    turn = np.radians(slope_deg)
    normal = np.array([np.sin(turn), 0.0, np.cos(turn)])
    foot = 0.25 * np.array([np.cos(turn), 0.0, -np.sin(turn)])
    seen = locate(deck, line, np.tile(2.0 * normal, (len(line), 1)), (foot + 0.02 * normal)[None])
    assert seen.height_m == pytest.approx([0.02], rel=1e-12)
    assert seen.rise_m_per_s == pytest.approx([2.0], rel=1e-12)
    assert seen.inside.all()
    # a point over the deck is taken to stand over the spot vertically below it
    assert seen.station_m == pytest.approx([0.25 + 0.02 * np.tan(turn)], rel=1e-9)


def test_stations_stick_to_the_panel() -> None:
    deck, line = deck_of(straight(10.0))
    shift = np.array([0.006, 0.0, 0.004])
    place = np.array([[0.2, 0.05, 0.0]])
    before = locate(deck, line, 0 * line, place)
    after = locate(deck, line + shift, 0 * line, place + shift)
    assert after.station_m == pytest.approx(before.station_m, rel=1e-12)
    assert after.height_m == pytest.approx(before.height_m, rel=1e-12)


def test_mass_velocity_and_depth_by_bin() -> None:
    """A flat deck of 0.6 m in 8 bins.  Bin 1 has twenty equal spheres at heights 1 to 20 mm:
    19 of 20 are 95 % of the mass, so the depth is 19 mm and a radius."""
    deck, line = deck_of(straight(0.0))
    edges = bins_m(deck)
    assert len(edges) == 9
    n = 20
    position = np.column_stack([np.full(n, 0.1), np.full(n, 0.05), 0.001 * np.arange(1, n + 1)])
    position = np.vstack([position, [[0.4, 0.05, 0.002], [0.4, 0.05, -0.01], [0.7, 0.05, 0.01]]])
    speed = np.concatenate([np.linspace(0.1, 0.3, n), [0.5, 9.0, 9.0]])
    velocity = np.outer(speed, [1.0, 0.0, 0.0])
    seen = locate(deck, line, 0 * line, position)
    profile = compute_profile(deck, snapshot(position, np.full(n + 3, 0.004), velocity), seen)
    one_kg = np.pi / 6 * 0.004**3 * 1430.0
    assert profile["mass_kg"] == pytest.approx([0, 20 * one_kg, 0, 0, 0, one_kg, 0, 0])
    assert profile["velocity_m_per_s"][[1, 5]] == pytest.approx([0.2, 0.5])
    assert profile["depth_m"][[1, 5]] == pytest.approx([0.019 + 0.002, 0.004])
    assert np.isnan(profile["depth_m"][[0, 2, 3, 4, 6, 7]]).all()


def test_velocity_is_along_the_slope() -> None:
    deck, line = deck_of(straight(30.0))
    turn = np.radians(30.0)
    down = np.array([np.cos(turn), 0.0, -np.sin(turn)])
    position = (0.1 * down + [0, 0, 0.005])[None]
    seen = locate(deck, line, 0 * line, position)
    profile = compute_profile(deck, snapshot(position, np.array([0.004]), (0.7 * down)[None]), seen)
    assert np.nanmax(profile["velocity_m_per_s"]) == pytest.approx(0.7, rel=1e-12)


def shaken(
    fastest_m_per_s: float, drift_m: float, height_m: Array, cycles: float = HELD_CYCLES + 1
) -> dict[str, float]:
    """Two 4 mm spheres on a panel that moves as a whole by +-5 mm, one drifting along."""
    deck, line = deck_of(straight(0.0))
    held = RetainedParticles(CYCLE_S, ACROSS, np.array([[0.1, 0.05], [0.12, 0.05], [0.2, 0.02]]))
    counts: dict[str, float] = {}
    for time in np.arange(0.0, cycles * CYCLE_S, CYCLE_S / 8):
        moved = np.array([0.005 * np.sin(2 * np.pi * time / CYCLE_S), 0.0, 0.0])
        rise = np.tile([0.0, 0.0, fastest_m_per_s * np.cos(2 * np.pi * time / CYCLE_S)], (len(line), 1))
        position = np.array([[0.1, 0.05, 0.0], [0.2 + drift_m * time, 0.021, 0.0]])
        position[:, 2] = height_m
        seen = locate(deck, line + moved, rise, position + moved)
        velocity = np.tile(rise[0], (2, 1))
        counts = held.at(float(time), snapshot(position + moved, np.full(2, 0.004), velocity), seen)
    return counts


@pytest.mark.parametrize("throw", [1.3, 1.6, 2.5])
def test_a_loose_grain_that_hops_low_is_no_sticker(throw: float) -> None:
    """A grain of 40 mm on a panel that shakes harmonically is thrown anew in each cycle and flies as a
    stone does. It never rises by a quarter of its diameter, and one that is held stays where it is."""
    g, speed, diameter_m = 9.80665, 2 * np.pi / CYCLE_S, 0.04
    amplitude_m = throw * g / speed**2
    deck, line = deck_of(straight(0.0))
    held = RetainedParticles(CYCLE_S, ACROSS, np.empty((0, 2)))
    step_s, counts, highest_m = CYCLE_S / 4000, {}, 0.0
    place_m, rate_m_per_s = 0.0, amplitude_m * speed
    for step in range(int((HELD_CYCLES + 2) * 4000)):
        time = step * step_s
        panel_m = amplitude_m * np.sin(speed * time)
        panel_m_per_s = amplitude_m * speed * np.cos(speed * time)
        rate_m_per_s -= g * step_s
        place_m += rate_m_per_s * step_s
        if place_m <= panel_m:  # it lands without a bounce
            place_m, rate_m_per_s = panel_m, max(rate_m_per_s, panel_m_per_s)
        highest_m = max(highest_m, place_m - panel_m)
        if step % 330 == 0:  # twelve outputs in each cycle, at ever other phases
            rise = np.tile([0.0, 0.0, panel_m_per_s], (len(line), 1))
            moved = line + np.array([0.0, 0.0, panel_m])
            heights = [[0.1, 0.05, place_m + diameter_m / 2], [0.3, 0.05, panel_m + diameter_m / 2]]
            velocity = np.array([[0.0, 0.0, rate_m_per_s], [0.0, 0.0, panel_m_per_s]])
            grains = snapshot(np.array(heights), np.full(2, diameter_m), velocity)
            counts = held.at(time, grains, locate(deck, moved, rise, grains.position_m))
    assert 0.0 < highest_m < diameter_m / 4
    assert counts["stickers"] == 1.0


def test_what_stays_on_a_shaking_panel_is_stuck() -> None:
    """0.2 m/s at 78.5 rad/s are 1.6 g.  At 1 m/s along, the other is at no place for long."""
    on_top = np.array([0.002, 0.002])
    assert shaken(0.2, 1.0, on_top)["stickers"] == 1.0
    assert shaken(0.2, 0.0, on_top)["stickers"] == 2.0
    assert shaken(0.2, 0.0, on_top)["mass_kg"] == pytest.approx(2 * np.pi / 6 * 0.004**3 * 1430)
    assert shaken(0.1, 0.0, on_top)["stickers"] == 0.0  # 0.8 g: nothing is thrown
    assert shaken(0.2, 0.0, on_top, HELD_CYCLES - 1)["stickers"] == 0.0  # not long enough
    assert shaken(0.2, 0.0, np.array([0.002, 0.009]))["stickers"] == 1.0  # lies on others


def test_what_sits_in_an_opening_blinds_it() -> None:
    """A sphere of diameter d seated on the rim of an opening a < d is sqrt(d^2 - a^2)/2 above
    it: 0.87 mm for 4 mm on 3.6 mm.  Lying on the panel, 2 mm."""
    seated = float(np.sqrt(4.0**2 - 3.6**2) / 2) * 1e-3
    assert shaken(0.2, 0.0, np.array([seated, 0.002]))["openings"] == 1.0
    assert shaken(0.2, 0.0, np.array([seated, seated]))["openings"] == 2.0
    assert shaken(0.2, 0.0, np.array([0.002, 0.002]))["openings"] == 0.0
    assert shaken(0.2, 0.0, np.array([-seated, -0.002]))["openings"] == 1.0  # the other hangs under the panel


def test_ids_that_come_and_go() -> None:
    deck, line = deck_of(straight(0.0))
    held = RetainedParticles(CYCLE_S, ACROSS, np.empty((0, 2)))
    position = np.array([[0.1, 0.05, 0.002], [0.2, 0.05, 0.002], [0.3, 0.05, 0.002]])
    every = snapshot(position, np.full(3, 0.004))
    rise = np.tile([0.0, 0.0, 1.0], (len(line), 1))
    parts = {0.0: [], 0.1: [0, 1], 0.3: [0, 1, 2], 0.6: [0, 2]}
    for time, rows in parts.items():
        particles = replace(every.part(rows), velocity_m_per_s=np.tile([0.0, 0.0, 1.0], (len(rows), 1)))
        seen = locate(deck, line, rise, particles.position_m)
        counts = held.at(time, particles, seen)
    assert counts["stickers"] == 1.0  # the first, since 0.1 s; the third came too late


def test_openings_in_the_world() -> None:
    """Two panels of one opening each, at the middle of the span of a taut panel."""
    pattern = "{shape='slot', length_m=0.02, width_m=0.003, pitch_along_m=0.2, pitch_across_m=0.15}"
    sets = [f"screen.panels.deck.apertures={pattern}", "screen.panels.deck.tension_m=0.004"]
    sets.append("screen.panels.deck.length_m=0.3")
    case = load_judged(ROOT / "cases/quickstart", "draft", sets).case
    centres_m = openings_m(case) @ axes(case)  # in deck axes
    assert centres_m == pytest.approx(np.array([[0.152, 0.1, 0.0], [0.338 + 0.152, 0.1, 0.0]]))
    assert cut_size_m(case) == 0.003
    plain = load_judged(ROOT / "cases/quickstart", "draft").case
    assert openings_m(plain).shape == (0, 3)
    assert cut_size_m(plain) is None


def test_the_first_cycles_in_which_nothing_can_be_held_are_in_no_mean(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Seven particles stick from the start, and count from the end of the fifth cycle on."""
    monkeypatch.setattr(bed, "openings_m", lambda _: [0])
    time_s = np.arange(1, 81) * CYCLE_S / 8
    stuck = np.where(time_s - time_s[0] >= (HELD_CYCLES - 1e-9) * CYCLE_S, 7.0, 0.0)
    table = {
        "held/time_s": time_s,
        "held/stickers": stuck,
        "held/mass_kg": 0.001 * stuck,
        "held/pegged_kg": 0.0005 * stuck,
        "held/openings": 0.0 * stuck,
        "profile/mass_kg": np.full((len(time_s), 2), 0.007),
    }

    def held_until(end_s: float) -> Held:
        run: Any = SimpleNamespace(
            case=None,
            cycle_s=CYCLE_S,
            read=table.__getitem__,
            output_rows=lambda _, start_s, until_s: (time_s > start_s) & (time_s <= until_s),
        )
        return retained_metrics(run, 0.0, end_s, False, chance)

    assert held_until(10 * CYCLE_S).stickers.value == pytest.approx(7.0)
    assert held_until(10 * CYCLE_S).pegged_percent.value == pytest.approx(25.0)
    assert held_until(4 * CYCLE_S).stickers.value is None


def test_the_area_of_unequal_panels(monkeypatch: pytest.MonkeyPatch) -> None:
    """Two panels of 0.3 x 0.2 m and one of 0.6 x 0.4 m: 0.36 m2 on a length of 1.2 m."""
    sides = [(0.3, 0.2), (0.3, 0.2), (0.6, 0.4)]
    panels = [SimpleNamespace(rectangle=SimpleNamespace(length_m=a, width_m=b)) for a, b in sides]
    monkeypatch.setattr(bed, "single_panels", lambda _: panels)
    run: Any = SimpleNamespace(case=None, read=lambda _: (np.arange(12) * 0.1 + 0.05)[None])
    assert deck_area_m2(run) == pytest.approx(0.36, rel=1e-12)
