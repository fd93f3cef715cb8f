"""Time integration of finite-element panels: explicit, implicit, and which step each takes."""

from __future__ import annotations

from typing import ClassVar

import numpy as np

from adapters.panel.common.panel import HeldForce
from adapters.panel.finite_element.structure import Structure
from adapters.panel.finite_element.tangent import Tangent
from orchestrator.ports import Array, HermitePath, Indices
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import PanelPlan, SolverFailed
from orchestrator.ports.state import SavedAttributes

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


def step_limits_s(plan: PanelPlan, tangent: Tangent) -> tuple[float, float]:
    """Return the largest and the usual step of ``plan``'s integrator for the structure in its present shape.

    Maxwell branches answer fast changes like springs and so raise the stiffness that limits an
    explicit step by their ratios.  Raises ValueError if there is no such integrator.
    """
    if plan.integrator == "implicit":
        return COARSEST_STEP_S, USUAL_STEP_S
    if plan.integrator != "explicit":
        raise ValueError(f"integrator {plan.integrator!r}: take 'explicit' or 'implicit'")
    stiffening = 1.0 + sum(ratio for ratio, _ in plan.material.branches)
    critical_s = 2.0 / (tangent.highest_frequency_rad_per_s() * stiffening**0.5)
    return STABLE_SHARE * critical_s, USUAL_SHARE * critical_s


class StructureBody(SavedAttributes):
    """A structure in motion, in whole steps of at most ``step_s`` that fill each sync interval.

    It is at rest at ``resting_m`` (nodes, 3) when t = 0; ``surface`` are the nodes that particles
    touch, in the order of their grid.
    """

    STATE: ClassVar[tuple[str, ...]] = ("position_m", "velocity_m_per_s", "internal_N")
    PARTS: ClassVar[tuple[str, ...]] = ("_structure",)

    def __init__(self, structure: Structure, surface: Indices, resting_m: Array, step_s: float) -> None:
        self._structure, self._step_s = structure, step_s
        self.mass_kg, self.held, self.surface = structure.mass_kg, structure.held, surface
        structure.rest(resting_m)
        self.position_m = resting_m.copy()
        self.velocity_m_per_s = np.zeros_like(resting_m)
        self.internal_N = structure.join(structure.force_N(resting_m))

    def stored_J(self) -> dict[str, float]:
        return self._structure.stored_J()

    def lost_J(self) -> float:
        return self._structure.lost_J()

    def close(self) -> None:
        self._structure.close()


class Explicit(StructureBody):
    """Velocity Verlet with a diagonal mass.

    Verlet, Physical Review 159 (1967) 98-103, doi:10.1103/PhysRev.159.98; the same scheme is known as
    the central difference method.  Second order, stable below  2 / (highest angular frequency).
    """

    @np.errstate(over="ignore", invalid="ignore")  # the panel reports a blow-up
    def move(self, path: HermitePath, outside_N: Array, interval: Interval) -> HeldForce:
        """Go on to the interval's end, the held nodes along ``path``, under a constant ``outside_N``."""
        structure, held = self._structure, self.held
        outside_N = structure.join(outside_N.copy())
        steps = interval.steps(self._step_s)
        step_s = interval.length_s / steps
        x, v = self.position_m, self.velocity_m_per_s
        kick = (0.5 * step_s) * structure.mobility_1_kg
        on_held = HeldForce(np.zeros((len(held), 3)))
        for step in range(1, steps + 1):
            fraction = step / steps
            v += kick * (outside_N - self.internal_N)
            before_m, before_N = x[held], self.internal_N[held]
            x += step_s * v
            x[held] = path.position_m(fraction)
            structure.begin_step(step_s)
            self.internal_N = structure.join(structure.force_N(x))
            structure.end_step()
            v += kick * (outside_N - self.internal_N)
            v[held] = path.velocity_m_per_s(fraction)
            on_held.add(step_s, 0.5 * (before_N + self.internal_N[held]), x[held] - before_m)
        return on_held


class NotConverged(Exception):
    """An error of Newton's iteration, which gave up on a step; the step is then halved."""


class GeneralizedAlpha(StructureBody):
    """The generalized-alpha method with Newton's iteration.

    Chung and Hulbert, J. Appl. Mech. 60 (1993) 371-375, doi:10.1115/1.2900803.  Second order, stable
    at any step for linear bodies; ``SPECTRAL_RADIUS`` is what is left of the highest frequencies per
    step.

    With a diagonal mass the method's acceleration is  (outside force - filtered force) / mass, where
    the filtered force is the internal one passed through the method's own recursion.  Keeping it in
    place of the acceleration makes momentum exact, whatever the Newton tolerance: the mean force at
    the held nodes is that of the same recursion, and a load that jumps between intervals acts in full.
    """

    STATE = (*StructureBody.STATE, "_filtered_N", "_factorised_for_s")
    PARTS = (*StructureBody.PARTS, "_tangent")  # which Newton's iteration keeps for many steps

    def __init__(
        self,
        structure: Structure,
        surface: Indices,
        resting_m: Array,
        step_s: float,
        tangent: Tangent,
        name: str,
    ) -> None:
        super().__init__(structure, surface, resting_m, step_s)
        self._filtered_N = self.internal_N.copy()
        self._tangent, self._name = tangent, name
        tangent.assemble(0.0, 1.0)  # so that there is a matrix to save
        self._factorised_for_s = 0.0
        self._negligible_m = NEGLIGIBLE_MOVE * float(np.ptp(structure.material_m, axis=0).max())

    @np.errstate(over="ignore", invalid="ignore")  # the panel reports a blow-up
    def move(self, path: HermitePath, outside_N: Array, interval: Interval) -> HeldForce:
        """Go on to the interval's end, the held nodes along ``path``, under a constant ``outside_N``."""
        steps = interval.steps(self._step_s)
        on_held = HeldForce(np.zeros((len(self.held), 3)))
        for step in range(steps):
            start, end = step / steps, (step + 1) / steps
            try:
                self._cover(path, outside_N, start, end, on_held, HALVINGS)
            except NotConverged as failure:
                time_s = interval.start_s + start * interval.length_s
                raise SolverFailed(
                    f"panel {self._name}, t = {time_s:.6g} s: Newton's iteration fails even with "
                    f"the step halved {HALVINGS} times: {failure}"
                ) from failure
        return on_held

    def close(self) -> None:
        self._tangent.close()
        super().close()

    def _cover(
        self, path: HermitePath, outside_N: Array, start: float, end: float, on_held: HeldForce, halvings: int
    ) -> None:
        """Make one step from fraction ``start`` to ``end`` of the interval; where it does not converge
        two of half the length, each of which may be halved ``halvings - 1`` times."""
        try:
            self._step(path, outside_N, start, end, on_held)
        except NotConverged:
            if halvings == 0:
                raise
            middle = 0.5 * (start + end)
            self._cover(path, outside_N, start, middle, on_held, halvings - 1)
            self._cover(path, outside_N, middle, end, on_held, halvings - 1)

    def _step(
        self, path: HermitePath, outside_N: Array, start: float, end: float, on_held: HeldForce
    ) -> None:
        structure, held, x, v = self._structure, self.held, self.position_m, self.velocity_m_per_s
        step_s = (end - start) * path.length_s
        before = structure.mobility_1_kg * (outside_N - self._filtered_N)  # acceleration
        trial = x + step_s * v + 0.5 * step_s**2 * before
        trial[held] = path.position_m(end)
        structure.begin_step(step_s)
        internal_N = self._solve(outside_N, before, trial, step_s)
        structure.end_step()
        recursion_N = (1 - ALPHA_F) * internal_N + ALPHA_F * self.internal_N - ALPHA_M * self._filtered_N
        filtered_N = recursion_N / (1 - ALPHA_M)
        after = structure.mobility_1_kg * (outside_N - filtered_N)
        mean_N = (1 - GAMMA) * self._filtered_N[held] + GAMMA * filtered_N[held]
        on_held.add(step_s, mean_N, trial[held] - x[held])
        v += step_s * ((1 - GAMMA) * before + GAMMA * after)
        v[held] = path.velocity_m_per_s(end)
        x[:] = trial
        self.internal_N, self._filtered_N = internal_N, filtered_N

    def _solve(self, outside_N: Array, before: Array, trial: Array, step_s: float) -> Array:
        """Iterate on ``trial`` by Newton's method, in place; return the internal force at its end."""
        structure, free, mass_kg = self._structure, self._structure.free, self.mass_kg[:, None]
        drift = self.position_m + step_s * self.velocity_m_per_s
        drift += (0.5 - BETA) * step_s**2 * before
        known = outside_N - ALPHA_F * self.internal_N - ALPHA_M * mass_kg * before
        inertia = (1 - ALPHA_M) / (BETA * step_s**2)
        last = moved_m = np.inf
        for _ in range(ITERATIONS):
            internal_N = structure.force_N(trial)
            residual = known - inertia * mass_kg * (trial - drift) - (1 - ALPHA_F) * internal_N
            scale = np.linalg.norm(known) + np.linalg.norm(internal_N)
            size = float(np.linalg.norm(residual[free]))
            if size <= TOLERANCE * scale or moved_m <= self._negligible_m:
                return internal_N
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
