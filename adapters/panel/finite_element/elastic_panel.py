"""The panel port around a structure and a time integrator, and how it is opened at rest."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import ExitStack, closing
from typing import Any, Protocol

import numpy as np
from scipy.sparse import csr_array, identity

from adapters.panel.common.body import Action, BodyState, HeldForce
from adapters.panel.finite_element import integrators
from adapters.panel.finite_element.grid import Interpolating, SurfaceNodes
from adapters.panel.finite_element.resting_shape import first_guess_m, settle
from adapters.panel.finite_element.structure import Structure
from adapters.panel.finite_element.tangent import Tangent
from orchestrator.ports import (
    Account,
    Array,
    HermitePath,
    Indices,
    Inertia,
    Known,
    Load,
    Motion,
    Mount,
    PanelState,
    Restorable,
    Saved,
    check_point_count,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import PanelPlan, SolverFailed
from orchestrator.ports.state import restore_attributes, save_attributes

_STATE = ("_clamps", "_impulse_N_s", "_load_J", "_clamps_J")


class ElasticBody(Restorable, Protocol):
    """What moves: mass (nodes,), which nodes are held, and what it stores and loses."""

    mass_kg: Array
    held: Indices

    def stored_J(self) -> dict[str, float]: ...

    def lost_J(self) -> float: ...

    def close(self) -> None: ...


class Integrator(Restorable, Protocol):
    def advance(self, state: BodyState, action: Action, interval: Interval) -> HeldForce:
        """Move ``state`` to the interval's end under ``action``."""
        ...

    def close(self) -> None: ...


class ElasticPanel:
    """A body that is at rest, in ``state``, when t = 0, moved by an integrator.

    The surface points are those nodes of the body that ``surface`` says, in the order of the
    ``grid``; the clamp points are its held nodes.
    """

    def __init__(
        self,
        plan: PanelPlan,
        body: ElasticBody,
        integrator: Integrator,
        state: BodyState,
        grid: Interpolating,
        surface: Indices | slice,
    ) -> None:
        self.mount = _mount(plan, state.position_m[body.held])
        self._plan = plan
        self._body = body
        self._integrator = integrator
        self._grid = grid
        self._surface = surface
        self._weight_N = body.mass_kg[:, None] * plan.gravity_m_per_s2
        self._held_kg = body.mass_kg[body.held, None]
        self._all_weight_N = self._weight_N.sum(axis=0)
        self._state = state
        self._clamps = Motion(self.mount.position_m, np.zeros_like(self.mount.position_m))
        self._impulse_N_s = np.zeros(3)
        self._load_J = self._clamps_J = 0.0
        static_N = (self._weight_N - state.internal_N)[body.held]
        self._initial = PanelState(self._surface_motion(), Load(static_N))

    def interpolation(self, coordinates_m: Array) -> csr_array:
        return self._grid.interpolation(coordinates_m)

    def inertia(self) -> Inertia:
        """Return the inertia of the free nodes on the surface."""
        nodes = len(self._body.mass_kg)
        on_surface = np.arange(nodes)[self._surface]
        free = np.setdiff1d(on_surface, self._body.held)
        shapes = identity(nodes, format="csr")[on_surface][:, free]
        return Inertia(csr_array(shapes), self._body.mass_kg[free], np.zeros((len(free), 3)))

    def initial(self) -> PanelState:
        return self._initial

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        state, held = self._state, self._body.held
        check_point_count(f"panel {self._plan.name}: clamps", clamps, len(held))
        check_point_count(f"panel {self._plan.name}: load", load, len(self._initial.surface))
        outside = self._weight_N.copy()
        outside[self._surface] += load.force_N
        started_m, started_m_per_s = (state.position_m.copy(), state.velocity_m_per_s.take(held, axis=0))
        action = Action(HermitePath(self._clamps, clamps, interval.length_s), outside)
        on_held = self._integrator.advance(state, action, interval)
        self._check(interval)
        self._clamps = clamps
        moved = state.position_m - started_m
        self._impulse_N_s += interval.length_s * self._all_weight_N
        self._load_J += float(np.vdot(load.force_N, moved[self._surface]))
        ended_m_per_s, on_clamps_N = (state.velocity_m_per_s.take(held, axis=0), outside.take(held, axis=0))
        gained_N_s = self._held_kg * (ended_m_per_s - started_m_per_s)
        self._clamps_J += (
            0.5 * float(np.vdot(gained_N_s, ended_m_per_s + started_m_per_s))
            + on_held.work_J
            - float(np.vdot(on_clamps_N, moved.take(held, axis=0)))
        )
        reaction = on_clamps_N - (gained_N_s + on_held.impulse_N_s) / interval.length_s
        return PanelState(self._surface_motion(), Load(reaction))

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Return the motion of the held nodes on the surface."""
        nodes = len(self._body.mass_kg)
        return clamps.among(nodes, self._body.held).part(np.arange(nodes)[self._surface])

    def account(self) -> Account:
        state, mass = self._state, self._body.mass_kg[:, None]
        stored = self._body.stored_J() | {
            "kinetic": 0.5 * float((mass * state.velocity_m_per_s**2).sum()),
            "gravitational": -float(np.vdot(self._weight_N, state.position_m)),
        }
        return Account(
            momentum_kg_m_per_s=(mass * state.velocity_m_per_s).sum(axis=0),
            outside_impulse_N_s=self._impulse_N_s.copy(),
            stored_J=stored,
            lost_J={"panel_damping": self._body.lost_J()},
            received_J={"load": self._load_J, "clamps": self._clamps_J},
        )

    def save(self) -> Saved:
        parts = {"state": self._state, "body": self._body, "integrator": self._integrator}
        return save_attributes(self, *_STATE) | {name: part.save() for name, part in parts.items()}

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_STATE)
        self._state.restore(saved["state"])
        self._body.restore(saved["body"])
        self._integrator.restore(saved["integrator"])

    def close(self) -> None:
        self._integrator.close()
        self._body.close()

    def _surface_motion(self) -> Motion:
        state = self._state
        return Motion(
            np.array(state.position_m[self._surface]), np.array(state.velocity_m_per_s[self._surface])
        )

    def _check(self, interval: Interval) -> None:
        """Free nodes do not outrun elastic waves in the material unless the solution blew up."""
        material = self._plan.material
        limit_m_per_s = (material.youngs_modulus_Pa / material.density_kg_per_m3) ** 0.5
        fastest_m_per_s = np.abs(self._state.velocity_m_per_s).max()
        if not fastest_m_per_s < limit_m_per_s:
            raise SolverFailed(
                f"panel {self._plan.name}, t = {interval.end_s} s: unstable, a node moves at "
                f"{fastest_m_per_s:.3g} m/s (elastic waves: {limit_m_per_s:.3g} m/s); take a smaller step"
            )


def _mount(plan: PanelPlan, held_m: Array) -> Mount:
    """The clamp points and the frame that holds each: that of the nearer clamp."""
    along_m = (held_m - plan.rectangle.corner_m) @ plan.rectangle.along
    second = along_m > 0.5 * plan.rectangle.span_m
    return Mount(held_m, tuple(plan.frames[int(end)] for end in second))


# From plan, structure, surface, resting shape (nodes, 3) and step in s; owns the structure.
Explicitly = Callable[[PanelPlan, Structure, SurfaceNodes[Any], Array, float], ElasticPanel]


def explicit(
    plan: PanelPlan, structure: Structure, surface: SurfaceNodes[Any], resting_m: Array, step_s: float
) -> ElasticPanel:
    """Open a panel with explicit steps in Python, for any structure."""
    state = _at_rest(structure, resting_m)
    integrator = integrators.Explicit(structure, step_s)
    return ElasticPanel(plan, structure, integrator, state, surface.grid, surface.nodes)


def open_panel(
    plan: PanelPlan, structure: Structure, surface: SurfaceNodes[Any], explicitly: Explicitly = explicit
) -> ElasticPanel:
    """Open the panel at rest between its clamps; ``explicitly`` makes the one with explicit steps.

    ValueError for a step that is too large, SolverFailed if no resting shape is found.
    """
    with ExitStack() as failed:
        failed.callback(structure.close)
        tangent = failed.enter_context(closing(Tangent(structure)))
        resting_m = _resting_m(plan, structure, tangent)
        step_s = integrators.step_s(plan, tangent)
        if plan.integrator == "explicit":
            panel = explicitly(plan, structure, surface, resting_m, step_s)
            tangent.close()
        else:
            integrator = integrators.GeneralizedAlpha(structure, tangent, step_s, plan.name)
            state = _at_rest(structure, resting_m)
            grid, nodes = surface.grid, surface.nodes
            panel = ElasticPanel(plan, structure, integrator, state, grid, nodes)
        failed.pop_all()
    return panel


def largest_step_s(plan: PanelPlan, structure: Structure) -> float:
    """Return the largest ``plan.step_s`` that ``open_panel`` accepts."""
    with closing(structure), closing(Tangent(structure)) as tangent:
        _resting_m(plan, structure, tangent)
        return integrators.largest_step_s(plan, tangent)


def _at_rest(structure: Structure, resting_m: Array) -> BodyState:
    structure.rest(resting_m)
    return BodyState.at_rest(resting_m, structure.force_N(resting_m))


def _resting_m(plan: PanelPlan, structure: Structure, tangent: Tangent) -> Array:
    """Positions (nodes, 3) at rest, left in the structure's field."""
    start_m = first_guess_m(plan.rectangle, plan.gravity_m_per_s2, structure.material_m)
    weight_N = structure.mass_kg[:, None] * plan.gravity_m_per_s2
    return settle(structure, tangent, start_m, weight_N, plan.name)
