"""The actions of the watch about what it sees, on the members on a line."""

from __future__ import annotations

import logging
import time
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from orchestrator.coupling.machine import Machine
from orchestrator.coupling.schemes.scheme import Scheme, Solvers, State
from orchestrator.output.records.summary import wall_by_part_s, worked_by_part_s
from orchestrator.ports import Load, Motion, PanelState
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import SolverFailed
from orchestrator.preflight.stability.limits import light_point_s
from orchestrator.run.monitor.monitor import Stopped, check_speeds
from tests.coupling.line import FreeFrame, HungPlate, Sphere
from tests.monitor.machines import monitored, on_a_line

STIFFNESS_N_per_m, DAMPING_N_s_per_m = 1e5, 20.0
LIMIT_s = light_point_s(STIFFNESS_N_per_m, DAMPING_N_s_per_m, 1.0 / 0.8, 0.0)  # 0.8 of it is counted
LONG_s, INTERVALS = 0.0062, 200
STAYS = "monitor.calm_s=100.0"  # short to the end
CREATED, GROWING = "created_energy", "growing_modes"
ALONE = {
    CREATED: ["monitor.growing_modes=warn", "monitor.largest_growing_share=1.0"],
    GROWING: ["monitor.created_energy=warn", "monitor.largest_created_share=1.0"],
}


def pressed() -> tuple[HungPlate, Machine]:
    """A plate of 1 kg that something heavy holds by a contact's spring and damper, on a soft spring
    to a heavy frame; it starts at rest 0.1 mm out of its place."""
    plate = HungPlate(1.0, 100.0, 20, x=1e-4)
    sphere = Sphere(1e9, STIFFNESS_N_per_m, 0.0, 0.0, 20, DAMPING_N_s_per_m, stays=True)
    return plate, on_a_line(sphere, plate, FreeFrame(1e9), "particles-first")


def test_the_interval_is_beyond_the_limit_and_its_half_is_not() -> None:
    assert LONG_s / 2 < LIMIT_s < LONG_s


@pytest.mark.parametrize("then", ["created_energy", "growing_modes"])
def test_what_would_grow_without_end_is_shortened_and_ends_as_a_fine_run(tmp_path: Path, then: str) -> None:
    """Each of the two alone finds it.  A fine run is still at its end; without the watch the plate
    is ten million times as far from there as at the start."""
    free, machine = pressed()
    monitored(tmp_path / "a", machine, LONG_s, INTERVALS, [*ALONE[CREATED], f"monitor.{CREATED}=warn"])
    assert abs(free.x) > 1e3
    watched, machine = pressed()
    monitor = monitored(tmp_path / "b", machine, LONG_s, INTERVALS, [*ALONE[then], STAYS])
    fine, machine = pressed()
    monitored(tmp_path / "c", machine, LONG_s / 16, 16 * INTERVALS)
    assert abs(watched.x - fine.x) < 1e-3 * 1e-4
    figures = monitor.figures(INTERVALS)
    assert figures["shortest_interval_s"] <= LONG_s / 2
    assert figures["figures"][then]["times"] >= 1
    assert figures["shortened_share"] == figures["shortened_intervals"] / INTERVALS > 0.5


def test_a_quiet_run_is_left_alone(tmp_path: Path) -> None:
    _, machine = pressed()
    monitor = monitored(tmp_path, machine, LONG_s / 8, INTERVALS)
    figures = monitor.figures(INTERVALS)
    assert figures["shortened_intervals"] == 0
    assert {figure["times"] for figure in figures["figures"].values()} == {0}


def test_warn_warns_once(tmp_path: Path, caplog: pytest.LogCaptureFixture) -> None:
    _, machine = pressed()
    sets = ["monitor.created_energy=warn", "monitor.growing_modes=warn"]
    with caplog.at_level(logging.INFO, "flipflow"):
        monitor = monitored(tmp_path, machine, LONG_s, INTERVALS, sets)
    assert caplog.text.count("a mode of the interface grows") == 1
    assert caplog.text.count("in the last intervals") == 1
    figures = monitor.figures(INTERVALS)
    assert figures["shortened_intervals"] == 0
    assert figures["figures"]["growing_modes"]["times"] > 10


def test_stop_stops_before_it_is_too_late(tmp_path: Path) -> None:
    plate, machine = pressed()
    with pytest.raises(Stopped, match=r"stopped by the monitor at t = .* s: a mode of the int") as at:
        monitored(tmp_path, machine, LONG_s, INTERVALS, [*ALONE[GROWING], "monitor.growing_modes=stop"])
    assert at.value.state.panel.surface.position_m[0, 0] == plate.x
    assert abs(plate.x) < 0.01


def test_what_cannot_be_shortened_further_is_said_once(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    """A frame lighter than what it carries: no interval is short enough."""
    plate = HungPlate(1.0, 1e9, 20, v=1.0)
    machine = on_a_line(Sphere(1.0, 1.0, 9.0, 0.0, 2), plate, FreeFrame(0.5), "serial-staggered")
    with caplog.at_level(logging.WARNING, "flipflow"), np.errstate(all="ignore"):
        monitor = monitored(tmp_path, machine, 1e-3, 60)
    assert monitor.figures(60)["shortest_interval_s"] == 1e-3 / 64
    assert caplog.text.count("cannot be shortened any further") == 1


def test_loads_are_recorded_as_means_of_the_whole_interval(tmp_path: Path) -> None:
    """The frame gains the momentum that was recorded of the reaction."""
    _, machine = pressed()
    recorded: list[float] = []
    monitored(
        tmp_path,
        machine,
        LONG_s,
        INTERVALS,
        each=lambda seen: recorded.append(seen.panel.reaction.force_N[0, 0]),
    )
    received = machine.members.frames.received.impulse_N_s[0]
    assert LONG_s * sum(recorded) == pytest.approx(received, rel=1e-12)


def test_calm_again_it_goes_on_in_whole_intervals(tmp_path: Path) -> None:
    """The alarm is over when the sphere lets go."""
    _, machine = pressed()
    sphere = machine.members.particles
    assert sphere is not None
    done = []

    def lets_go(_: object) -> None:
        done.append(1)
        if len(done) == 40:
            sphere._solver.stiffness_N_per_m = sphere._solver.damping_N_s_per_m = 0.0  # type: ignore[attr-defined]

    monitor = monitored(tmp_path, machine, LONG_s, 200, ["monitor.calm_s=0.21"], lets_go)
    assert monitor.pace.parts == 1
    assert monitor.pace.trusted
    assert 30 <= monitor.pace.divided < 180


def test_it_goes_on_bit_for_bit_from_a_save(tmp_path: Path) -> None:
    _, machine = pressed()
    whole = monitored(tmp_path / "a", machine, LONG_s, 30)
    other, again = pressed()[1], None
    again = monitored(tmp_path / "b", other, LONG_s, 0)
    again.restore(whole.save())
    for name, value in flat(whole.save()).items():
        np.testing.assert_array_equal(value, flat(again.save())[name])


def flat(saved: dict, within: str = "") -> dict:
    flat_table = {}
    for name, value in saved.items():
        key = f"{within}/{name}"
        flat_table |= flat(value, key) if isinstance(value, dict) else {key: value}
    return flat_table


@pytest.mark.parametrize("scheme", ["particles-first", "robin", "aitken", "quasi-newton"])
def test_the_scheme_is_charged_for_what_it_repeats(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, scheme: str
) -> None:
    """The clock moves with the members only: a run of the plate takes 1 s, of the sphere 10, of the scheme
    itself 100."""
    now_s, runs, intervals = 0.0, {HungPlate: 0, Sphere: 0}, 5

    def spend(time_s: float) -> None:
        nonlocal now_s
        now_s += time_s

    def slow(kind: type[HungPlate | Sphere], time_s: float) -> None:
        advance = kind.advance

        def slowly(*arguments: Any) -> Any:
            runs[kind] += 1
            spend(time_s)
            return advance(*arguments)

        monkeypatch.setattr(kind, "advance", slowly)

    def slow_scheme(solvers: Solvers, interval: Interval, now: State) -> State:
        spend(100.0)
        return machine.scheme.advance(solvers, interval, now)

    monkeypatch.setattr(time, "perf_counter", lambda: now_s)
    slow(HungPlate, 1.0)
    slow(Sphere, 10.0)
    machine = on_a_line(Sphere(1.0, 1e3, -1e-3, 0.0), HungPlate(2.0, 3.0), FreeFrame(5.0), scheme)
    with machine.stopwatch("rest"):
        monitored(tmp_path, replace(machine, scheme=Scheme(slow_scheme)), 0.01, intervals)
    tries = {"particles-first": 1, "robin": 2}.get(scheme)
    assert runs[HungPlate] == tries * intervals if tries else runs[HungPlate] > 2 * intervals
    again_s = {"panel": runs[HungPlate] - intervals, "particles": 10 * (runs[Sphere] - intervals)}
    stopwatch = machine.stopwatch
    assert stopwatch.repeated_s == {part: time_s for part, time_s in again_s.items() if time_s}
    by_part_s = wall_by_part_s(stopwatch, now_s)
    assert by_part_s == dict.fromkeys(by_part_s, 0.0) | {
        "panel": intervals,
        "particles": 10 * intervals,
        "coupling": 100 * intervals + sum(again_s.values()),
    }
    summary = {"wall_by_part_s": by_part_s, "repeated_by_part_s": stopwatch.repeated_s}
    assert worked_by_part_s(summary) == by_part_s | {
        "panel": runs[HungPlate],
        "particles": 10 * runs[Sphere],
        "coupling": 100 * intervals,
    }


@pytest.mark.parametrize(("speed_m_per_s", "stops"), [(170.0, False), (180.0, True)])
def test_a_point_is_as_fast_as_its_velocity_is_long(speed_m_per_s: float, stops: bool) -> None:
    """A velocity of 174 m/s along each axis of a diagonal of space is more than 300 m/s."""
    moved = Motion(np.zeros((1, 3)), np.full((1, 3), speed_m_per_s))
    still = Load(np.zeros((1, 3)))
    state = State(moved, np.zeros((1, 3)), PanelState(moved, still), still)
    with pytest.raises(SolverFailed, match="unstable") if stops else nullcontext():
        check_speeds(state, 0.0, str)
