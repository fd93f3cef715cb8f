"""The ledger of LIGGGHTS's particles: their momentum and energy, with the gains and losses."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from adapters.particles.liggghts.input import has_bodies
from orchestrator.ports import Account, AngularAccount, Array
from orchestrator.ports.grains import turned, turned_back
from orchestrator.ports.plans import ParticleList, ParticlesPlan
from orchestrator.ports.state import SavedAttributes

if TYPE_CHECKING:
    from adapters.particles._liggghts import Engine


@dataclass
class Bodies:
    """The properties of n rigid bodies, a row each."""

    mass_kg: Array  # (n,)
    position_m: Array  # (n, 3)
    velocity_m_per_s: Array  # (n, 3)
    spin_rad_per_s: Array  # (n, 3)
    own_kg_m2_per_s: Array  # (n, 3) angular momentum about the centre of mass

    def __len__(self) -> int:
        return len(self.mass_kg)

    def momentum_kg_m_per_s(self) -> Array:
        """Return the momentum (3,) of all bodies."""
        return self.mass_kg @ self.velocity_m_per_s

    def moved_N_s(self) -> float:
        """Return the sum of the sizes of the bodies' momenta."""
        return float(self.mass_kg @ np.linalg.norm(self.velocity_m_per_s, axis=1))

    def angular_momentum_kg_m2_per_s(self) -> Array:
        """Return the angular momentum (3,) of all bodies about the world's origin."""
        orbital = self.mass_kg @ np.cross(self.position_m, self.velocity_m_per_s)
        return np.asarray(orbital + self.own_kg_m2_per_s.sum(axis=0))

    def kinetic_J(self) -> float:
        """Return the kinetic energy of all bodies, rotation included."""
        moving = self.mass_kg @ np.sum(self.velocity_m_per_s**2, axis=1)
        return float(moving + np.vdot(self.own_kg_m2_per_s, self.spin_rad_per_s)) / 2.0

    def gravitational_J(self, gravity_m_per_s2: Array) -> float:
        """Return the potential energy of all bodies, zero at the world's origin."""
        return -float(self.mass_kg @ (self.position_m @ gravity_m_per_s2))

    def mechanical_J(self, gravity_m_per_s2: Array) -> float:
        """Return the kinetic and potential energy of all bodies."""
        return self.kinetic_J() + self.gravitational_J(gravity_m_per_s2)


def _listed(particles: ParticleList) -> Bodies:
    """Return the bodies of a list that the orchestrator made."""
    motion = (particles.position_m, particles.velocity_m_per_s, particles.spin_rad_per_s)
    spin = turned_back(particles.orientation, particles.spin_rad_per_s)
    own = turned(particles.orientation, particles.grains.inertia_kg_m2 * spin)
    return Bodies(particles.grains.mass_kg, *motion, own)


def _owned(arrays: dict[str, Any]) -> Bodies:
    """Return the bodies of the engine's arrays; those of single spheres have no angular momentum in them."""
    mass_kg, spin = arrays["rmass"], arrays["omega"]
    if (own := arrays.get("angular_momentum")) is None:
        own = (0.4 * mass_kg * arrays["radius"] ** 2)[:, None] * spin
    return Bodies(mass_kg, arrays["x"], arrays["v"], spin, own)


class ParticleLedger(SavedAttributes):
    """The ledger of all particles, with sums over the ranks.  Potential energy is zero at the origin."""

    STATE = (
        "_mass_kg",
        "_impulse_N_s",
        "_moved_N_s",
        "_came_kg_m2_per_s",
        "_fed_J",
        "_removed_J",
        "_first_J",
        "removed_count",
    )

    def __init__(self, plan: ParticlesPlan, communicator: Any) -> None:
        self._comm = communicator
        self._gravity_m_per_s2 = plan.gravity_m_per_s2
        self._adhesive = plan.adhesion is not None
        self._periodic = plan.periodic_y
        self._has_bodies = has_bodies(plan)
        self._airy = plan.air is not None
        self._mass_kg = float(_listed(plan.particles).mass_kg.sum())
        self._impulse_N_s, self._came_kg_m2_per_s = np.zeros((2, 3))
        self._fed_J = self._removed_J = self._first_J = self._moved_N_s = 0.0
        self.removed_count = 0

    def _present(self, engine: Engine) -> Bodies:
        return _owned(engine.bodies() if self._has_bodies else engine.particles())

    def open(self, engine: Engine) -> None:
        """Store the energy at t = 0."""
        self._first_J = sum(self._stored_J(engine).values())

    def add_gravity(self, length_s: float) -> None:
        """Add gravity's impulse on all particles over ``length_s``."""
        self._impulse_N_s += self._mass_kg * length_s * self._gravity_m_per_s2

    def add_fed(self, particles: ParticleList) -> None:
        """Add particles that were fed, the same on all ranks."""
        new = _listed(particles)
        self._mass_kg += float(new.mass_kg.sum())
        self._impulse_N_s += new.momentum_kg_m_per_s()
        self._moved_N_s += new.moved_N_s()
        self._came_kg_m2_per_s += new.angular_momentum_kg_m2_per_s()
        self._fed_J += new.mechanical_J(self._gravity_m_per_s2)

    def subtract_removed(self, arrays: dict[str, Any], before_end_s: Array, filled_s: Array) -> None:
        """Subtract this rank's particles, removed ``before_end_s`` (n,) before the interval's end.

        In the last ``filled_s`` (n,) before that, only gravity has acted on them."""
        gone, gravity_m_per_s2 = _owned(arrays), self._gravity_m_per_s2
        # `add_gravity` lets gravity act on them to the interval's end
        taken_N_s = gone.momentum_kg_m_per_s() + (gone.mass_kg @ before_end_s) * gravity_m_per_s2
        # the sum of gravity's moments knows them up to then
        earlier_m_per_s = gone.velocity_m_per_s - np.outer(filled_s, gravity_m_per_s2)
        angular = replace(gone, velocity_m_per_s=earlier_m_per_s).angular_momentum_kg_m2_per_s()
        removed_J = gone.mechanical_J(gravity_m_per_s2)
        sums = np.array([len(gone), gone.mass_kg.sum(), removed_J, *taken_N_s, *angular, gone.moved_N_s()])
        sums = self._comm.allreduce(sums)
        self.removed_count += round(sums[0])
        self._mass_kg -= sums[1]
        self._removed_J += sums[2]
        self._impulse_N_s -= sums[3:6]
        self._came_kg_m2_per_s -= sums[6:9]
        self._moved_N_s += float(sums[9])

    def account(self, engine: Engine) -> Account:
        """Return the present account."""
        mine = self._present(engine)
        stored_J = self._stored_J(engine)
        work_J = float(self._comm.allreduce(engine.surface_work_J()))
        gained_J = sum(stored_J.values()) - self._first_J
        air_N_s, air_N_m_s, air_J = self._from_air(engine)
        lost_J = work_J + self._fed_J - self._removed_J - gained_J
        return Account(
            momentum_kg_m_per_s=self._comm.allreduce(mine.momentum_kg_m_per_s()),
            outside_impulse_N_s=self._impulse_N_s + air_N_s,
            stored_J=stored_J,
            lost_J={"contact_dissipation": lost_J + air_J} | ({"air_drag": -air_J} if self._airy else {}),
            supplied_J={"feed": self._fed_J, "removal": -self._removed_J},
            received_J={"surface": work_J},
            angular=None if self._periodic else self._angular(engine, air_N_m_s),
            moved_N_s=self._moved_N_s + float(self._comm.allreduce(mine.moved_N_s())),
        )

    def _from_air(self, engine: Engine) -> tuple[Array, Array, float]:
        """Return impulse (3,), angular impulse (3,) and work of the air on all particles since t = 0."""
        if not self._airy:
            return np.zeros(3), np.zeros(3), 0.0
        mine = engine.air()
        sums = np.array([*mine["impulse_N_s"], *mine["angular_impulse_N_m_s"], mine["work_J"]])
        sums = self._comm.allreduce(sums)
        return sums[:3], sums[3:6], float(sums[6])

    def _angular(self, engine: Engine, air_N_m_s: Array) -> AngularAccount:
        """Return the angular momentum, which would jump for particles moved across periodic sides."""
        momentum = self._present(engine).angular_momentum_kg_m2_per_s()
        given, moment = engine.angular_impulse_N_m_s(), engine.mass_moment_time_kg_m_s()
        momentum, given, moment = self._comm.allreduce(np.array([momentum, given, moment]))
        fell = np.cross(moment, self._gravity_m_per_s2)
        outside = fell + air_N_m_s + self._came_kg_m2_per_s
        return AngularAccount(momentum, outside, {"surface": -given})

    def _stored_J(self, engine: Engine) -> dict[str, float]:
        mine = self._present(engine)
        surface, pairs = engine.surface_energy_J(), engine.pair_energy_J()
        contacts_J = [surface[part] + pairs[part] for part in ("elastic_J", "adhesion_J")]
        motion_J = (mine.kinetic_J(), mine.gravitational_J(self._gravity_m_per_s2))
        sums = self._comm.allreduce(np.array([*motion_J, *contacts_J]))
        names = ("kinetic", "gravitational", "contact_elastic", "adhesion")
        stored_J = dict(zip(names, map(float, sums), strict=True))
        if not self._adhesive:
            del stored_J["adhesion"]
        return stored_J
