"""A panel on stops: closed forms, momentum and energy, on the strip and on the finite elements."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from orchestrator.coupling.stopped_panel import StoppedPanel
from orchestrator.ports import Account, Array, Interpolation, Known, Load, Motion, Mount, PanelState
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import PanelPlan, StopPlan
from tests.panel.elastic_plans import plan
from tests.saved_states import differences

SOLVERS = [
    "strip",
    pytest.param("sheet", marks=pytest.mark.solver),
    pytest.param("solid", marks=pytest.mark.solver),
]
ALONG = {"strip": 12, "sheet": 6, "solid": 4}  # cells, as many as half cells over the stop
DENSITY_KG_PER_M3, THICKNESS_M = 1200.0, 0.004
AREAL_KG_M2 = DENSITY_KG_PER_M3 * THICKNESS_M
INTERVAL_S = 1e-4


def stop(q: float, gap_m: float = 0.002, damping_ratio: float = 0.0, frame: str = "driving") -> StopPlan:
    """All along the middle half; ``q`` = k dt^2 / m, the limit is 4."""
    stiffness = q * AREAL_KG_M2 / INTERVAL_S**2
    damping = 2 * damping_ratio * np.sqrt(stiffness * AREAL_KG_M2)
    return StopPlan("beam", frame, 0.03, 0.09, gap_m, stiffness, damping)


def stopped(solver: str, stops: tuple[StopPlan, ...], **changes: object) -> StoppedPanel:
    cells = (ALONG[solver], 1)
    made: PanelPlan = plan(length_m=0.12, cells=cells, clamp_m=0.02, **changes)
    if solver == "solid":
        made = replace(made, integrator="implicit")
    made = replace(made, stops=stops)
    return StoppedPanel(import_module(f"adapters.panel.{solver}").build(made), made)


def mount(panel: StoppedPanel, shift_m: Array, velocity_m_per_s: Array, which: Array) -> Motion:
    """The points ``which`` of the mount shifted and moving, the others where they are."""
    place, speed = panel.mount.position_m.copy(), np.zeros_like(panel.mount.position_m)
    place[which] += shift_m
    speed[which] = velocity_m_per_s
    return Motion(place, speed)


def tops(panel: StoppedPanel) -> Array:
    """Return which points of the mount are the stop's: the last three."""
    return np.arange(len(panel.mount.frame)) >= len(panel.mount.frame) - 3


def lift(panel: StoppedPanel, time_s: float, end_s: float, height_m: float) -> Motion:
    """The stop rises smoothly by ``height_m`` until ``end_s``."""
    t = min(time_s / end_s, 1.0)
    up, speed = height_m * (3 - 2 * t) * t**2, height_m * 6 * t * (1 - t) / end_s
    z = np.array([0.0, 0.0, 1.0])
    return mount(panel, up * z, speed * z, tops(panel))


def balance_J(panel: StoppedPanel) -> float:
    account = panel.account()
    kept = sum(account.stored_J.values()) + sum(account.lost_J.values())
    return float(kept - sum(account.received_J.values()))


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_panel_pressed_on_a_stop_rests_on_its_layer(solver: str) -> None:
    """The stop is raised by 3 mm through a gap of 2 mm: the clamps' and the stop's forces add up to
    the weight, and the stop carries k g over its points, whatever the panel is."""
    panel = stopped(
        solver, (stop(0.05, damping_ratio=0.5),), branches=((1.0, 3e-3), (0.5, 5e-4)), span_m=0.123
    )
    unloaded = Load.zero(len(panel.initial().surface))
    for index in range(2500):
        clamps = lift(panel, (index + 1) * INTERVAL_S, 0.1, 0.003)
        state = panel.advance(Interval(index, INTERVAL_S), clamps, unloaded)
    carried_N = -state.reaction.force_N[tops(panel)].sum(axis=0)
    weight_N = 9.81 * AREAL_KG_M2 * 0.16 * 0.05
    assert state.reaction.force_N.sum(axis=0)[2] == pytest.approx(-weight_N, rel=1e-3)
    assert carried_N[2] > 1.0  # many times the weight
    through_m = depths_m(solver, panel, state, clamps)
    assert through_m.max() > 0
    spring_N = stop(0.05).stiffness_Pa_per_m * 0.06 * 0.05 * np.mean(np.maximum(through_m, 0.0))
    assert carried_N[2] == pytest.approx(spring_N, rel=2e-3)


def depths_m(solver: str, panel: StoppedPanel, state: PanelState, clamps: Motion) -> Array:
    """Return the depths of the middles of cells half as large as the panel's, which the layer looks at."""
    along = ALONG[solver]
    s, y = np.meshgrid(0.03 + 0.06 * (np.arange(along) + 0.5) / along, [0.0125, 0.0375])
    places = panel.interpolation(np.column_stack([s.ravel(), y.ravel()])).values
    top_m = clamps.position_m[-3, 2]
    return np.asarray(top_m - (places @ state.surface.position_m)[:, 2])


class Plate:
    """A rigid plate that nothing holds, in place of a panel: x'' = F/m + g, exactly."""

    def __init__(self, made: PanelPlan, speed_m_per_s: float = 0.0) -> None:
        at = made.rectangle
        self.mass_kg = AREAL_KG_M2 * at.length_m * at.width_m
        self.gravity_m_per_s2 = made.gravity_m_per_s2
        self.mount = Mount(np.empty((0, 3)), ())
        corners = at.mounted(np.array([[0, 0], [at.length_m, 0], [0, at.width_m]]))
        self.size_m, self.load_N = np.array([at.length_m, at.width_m]), np.zeros((3, 3))
        self.surface = Motion(corners, np.tile([0.0, 0.0, -speed_m_per_s], (3, 1)))
        self.work_J = 0.0

    def initial(self) -> PanelState:
        return PanelState(self.surface, Load(np.empty((0, 3))))

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        dt, self.load_N = interval.length_s, load.force_N
        acceleration = load.force_N.sum(axis=0) / self.mass_kg + self.gravity_m_per_s2
        moved_m = dt * self.surface.velocity_m_per_s + dt**2 / 2 * acceleration
        self.work_J += float(np.vdot(load.force_N, moved_m))
        velocity_m_per_s = self.surface.velocity_m_per_s + dt * acceleration
        self.surface = Motion(self.surface.position_m + moved_m, velocity_m_per_s)
        return self.initial()

    def account(self) -> Account:
        speed_m_per_s = self.surface.velocity_m_per_s[0]
        momentum = self.mass_kg * speed_m_per_s
        return Account(
            momentum,
            np.zeros(3),
            stored_J={"kinetic": 0.5 * self.mass_kg * float(speed_m_per_s @ speed_m_per_s)},
            received_J={"load": self.work_J, "clamps": 0.0},
        )

    def interpolation(self, coordinates_m: Array) -> Interpolation:
        share = coordinates_m / self.size_m
        return Interpolation.on_surface(csr_array(np.column_stack([1 - share.sum(axis=1), share])))

    def close(self) -> None:
        pass


def bounced(q: float, damping_ratio: float, interval_s: float = INTERVAL_S) -> tuple[Plate, Any]:
    """A weightless plate thrown at 1 m/s onto a stop of the stiffness ``stop(q)`` under all of it,
    after it has left again."""
    made = plan(length_m=0.12, gravity_m_per_s2=0.0)
    whole = replace(stop(q, damping_ratio=damping_ratio), from_m=0.0, to_m=0.12)
    made = replace(made, stops=(whole,))
    plate = Plate(made, speed_m_per_s=1.0)
    panel = StoppedPanel(plate, made)
    still = mount(panel, np.zeros(3), np.zeros(3), tops(panel))
    for index in range(10000):
        panel.advance(Interval(index, interval_s), still, Load.zero(3))
        if plate.surface.velocity_m_per_s[0, 2] > 0 and plate.surface.position_m[0, 2] > 0.3:
            return plate, panel
    raise AssertionError("it never left")


@pytest.mark.parametrize("damping_ratio", [0.0, 0.1, 0.3])
def test_a_plate_bounces_as_the_spring_and_damper_let_it(damping_ratio: float) -> None:
    """Restitution of a spring and damper that never pull, from where their force is zero: Schwager,
    T. and Poeschel, T., Granular Matter 9, 2007, 465-469, doi 10.1007/s10035-007-0065-z; a hundred
    intervals per contact: 1e-2."""
    plate, panel = bounced(1e-3, damping_ratio)
    e = 1.0
    if damping_ratio:
        root = np.sqrt(1 - damping_ratio**2)
        angle = np.pi - np.arctan2(2 * damping_ratio * root, root**2 - damping_ratio**2)
        e = float(np.exp(-damping_ratio / root * angle))
    assert plate.surface.velocity_m_per_s[0, 2] == pytest.approx(e, rel=1e-2)
    account = panel.account()
    lost_J = 0.5 * plate.mass_kg * (1.0 - plate.surface.velocity_m_per_s[0, 2] ** 2)
    assert account.stored_J["stops"] == 0.0
    # the energy of the spring's last interval is what is not booked as damping
    assert account.lost_J["stop_damping"] == pytest.approx(lost_J, abs=0.01 * plate.mass_kg)


def test_energy_of_an_elastic_bounce_is_of_second_order() -> None:
    """The same layer at shorter intervals; the worst of several phases of touching down."""
    worst = []
    for split in (1, 2, 4):
        interval_s, errors = INTERVAL_S / split, []
        for phase in range(7):
            made_gap_m = 0.002 + phase / 7 * interval_s
            plate = _bounce_from(made_gap_m, 0.02, interval_s)
            errors.append(abs(plate.surface.velocity_m_per_s[0, 2] ** 2 - 1.0))
        worst.append(max(errors))
    assert worst[2] < 0.01
    assert worst[0] / worst[2] > 10.0  # 16 is second order


def _bounce_from(gap_m: float, q: float, interval_s: float) -> Plate:
    made = plan(length_m=0.12, gravity_m_per_s2=0.0)
    whole = replace(stop(q, gap_m=gap_m), from_m=0.0, to_m=0.12)
    made = replace(made, stops=(whole,))
    plate = Plate(made, speed_m_per_s=1.0)
    panel = StoppedPanel(plate, made)
    still = mount(panel, np.zeros(3), np.zeros(3), tops(panel))
    for index in range(int(0.02 / interval_s)):
        panel.advance(Interval(index, interval_s), still, Load.zero(3))
    return plate


@pytest.mark.parametrize(("q", "stays"), [(3.9, True), (4.1, False)])
def test_the_limit_of_stiffness(q: float, stays: bool) -> None:
    """A plate that is slowly pressed on an elastic layer stays on it, up to q = 4."""
    made = plan(length_m=0.12, gravity_m_per_s2=0.0)
    whole = replace(stop(q, gap_m=1e-12), from_m=0.0, to_m=0.12)
    plate = Plate(made)
    panel = StoppedPanel(plate, replace(made, stops=(whole,)))
    still = mount(panel, np.zeros(3), np.zeros(3), tops(panel))
    deepest_m, pressed_N = 0.0, 100.0
    for index in range(600):
        load = Load(np.tile([0.0, 0.0, -pressed_N / 3 * min(index / 400, 1.0)], (3, 1)))
        state = panel.advance(Interval(index, INTERVAL_S), still, load)
        deepest_m = max(deepest_m, 0.3 - float(state.surface.position_m[0, 2]))
    rest_m = pressed_N / (0.12 * 0.05 * whole.stiffness_Pa_per_m)
    assert (deepest_m < 2 * rest_m) == stays


def test_force_and_torque_pass_to_a_turning_top() -> None:
    """The load on the panel and the reaction at the top's corners, where they are in the middle of the
    interval, make up neither a force nor a couple, to rounding."""
    made = plan(length_m=0.12, gravity_m_per_s2=0.0)
    made = replace(made, stops=(stop(0.1, gap_m=1e-6),))
    plate = Plate(made, speed_m_per_s=0.5)
    panel = StoppedPanel(plate, made)
    start_m = panel.mount.position_m
    turn = Rotation.from_rotvec([0.02, 0.05, 0.01])
    end_m = turn.apply(start_m - start_m[0]) + start_m[0] + [0.001, 0.0, 0.002]
    before = plate.surface
    clamps = Motion(end_m, (end_m - start_m) / INTERVAL_S)
    state = panel.advance(Interval(0, INTERVAL_S), clamps, Load.zero(3))
    reaction_N = state.reaction.force_N
    assert np.abs(reaction_N).max() > 1.0
    np.testing.assert_allclose(
        reaction_N.sum(axis=0), -plate.load_N.sum(axis=0), atol=1e-12 * np.abs(reaction_N).max()
    )
    at_m = before.position_m + INTERVAL_S / 2 * before.velocity_m_per_s
    torque = np.cross(at_m, plate.load_N).sum(axis=0)
    torque += np.cross((start_m + end_m) / 2, reaction_N).sum(axis=0)
    np.testing.assert_allclose(torque, 0.0, atol=1e-12 * np.abs(reaction_N).max())


@pytest.mark.parametrize("solver", SOLVERS)
def test_energy_closes_while_a_panel_is_beaten(solver: str) -> None:
    """The stop swings through the panel's plane; what the books do not explain, over what the
    damper took: 2 %, the interval's error."""
    panel = stopped(solver, (stop(0.02, gap_m=0.001, damping_ratio=0.2),), span_m=0.123)
    start_J, unloaded = balance_J(panel), Load.zero(len(panel.initial().surface))
    for index in range(400):
        t = (index + 1) * INTERVAL_S
        up_m, speed = 0.003 * np.sin(157 * t / 2) ** 2, 0.003 * 78.5 * np.sin(157 * t)
        z = np.array([0.0, 0.0, 1.0])
        panel.advance(Interval(index, INTERVAL_S), mount(panel, up_m * z, speed * z, tops(panel)), unloaded)
    account = panel.account()
    assert account.lost_J["stop_damping"] > 3e-4
    assert abs(balance_J(panel) - start_J) < 0.02 * account.lost_J["stop_damping"]


def test_a_panel_that_lies_on_its_stop_is_refused() -> None:
    with pytest.raises(ValueError, match="stop"):
        stopped("strip", (stop(0.1, gap_m=0.001),), span_m=0.118)


def test_it_goes_on_bit_for_bit() -> None:
    def moved(panel: StoppedPanel, intervals: range) -> None:
        for index in intervals:
            clamps = lift(panel, (index + 1) * INTERVAL_S, 0.01, 0.004)
            panel.advance(Interval(index, INTERVAL_S), clamps, Load.zero(26 + 4))

    panels = [stopped("strip", (stop(0.1),)) for _ in range(2)]
    points = len(panels[0].initial().surface)
    assert points == 30
    moved(panels[0], range(80))
    saved = panels[0].save()
    panels[1].restore(saved)
    for panel in panels:
        moved(panel, range(80, 120))
    assert differences(panels[0].save(), panels[1].save()) == []
    assert panels[0].account().received_J["clamps"] > 1e-4  # the stop has pushed it


def test_what_a_panel_knows_of_its_clamps_it_knows_on_stops_too() -> None:
    """The tops do not matter: nothing that particles touch hangs on them."""
    panel = stopped("strip", (stop(0.5),))
    end = mount(panel, np.array([1e-4, 0.0, 0.0]), np.zeros(3), ~tops(panel))
    known = panel.ahead(Interval(0, INTERVAL_S), Known(end, ~tops(panel)))
    surface = panel.advance(Interval(0, INTERVAL_S), end, Load.zero(len(known.which))).surface
    which = known.which
    assert which.sum() == len(panel.mount.frame) - 3
    assert known.motion.position_m[which] == pytest.approx(surface.position_m[which], abs=1e-15)
    assert not panel.ahead(Interval(1, INTERVAL_S), Known(end, tops(panel))).which.any()
