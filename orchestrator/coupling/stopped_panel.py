"""A panel that can come to lie on beams below it: a wrapper around any panel solver.

A stop is a flat top under a length of the panel, carried by a frame.  What has come through it is
pushed back along the top's normal with the pressure

    p = max(k g + c dg/dt, 0),   g > 0 the depth,

of a Winkler layer with a damper.  It acts on points of the panel's mesh through the solver's own
interpolation and on three points of the top, so that force, torque and virtual work pass without
loss.  It is taken in the middle of the interval, as the motion at its start foretells it, and is
constant over it: exact in momentum, of second order in energy, stable up to k = 4 m / dt^2 for a
mass m per area (docs/theory/panel_stops.md).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.sparse import csr_array

from orchestrator.coupling.stop_tops import Through, corners_m, tops
from orchestrator.ports import (
    Account,
    Array,
    Inertia,
    Known,
    Load,
    MeshedPanel,
    Motion,
    Mount,
    PanelState,
    Saved,
    counted,
)
from orchestrator.ports.ahead import ahead_of
from orchestrator.ports.clock import Interval
from orchestrator.ports.inertia import inertia_of
from orchestrator.ports.plans import PanelPlan
from orchestrator.ports.state import restorable, restore_attributes, save_attributes

POINTS_PER_CELL = 2  # along and across, of the panel's mesh

_STATE = ("_corners", "_surface", "_lost_J", "_from_stops_J", "_to_panel_J")


class StoppedPanel:
    """``MeshedPanel``; the tops' points, three for each stop, follow the clamp points."""

    def __init__(self, panel: MeshedPanel, plan: PanelPlan) -> None:
        """Raises ValueError if the panel lies on a stop before anything moves: no solver finds the
        rest of a panel on beams."""
        at = plan.rectangle
        self._panel, self._stops = panel, len(plan.stops)
        self._follow = ahead_of(panel)
        cell_m = np.divide((at.length_m, at.width_m), plan.cells)
        self._tops = tops(plan.stops, at, cell_m / POINTS_PER_CELL)
        self._H = panel.interpolation(self._tops.coordinates_m)
        self._HT = csr_array(self._H.T)
        corners = np.concatenate([corners_m(stop, at) for stop in plan.stops])
        frames = tuple(stop.frame for stop in plan.stops for _ in range(3))
        self._clamps = len(panel.mount.frame)
        self.mount = Mount(np.vstack([panel.mount.position_m, corners]), (*panel.mount.frame, *frames))
        self._corners = Motion(corners, np.zeros_like(corners))
        self._surface = panel.initial().surface
        self._lost_J = self._from_stops_J = self._to_panel_J = 0.0
        self._refuse_rest_on(plan)

    def inertia(self) -> Inertia:
        return inertia_of(self._panel)

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Of the panel's own clamps; the tops carry nothing that particles touch."""
        return self._follow(interval, clamps.part(slice(self._clamps)))

    def initial(self) -> PanelState:
        return self._with(self._panel.initial(), np.zeros((3 * self._stops, 3)))

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        counted("stopped panel's clamps and stops", clamps, len(self.mount.frame))
        own, corners = clamps.part(slice(self._clamps)), clamps.part(slice(self._clamps, None))
        middle, elastic_N, damping_N = self._pushed(corners, interval.length_s)
        force_N = (elastic_N + damping_N)[:, None] * middle.normal
        state = self._panel.advance(interval, own, Load(load.force_N + self._HT @ force_N))
        self._book(state.surface, corners, middle, force_N, damping_N)
        on_corners_N = self._tops.onto_corners(middle.share, -force_N, self._stops)
        return self._with(state, on_corners_N.reshape(-1, 3))

    def account(self) -> Account:
        """Of the panel and the layers on the stops."""
        own, depth_m = self._panel.account(), np.maximum(self._now().depth_m, 0.0)
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
        return {"panel": restorable(self._panel).save(), **save_attributes(self, *_STATE)}

    def restore(self, saved: Saved) -> None:
        restorable(self._panel).restore(saved["panel"])
        restore_attributes(self, saved, *_STATE)

    def interpolation(self, coordinates_m: Array) -> csr_array:
        return self._panel.interpolation(coordinates_m)

    def close(self) -> None:
        self._panel.close()

    def _with(self, state: PanelState, on_corners_N: Array) -> PanelState:
        return PanelState(state.surface, Load(np.vstack([state.reaction.force_N, on_corners_N])))

    def _now(self) -> Through:
        place_m = self._H @ self._surface.position_m
        return self._tops.through(self._corners.position_m.reshape(-1, 3, 3), place_m)

    def _pushed(self, end: Motion, length_s: float) -> tuple[Through, Array, Array]:
        """Where the points are in the middle of the interval, and the springs' and the dampers'
        forces (n,) along the normals."""
        start, velocity_m_per_s = self._corners.position_m, self._H @ self._surface.velocity_m_per_s
        place_m = self._H @ self._surface.position_m + length_s / 2 * velocity_m_per_s
        middle = self._tops.through(((start + end.position_m) / 2).reshape(-1, 3, 3), place_m)
        tops_m_per_s = self._at_feet(middle, (end.position_m - start) / length_s)
        closing_m_per_s = np.einsum("nk,nk->n", middle.normal, tops_m_per_s - velocity_m_per_s)
        touching = middle.depth_m > 0
        elastic_N = np.where(touching, self._tops.stiffness_N_per_m * middle.depth_m, 0.0)
        damping_N = np.where(touching, self._tops.damping_N_s_per_m * closing_m_per_s, 0.0)
        return middle, elastic_N, np.maximum(damping_N, -elastic_N)

    def _at_feet(self, middle: Through, of_corners: Array) -> Array:
        """Values (n, 3) at the points' feet of values at the corners."""
        corners = of_corners.reshape(-1, 3, 3)[self._tops.stop]
        return np.asarray(np.einsum("nc,nck->nk", middle.share, corners))

    def _book(
        self, surface: Motion, corners: Motion, middle: Through, force_N: Array, damping_N: Array
    ) -> None:
        moved_m = self._H @ (surface.position_m - self._surface.position_m)
        tops_m = self._at_feet(middle, corners.position_m - self._corners.position_m)
        self._to_panel_J += float(np.vdot(force_N, moved_m))
        self._from_stops_J += float(np.vdot(force_N, tops_m))
        closed_m = np.einsum("nk,nk->n", middle.normal, tops_m - moved_m)
        self._lost_J += float(damping_N @ closed_m)
        self._surface, self._corners = surface, corners

    def _refuse_rest_on(self, plan: PanelPlan) -> None:
        depth_m = self._now().depth_m
        if (deepest := int(np.argmax(depth_m))) >= 0 and depth_m[deepest] > 0:
            name = plan.stops[self._tops.stop[deepest]].name
            raise ValueError(
                f"panel {plan.name} lies on its stop {name} before anything moves, "
                f"{depth_m[deepest]:.3g} m below its top"
            )
