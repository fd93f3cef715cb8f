"""The scheme ``robin``: a tangent of the contacts stands in for the particles.

``robin`` runs each solver once in an interval, and the panel a second time, for a trial: under the
last interval's load, after which it is restored.  From that and from the particles' contact tangent
(``ContactTangent``) follows the chord along which the surface will go,

    v = v_trial + s H / (2 M) (push - Z v - load_before),

for all masses M of the surface at once: H / (2 M) is the mean velocity that a constant unit load
gives a free mass, and s is the share of it that the panel showed in the last interval.  The
particles then move on that chord, the panel under the mean load that they give, and momentum is
exact.  The chord starts where the particles last saw the surface, so that their path has no jumps.
The scheme is named after Robin's condition, which ties force to velocity (for fluids: Badia, S., Nobile,
F. and Vergara, C., Journal of Computational Physics 227, 2008, 7027-7051,
doi 10.1016/j.jcp.2008.04.006).

Points behind which no mass is known move as in ``particles_first``: as a drive moves them, or else
at their velocity.  Where no mass is known at all (rigid panels), the scheme is ``particles_first``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from orchestrator.coupling._kernel import PointMatrix
from orchestrator.coupling.schemes.scheme import Forecast, Solvers, State, finish_interval, forecast
from orchestrator.coupling.schemes.staggered import particles_first
from orchestrator.ports import (
    Array,
    ContactTangent,
    HermitePath,
    Indices,
    Inertia,
    Load,
    Motion,
    Panel,
    Predicting,
    Saved,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.panel import surface_inertia
from orchestrator.ports.state import restore_attributes, save_attributes

SOLVED = 1e-4  # of the excess load: less than what the contacts' linear answer is worth
MOST_ITERATIONS = 200
LEAST_SHARE = 1e-3


@dataclass(frozen=True)
class TouchedPoints:
    """The points of the surface that particles touch, of the contact tangent: of thousands only some hundred.

    ``number`` (n,) are their numbers, ``impedance_N_s_per_m`` (n, 3, 3) is what resists their motion.
    """

    number: Indices
    impedance_N_s_per_m: Array

    @staticmethod
    def of(tangent: ContactTangent) -> TouchedPoints:
        """Return the points at which a tangent resists."""
        Z = tangent.impedance_N_s_per_m
        number = np.flatnonzero(Z[:, 0, 0] + Z[:, 1, 1] + Z[:, 2, 2])
        return TouchedPoints(number, Z[number])

    def resisting_N(self, velocity_m_per_s: Array) -> Array:
        """Return the force (n, 3) that the particles' push loses because these points move at (n, 3)."""
        return np.asarray(np.einsum("pij,pj->pi", self.impedance_N_s_per_m, velocity_m_per_s))


@dataclass(frozen=True)
class SurfaceCompliance:
    """The yielding of the masses behind a surface to a constant load, while the particles answer.

    ``shapes`` are the inertia's shapes, ``sizes`` those of their entries, and ``size`` (points, 1) the sum
    of these at a point.  ``known`` (points,) tells whether anything is known of a point's mass.
    """

    inertia: Inertia
    shapes: PointMatrix
    sizes: PointMatrix
    size: Array
    known: npt.NDArray[np.bool_]

    @staticmethod
    def of(panel: Panel) -> SurfaceCompliance:
        """Return the compliance of a panel's surface."""
        inertia = surface_inertia(panel)
        of, masses = inertia.shapes, len(inertia.mass_kg)
        shapes = PointMatrix(of.indptr, of.indices, of.data, masses)
        sizes = PointMatrix(of.indptr, of.indices, np.abs(of.data), masses)
        size = sizes.times(np.ones((masses, 3)))[:, :1]
        return SurfaceCompliance(inertia, shapes, sizes, size, np.diff(of.indptr) > 0)

    def yielding_velocity_m_per_s(
        self, excess_N: Array, touched: TouchedPoints, length_s: float, share: Array
    ) -> Array:
        """Return the mean velocity (points, 3) at which the points yield over an interval to ``excess_N``
        (points, 3).

        The velocity is shapes u, where the masses' velocity u solves

            (2 M / (s H) + shapes' Z shapes) u = shapes' excess,

        by conjugate gradients.  Their preconditioner has the trace of each Z spread over the masses under it
        by the sizes of the shapes, which is never less than the matrix.
        """
        right_side, at = self._on_masses(excess_N), touched.number
        free = np.outer(self.inertia.mass_kg, 2 / (length_s * share))
        resisting = np.zeros_like(excess_N)
        resisting[at] = self.size[at] * np.einsum("pii->p", touched.impedance_N_s_per_m)[:, None]
        lumped = free + self.sizes.transposed_times(resisting)

        def product(u: Array) -> Array:
            resisting[at] = touched.resisting_N(self.shapes.times(u)[at])
            return free * u + self._on_masses(resisting)

        return self.shapes.times(conjugate_gradients(product, right_side, lumped))

    def share(self, more: Load, gave_m_per_s: Array, length_s: float, before: Array) -> Array:
        """Return the share of free masses' motion that the surface showed, (3,) by direction.

        The share is the work of the load ``more`` on the mean velocity ``gave_m_per_s`` (points, 3) that it
        really caused, over its work on free masses: 1 for a free mass, less where the panel's stiffness holds
        it.  The share is ``before`` if the load did not change.
        """
        on_masses_N = self._on_masses(more.force_N)
        free = length_s / 2 * (1.0 / self.inertia.mass_kg @ on_masses_N**2)
        real, share = self._counts @ (more.force_N * gave_m_per_s), before.copy()
        np.divide(real, free, out=share, where=free > 0)
        return np.clip(share, LEAST_SHARE, 1.0)

    @cached_property
    def _counts(self) -> Array:
        """One for each point that counts, zero for the others, (points,)."""
        return self.known.astype(float)

    def _on_masses(self, points_N: Array) -> Array:
        """Return the part of the points' load to which the masses yield."""
        return self.inertia.yielding(self.shapes.transposed_times(points_N))


def conjugate_gradients(product: Callable[[Array], Array], right_side: Array, diagonal: Array) -> Array:
    """Return u with ``product(u) = right_side``, all (masses, 3), to the share ``SOLVED`` of the right side.

    ``product`` is symmetric and positive, and ``diagonal`` (masses, 3) is near to it.  M. R. Hestenes and
    E. Stiefel, Journal of Research of the National Bureau of Standards 49 (1952) 409-436,
    doi 10.6028/jres.049.044; two or three iterations are usual, of which SciPy's own work would be most.
    """
    u, residual = np.zeros_like(right_side), right_side.copy()
    enough = SOLVED**2 * np.vdot(residual, residual)
    downhill = residual / diagonal
    direction, slope = downhill, np.vdot(residual, downhill)
    for _ in range(MOST_ITERATIONS):
        if np.vdot(residual, residual) <= enough:
            break
        resisted = product(direction)
        step = slope / np.vdot(direction, resisted)
        u += step * direction
        residual -= step * resisted
        downhill = residual / diagonal
        slope, before = np.vdot(residual, downhill), slope
        direction = downhill + slope / before * direction
    return u


class Robin:
    """The scheme ``robin`` with its memory.

    It remembers the places where the particles last saw the surface (None before the first interval), and the
    share s for each direction in space.
    """

    def __init__(self) -> None:
        self._seen_m: Array | None = None
        self._share = np.ones(3)
        self._compliance: SurfaceCompliance | None = None

    def advance(self, solvers: Solvers, interval: Interval, now: State) -> State:
        if solvers.particles is None:
            return particles_first(solvers, interval, now)
        compliance = self._compliance = self._compliance or SurfaceCompliance.of(solvers.panel)
        if not compliance.known.any():
            return particles_first(solvers, interval, now)
        tangent = cast(Predicting, solvers.particles).contact_tangent(interval.length_s)
        known = forecast(solvers, interval, now)
        trial = trial_surface(solvers, interval, now, known)
        path = known.path(self._predicted_path(compliance, tangent, trial, interval, now))
        load = solvers.particles.advance(interval, path)
        panel = solvers.panel.advance(interval, known.clamps, load)
        self._seen_m = path.end.position_m
        more = Load(load.force_N - now.load.force_N)
        gave_m_per_s = (panel.surface.position_m - trial.position_m) / interval.length_s
        self._share = compliance.share(more, gave_m_per_s, interval.length_s, self._share)
        return finish_interval(solvers, interval, now, panel, load)

    def _predicted_path(
        self,
        compliance: SurfaceCompliance,
        tangent: ContactTangent,
        trial: Motion,
        interval: Interval,
        now: State,
    ) -> HermitePath:
        """Return the chord along which the surface will go, by the formula at the head of this file."""
        length_s, surface, known = interval.length_s, now.panel.surface, compliance.known[:, None]
        start_m = surface.position_m
        if self._seen_m is not None:
            start_m = np.where(known, self._seen_m, start_m)
        trial_m_per_s = (trial.position_m - start_m) / length_s
        velocity_m_per_s = np.where(known, trial_m_per_s, surface.velocity_m_per_s)
        touched = TouchedPoints.of(tangent)
        excess_N = tangent.push_N - now.load.force_N
        excess_N[touched.number] -= touched.resisting_N(velocity_m_per_s[touched.number])
        velocity_m_per_s += compliance.yielding_velocity_m_per_s(excess_N, touched, length_s, self._share)
        end_m = start_m + length_s * velocity_m_per_s
        return HermitePath(Motion(start_m, velocity_m_per_s), Motion(end_m, velocity_m_per_s), length_s)

    def figures(self) -> dict[str, Any]:
        """Return nothing for ``summary.json``, since robin does not iterate."""
        return {}

    def save(self) -> Saved:
        seen = {} if self._seen_m is None else {"seen_m": self._seen_m.copy()}
        return save_attributes(self, "_share") | seen

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, "_share")
        self._seen_m = np.array(saved["seen_m"]) if "seen_m" in saved else None


def trial_surface(solvers: Solvers, interval: Interval, now: State, known: Forecast) -> Motion:
    """Return the surface at the interval's end under the last load; the panel is restored."""
    before = solvers.panel.save()
    moved = solvers.panel.advance(interval, known.clamps, now.load)
    solvers.panel.restore(before)
    return moved.surface
