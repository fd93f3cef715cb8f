"""Time integration of finite-element panels: explicit, implicit, and which step each takes."""

from __future__ import annotations

import numpy as np

from adapters.panel.common.body import Action, BodyState, HeldForce
from adapters.panel.finite_element.structure import Structure
from adapters.panel.finite_element.tangent import Tangent
from orchestrator.ports import Array, Saved
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import PanelPlan, SolverFailed
from orchestrator.ports.state import restore_attributes, save_attributes

SPECTRAL_RADIUS = 0.8
ALPHA_M = (2 * SPECTRAL_RADIUS - 1) / (SPECTRAL_RADIUS + 1)
ALPHA_F = SPECTRAL_RADIUS / (SPECTRAL_RADIUS + 1)
GAMMA = 0.5 - ALPHA_M + ALPHA_F
BETA = 0.25 * (1 - ALPHA_M + ALPHA_F) ** 2

TOLERANCE = 1e-7  # residual over the forces in play
NEGLIGIBLE_MOVE = 1e-12  # of the panel's size: all that rounding leaves where forces are tiny
ITERATIONS = 15
SLOW = 0.2  # a residual that shrinks less than this per iteration asks for a new tangent
HALVINGS = 8

# Explicit: shares of the step at which small vibrations about the resting shape become unstable.
# The first leaves room for stiffening in motion, the second is what step_s = 0 takes.
STABLE_SHARE = 0.95
USUAL_SHARE = 0.85
# Implicit: no stability limit, but accuracy (docs/theory/panel_sheet.md).
COARSEST_STEP_S = 1e-3
USUAL_STEP_S = 2e-4


def step_s(plan: PanelPlan, tangent: Tangent) -> float:
    """Return the step of ``plan``'s integrator for a structure that stands in its resting shape.

    ValueError if there is no such integrator or ``plan.step_s`` is too large for it.
    """
    largest, usual = _limits_s(plan, tangent)
    if plan.step_s > largest:
        raise ValueError(
            f"panel {plan.name}: step_s = {plan.step_s} is above the limit of {largest:.3g} s; "
            f"use {usual:.2g} or 0 (the solver's own choice)"
        )
    return plan.step_s or usual


def largest_step_s(plan: PanelPlan, tangent: Tangent) -> float:
    """Return the largest step for the structure in its present shape."""
    return _limits_s(plan, tangent)[0]


def _limits_s(plan: PanelPlan, tangent: Tangent) -> tuple[float, float]:
    """Return the largest and the usual step.

    Maxwell branches answer fast changes like springs and so raise
    the stiffness that limits an explicit step by their ratios."""
    if plan.integrator == "implicit":
        return COARSEST_STEP_S, USUAL_STEP_S
    if plan.integrator != "explicit":
        raise ValueError(f"panel {plan.name}: integrator {plan.integrator!r}: take 'explicit' or 'implicit'")
    stiffening = 1.0 + sum(ratio for ratio, _ in plan.material.branches)
    critical_s = 2.0 / (tangent.highest_frequency_rad_per_s() * stiffening**0.5)
    return STABLE_SHARE * critical_s, USUAL_SHARE * critical_s


class Explicit:
    """Velocity Verlet with a diagonal mass, in whole steps of at most ``largest_step_s`` that fill each
    sync interval.

    Verlet, Physical Review 159 (1967) 98-103, doi:10.1103/PhysRev.159.98; the same scheme is known as
    the central difference method.  Second order, stable below  2 / (highest angular frequency).
    """

    def __init__(self, structure: Structure, largest_step_s: float) -> None:
        self._structure = structure
        self._largest_step_s = largest_step_s

    @np.errstate(over="ignore", invalid="ignore")  # the panel reports a blow-up
    def advance(self, state: BodyState, action: Action, interval: Interval) -> HeldForce:
        """Move ``state`` to the interval's end under ``action``."""
        body, held = self._structure, self._structure.held
        steps = interval.steps(self._largest_step_s)
        step_s = interval.length_s / steps
        x, v = state.position_m, state.velocity_m_per_s
        kick = (0.5 * step_s) * body.mobility_1_kg
        on_held = HeldForce.none(len(held))
        for step in range(1, steps + 1):
            fraction = step / steps
            v += kick * (action.outside_N - state.internal_N)
            before_m, before_N = x[held], state.internal_N[held]
            x += step_s * v
            x[held] = action.held.position_m(fraction)
            body.begin_step(step_s)
            state.internal_N = body.force_N(x)
            body.end_step()
            v += kick * (action.outside_N - state.internal_N)
            v[held] = action.held.velocity_m_per_s(fraction)
            on_held.add(step_s, 0.5 * (before_N + state.internal_N[held]), x[held] - before_m)
        return on_held

    def save(self) -> Saved:
        """A step remembers nothing that ``State`` and the structure do not know."""
        return {}

    def restore(self, saved: Saved) -> None:
        """Nothing to restore."""

    def close(self) -> None:
        """Nothing is open."""


class NotConverged(Exception):
    """Newton's iteration gave up on a step; the step is then halved."""


class GeneralizedAlpha:
    """The generalized-alpha method with Newton's iteration, in whole steps of at most ``largest_step_s``
    that fill each sync interval.

    Chung and Hulbert, J. Appl. Mech. 60 (1993) 371-375, doi:10.1115/1.2900803.  Second order, stable
    at any step for linear bodies; ``SPECTRAL_RADIUS`` is what is left of the highest frequencies per
    step.

    With a diagonal mass the method's acceleration is  (outside force - filtered force) / mass, where
    the filtered force is the internal one passed through the method's own recursion.  Keeping it in
    place of the acceleration makes momentum exact, whatever the Newton tolerance: the mean force at
    the held nodes is that of the same recursion, and a load that jumps between intervals acts in full.
    """

    def __init__(self, structure: Structure, tangent: Tangent, largest_step_s: float, name: str) -> None:
        self._structure = structure
        self._tangent = tangent
        self._largest_step_s = largest_step_s
        self._name = name
        self._factorised_for_s = 0.0
        self._negligible_m = NEGLIGIBLE_MOVE * float(np.ptp(structure.material_m, axis=0).max())
        self._mass_kg = structure.mass_kg[:, None]

    @np.errstate(over="ignore", invalid="ignore")  # the panel reports a blow-up
    def advance(self, state: BodyState, action: Action, interval: Interval) -> HeldForce:
        """Move ``state`` to the interval's end under ``action``."""
        steps = interval.steps(self._largest_step_s)
        on_held = HeldForce.none(len(self._structure.held))
        for step in range(steps):
            start, end = step / steps, (step + 1) / steps
            try:
                self._cover(state, action, start, end, on_held, HALVINGS)
            except NotConverged as failure:
                time_s = interval.start_s + start * interval.length_s
                raise SolverFailed(
                    f"panel {self._name}, t = {time_s:.6g} s: Newton's iteration fails even with "
                    f"the step halved {HALVINGS} times: {failure}"
                ) from failure
        return on_held

    def save(self) -> Saved:
        """Save the tangent, too, which Newton's iteration keeps for many steps."""
        return save_attributes(self, "_factorised_for_s") | {"tangent": self._tangent.save()}

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, "_factorised_for_s")
        self._tangent.restore(saved["tangent"])

    def close(self) -> None:
        self._tangent.close()

    def _cover(
        self, state: BodyState, action: Action, start: float, end: float, on_held: HeldForce, halvings: int
    ) -> None:
        """Make one step from fraction ``start`` to ``end`` of the interval; where it does not converge
        two of half the length, each of which may be halved ``halvings - 1`` times."""
        try:
            self._step(state, action, start, end, on_held)
        except NotConverged:
            if halvings == 0:
                raise
            middle = 0.5 * (start + end)
            self._cover(state, action, start, middle, on_held, halvings - 1)
            self._cover(state, action, middle, end, on_held, halvings - 1)

    def _step(self, state: BodyState, action: Action, start: float, end: float, on_held: HeldForce) -> None:
        body, held = self._structure, self._structure.held
        outside_N, step_s = action.outside_N, (end - start) * action.held.length_s
        before = body.mobility_1_kg * (outside_N - state.filtered_N)  # acceleration
        trial = state.position_m + step_s * state.velocity_m_per_s + 0.5 * step_s**2 * before
        trial[held] = action.held.position_m(end)
        body.begin_step(step_s)
        internal = self._solve(state, outside_N, before, trial, step_s)
        body.end_step()
        filtered = ((1 - ALPHA_F) * internal + ALPHA_F * state.internal_N - ALPHA_M * state.filtered_N) / (
            1 - ALPHA_M
        )
        after = body.mobility_1_kg * (outside_N - filtered)
        mean_N = (1 - GAMMA) * state.filtered_N[held] + GAMMA * filtered[held]
        on_held.add(step_s, mean_N, trial[held] - state.position_m[held])
        state.velocity_m_per_s += step_s * ((1 - GAMMA) * before + GAMMA * after)
        state.velocity_m_per_s[held] = action.held.velocity_m_per_s(end)
        state.position_m[:] = trial
        state.internal_N, state.filtered_N = internal, filtered

    def _solve(self, state: BodyState, outside_N: Array, before: Array, trial: Array, step_s: float) -> Array:
        """Iterate on ``trial`` by Newton's method, in place; return the internal force at its end."""
        body, free, mass = self._structure, self._structure.free, self._mass_kg
        drift = state.position_m + step_s * state.velocity_m_per_s
        drift += (0.5 - BETA) * step_s**2 * before
        known = outside_N - ALPHA_F * state.internal_N - ALPHA_M * mass * before
        inertia = (1 - ALPHA_M) / (BETA * step_s**2)
        last = moved_m = np.inf
        for _ in range(ITERATIONS):
            internal = body.force_N(trial)
            residual = known - inertia * mass * (trial - drift) - (1 - ALPHA_F) * internal
            scale = np.linalg.norm(known) + np.linalg.norm(internal)
            size = float(np.linalg.norm(residual[free]))
            if size <= TOLERANCE * scale or moved_m <= self._negligible_m:
                return internal
            if not np.isfinite(size):
                raise NotConverged("the force is not finite")
            if step_s != self._factorised_for_s or size > SLOW * last:
                self._tangent.factorise(inertia, 1 - ALPHA_F)
                self._factorised_for_s = step_s
            last = size
            move = self._tangent.solve(residual)
            moved_m = float(np.abs(move).max())
            trial += move
        raise NotConverged(f"residual {size / scale:.1e}, wanted {TOLERANCE:.0e}")
