"""Plans and motions for the tests of the finite-element panels."""

from __future__ import annotations

import numpy as np

from orchestrator.ports import Array, Load, Motion, Panel, PanelState
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import AperturePattern, Rectangle
from orchestrator.ports.plans import HyperelasticPlan, PanelPlan

# Polyurethane of the FFS0827 screen: C10 and C01 as the paper prints them, K = 2 GPa.
C10_PA, C01_PA, BULK_PA = 7e5, 2.8e6, 2e9
BRANCHES = ((0.1, 1e-2), (0.1, 2e-3), (0.1, 4e-4), (0.1, 8e-5))


def plan(
    *,
    length_m: float = 0.33,
    span_m: float | None = None,
    width_m: float = 0.05,
    thickness_m: float = 0.004,
    clamp_m: float = 0.02,
    cells: tuple[int, int] = (16, 1),
    integrator: str = "explicit",
    step_s: float = 0.0,
    gravity_m_per_s2: float = 9.81,
    density_kg_per_m3: float = 1200.0,
    branches: tuple[tuple[float, float], ...] = (),
    sync_interval_s: float = 1e-4,
    apertures: AperturePattern | None = None,
    joined_sides: bool = False,
    clamp_angle_deg: float = 0.0,
    moulded_sag_m: float = 0.0,
) -> PanelPlan:
    """A panel along x, its width along y, gravity down z."""
    rectangle = Rectangle(
        corner_m=np.array([0.1, -0.2, 0.3]),
        along=np.array([1.0, 0.0, 0.0]),
        across=np.array([0.0, 1.0, 0.0]),
        length_m=length_m,
        span_m=length_m if span_m is None else span_m,
        width_m=width_m,
        clamp_m=clamp_m,
        clamp_angle_deg=clamp_angle_deg,
    )
    return PanelPlan(
        name="panel 1",
        rectangle=rectangle,
        frames=("driving", "driven"),
        thickness_m=thickness_m,
        material=HyperelasticPlan(density_kg_per_m3, C10_PA, C01_PA, BULK_PA, branches),
        gravity_m_per_s2=np.array([0.0, 0.0, -gravity_m_per_s2]),
        cells=cells,
        step_s=step_s,
        integrator=integrator,
        sync_interval_s=sync_interval_s,
        apertures=apertures,
        joined_sides=joined_sides,
        moulded_sag_m=moulded_sag_m,
    )


def second_clamp(panel: Panel) -> Array:
    """(clamps,) 1 where the second frame holds the point, else 0."""
    return np.array([float(frame == "driven") for frame in panel.mount.frame])


def shaken(panel: Panel, time_s: float, amplitude_m: float = 0.006, speed: float = 78.5) -> Motion:
    """The second clamp moves along x by  A sin^2(w t / 2), so that it starts smoothly."""
    moved = np.zeros_like(panel.mount.position_m)
    rate = np.zeros_like(moved)
    moved[:, 0] = second_clamp(panel) * amplitude_m * np.sin(0.5 * speed * time_s) ** 2
    rate[:, 0] = second_clamp(panel) * 0.5 * amplitude_m * speed * np.sin(speed * time_s)
    return Motion(panel.mount.position_m + moved, rate)


def shake(panel: Panel, length_s: float, intervals: int) -> tuple[list[PanelState], PanelState]:
    """All states of a panel whose second clamp is shaken, and the initial one."""
    initial = panel.initial()
    unloaded = Load.zero(len(initial.surface))
    states = [
        panel.advance(Interval(k, length_s), shaken(panel, (k + 1) * length_s), unloaded)
        for k in range(intervals)
    ]
    return states, initial


def height_m(state: PanelState) -> float:
    """World z of the panel's middle point."""
    return float(state.surface.position_m[len(state.surface) // 2, 2])


def pull_N(panel: Panel, state: PanelState) -> float:
    """Force along x on the second frame."""
    return float(second_clamp(panel) @ state.reaction.force_N[:, 0])


def difference(value: Array, reference: Array) -> float:
    """Relative L2 norm of  value - reference."""
    return float(np.linalg.norm(value - reference) / np.linalg.norm(reference))


def defect_J(panel: Panel, stored_at_start_J: float) -> float:
    """Return the energy that a panel's account fails to explain, in J."""
    account = panel.account()
    return (
        sum(account.stored_J.values())
        - stored_at_start_J
        + sum(account.lost_J.values())
        - sum(account.received_J.values())
    )
