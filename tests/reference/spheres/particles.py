"""The open spheres: velocity Verlet, as LIGGGHTS with flipflow does it.  Every MPI rank computes the same."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

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
from orchestrator.ports.geometry import UPPER, RigidVertices, closest_on_triangle
from orchestrator.ports.physics import sphere_drag_N
from orchestrator.ports.plans import ExitPlan, ParticlesPlan
from orchestrator.ports.state import as_arrays, like, restore_attributes, save_attributes
from tests.reference.spheres.bodies import Bodies
from tests.reference.spheres.contacts import Contacts, Neighbours, find_near_surface
from tests.reference.spheres.crossing import find_crossings
from tests.reference.spheres.forces import SphereForces, compute_contact_tangent, compute_forces
from tests.reference.spheres.laws import Laws
from tests.reference.spheres.triangle_spin import cross
from tests.reference.spheres.visits import Visits

TINY_M_PER_S = 1e-300  # a grain at rest has no drag
_BOOKS = (
    "_impulse_N_s",
    "_supplied_J",
    "_lost_J",
    "_air_J",
    "_received_J",
    "_came_kg_m2_per_s",
    "_given_kg_m2_per_s",
)
_SUMS = ("_drag_N", "_worn_m3", "_fed", "_deepest", "_crossings", "_mass_moment_time_kg_m_s", *_BOOKS)
_STATE = ("_bodies", "_surface_m", "_near", "_now", "_visits", *_SUMS)


class SpheresSolver:
    """``Particles`` in NumPy."""

    def __init__(self, plan: ParticlesPlan) -> None:
        self._rigid, self._points = plan.surface.rigid, len(plan.surface.position_m)
        vertices = replace(plan.surface, position_m=plan.surface.vertices_m, rigid=RigidVertices.none())
        self._plan = plan = replace(plan, surface=vertices)  # all vertices are points inside of here
        self._laws = Laws.of(plan)
        self._bodies = Bodies.of(plan.particles, 1)
        self._spheres = self._bodies.spheres(plan.shapes)
        self._drag_N = self._compute_drag()
        self._surface_m = plan.surface.position_m.copy()
        self._near = Neighbours.of(self._spheres, plan.surface, self._surface_m)
        at_rest = Motion(self._surface_m, np.zeros_like(self._surface_m))
        self._now = self._compute_forces(at_rest, None, 0.0)
        self._visits = Visits.of(len(self._bodies), plan.counted_panels)
        self._worn_m3 = np.zeros(len(self._surface_m))
        self._fed = 0  # particles, since t = 0
        self._deepest, self._crossings = self._now.contacts.deepest(), Crossings.none()
        self._removed: list[Removed] = []
        self._impulse_N_s = np.zeros(3)
        self._supplied_J = {"feed": 0.0, "removal": 0.0}
        self._lost_J = self._air_J = self._received_J = 0.0
        # angular momentum that came with particles and that went to the surface, and what gravity
        # gives it by: the integral over time of mass times place
        self._came_kg_m2_per_s, self._given_kg_m2_per_s, self._mass_moment_time_kg_m_s = np.zeros((3, 3))

    def initial(self) -> Load:
        return Load(self._on_points(self._now.on_points_N))

    def advance(self, interval: Interval, path: HermitePath) -> Load:
        check_point_count("particles' surface", path.end, self._points)
        start, end = (
            Motion(self._rigid.at(motion.position_m), self._rigid.at(motion.velocity_m_per_s))
            for motion in (path.start, path.end)
        )
        path = HermitePath(start, end, path.length_s)
        self._feed(interval)
        before_m, impulse_N_s = self._surface_m, np.zeros_like(self._surface_m)
        steps = interval.steps(self._plan.step_s)
        step_s = interval.length_s / steps
        self._jump_to(path.start)
        self._give(step_s / 2.0, impulse_N_s)
        for step in range(1, steps + 1):
            half_way_m_per_s = path.velocity_m_per_s((step - 0.5) / steps)
            centers_m = self._spheres.position_m.copy()
            self._step(step_s, path.at(step / steps), half_way_m_per_s)
            self._give(step_s if step < steps else step_s / 2.0, impulse_N_s)
            self._observe(centers_m, before_m, interval.start_s + step * step_s)
            before_m = self._surface_m
        self._remove(interval.end_s)
        if self._plan.deck is not None:
            self._visits.observe(self._plan.deck, self._surface_m, self._bodies, interval.length_s)
        return Load(self._on_points(impulse_N_s) / interval.length_s)

    def snapshot(self) -> ParticleSnapshot:
        return self._bodies.snapshot()

    def removed(self) -> Removed:
        since, self._removed = self._removed, []
        return self._sorted(since)

    def overlaps(self) -> Overlaps:
        since, self._deepest = self._deepest, Overlaps()
        return since

    def crossings(self) -> Crossings:
        return self._crossings

    def contact_tangent(self, length_s: float) -> ContactTangent:
        at_vertices = compute_contact_tangent(self._spheres, self._now, self._plan.gravity_m_per_s2, length_s)
        return ContactTangent(*map(self._on_points, vars(at_vertices).values()))

    def worn_m3(self) -> Array:
        assert self._plan.wear_m3_per_N_m is not None, "asked of a plan without wear"
        return self._worn_m3.copy()

    def account(self) -> Account:
        stored_J = {
            "kinetic": self._bodies.kinetic_J(),
            "gravitational": self._bodies.gravitational_J(self._plan.gravity_m_per_s2),
            "contact_elastic": float(self._now.acting.elastic_J.sum()),
        }
        if self._plan.adhesion is not None:
            stored_J["adhesion"] = float(self._now.acting.adhesion_J.sum())
        return Account(
            self._bodies.momentum_kg_m_per_s(),
            self._impulse_N_s.copy(),
            stored_J,
            lost_J={"contact_dissipation": self._lost_J}
            | ({} if self._plan.air is None else {"air_drag": self._air_J}),
            supplied_J=dict(self._supplied_J),
            received_J={"surface": self._received_J},
            angular=AngularAccount(
                self._bodies.angular_momentum_kg_m2_per_s(),
                self._came_kg_m2_per_s + np.cross(self._mass_moment_time_kg_m_s, self._plan.gravity_m_per_s2),
                {"surface": -self._given_kg_m2_per_s},
            ),
        )

    def save(self) -> Saved:
        return save_attributes(self, *_STATE) | {"removed": as_arrays(self._sorted(self._removed))}

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_STATE)
        self._spheres = self._bodies.spheres(self._plan.shapes)
        self._removed = [like(self._sorted([]), saved["removed"])]

    def close(self) -> None:
        pass

    def _sorted(self, removed: list[Removed]) -> Removed:
        return sort_removed(removed, self._plan.particles.grains.shapes, self._plan.counted_panels)

    def _on_points(self, at_vertices: Array) -> Array:
        """Return what acts on the points (n, ...), from what acts on the vertices (vertices, ...)."""
        at_points, first, share = at_vertices[: self._points].copy(), self._rigid.first, self._rigid.share
        of_rigid = at_vertices[self._points :]
        for k, part in enumerate([1.0 - share.sum(axis=1), *share.T]):
            np.add.at(at_points, first + k, part.reshape(-1, *[1] * (of_rigid.ndim - 1)) * of_rigid)
        return np.asarray(at_points)

    def _step(self, step_s: float, surface: Motion, half_way_m_per_s: Array) -> None:
        """Springs at the step's end go by the velocities of its middle, the surface's too."""
        now, before = self._bodies, self._now
        self._book_air(step_s / 2.0)
        self._kick(step_s / 2.0)
        mass_moment_kg_m = now.mass_kg @ now.position_m
        now.drift(self._spheres, step_s)
        mass_moment_kg_m = mass_moment_kg_m + now.mass_kg @ now.position_m
        self._mass_moment_time_kg_m_s = self._mass_moment_time_kg_m_s + step_s / 2.0 * mass_moment_kg_m
        if self._near.outdated(self._spheres.position_m, surface.position_m):
            self._near = Neighbours.of(self._spheres, self._plan.surface, surface.position_m)
        self._now = self._compute_forces(Motion(surface.position_m, half_way_m_per_s), before, step_s)
        self._drag_N = self._compute_drag()
        self._wear()
        self._kick(step_s / 2.0)
        self._book_air(step_s / 2.0)
        self._impulse_N_s += step_s * now.mass_kg.sum() * self._plan.gravity_m_per_s2
        self._lost_J += self._now.lost_J
        self._move_surface(surface, before)
        self._lost_J += step_s / 2.0 * (before.damping_W + self._now.damping_W)

    def _kick(self, step_s: float) -> None:
        forces, field_m_per_s2 = self._now, self._plan.gravity_m_per_s2
        if self._plan.air is not None:
            field_m_per_s2 = field_m_per_s2 + self._drag_N / self._bodies.mass_kg[:, None]
        self._bodies.kick(self._spheres, forces.force_N, forces.torque_N_m, step_s, field_m_per_s2)

    def _compute_drag(self) -> Array:
        """The drag (n, 3) of still air on the grains, as on spheres of their volume."""
        velocity_m_per_s, air = self._bodies.velocity_m_per_s, self._plan.air
        if air is None:
            return np.zeros_like(velocity_m_per_s)
        speed_m_per_s = np.linalg.norm(velocity_m_per_s, axis=1)
        diameter_m = self._bodies.grains.equivalent_diameter_m
        drag_N = sphere_drag_N(diameter_m, speed_m_per_s, air.density_kg_per_m3, air.viscosity_Pa_s)
        return -(drag_N / np.maximum(speed_m_per_s, TINY_M_PER_S))[:, None] * velocity_m_per_s

    def _book_air(self, length_s: float) -> None:
        """Book what the air gives and takes in ``length_s`` at the present places and velocities."""
        now, drag_N = self._bodies, self._drag_N
        self._impulse_N_s += length_s * drag_N.sum(axis=0)
        moment_N_m = cross(now.position_m, drag_N).sum(axis=0)
        self._came_kg_m2_per_s = self._came_kg_m2_per_s + length_s * moment_N_m
        self._air_J -= length_s * float(np.vdot(drag_N, now.velocity_m_per_s))

    def _compute_forces(self, surface: Motion, before: SphereForces | None, step_s: float) -> SphereForces:
        return compute_forces(
            self._laws, self._plan.surface, self._spheres, surface, self._near, before, step_s
        )

    def _jump_to(self, surface: Motion) -> None:
        """Go on with what the surface pushes with from where the coupling corrects it to at a sync point."""
        before, jump_m = self._now, surface.position_m - self._surface_m
        if jump_m.any():
            if self._near.outdated(self._spheres.position_m, surface.position_m):
                self._near = Neighbours.of(self._spheres, self._plan.surface, surface.position_m)
            again = self._compute_forces(surface, before, 0.0)
            self._now = before.with_surface_of(again, len(self._spheres))
            self._lost_J += again.lost_J
        self._lost_J += (before.compute_spent_J(jump_m) + self._now.compute_spent_J(jump_m)) / 2.0
        self._move_surface(surface, before)

    def _move_surface(self, surface: Motion, before: SphereForces) -> None:
        """Book the work of the surface's move by the trapezoidal rule, as Verlet does it."""
        mean_N = (before.on_points_N + self._now.on_points_N) / 2.0
        self._received_J -= float(np.vdot(mean_N, surface.position_m - self._surface_m))
        self._surface_m = surface.position_m
        self._now = self._now.at_velocities(self._spheres, surface.velocity_m_per_s)

    def _give(self, length_s: float, impulse_N_s: Array) -> None:
        """Add up the impulse on the surface points and its moment about the world's origin."""
        force_N = self._now.on_points_N
        impulse_N_s += length_s * force_N
        moment_N_m = cross(self._surface_m, force_N).sum(axis=0)
        self._given_kg_m2_per_s = self._given_kg_m2_per_s + length_s * moment_N_m

    def _wear(self) -> None:
        """Wear the surface where something slides on it: volume = rate * force * distance (Archard,
        J. F., Journal of Applied Physics 24, 1953, 981-988, doi 10.1063/1.1721448;
        docs/theory/wear.md)."""
        if self._plan.wear_m3_per_N_m is None:
            return
        contacts = self._now.contacts
        worn_m3 = self._plan.wear_m3_per_N_m[contacts.materials] * self._now.acting.rubbed_J
        np.add.at(self._worn_m3, contacts.points, contacts.barycentric * worn_m3[:, None])

    def _observe(self, centers_m: Array, before_m: Array, time_s: float) -> None:
        """Keep how deep contacts are, and who went through the surface in the step that ends now;
        centres and surface points were at ``centers_m`` and ``before_m``."""
        now, contacts = self._spheres, self._now.contacts
        self._deepest = self._deepest.deepest(contacts.deepest())
        self._visits.touched[now.body[contacts.first[self._touches_deck(contacts)]]] = True
        way_m = (before_m, self._surface_m)
        rows = find_crossings(now, contacts, centers_m, self._plan.surface.triangles, way_m)
        if len(rows):
            some = Crossings(len(rows), int(now.id[rows[0]]), time_s, now.position_m[rows[0]].copy())
            self._crossings = self._crossings.followed_by(some)

    def _touches_deck(self, contacts: Contacts) -> npt.NDArray[np.bool_]:
        """Tell which contacts are with the upper side of a panel, or with a wall, which has points there."""
        surface = self._plan.surface
        upper = surface.on_deck & (True if surface.side is None else surface.side == UPPER)
        of_deck = np.isin(np.arange(len(surface.position_m)), surface.triangles[upper])
        return np.asarray((contacts.second < 0) & of_deck[contacts.points].any(axis=1))

    def _feed(self, interval: Interval) -> None:
        """Take in the particles that are due and overlap neither present ones nor the surface."""
        if self._plan.feed is None:
            return
        next_id = 1 + len(self._plan.particles) + self._fed
        offered = Bodies.of(self._plan.feed.due(interval), next_id)
        accepted = self._find_room(offered)
        self._plan.feed.settle(accepted)
        if not accepted.any():
            return
        new = offered.part(accepted)
        new.id = next_id + np.arange(len(new))
        self._fed += len(new)
        self._supplied_J["feed"] += new.mechanical_J(self._plan.gravity_m_per_s2)
        self._impulse_N_s += new.momentum_kg_m_per_s()
        self._came_kg_m2_per_s = self._came_kg_m2_per_s + new.angular_momentum_kg_m2_per_s()
        self._replace(Bodies.joined([self._bodies, new]), np.arange(len(self._bodies)))

    def _find_room(self, offered: Bodies) -> npt.NDArray[np.bool_]:
        from scipy.spatial.distance import cdist

        now, triangles = self._spheres, self._plan.surface.triangles
        spheres = offered.spheres(self._plan.shapes)
        reach_m = np.add.outer(spheres.radius_m, now.radius_m)
        blocked = np.any(cdist(spheres.position_m, now.position_m) < reach_m, axis=1)
        blocked[find_near_surface(spheres, 0.0, self._surface_m[triangles])[0]] = True
        free = np.ones(len(offered), dtype=bool)
        free[spheres.body[blocked]] = False
        return free

    def _remove(self, time_s: float) -> None:
        """Take out who is in an exit or has left the domain; contacts end with their energy."""
        now, (lowest_m, highest_m) = self._bodies, self._plan.domain_m
        exit_of = np.full(len(now), -1)
        for number, box in reversed(list(enumerate(self._plan.exits))):
            held = np.flatnonzero(box.holds(now.position_m))
            exit_of[held[self._has_left(box, now.position_m[held])]] = number
        inside = np.all((now.position_m >= lowest_m) & (now.position_m <= highest_m), axis=1)
        stays = inside & (exit_of < 0)
        if stays.all():
            return
        left, stored_J = now.part(~stays), self._now.stored_J()
        if self._plan.deck is not None:
            below = [number for number, box in enumerate(self._plan.exits) if box.product == "undersize"]
            passes = ~stays & np.isin(exit_of, below)
            self._visits.passed(self._plan.deck, self._surface_m, now, passes)
        visits = self._visits.part(~stays)
        self._replace(now.part(stays), np.where(stays, np.cumsum(stays) - 1, -1))
        self._removed.append(left.removed(time_s, exit_of[~stays], visits))
        ended_J = stored_J - self._now.stored_J()
        self._supplied_J["removal"] -= left.mechanical_J(self._plan.gravity_m_per_s2) + ended_J
        self._impulse_N_s -= left.momentum_kg_m_per_s()
        self._came_kg_m2_per_s = self._came_kg_m2_per_s - left.angular_momentum_kg_m2_per_s()

    def _has_left(self, box: ExitPlan, position_m: Array) -> npt.NDArray[np.bool_]:
        """Tell who is below the nearest panel that reaches into an exit of the undersize."""
        surface, below = self._plan.surface, np.ones(len(position_m), dtype=bool)
        if surface.panel is None or box.product != "undersize":
            return below
        corners_m = self._surface_m[surface.floor]
        in_box_m = (corners_m - box.center_m) @ box.axes.T
        meets = (in_box_m.min(axis=1) <= box.half_m) & (in_box_m.max(axis=1) >= -box.half_m)
        corners_m = corners_m[meets.all(axis=1)]
        for row, place_m in enumerate(position_m if len(corners_m) else ()):
            nearest_m = np.einsum("ij,ijk->ik", closest_on_triangle(place_m[None], corners_m), corners_m)
            away_m = place_m - nearest_m
            normal = np.cross(corners_m[:, 1] - corners_m[:, 0], corners_m[:, 2] - corners_m[:, 0])
            height_m = np.einsum("ij,ij->i", away_m, normal) / np.linalg.norm(normal, axis=1)
            distance_m = np.linalg.norm(away_m, axis=1)
            alike = distance_m <= distance_m.min() * (1 + 1e-9)
            below[row] = height_m[alike][np.argmax(np.abs(height_m[alike]))] < 0.0
        return below

    def _replace(self, new: Bodies, row: Indices) -> None:
        """Go on with ``new`` grains; the present ones are now in rows ``row`` (< 0: gone)."""
        before, self._spheres = self._spheres, new.spheres(self._plan.shapes)
        self._bodies = new
        self._drag_N = self._compute_drag()
        self._visits = self._visits.renumbered(row, len(new))
        within = np.arange(len(before)) - np.searchsorted(before.body, before.body)
        to = row[before.body]
        sphere_row = np.where(to >= 0, np.searchsorted(self._spheres.body, to) + within, -1)
        self._now = self._now.renumbered(sphere_row, len(self._spheres))
        self._near = Neighbours.of(self._spheres, self._plan.surface, self._surface_m)
