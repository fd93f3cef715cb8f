"""Members whose hand-over is turned off are members: of any scheme, and to be taken back."""

from __future__ import annotations

from collections.abc import Callable

import pytest

from orchestrator.coupling.ablation import (
    PanelBetweenStillClamps,
    ParticlesOnStillSurface,
    UnloadedPanel,
    UnpushedFrames,
)
from orchestrator.coupling.schemes import SCHEMES, create_scheme
from orchestrator.coupling.schemes.scheme import Solvers, State, initial_state
from orchestrator.ports import Saved
from orchestrator.ports.clock import Interval
from orchestrator.ports.state import as_arrays
from tests.coupling.line import FreeFrame, HungPlate, Sphere, members, point
from tests.saved_states import differences

INTERVAL_S = 1e-3


def machine() -> Solvers:
    """The sphere hits the plate at once, the plate pulls the frame, the frame moves."""
    return members(Sphere(1.0, 1e4, 1e-3, -1.0), HungPlate(1.0, 1e5), FreeFrame(5.0, v=0.5))


def without_reaction(whole: Solvers) -> Solvers:
    return Solvers(UnpushedFrames(whole.frames), whole.panel, whole.particles)


def without_frame_motion(whole: Solvers) -> Solvers:
    return Solvers(whole.frames, PanelBetweenStillClamps(whole.panel), whole.particles)


def without_load(whole: Solvers) -> Solvers:
    return Solvers(whole.frames, UnloadedPanel(whole.panel), whole.particles)


def without_panel_motion(whole: Solvers) -> Solvers:
    assert whole.particles is not None
    still = ParticlesOnStillSurface(whole.particles, point(0.0, 0.0))
    return Solvers(whole.frames, whole.panel, still)


WITHOUT = [without_reaction, without_frame_motion, without_load, without_panel_motion]


def advanced(solvers: Solvers, name: str, state: State, intervals: range) -> State:
    chosen = create_scheme(name)
    for index in intervals:
        state = chosen.advance(solvers, Interval(index, INTERVAL_S), state)
    return state


def saved(solvers: Solvers) -> Saved:
    parts = {"frames": solvers.frames, "panel": solvers.panel, "particles": solvers.particles}
    return {name: solver.save() for name, solver in parts.items()}


@pytest.mark.parametrize("name", SCHEMES)
@pytest.mark.parametrize("without", WITHOUT)
def test_every_scheme_runs_without_it(without: Callable[[Solvers], Solvers], name: str) -> None:
    """The scheme ends elsewhere than with the effect; the sphere has touched the plate."""
    ends = []
    for solvers in (machine(), without(machine())):
        ends.append(advanced(solvers, name, initial_state(solvers), range(5)))
        assert ends[-1].load.force_N.any()
    assert differences(*map(as_arrays, ends)) != []


@pytest.mark.parametrize("without", WITHOUT)
def test_members_step_back_and_others_take_over(without: Callable[[Solvers], Solvers]) -> None:
    """Bit for bit."""
    first, second = without(machine()), without(machine())
    state = advanced(first, "particles-first", initial_state(first), range(5))
    before = saved(first)
    ends = [as_arrays(advanced(first, "particles-first", state, range(5, 10)))]
    assert differences(before, saved(first)) != []
    for solvers in (first, second):
        for name in before:
            getattr(solvers, name).restore(before[name])
        assert differences(before, saved(solvers)) == []
        ends.append(as_arrays(advanced(solvers, "particles-first", state, range(5, 10))))
    assert differences(ends[0], ends[1]) == []
    assert differences(ends[0], ends[2]) == []


def test_robin_without_any_known_mass_is_particles_first() -> None:
    """Bit for bit; the panel does not yield to what it does not feel."""
    ends = []
    for name in ("robin", "particles-first"):
        solvers = without_load(machine())
        ends.append(as_arrays(advanced(solvers, name, initial_state(solvers), range(10))))
    assert differences(*ends) == []
