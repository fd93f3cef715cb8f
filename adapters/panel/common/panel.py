"""Common parts of all panels of this folder: the calls of the port, and the accounts behind them."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar, Protocol

import numpy as np

from orchestrator.ports import (
    Account,
    Array,
    HermitePath,
    Indices,
    Load,
    Motion,
    Mount,
    PanelState,
    Restorable,
    check_point_count,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import PanelPlan
from orchestrator.ports.state import SavedAttributes


class AccountedPanel(SavedAttributes, ABC):
    """A ``Panel`` with momentum and energy accounts, whose motion a subclass computes.

    A subclass moves the panel in ``_move``, and returns its masses in ``_masses`` if they are not at the
    points of the surface.  It sets ``_surface``, the present motion of the surface, and ``_rest_m``
    (masses, 3), where the potential of gravity is zero.
    """

    STATE: ClassVar[tuple[str, ...]] = ("_clamps", "_surface", "_elapsed_s", "_received_J")
    _surface: Motion
    _rest_m: Array

    def __init__(self, name: str, mount: Mount, mass_kg: Array, gravity_m_per_s2: Array) -> None:
        self._name, self.mount = name, mount
        self._mass_kg, self._gravity_m_per_s2 = mass_kg[:, None], gravity_m_per_s2
        self._weight_N = self._mass_kg * gravity_m_per_s2
        self._clamps = Motion(mount.position_m, np.zeros_like(mount.position_m))
        self._elapsed_s, self._received_J = 0.0, {"load": 0.0, "clamps": 0.0}

    def initial(self) -> PanelState:
        return PanelState(self._surface, Load(self._static_reaction_N()))

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        check_point_count(f"{self._name}: clamps", clamps, len(self._clamps))
        check_point_count(f"{self._name}: load", load, len(self._surface))
        surface, reaction_N, clamps_J = self._move(interval, clamps, load.force_N)
        moved_m = surface.position_m - self._surface.position_m
        self._received_J["load"] += float(np.vdot(load.force_N, moved_m))
        self._received_J["clamps"] += clamps_J
        self._clamps, self._surface = clamps, surface
        self._elapsed_s += interval.length_s
        return PanelState(surface, Load(reaction_N))

    def account(self) -> Account:
        position_m, velocity_m_per_s = self._masses()
        momentum_kg_m_per_s = self._mass_kg * velocity_m_per_s
        return Account(
            momentum_kg_m_per_s.sum(axis=0),
            self._mass_kg.sum() * self._gravity_m_per_s2 * self._elapsed_s,
            stored_J={
                "kinetic": float(np.vdot(momentum_kg_m_per_s, velocity_m_per_s) / 2),
                "gravitational": -float(np.vdot(self._weight_N, position_m - self._rest_m)),
            },
            received_J=dict(self._received_J),
        )

    @abstractmethod
    def _static_reaction_N(self) -> Array:
        """Return the force (clamps, 3) on the frames at rest."""

    @abstractmethod
    def _move(self, interval: Interval, clamps: Motion, load_N: Array) -> tuple[Motion, Array, float]:
        """Move the panel to the interval's end.

        Return the surface there, the mean force (clamps, 3) on the frames, and the work of the
        clamps on the panel in J.
        """

    def _masses(self) -> tuple[Array, Array]:
        """Return positions and velocities (masses, 3) of the points to which ``mass_kg`` belongs."""
        return self._surface.position_m, self._surface.velocity_m_per_s


@dataclass
class HeldForce:
    """The force at a body's held nodes over an interval.

    It has the impulse (held, 3) and the work on the nodes' motion, both with the mean force that the scheme
    itself uses in each step.
    """

    impulse_N_s: Array
    work_J: float = 0.0

    def add(self, step_s: float, force_N: Array, moved_m: Array) -> None:
        """Add a step with this mean force and these displacements of the held nodes, (held, 3) each."""
        self.impulse_N_s += step_s * force_N
        self.work_J += float(np.vdot(force_N, moved_m))


class Body(Restorable, Protocol):
    """Masses (nodes,) that move; positions, velocities and internal forces have shape (nodes, 3).

    ``held`` are the numbers of the nodes whose motion is prescribed.
    """

    mass_kg: Array
    held: Indices

    @property
    def position_m(self) -> Array: ...

    @property
    def velocity_m_per_s(self) -> Array: ...

    @property
    def internal_N(self) -> Array: ...

    def move(self, path: HermitePath, outside_N: Array, interval: Interval) -> HeldForce:
        """Move to the interval's end under a constant outside force, with the held nodes along ``path``."""
        ...

    def stored_J(self) -> dict[str, float]:
        """Return the stored energies in J by name: the elastic energies and the Maxwell branches' energy."""
        ...

    def lost_J(self) -> float:
        """Return the energy in J that the Maxwell branches have dissipated since the start."""
        ...

    def close(self) -> None: ...


class BodyPanel(AccountedPanel):
    """A panel that a deformable body carries; the body is at rest when t = 0."""

    PARTS = ("_body",)

    def __init__(self, plan: PanelPlan, mount: Mount, body: Body) -> None:
        super().__init__(f"panel {plan.name}", mount, body.mass_kg, plan.gravity_m_per_s2)
        self._body, self._rest_m = body, body.position_m.copy()

    def account(self) -> Account:
        account = super().account()
        stored_J = {**account.stored_J, **self._body.stored_J()}
        return replace(account, stored_J=stored_J, lost_J={"panel_damping": self._body.lost_J()})

    def close(self) -> None:
        self._body.close()

    def _masses(self) -> tuple[Array, Array]:
        return self._body.position_m, self._body.velocity_m_per_s


def choose_step_s(plan: PanelPlan, largest_s: float, usual_s: float) -> float:
    """Return the plan's step, or ``usual_s`` for 0.  Raises ValueError for a step above ``largest_s``."""
    if plan.step_s > largest_s:
        raise ValueError(
            f"panel {plan.name}: step_s = {plan.step_s} is above the limit of {largest_s:.3g} s; "
            f"take {usual_s:.3g} s, or 0 for just that"
        )
    return plan.step_s or usual_s
