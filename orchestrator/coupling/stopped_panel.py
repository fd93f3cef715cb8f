"""The wrapper of a panel that can come to lie on beams below it.

A stop is a flat top under a length of the panel, carried by a frame.  Points of the panel that have come
through it are pushed back along the top's normal with the pressure

    p = max(k g + c dg/dt, 0),   g > 0 the depth,

of a Winkler layer with a damper.  The pressure acts on points of the panel's mesh through the solver's own
interpolation and on three points of the top, so that force, torque and virtual work pass without
loss.  It is evaluated in the middle of the interval, as the motion at the start predicts it, and is
constant over the interval.  The method is exact in momentum, of second order in energy, and stable up to
k = 4 m / dt^2 for a mass m per area (docs/theory/panel_stops.md).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_array

from orchestrator.coupling.wrappers import PanelWrapper
from orchestrator.ports import (
    Account,
    Array,
    Indices,
    Known,
    Load,
    MeshedPanel,
    Motion,
    Mount,
    PanelState,
    Saved,
    check_point_count,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import Foot, Rectangle, foot_on_triangle
from orchestrator.ports.plans import PanelPlan, StopPlan
from orchestrator.ports.state import restore_attributes, save_attributes


@dataclass(frozen=True)
class Tops:
    """All stops of a panel.

    For its n points that can meet a stop it has the material coordinates (n, 2), the number of the stop (n,),
    and stiffness and damping of the layer under the point (n,).
    """

    coordinates_m: Array
    stop: Indices
    stiffness_N_per_m: Array
    damping_N_s_per_m: Array


def tops(stops: tuple[StopPlan, ...], rectangle: Rectangle, spacing_m: Array) -> Tops:
    """Return all tops, with points in the middles of cells of at most ``spacing_m`` (2,)."""
    coordinates, number, areas = [], [], []
    for place, stop in enumerate(stops):
        sides_m = np.array([stop.to_m - stop.from_m, rectangle.width_m])
        counts = np.ceil(sides_m / spacing_m - 1e-9).astype(int)
        s, y = ((np.arange(n) + 0.5) * side / n for n, side in zip(counts, sides_m, strict=True))
        grid = np.stack(np.meshgrid(stop.from_m + s, y, indexing="ij"), axis=-1).reshape(-1, 2)
        coordinates.append(grid)
        number.append(np.full(len(grid), place))
        areas.append(np.full(len(grid), sides_m.prod() / len(grid)))
    of, area_m2 = np.concatenate(number), np.concatenate(areas)
    stiffness, damping = np.array([(s.stiffness_Pa_per_m, s.damping_Pa_s_per_m) for s in stops])[of].T
    return Tops(np.concatenate(coordinates), of, stiffness * area_m2, damping * area_m2)


def corners_m(stop: StopPlan, rectangle: Rectangle) -> Array:
    """Return the top's corners (3, 3) in the world at t = 0, with the panel straight between its clamps."""
    below_m = rectangle.corner_m - stop.gap_m * rectangle.normal
    ends = np.array([[stop.from_m, 0.0], [stop.to_m, 0.0], [stop.from_m, rectangle.width_m]])
    return np.asarray(rectangle.mounted(ends) - rectangle.corner_m + below_m)


POINTS_PER_CELL = 2  # along and across, of the panel's mesh


class StoppedPanel(PanelWrapper):
    """A ``MeshedPanel`` on stops; the tops' points, three for each stop, follow the clamp points.

    Raises ValueError if the panel lies on a stop before anything moves: no solver finds the rest of
    a panel on beams.
    """

    STATE = ("_corners", "_surface", "_lost_J", "_from_stops_J", "_to_panel_J")

    def __init__(self, panel: MeshedPanel, plan: PanelPlan) -> None:
        super().__init__(panel)
        self.interpolation = panel.interpolation
        at = plan.rectangle
        cell_m = np.divide((at.length_m, at.width_m), plan.cells)
        self._tops = tops(plan.stops, at, cell_m / POINTS_PER_CELL)
        self._H = panel.interpolation(self._tops.coordinates_m).values
        self._HT = csr_array(self._H.T)
        corners = np.concatenate([corners_m(stop, at) for stop in plan.stops])
        frames = tuple(stop.frame for stop in plan.stops for _ in range(3))
        self._clamps = len(panel.mount.frame)
        self.mount = Mount(np.vstack([panel.mount.position_m, corners]), (*panel.mount.frame, *frames))
        self._corners = Motion(corners, np.zeros_like(corners))
        self._surface = panel.initial().surface
        self._lost_J = self._from_stops_J = self._to_panel_J = 0.0
        depth_m = self._depths_m()
        if (deepest := int(np.argmax(depth_m))) >= 0 and depth_m[deepest] > 0:
            name = plan.stops[self._tops.stop[deepest]].name
            raise ValueError(
                f"panel {plan.name} lies on its stop {name} before anything moves, "
                f"{depth_m[deepest]:.3g} m below its top"
            )

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Return the surface motion that follows from the panel's own clamps; particles touch no tops."""
        return super().ahead(interval, clamps.part(slice(self._clamps)))

    def initial(self) -> PanelState:
        return self._add_stop_reaction(super().initial(), np.zeros_like(self._corners.position_m))

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        check_point_count("stopped panel's clamps and stops", clamps, len(self.mount.frame))
        own, corners = clamps.part(slice(self._clamps)), clamps.part(slice(self._clamps, None))
        middle, elastic_N, damping_N = self._stop_forces(corners, interval.length_s)
        force_N = (elastic_N + damping_N)[:, None] * middle.normal
        state = super().advance(interval, own, Load(load.force_N + self._HT @ force_N))
        self._book(state.surface, corners, middle, force_N, damping_N)
        on_corners_N = np.zeros((len(corners) // 3, 3, 3))
        np.add.at(on_corners_N, self._tops.stop, middle.share[:, :, None] * -force_N[:, None, :])
        return self._add_stop_reaction(state, on_corners_N.reshape(-1, 3))

    def account(self) -> Account:
        """Return the account of the panel and of the layers on the stops."""
        own, depth_m = super().account(), np.maximum(self._depths_m(), 0.0)
        stored_J = {"stops": 0.5 * float(self._tops.stiffness_N_per_m @ depth_m**2)}
        received_J = dict(own.received_J)
        received_J["load"] -= self._to_panel_J
        received_J["clamps"] += self._from_stops_J
        return replace(
            own,
            stored_J={**own.stored_J, **stored_J},
            lost_J={**own.lost_J, "stop_damping": self._lost_J},
            received_J=received_J,
        )

    def save(self) -> Saved:
        return {"panel": super().save(), **save_attributes(self, *self.STATE)}

    def restore(self, saved: Saved) -> None:
        super().restore(saved["panel"])
        restore_attributes(self, saved, *self.STATE)

    def _add_stop_reaction(self, state: PanelState, on_corners_N: Array) -> PanelState:
        return PanelState(state.surface, Load(np.vstack([state.reaction.force_N, on_corners_N])))

    def _feet(self, of_corners_m: Array, place_m: Array) -> Foot:
        """Return the feet of points at ``place_m`` (n, 3) on their tops, whose corners (3 stops, 3) are at
        ``of_corners_m``."""
        return foot_on_triangle(of_corners_m.reshape(-1, 3, 3)[self._tops.stop], place_m)

    def _depths_m(self) -> Array:
        """Return the depths (n,) by which the points have come through their tops now."""
        return -self._feet(self._corners.position_m, self._H @ self._surface.position_m).height_m

    def _stop_forces(self, end: Motion, length_s: float) -> tuple[Foot, Array, Array]:
        """Return the points' places in the middle of the interval, and the springs' and the dampers' forces
        (n,) along the normals."""
        start, velocity_m_per_s = self._corners.position_m, self._H @ self._surface.velocity_m_per_s
        place_m = self._H @ self._surface.position_m + length_s / 2 * velocity_m_per_s
        middle = self._feet((start + end.position_m) / 2, place_m)
        tops_m_per_s = self._at_feet(middle, (end.position_m - start) / length_s)
        closing_m_per_s = np.einsum("nk,nk->n", middle.normal, tops_m_per_s - velocity_m_per_s)
        depth_m = -middle.height_m
        elastic_N = np.where(depth_m > 0, self._tops.stiffness_N_per_m * depth_m, 0.0)
        damping_N = np.where(depth_m > 0, self._tops.damping_N_s_per_m * closing_m_per_s, 0.0)
        return middle, elastic_N, np.maximum(damping_N, -elastic_N)

    def _at_feet(self, middle: Foot, of_corners: Array) -> Array:
        """Return values (n, 3) at the points' feet, interpolated from values at the corners."""
        corners = of_corners.reshape(-1, 3, 3)[self._tops.stop]
        return np.asarray(np.einsum("nc,nck->nk", middle.share, corners))

    def _book(self, surface: Motion, corners: Motion, middle: Foot, force_N: Array, damping_N: Array) -> None:
        moved_m = self._H @ (surface.position_m - self._surface.position_m)
        tops_m = self._at_feet(middle, corners.position_m - self._corners.position_m)
        self._to_panel_J += float(np.vdot(force_N, moved_m))
        self._from_stops_J += float(np.vdot(force_N, tops_m))
        closed_m = np.einsum("nk,nk->n", middle.normal, tops_m - moved_m)
        self._lost_J += float(damping_N @ closed_m)
        self._surface, self._corners = surface, corners
