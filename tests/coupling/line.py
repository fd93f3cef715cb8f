"""Three members on a line (the x axis), each exact between sync points: for tests of schemes.

A sphere meets, through a linear spring, a plate; the plate hangs on a frame by a linear spring.
Forces are piecewise constant as the ports hand them over, so everything is integrated in closed
form except the sphere, which takes many small steps.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.sparse import csr_array

from orchestrator.coupling.schemes.scheme import Solvers
from orchestrator.ports import (
    Account,
    ContactTangent,
    Crossings,
    HermitePath,
    Inertia,
    Load,
    Motion,
    Mount,
    PanelState,
    Saved,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.state import restore_attributes, save_attributes


def point(x: float, v: float) -> Motion:
    return Motion(np.array([[x, 0.0, 0.0]]), np.array([[v, 0.0, 0.0]]))


def push(force: float) -> Load:
    return Load(np.array([[force, 0.0, 0.0]]))


@dataclass
class FreeFrame:
    """A free mass, or one with a damper to the ground (which takes small steps)."""

    mass_kg: float
    x: float = 0.0
    v: float = 0.0
    damping_N_s_per_m: float = 0.0

    def save(self) -> Saved:
        return save_attributes(self, "x", "v")

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, "x", "v")

    def initial(self) -> Motion:
        return point(self.x, self.v)

    def advance(self, interval: Interval, reaction: Load) -> Motion:
        steps = 40 if self.damping_N_s_per_m else 1
        h, force = interval.length_s / steps, reaction.force_N[0, 0]
        for _ in range(steps):
            a = (force - self.damping_N_s_per_m * self.v) / self.mass_kg
            self.x += h * self.v + h * h * a / 2
            self.v += h * a
        return self.initial()

    def account(self) -> Account:
        raise NotImplementedError

    def close(self) -> None: ...


@dataclass
class HungPlate:
    """A mass on a spring to its clamp, ``steps`` velocity-Verlet steps an interval."""

    mass_kg: float
    stiffness_N_per_m: float
    steps: int = 40
    x: float = 0.0
    v: float = 0.0
    clamp: Motion = field(default_factory=lambda: point(0.0, 0.0))
    mount: Mount = field(default_factory=lambda: Mount(np.zeros((1, 3)), ("frame",)))

    def inertia(self) -> Inertia:
        return Inertia(csr_array(np.eye(1)), np.array([self.mass_kg]), np.zeros((1, 3)))

    def save(self) -> Saved:
        return save_attributes(self, "x", "v", "clamp")

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, "x", "v", "clamp")

    def initial(self) -> PanelState:
        return PanelState(point(self.x, self.v), push(0.0))

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        path, dt = HermitePath(self.clamp, clamps, interval.length_s), interval.length_s / self.steps
        pull = self.stiffness_N_per_m * (self.x - path.position_m(0.0)[0, 0])
        impulse = 0.0
        for step in range(self.steps):
            self.v += dt / 2 * (load.force_N[0, 0] - pull) / self.mass_kg
            self.x += dt * self.v
            after = self.stiffness_N_per_m * (self.x - path.position_m((step + 1) / self.steps)[0, 0])
            self.v += dt / 2 * (load.force_N[0, 0] - after) / self.mass_kg
            impulse += dt / 2 * (pull + after)
            pull = after
        self.clamp = clamps
        return PanelState(point(self.x, self.v), push(impulse / interval.length_s))

    def account(self) -> Account:
        raise NotImplementedError

    def close(self) -> None: ...


@dataclass
class Sphere:
    """Overlaps the plate where x < plate; a linear contact spring and damper.  With ``stays`` it
    never lets go, as if something pressed on it."""

    mass_kg: float
    stiffness_N_per_m: float
    x: float
    v: float
    steps: int = 40
    damping_N_s_per_m: float = 0.0
    stays: bool = False
    seen: float = 0.0  # where the plate was at last

    def save(self) -> Saved:
        return save_attributes(self, "x", "v", "seen")

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, "x", "v", "seen")

    def contact_tangent(self, length_s: float) -> ContactTangent:
        """Return the tangent by the implicit midpoint rule, of the contact that there is now."""
        overlap = self.seen - self.x
        touching = float(overlap > 0.0 or self.stays)
        impedance = self.stiffness_N_per_m * length_s / 2 + self.damping_N_s_per_m
        share = touching / (1 + impedance * length_s / (2 * self.mass_kg))
        resisting = np.zeros((1, 3, 3))
        resisting[0, 0, 0] = share * impedance
        given = share * (impedance * self.v - self.stiffness_N_per_m * overlap)
        return ContactTangent(push(given).force_N, resisting)

    def initial(self) -> Load:
        return push(0.0)

    def advance(self, interval: Interval, path: HermitePath) -> Load:
        dt = interval.length_s / self.steps
        force = self._force(path, 0.0)
        impulse = 0.0
        for step in range(self.steps):
            self.v += dt / 2 * force / self.mass_kg
            self.x += dt * self.v
            after = self._force(path, (step + 1) / self.steps)
            self.v += dt / 2 * after / self.mass_kg
            impulse += dt / 2 * (force + after)
            force = after
        self.seen = path.end.position_m[0, 0]
        return push(-impulse / interval.length_s)

    def _force(self, path: HermitePath, fraction: float) -> float:
        overlap = path.position_m(fraction)[0, 0] - self.x
        rate = path.velocity_m_per_s(fraction)[0, 0] - self.v
        if overlap <= 0.0 and not self.stays:
            return 0.0
        return self.stiffness_N_per_m * overlap + self.damping_N_s_per_m * rate

    def crossings(self) -> Crossings:
        return Crossings.none()

    def snapshot(self) -> None:
        raise NotImplementedError

    def account(self) -> Account:
        raise NotImplementedError

    def close(self) -> None: ...


def members(sphere: Sphere, plate: HungPlate, frame: FreeFrame) -> Solvers:
    return Solvers(frame, plate, sphere)
