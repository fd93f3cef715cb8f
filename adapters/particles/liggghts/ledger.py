"""Momentum and energy of the particles: what they own, and what came and went."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from orchestrator.ports import Account, AngularAccount, Array, Saved
from orchestrator.ports.plans import ParticleList, ParticlesPlan
from orchestrator.ports.state import put_back, taken

if TYPE_CHECKING:
    from adapters.particles._liggghts import Engine


_SUMS = ("_mass_kg", "_impulse_N_s", "_came_kg_m2_per_s", "_fed_J", "_removed_J", "_first_J", "removed_count")


class Ledger:
    """Sums over the ranks of the communicator.  Potential energy is zero at the origin."""

    def __init__(self, plan: ParticlesPlan, communicator: Any) -> None:
        self._comm = communicator
        self._gravity_m_per_s2 = plan.gravity_m_per_s2
        self._adhesive = plan.adhesion is not None
        self._mass_kg = 0.0
        self._impulse_N_s, self._came_kg_m2_per_s = np.zeros((2, 3))
        self._periodic = plan.periodic_y
        self._fed_J = self._removed_J = self._first_J = 0.0
        self.removed_count = 0
        self._mass_kg = float(_mass(plan.particles).sum())

    def open(self, engine: Engine) -> None:
        """At t = 0."""
        self._first_J = sum(self._stored(engine).values())

    def fell(self, length_s: float) -> None:
        """Gravity acted on all particles for ``length_s``."""
        self._impulse_N_s += self._mass_kg * length_s * self._gravity_m_per_s2

    def fed(self, new: ParticleList) -> None:
        mass_kg = _mass(new)
        self._mass_kg += float(mass_kg.sum())
        self._impulse_N_s += mass_kg @ new.velocity_m_per_s
        self._came_kg_m2_per_s += _angular_momentum(
            mass_kg, new.position_m, new.velocity_m_per_s, new.spin_rad_per_s, 0.5 * new.diameter_m
        )
        self._fed_J += sum(
            self._motion_J(
                mass_kg, new.position_m, new.velocity_m_per_s, new.spin_rad_per_s, 0.5 * new.diameter_m
            )
        )

    def removed(self, mine: dict[str, Any], before_end_s: Array, step_s: float) -> None:
        """Particles of this rank taken out, ``before_end_s`` (n,) before the interval's end."""
        mass_kg, velocity_m_per_s = mine["rmass"], mine["v"]
        motion_J = self._motion_J(mass_kg, mine["x"], velocity_m_per_s, mine["omega"], mine["radius"])
        # `fell` lets gravity act on them to the interval's end
        taken_N_s = mass_kg @ velocity_m_per_s + (mass_kg @ before_end_s) * self._gravity_m_per_s2
        # the sum of gravity's moments knows them up to the step before
        half_a_step_before_m_per_s = velocity_m_per_s - step_s / 2.0 * self._gravity_m_per_s2
        gone = _angular_momentum(
            mass_kg, mine["x"], half_a_step_before_m_per_s, mine["omega"], mine["radius"]
        )
        sums = np.array([len(mass_kg), mass_kg.sum(), sum(motion_J), *taken_N_s, *gone])
        sums = self._comm.allreduce(sums)
        self.removed_count += round(sums[0])
        self._mass_kg -= sums[1]
        self._removed_J += sums[2]
        self._impulse_N_s -= sums[3:6]
        self._came_kg_m2_per_s -= sums[6:]

    def account(self, engine: Engine) -> Account:
        mine = engine.particles()
        stored_J = self._stored(engine)
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
        """Of particles that are moved across periodic sides it would jump."""
        mine = engine.particles()
        momentum = _angular_momentum(mine["rmass"], mine["x"], mine["v"], mine["omega"], mine["radius"])
        given, moment = engine.angular_impulse_N_m_s(), engine.mass_moment_time_kg_m_s()
        momentum, given, moment = self._comm.allreduce(np.array([momentum, given, moment]))
        fell = np.cross(moment, self._gravity_m_per_s2)
        return AngularAccount(momentum, fell + self._came_kg_m2_per_s, {"surface": -given})

    def save(self) -> Saved:
        return taken(self, *_SUMS)

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, *_SUMS)

    def _stored(self, engine: Engine) -> dict[str, float]:
        mine = engine.particles()
        kinetic_J, potential_J = self._motion_J(
            mine["rmass"], mine["x"], mine["v"], mine["omega"], mine["radius"]
        )
        contacts_J = np.add(engine.surface_energy_J(), engine.pair_energy_J())
        sums = self._comm.allreduce(np.array([kinetic_J, potential_J, *contacts_J]))
        names = ("kinetic", "gravitational", "contact_elastic", "adhesion")
        stored_J = dict(zip(names, map(float, sums), strict=True))
        if not self._adhesive:
            del stored_J["adhesion"]
        return stored_J

    def _motion_J(
        self, mass_kg: Array, x_m: Array, v_m_per_s: Array, spin_rad_per_s: Array, radius_m: Array
    ) -> tuple[float, float]:
        """Kinetic (with rotation, solid spheres) and gravitational energy."""
        inertia_kg_m2 = 0.4 * mass_kg * radius_m**2
        turning = inertia_kg_m2 @ (spin_rad_per_s**2).sum(axis=1)
        kinetic_J = 0.5 * float(mass_kg @ (v_m_per_s**2).sum(axis=1) + turning)
        return kinetic_J, -float(mass_kg @ (x_m @ self._gravity_m_per_s2))


def _mass(particles: ParticleList) -> Array:
    mass_kg: Array = np.pi / 6.0 * particles.diameter_m**3 * particles.density_kg_per_m3
    return mass_kg


def _angular_momentum(
    mass_kg: Array, x_m: Array, v_m_per_s: Array, spin_rad_per_s: Array, radius_m: Array
) -> Array:
    """(3,) about the origin, of solid spheres."""
    own = (0.4 * mass_kg * radius_m**2) @ spin_rad_per_s
    return np.asarray(mass_kg @ np.cross(x_m, v_m_per_s) + own)
