"""The books of LIGGGHTS's particles: the momentum and energy that they own, and what came and went."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from orchestrator.ports import Account, AngularAccount, Array, Saved
from orchestrator.ports.physics import sphere_mass_kg
from orchestrator.ports.plans import ParticleList, ParticlesPlan
from orchestrator.ports.state import restore_attributes, save_attributes

if TYPE_CHECKING:
    from adapters.particles._liggghts import Engine


_SUMS = ("_mass_kg", "_impulse_N_s", "_came_kg_m2_per_s", "_fed_J", "_removed_J", "_first_J", "removed_count")


class Ledger:
    """Sums over the ranks of the communicator.  Potential energy is zero at the origin.

    Particles are given by LIGGGHTS's arrays: rmass, x, v, omega, radius.
    """

    def __init__(self, plan: ParticlesPlan, communicator: Any) -> None:
        self._comm = communicator
        self._gravity_m_per_s2 = plan.gravity_m_per_s2
        self._adhesive = plan.adhesion is not None
        self._periodic = plan.periodic_y
        self._mass_kg = float(_arrays(plan.particles)["rmass"].sum())
        self._impulse_N_s, self._came_kg_m2_per_s = np.zeros((2, 3))
        self._fed_J = self._removed_J = self._first_J = 0.0
        self.removed_count = 0

    def open(self, engine: Engine) -> None:
        """Remember the energy at t = 0."""
        self._first_J = sum(self._stored_J(engine).values())

    def add_gravity(self, length_s: float) -> None:
        """Book gravity's impulse on all particles for ``length_s``."""
        self._impulse_N_s += self._mass_kg * length_s * self._gravity_m_per_s2

    def add_fed(self, particles: ParticleList) -> None:
        """Book particles that came, alike on all ranks."""
        new = _arrays(particles)
        self._mass_kg += float(new["rmass"].sum())
        self._impulse_N_s += new["rmass"] @ new["v"]
        self._came_kg_m2_per_s += _angular_momentum_kg_m2_per_s(new, new["v"])
        self._fed_J += sum(self._motion_J(new))

    def subtract_removed(self, gone: dict[str, Any], before_end_s: Array, step_s: float) -> None:
        """Book particles of this rank taken out, ``before_end_s`` (n,) before the interval's end."""
        mass_kg, velocity_m_per_s = gone["rmass"], gone["v"]
        # `add_gravity` lets gravity act on them to the interval's end
        taken_N_s = mass_kg @ velocity_m_per_s + (mass_kg @ before_end_s) * self._gravity_m_per_s2
        # the sum of gravity's moments knows them up to the step before
        half_a_step_before_m_per_s = velocity_m_per_s - step_s / 2.0 * self._gravity_m_per_s2
        angular = _angular_momentum_kg_m2_per_s(gone, half_a_step_before_m_per_s)
        sums = np.array([len(mass_kg), mass_kg.sum(), sum(self._motion_J(gone)), *taken_N_s, *angular])
        sums = self._comm.allreduce(sums)
        self.removed_count += round(sums[0])
        self._mass_kg -= sums[1]
        self._removed_J += sums[2]
        self._impulse_N_s -= sums[3:6]
        self._came_kg_m2_per_s -= sums[6:]

    def account(self, engine: Engine) -> Account:
        """The books of now."""
        mine = engine.particles()
        stored_J = self._stored_J(engine)
        work_J = float(self._comm.allreduce(engine.surface_work_J()))
        gained_J = sum(stored_J.values()) - self._first_J
        return Account(
            momentum_kg_m_per_s=self._comm.allreduce(mine["rmass"] @ mine["v"]),
            outside_impulse_N_s=self._impulse_N_s.copy(),
            stored_J=stored_J,
            lost_J={"contact_dissipation": work_J + self._fed_J - self._removed_J - gained_J},
            supplied_J={"feed": self._fed_J, "removal": -self._removed_J},
            received_J={"surface": work_J},
            angular=None if self._periodic else self._angular(engine),
        )

    def _angular(self, engine: Engine) -> AngularAccount:
        """Angular momentum; of particles that are moved across periodic sides it would jump."""
        mine = engine.particles()
        momentum = _angular_momentum_kg_m2_per_s(mine, mine["v"])
        given, moment = engine.angular_impulse_N_m_s(), engine.mass_moment_time_kg_m_s()
        momentum, given, moment = self._comm.allreduce(np.array([momentum, given, moment]))
        fell = np.cross(moment, self._gravity_m_per_s2)
        return AngularAccount(momentum, fell + self._came_kg_m2_per_s, {"surface": -given})

    def save(self) -> Saved:
        return save_attributes(self, *_SUMS)

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_SUMS)

    def _stored_J(self, engine: Engine) -> dict[str, float]:
        kinetic_J, potential_J = self._motion_J(engine.particles())
        surface, pairs = engine.surface_energy_J(), engine.pair_energy_J()
        contacts_J = [surface[part] + pairs[part] for part in ("elastic_J", "adhesion_J")]
        sums = self._comm.allreduce(np.array([kinetic_J, potential_J, *contacts_J]))
        names = ("kinetic", "gravitational", "contact_elastic", "adhesion")
        stored_J = dict(zip(names, map(float, sums), strict=True))
        if not self._adhesive:
            del stored_J["adhesion"]
        return stored_J

    def _motion_J(self, some: dict[str, Any]) -> tuple[float, float]:
        """Kinetic (with rotation, solid spheres) and gravitational energy."""
        turning = _inertia_kg_m2(some) @ (some["omega"] ** 2).sum(axis=1)
        kinetic_J = 0.5 * float(some["rmass"] @ (some["v"] ** 2).sum(axis=1) + turning)
        return kinetic_J, -float(some["rmass"] @ (some["x"] @ self._gravity_m_per_s2))


def _arrays(particles: ParticleList) -> dict[str, Array]:
    """Particles from memory under LIGGGHTS's names."""
    return {
        "rmass": sphere_mass_kg(particles.diameter_m, particles.density_kg_per_m3),
        "x": particles.position_m,
        "v": particles.velocity_m_per_s,
        "omega": particles.spin_rad_per_s,
        "radius": 0.5 * particles.diameter_m,
    }


def _inertia_kg_m2(some: dict[str, Any]) -> Array:
    """The moments of inertia (n,) of solid spheres."""
    return np.asarray(0.4 * some["rmass"] * some["radius"] ** 2)


def _angular_momentum_kg_m2_per_s(some: dict[str, Any], velocity_m_per_s: Array) -> Array:
    """The angular momentum (3,) about the origin."""
    orbital = some["rmass"] @ np.cross(some["x"], velocity_m_per_s)
    return np.asarray(orbital + _inertia_kg_m2(some) @ some["omega"])
