"""A few to some hundred spheres in NumPy: for tests and for the draft level.

Velocity Verlet with the contact forces at the half-step velocity, as LIGGGHTS does it.  Equations,
limits and what was measured: docs/theory/spheres.md.  Every MPI rank computes the same.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
from scipy.spatial.distance import cdist

from adapters.particles.spheres.contacts import laws
from adapters.particles.spheres.crossing import crossed
from adapters.particles.spheres.forces import Forces, System, forces_at
from adapters.particles.spheres.neighbours import near_surface, neighbours
from adapters.particles.spheres.response import response
from adapters.particles.spheres.rolling import rolling
from adapters.particles.spheres.state import Spheres, spheres
from adapters.particles.spheres.wear import wear
from adapters.particles.surface.triangle_spin import cross
from orchestrator.ports import (
    Account,
    AngularAccount,
    Array,
    ContactTangent,
    Crossings,
    HermitePath,
    Indices,
    Load,
    Motion,
    Overlaps,
    ParticleSnapshot,
    Removed,
    Saved,
    check_point_count,
    sort_removed,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import ParticlesPlan
from orchestrator.ports.state import as_arrays, like, restore_attributes, save_attributes

_SUMS = (
    "_impulse_N_s",
    "_supplied_J",
    "_lost_J",
    "_received_J",
    "fed",
    "_deepest",
    "_crossings",
    "_came",
    "_fell_kg_m_s",
    "_given",
)
_STATE = ("_spheres", "_surface_m", "_near", "_now", *_SUMS)


class SpheresSolver:
    """``Particles`` in NumPy.  ``fed`` counts particles since t = 0."""

    def __init__(self, plan: ParticlesPlan) -> None:
        self._plan = plan
        self._wear = wear(plan)
        self._system = System(plan.surface, laws(plan), rolling(plan), self._wear)
        self._spheres = spheres(plan.particles, 1)
        self._surface_m = plan.surface.position_m.copy()
        self._near = neighbours(self._spheres, plan.surface, self._surface_m)
        at_rest = Motion(self._surface_m, np.zeros_like(self._surface_m))
        self._now = self._forces(at_rest, None, 0.0)
        self._impulse_N_s = np.zeros(3)
        # angular momentum that came with particles and that went to the surface, N m s, and what
        # gravity gives it by: the integral over time of mass times place
        self._came, self._given, self._fell_kg_m_s = np.zeros((3, 3))
        self._supplied_J = {"feed": 0.0, "removal": 0.0}
        self._lost_J = self._received_J = 0.0
        self._removed: list[Removed] = []
        self._deepest, self._crossings = self._deepest_now(), Crossings.none()
        self.fed = 0

    def initial(self) -> Load:
        return Load(self._now.on_points_N)

    def advance(self, interval: Interval, path: HermitePath) -> Load:
        check_point_count("particles' surface", path.end, len(self._surface_m))
        self._feed(interval)
        before_m, on_surface_N_m = self._surface_m, self._on_surface_N_m()
        self._jump_to(path.start)
        steps, start_s = interval.steps(self._plan.step_s), interval.start_s
        step_s = interval.length_s / steps
        self._given = self._given + step_s / 2.0 * on_surface_N_m
        impulse_N_s = step_s / 2.0 * self._now.on_points_N
        for step in range(1, steps + 1):
            half_way_m_per_s = path.velocity_m_per_s((step - 0.5) / steps)
            centers_m = self._spheres.position_m.copy()
            self._step(step_s, path.at(step / steps), half_way_m_per_s)
            impulse_N_s += step_s * self._now.on_points_N
            self._given = self._given + step_s * self._on_surface_N_m()
            self._watch(centers_m, before_m, start_s + step * step_s)
            before_m = self._surface_m
        impulse_N_s -= step_s / 2.0 * self._now.on_points_N
        self._given = self._given - step_s / 2.0 * self._on_surface_N_m()
        self._remove(interval.end_s)
        return Load(impulse_N_s / interval.length_s)

    def snapshot(self) -> ParticleSnapshot:
        return self._spheres.snapshot()

    def removed(self) -> Removed:
        since, self._removed = self._removed, []
        return sort_removed(since)

    def overlaps(self) -> Overlaps:
        since, self._deepest = self._deepest, Overlaps()
        return since

    def crossings(self) -> Crossings:
        return self._crossings

    def contact_tangent(self, length_s: float) -> ContactTangent:
        return response(self._system, self._spheres, self._now, self._plan.gravity_m_per_s2, length_s)

    def worn_m3(self) -> Array:
        assert self._wear is not None, "asked of a plan without wear"
        return self._wear.worn_m3.copy()

    def account(self) -> Account:
        stored_J = {
            "kinetic": self._spheres.kinetic_J(),
            "gravitational": self._spheres.gravitational_J(self._plan.gravity_m_per_s2),
            "contact_elastic": float(self._now.elastic_J.sum()),
        }
        if self._plan.adhesion is not None:
            stored_J["adhesion"] = float(self._now.adhesion_J.sum())
        return Account(
            self._spheres.momentum_kg_m_per_s(),
            self._impulse_N_s.copy(),
            stored_J,
            lost_J={"contact_dissipation": self._lost_J},
            supplied_J=dict(self._supplied_J),
            received_J={"surface": self._received_J},
            angular=AngularAccount(
                self._spheres.angular_momentum_kg_m2_per_s(),
                self._came + np.cross(self._fell_kg_m_s, self._plan.gravity_m_per_s2),
                {"surface": -self._given},
            ),
        )

    def save(self) -> Saved:
        saved = save_attributes(self, *_STATE) | {"removed": as_arrays(sort_removed(self._removed))}
        return saved if self._wear is None else saved | {"wear": self._wear.save()}

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_STATE)
        self._removed = [like(sort_removed([]), saved["removed"])]
        if self._wear is not None:
            self._wear.restore(saved["wear"])

    def close(self) -> None:
        pass

    def _step(self, step_s: float, surface: Motion, half_way_m_per_s: Array) -> None:
        """Forces at the step's end go by the velocities of its middle, the surface's too."""
        now, before = self._spheres, self._now
        self._kick(step_s / 2.0)
        falls_kg_m = now.mass_kg @ now.position_m
        now.position_m += step_s * now.velocity_m_per_s
        falls_kg_m = falls_kg_m + now.mass_kg @ now.position_m
        self._fell_kg_m_s = self._fell_kg_m_s + step_s / 2.0 * falls_kg_m
        if self._near.outdated(now.position_m, surface.position_m):
            self._near = neighbours(now, self._plan.surface, surface.position_m)
        self._now = self._forces(Motion(surface.position_m, half_way_m_per_s), before, step_s)
        self._kick(step_s / 2.0)
        self._impulse_N_s += step_s * now.mass_kg.sum() * self._plan.gravity_m_per_s2
        self._surface_to(surface.position_m, before)
        moved = self._now.carried(surface.velocity_m_per_s)
        self._now = moved.damped(now.velocity_m_per_s, now.spin_rad_per_s)
        self._lost_J += self._now.lost_J
        self._lost_J += step_s / 2.0 * (before.damping_W + self._now.damping_W)

    def _jump_to(self, surface: Motion) -> None:
        """Book the coupling's correction of the surface's place and velocity at a sync point."""
        self._lost_J += self._now.spent_J(surface.position_m - self._surface_m)
        self._surface_to(surface.position_m, self._now)
        now = self._spheres
        moved = self._now.carried(surface.velocity_m_per_s)
        self._now = moved.damped(now.velocity_m_per_s, now.spin_rad_per_s)

    def _kick(self, step_s: float) -> None:
        now = self._spheres
        now.velocity_m_per_s += step_s * (
            self._now.force_N / now.mass_kg[:, None] + self._plan.gravity_m_per_s2
        )
        now.spin_rad_per_s += step_s * self._now.torque_N_m / now.inertia_kg_m2[:, None]

    def _forces(self, surface: Motion, before: Forces | None, step_s: float) -> Forces:
        return forces_at(self._system, self._spheres, surface, self._near, before, step_s)

    def _on_surface_N_m(self) -> Array:
        """Moment of the forces on the surface about the world's origin."""
        return np.asarray(cross(self._surface_m, self._now.on_points_N).sum(axis=0))

    def _surface_to(self, position_m: Array, before: Forces) -> None:
        """Book the work of the surface's move by the trapezoidal rule, as Verlet does it."""
        mean_N = (before.on_points_N + self._now.on_points_N) / 2.0
        self._received_J -= float(np.vdot(mean_N, position_m - self._surface_m))
        self._surface_m = position_m

    def _watch(self, centers_m: Array, before_m: Array, time_s: float) -> None:
        """Keep how deep contacts are, and who went through the surface in the step that ends now;
        centres and surface points were at ``centers_m`` and ``before_m``."""
        now = self._spheres
        self._deepest = self._deepest.deepest(self._deepest_now())
        way_m = (before_m, self._surface_m)
        rows = crossed(now, self._now.touching, centers_m, self._plan.surface.triangles, way_m)
        if len(rows):
            some = Crossings(len(rows), int(now.id[rows[0]]), time_s, now.position_m[rows[0]].copy())
            self._crossings = self._crossings.followed_by(some)

    def _deepest_now(self) -> Overlaps:
        return self._now.touching.deepest(2.0 * self._spheres.radius_m)

    def _feed(self, interval: Interval) -> None:
        if self._plan.feed is None:
            return
        next_id = 1 + len(self._plan.particles) + self.fed
        offered = spheres(self._plan.feed.due(interval), next_id)
        accepted = self._room_for(offered)
        self._plan.feed.settle(accepted)
        if not accepted.any():
            return
        new = offered.part(accepted)
        new.id = next_id + np.arange(len(new))
        self.fed += len(new)
        self._supplied_J["feed"] += self._mechanical_J(new)
        self._impulse_N_s += new.momentum_kg_m_per_s()
        self._came = self._came + new.angular_momentum_kg_m2_per_s()
        self._replace(self._spheres.joined(new), np.arange(len(self._spheres)))

    def _room_for(self, offered: Spheres) -> npt.NDArray[np.bool_]:
        """Which of the offered spheres overlap neither present ones nor the surface."""
        now, triangles = self._spheres, self._plan.surface.triangles
        reach_m = np.add.outer(offered.radius_m, now.radius_m)
        free = np.all(cdist(offered.position_m, now.position_m) >= reach_m, axis=1)
        free[near_surface(offered, 0.0, self._surface_m[triangles])[0]] = False
        return np.asarray(free)

    def _remove(self, time_s: float) -> None:
        """Take out who is in an exit or has left the domain; contacts end with their energy."""
        now, (lowest_m, highest_m) = self._spheres, self._plan.domain_m
        exit_of = np.full(len(now), -1)
        for number, one in reversed(list(enumerate(self._plan.exits))):
            exit_of[one.holds(now.position_m)] = number
        inside = np.all((now.position_m >= lowest_m) & (now.position_m <= highest_m), axis=1)
        stays = inside & (exit_of < 0)
        if stays.all():
            return
        left, stored_J = now.part(~stays), self._contacts_J()
        self._replace(now.part(stays), np.where(stays, np.cumsum(stays) - 1, -1))
        self._removed.append(left.removed(time_s, exit_of[~stays]))
        ended_J = stored_J - self._contacts_J()
        self._supplied_J["removal"] -= self._mechanical_J(left) + ended_J
        self._impulse_N_s -= left.momentum_kg_m_per_s()
        self._came = self._came - left.angular_momentum_kg_m2_per_s()

    def _replace(self, new: Spheres, row: Indices) -> None:
        """Go on with ``new`` spheres; the present ones are now in rows ``row`` (< 0: gone)."""
        self._spheres = new
        self._now = self._now.renumbered(row, len(new))
        self._near = neighbours(new, self._plan.surface, self._surface_m)

    def _contacts_J(self) -> float:
        return float(self._now.elastic_J.sum() + self._now.adhesion_J.sum())

    def _mechanical_J(self, some: Spheres) -> float:
        return some.kinetic_J() + some.gravitational_J(self._plan.gravity_m_per_s2)
