"""The panel port around a finite-element body, which is opened at rest."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack
from typing import Protocol

import numpy as np
from scipy.sparse import csr_array, identity

from adapters.panel.common.grid import ElementGrid
from adapters.panel.common.panel import Body, BodyPanel, choose_step_s
from adapters.panel.common.solid_grid import PiercedGrid
from adapters.panel.finite_element import integrators
from adapters.panel.finite_element.panel_at_rest import PanelAtRest
from adapters.panel.finite_element.structure import Structure
from adapters.panel.finite_element.tangent import Tangent
from orchestrator.ports import Array, HermitePath, Indices, Inertia, Interpolation, Known, Motion, Mount
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import PanelPlan, SolverFailed


class ElasticBody(Body, Protocol):
    """A body that particles touch."""

    @property
    def surface(self) -> Indices | slice:
        """The nodes that particles touch, in the order of their grid."""
        ...


MakeBody = Callable[[Structure, Indices, Array, float], ElasticBody]
"""A function that makes a body from a structure, its surface's nodes, the shape at rest and a step in s."""


class ElasticPanel(BodyPanel):
    """A ``MeshedPanel`` around a finite-element body, which is at rest when t = 0.

    Its clamp points are the held nodes of the body, its surface points the nodes of ``grid``.
    """

    _body: ElasticBody

    def __init__(self, plan: PanelPlan, body: ElasticBody, grid: ElementGrid | PiercedGrid) -> None:
        held_m = body.position_m[body.held]
        along_m = (held_m - plan.rectangle.corner_m) @ plan.rectangle.along
        second = along_m > 0.5 * plan.rectangle.span_m  # the nearer clamp's frame holds a point
        super().__init__(plan, Mount(held_m, tuple(plan.frames[int(end)] for end in second)), body)
        self._grid = grid
        self._waves_m_per_s = (plan.material.youngs_modulus_Pa / plan.material.density_kg_per_m3) ** 0.5
        self._surface = self._surface_motion()

    def interpolation(self, coordinates_m: Array) -> Interpolation:
        return self._grid.interpolation(coordinates_m)

    def inertia(self) -> Inertia:
        """Return the inertia of the free nodes on the surface."""
        body, on_surface = self._body, self._surface_nodes()
        free = np.setdiff1d(on_surface, body.held)
        shapes = identity(len(body.mass_kg), format="csr")[on_surface][:, free]
        return Inertia(csr_array(shapes), body.mass_kg[free], np.zeros((len(free), 3)))

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Return the motion of the held nodes on the surface."""
        nodes = len(self._body.mass_kg)
        return clamps.among(nodes, self._body.held).part(self._surface_nodes())

    def _static_reaction_N(self) -> Array:
        return np.asarray((self._weight_N - self._body.internal_N)[self._body.held])

    def _move(self, interval: Interval, clamps: Motion, load_N: Array) -> tuple[Motion, Array, float]:
        body, held = self._body, self._body.held
        outside_N = self._weight_N.copy()
        outside_N[body.surface] += load_N
        start_m, start_m_per_s = body.position_m[held], body.velocity_m_per_s[held]
        on_held = body.move(HermitePath(self._clamps, clamps, interval.length_s), outside_N, interval)
        self._check_speed(interval, float(np.abs(body.velocity_m_per_s).max()))
        end_m_per_s, on_clamps_N = body.velocity_m_per_s[held], outside_N[held]
        gained_N_s = self._mass_kg[held] * (end_m_per_s - start_m_per_s)
        clamps_J = (
            0.5 * float(np.vdot(gained_N_s, end_m_per_s + start_m_per_s))
            + on_held.work_J
            - float(np.vdot(on_clamps_N, body.position_m[held] - start_m))
        )
        reaction_N = on_clamps_N - (gained_N_s + on_held.impulse_N_s) / interval.length_s
        return self._surface_motion(), reaction_N, clamps_J

    def _surface_nodes(self) -> Indices:
        return np.arange(len(self._body.mass_kg))[self._body.surface]

    def _surface_motion(self) -> Motion:
        body = self._body
        return Motion(np.array(body.position_m[body.surface]), np.array(body.velocity_m_per_s[body.surface]))

    def _check_speed(self, interval: Interval, fastest_m_per_s: float) -> None:
        """Raise SolverFailed where a node outruns elastic waves, which it does if the solution blew up."""
        if not fastest_m_per_s < self._waves_m_per_s:
            raise SolverFailed(
                f"{self._name}, t = {interval.end_s:.6g} s: unstable, a node moves at "
                f"{fastest_m_per_s:.3g} m/s (elastic waves: {self._waves_m_per_s:.3g} m/s); "
                "take a smaller step"
            )


def open_panel(
    plan: PanelPlan,
    rest: PanelAtRest,
    structure: Structure,
    grid: ElementGrid | PiercedGrid,
    surface: Indices,
    make_explicit: MakeBody = integrators.Explicit,
    explicit_panel: type[ElasticPanel] | None = None,
) -> ElasticPanel:
    """Open the panel at rest between its clamps.

    ``make_explicit`` makes the body with explicit steps, and ``explicit_panel`` the panel around it.

    Raises ValueError for a step that is too large.
    """
    resting_m = plan.rectangle.corner_m + rest.from_corner_m
    with ExitStack() as failed:
        failed.callback(structure.close)
        step_s = choose_step_s(plan, *rest.step_limits_s)
        body: ElasticBody
        kind = ElasticPanel
        if plan.integrator == "explicit":
            body, kind = make_explicit(structure, surface, resting_m, step_s), explicit_panel or kind
        else:
            tangent = Tangent(structure)
            failed.callback(tangent.close)
            body = integrators.GeneralizedAlpha(structure, surface, resting_m, step_s, tangent, plan.name)
        failed.pop_all()
    return kind(plan, body, grid)
