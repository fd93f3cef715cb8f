"""What a solver's adapter tells of itself before it is opened.

Each solver has a door: a module of the port's folder, named after the solver, or an object that an
installed package names in its entry points (group ``flipflow.panel``, ``flipflow.frames`` or
``flipflow.particles``).  The door holds one record ``ADAPTER`` of the kinds below.  Everything that
the orchestrator must know of a solver (what it can do, what it costs, what it leaves out, what it
cannot take) stands there, so that no other file names a solver.  Shapes of grains come through such doors,
too (folder ``shapes``, group ``flipflow.shapes``); their record is a ``ports.grains.Shape``.

Importing a door must not import the solver's own library: ``build`` does that, and ``needs`` names
the modules that it takes.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Generic, TypeVar

from orchestrator.ports import Frames, MeshedPanel, Particles
from orchestrator.ports.plans import (
    Cost,
    FramesPlan,
    FramesWork,
    MeshSize,
    PanelPlan,
    PanelsWork,
    ParticlesPlan,
    ParticlesWork,
)

__all__ = ["Adapter", "Cost", "FramesAdapter", "Objection", "PanelAdapter", "ParticlesAdapter"]

Plan = TypeVar("Plan")
Work = TypeVar("Work")
Solver = TypeVar("Solver")


@dataclass(frozen=True)
class Objection:
    """Why a solver cannot take a plan: what is wrong, what to do about it, and the case's key."""

    what: str
    hint: str = ""
    key: tuple[str | int, ...] = ()


def _no_objections(plan: object) -> Iterable[Objection]:
    return ()


@dataclass(frozen=True, kw_only=True)
class Adapter(Generic[Plan, Work, Solver]):
    """What every adapter tells.

    Parameters
    ----------
    about
        One line for the documentation and the help: what the solver is.
    build
        Makes the open solver of a plan.  It raises ValueError for a plan that the solver cannot
        take, SolverFailed where the solver gives up, and SolverMissing without its library.
    cost
        Processor time that so much work takes.
    leaves_out
        Effects that the solver does not have (names as ``flipflow explain`` lists them), each with
        what the solver does instead.
    objections
        What the solver cannot take in a plan, asked by ``flipflow check``.
    needs
        Modules that ``build`` imports, which raise SolverMissing without the solver's library.
    fidelity
        Place in the hierarchy of the port's models, the better the higher.
    """

    about: str
    build: Callable[[Plan], Solver]
    cost: Callable[[Work], Cost]
    leaves_out: Mapping[str, str] = field(default_factory=dict)
    objections: Callable[[Plan], Iterable[Objection]] = _no_objections
    needs: tuple[str, ...] = ()
    fidelity: float

    def load(self) -> None:
        """Import what ``build`` needs.  Raises SolverMissing where the library is not installed."""
        for module in self.needs:
            import_module(module)


@dataclass(frozen=True, kw_only=True)
class PanelAdapter(Adapter[PanelPlan, PanelsWork, MeshedPanel]):
    """A solver of panels.

    Parameters
    ----------
    deforms
        The surface changes its shape; False where it is flat between its clamps.
    yields
        The surface's points give way to the particles' load; False where every load goes on to the
        frames.
    varies_across
        The surface may move otherwise at the middle of the width than at its edges.
    compresses
        The material changes its volume as ``bulk_modulus_Pa`` lets it; False where it keeps it.
    joins_sides
        Explicit steps join the sides of a panel that goes on beyond them (``PanelPlan.joined_sides``); False
        where sides are free.
    integrators
        What ``panel.integrator`` may be.
    largest_step_s
        The longest stable step of explicit integration; None where steps are not limited.
    mesh_size
        The mesh of a solver that resolves openings, before it is made; None for a regular grid.
    memory_GiB
        Memory that a panel's mesh and matrices take; None where it is small.
    lightest_kg
        Effective mass of the lightest point that a particle can touch, of a plan and the surface's
        cells along and across; None takes a surface cell's share of the panel's mass.
    refined_by
        Factor between the numbers of cells of a series that shows convergence; 0: none.
    order
        Power of the cell's length with which the error falls, where it is known.
    """

    deforms: bool = True
    yields: bool = True
    varies_across: bool = True
    compresses: bool = False
    joins_sides: bool = False
    integrators: tuple[str, ...] = ("explicit", "implicit")
    largest_step_s: Callable[[PanelPlan], float] | None = None
    mesh_size: Callable[[PanelPlan], MeshSize] | None = None
    memory_GiB: Callable[[PanelPlan], float] | None = None
    lightest_kg: Callable[[PanelPlan, tuple[int, int]], float] | None = None
    refined_by: float = 0.0
    order: float | None = None


@dataclass(frozen=True, kw_only=True)
class FramesAdapter(Adapter[FramesPlan, FramesWork, Frames]):
    """A solver of frames.

    Parameters
    ----------
    moved_by_forces
        Forces move the frames that have no drive; False where drives alone move frames.
    drives
        Frames can follow a drive.
    rotates
        Frames turn, and so need moments of inertia.
    motors
        Motors lag behind under load; False where shafts turn at their speed.
    hysteresis
        Bushings follow their measured curves; False where each has one stiffness and one damping.
    """

    moved_by_forces: bool = True
    drives: bool = True
    rotates: bool = True
    motors: bool = True
    hysteresis: bool = True


@dataclass(frozen=True, kw_only=True)
class ParticlesAdapter(Adapter[ParticlesPlan, ParticlesWork, Particles]):
    """A solver of particles.

    Parameters
    ----------
    periodic
        The sides of a slice may be periodic.
    clumps
        A grain may be made of several spheres; False where each is a single sphere.
    """

    periodic: bool = True
    clumps: bool = True
