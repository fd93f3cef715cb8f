"""Forecasts of schemes for an interval's end: clamps by their drives, or by their last acceleration."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import pytest
from scipy.sparse import csr_array

from orchestrator.coupling.ablation import PanelBetweenStillClamps, UnloadedPanel, UnpushedFrames
from orchestrator.coupling.mapping import MappedPanel
from orchestrator.coupling.metered import MeteredFrames, MeteredPanel, Stopwatch, TimedPanel
from orchestrator.coupling.mpi import FramesOnFirstRank
from orchestrator.coupling.panel_set import PanelSet
from orchestrator.coupling.schemes import SCHEMES, create_scheme
from orchestrator.coupling.schemes.scheme import Solvers, State, extrapolate, forecast, initial_state
from orchestrator.ports import Frames, HermitePath, Known, Load, Motion, Panel, PanelState
from orchestrator.ports.clock import Interval
from orchestrator.ports.frames import find_driven_points
from orchestrator.ports.panel import surface_ahead
from tests.coupling.line import FreeFrame, HungPlate, Sphere, point, push

LENGTH_S = 0.1
EXTRAPOLATING = [name for name in SCHEMES if name != "serial-staggered"]
every_scheme = pytest.mark.parametrize("name", EXTRAPOLATING)


@dataclass
class Told(HungPlate):
    """Keeps what it was told of its clamp last."""

    received: list[Motion] = field(default_factory=list)

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        self.received.append(clamps)
        return super().advance(interval, clamps, load)


@dataclass
class PushedFrame(FreeFrame):
    """A free mass with a constant force on it besides."""

    force_N: float = 0.0

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        return super().advance(interval, Load(reaction.force_N + push(self.force_N).force_N))


@dataclass
class DrivenFrame(FreeFrame):
    """Carries its point as x = sin(t), whatever pushes it."""

    def initial(self) -> Motion:
        return at(0.0)

    def ahead(self, interval: Interval) -> Known:
        return Known(at(interval.end_s), np.array([True]))

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        return at(interval.end_s)


def at(time_s: float) -> Motion:
    return point(float(np.sin(time_s)), float(np.cos(time_s)))


class DrivenPlate(Told):
    """A plate that is its clamp."""

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        return clamps

    def initial(self) -> PanelState:
        return PanelState(at(0.0), push(0.0))

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        self.received.append(clamps)
        return PanelState(clamps, load)


@dataclass
class Seeing(Sphere):
    """Keeps the paths that it was shown."""

    paths: list[HermitePath] = field(default_factory=list)

    def advance(self, interval: Interval, path: HermitePath) -> Load:
        self.paths.append(path)
        return super().advance(interval, path)


def run(name: str, solvers: Solvers, intervals: int) -> list[State]:
    state, way = initial_state(solvers), create_scheme(name)
    states = [state]
    for index in range(intervals):
        state = way.advance(solvers, Interval(index, LENGTH_S), state)
        states.append(state)
    return states


def test_extrapolated_clamps_are_exact_at_constant_acceleration() -> None:
    """x = 2 + 3 t - 5 t^2 / 2."""
    end = extrapolate(point(2.0, 3.0), np.array([[-5.0, 0.0, 0.0]]), 0.2)
    assert end.position_m[0] == pytest.approx([2.0 + 0.6 - 0.1, 0.0, 0.0], rel=1e-14)
    assert end.velocity_m_per_s[0] == pytest.approx([2.0, 0.0, 0.0], rel=1e-14)


@every_scheme
def test_a_panel_on_a_frame_that_speeds_up_evenly_is_told_where_it_will_be(name: str) -> None:
    """A frame of 2 kg under 3 N, a panel that does not push it; from the second interval on, when
    an acceleration has been seen."""
    panel = Told(1.0, 0.0)
    states = run(name, Solvers(PushedFrame(2.0, force_N=3.0), panel, None), 4)
    for motion, state in zip(panel.received[1:], states[2:], strict=True):
        assert motion.position_m == pytest.approx(state.clamps.position_m, rel=1e-13)
        assert motion.velocity_m_per_s == pytest.approx(state.clamps.velocity_m_per_s, rel=1e-13)
    first = extrapolate(states[0].clamps, np.zeros((1, 3)), LENGTH_S)
    assert panel.received[0].position_m == pytest.approx(first.position_m, abs=1e-15)


@every_scheme
def test_a_panel_on_a_driven_frame_is_told_where_the_drive_has_it(name: str) -> None:
    """The forecast holds from the first interval on, bit for bit; the plate itself is free to swing."""
    panel, sphere = Told(1.0, 4.0), Sphere(1.0, 5.0, -0.01, 0.0)
    states = run(name, Solvers(DrivenFrame(1.0), panel, sphere), 4)
    last_told = panel.received[-1]
    assert (last_told.position_m == states[-1].clamps.position_m).all()
    assert (last_told.velocity_m_per_s == at(4 * LENGTH_S).velocity_m_per_s).all()


@every_scheme
def test_particles_see_the_true_path_of_what_is_driven(name: str) -> None:
    """Cubic Hermite between exact ends: off by no more than H^4 / 384 of the fourth derivative, in
    velocity by H^3 sqrt(3) / 216 of it; on the way, nothing is run twice."""
    sphere = Seeing(1.0, 5.0, -0.01, 0.0)
    run(name, Solvers(DrivenFrame(1.0), DrivenPlate(1.0, 0.0), sphere), 4)
    assert len(sphere.paths) == 4
    for index, path in enumerate(sphere.paths):
        for fraction in np.linspace(0.0, 1.0, 9):
            time_s = (index + fraction) * LENGTH_S
            off = path.position_m(fraction)[0, 0] - np.sin(time_s)
            assert abs(off) <= LENGTH_S**4 / 384 * np.sin((index + 1) * LENGTH_S) + 1e-15
            off = path.velocity_m_per_s(fraction)[0, 0] - np.cos(time_s)
            assert abs(off) <= 3**0.5 / 216 * LENGTH_S**3 * np.sin((index + 1) * LENGTH_S) + 1e-15


def test_what_is_not_driven_is_not_known() -> None:
    """The surface of a panel that says nothing of it is not known, either."""
    free = Solvers(FreeFrame(1.0, v=0.5), HungPlate(1.0, 0.0), None)
    known = forecast(free, Interval(0, LENGTH_S), initial_state(free))
    assert known.surface is None
    assert not known.is_settled
    assert known.clamps.position_m[0, 0] == pytest.approx(0.05)
    driven = Solvers(DrivenFrame(1.0), HungPlate(1.0, 0.0), None)
    assert forecast(driven, Interval(0, LENGTH_S), initial_state(driven)).surface is None


def test_known_points_among_others() -> None:
    known = Known(point(1.0, 2.0), np.array([True])).among(3, np.array([1]))
    assert known.which.tolist() == [False, True, False]
    rest = Motion(np.full((3, 3), 7.0), np.full((3, 3), 8.0))
    over = known.over(rest)
    assert over.position_m[:, 0].tolist() == [7.0, 1.0, 7.0]
    assert over.velocity_m_per_s[:, 0].tolist() == [8.0, 2.0, 8.0]
    assert known.part(slice(1, 3)).which.tolist() == [True, False]


class OneRank:
    """A communicator of one process."""

    rank, size = 0, 1

    def bcast(self, value: object) -> object:
        return value

    def allgather(self, value: object) -> list[object]:
        return [value]

    def Bcast(self, numbers: object) -> None:
        """Leave the numbers as they are."""


def frames_around(inner: Frames) -> list[Frames]:
    return [MeteredFrames(inner, "frames", Stopwatch()), FramesOnFirstRank(OneRank(), lambda: inner)]


@pytest.mark.parametrize("which", range(2))
def test_what_stands_around_frames_passes_on_what_is_known(which: int) -> None:
    interval = Interval(3, LENGTH_S)
    driven, free = (frames_around(inner)[which] for inner in (DrivenFrame(1.0), FreeFrame(1.0)))
    driven.initial()
    free.initial()
    known = find_driven_points(driven, interval)
    assert known is not None
    assert known.motion.position_m[0, 0] == np.sin(0.4)
    assert find_driven_points(free, interval) is None


@every_scheme
def test_where_frames_go_that_feel_nothing_is_known_ahead(name: str) -> None:
    """Free ones under a force that grows, so that no extrapolation is right; they move once."""
    panel, frame = Told(1.0, 4.0), PushedFrame(2.0, v=0.3)
    frames, way = UnpushedFrames(frame), create_scheme(name)
    solvers = Solvers(frames, panel, None)
    state = initial_state(solvers)
    for index in range(4):
        frame.force_N += 1.0
        state = way.advance(solvers, Interval(index, LENGTH_S), state)
        assert (panel.received[-1].position_m == state.clamps.position_m).all()
        assert (panel.received[-1].velocity_m_per_s == state.clamps.velocity_m_per_s).all()
    assert frame.v == pytest.approx(0.3 + (1 + 2 + 3 + 4) * LENGTH_S / 2)


def panels_around(inner: Panel) -> list[Panel]:
    twice = csr_array(np.ones((2, 1)))
    return [
        UnloadedPanel(inner),
        TimedPanel(inner, "panel", "panel", Stopwatch()),
        MeteredPanel(inner, "panels", "mapping", Stopwatch()),
        MappedPanel(inner, twice),
        PanelSet(2, lambda i: inner),
        PanelSet(2, lambda i: inner, OneRank()),
    ]


@pytest.mark.parametrize("which", range(6))
def test_what_stands_around_panels_passes_on_what_is_known(which: int) -> None:
    interval, panels = Interval(3, LENGTH_S), panels_around(DrivenPlate(1.0, 0.0))
    clamps = len(panels[which].mount.frame)
    end = Motion(np.full((clamps, 3), 7.0), np.full((clamps, 3), 8.0))
    ahead = surface_ahead(panels[which])(interval, Known(end, np.ones(clamps, dtype=np.bool_)))
    assert ahead.which.all()
    assert ahead.motion.position_m.tolist() == np.full((len(ahead.which), 3), 7.0).tolist()
    assert ahead.motion.velocity_m_per_s.tolist() == np.full((len(ahead.which), 3), 8.0).tolist()
    silent = panels_around(HungPlate(1.0, 0.0))[which]
    assert not surface_ahead(silent)(interval, Known(end, np.ones(clamps, dtype=np.bool_))).which.any()


def test_a_panel_whose_clamps_are_held_is_known_to_stand_still() -> None:
    panel = PanelBetweenStillClamps(DrivenPlate(1.0, 0.0))
    end = Known(point(7.0, 8.0), np.array([False]))
    ahead = panel.ahead(Interval(3, LENGTH_S), end)
    assert ahead.which.all()
    assert not ahead.motion.position_m.any()
    assert not ahead.motion.velocity_m_per_s.any()
