"""How much a solver has to do in a run, and what that costs: what a cost is predicted from.

Every port has a module ``adapters.<port>.costs`` with one function for each of its solvers, named
as the solver is (with _ for -), from the port's work to its ``Cost``.  It needs no solver to be
installed.
"""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Cost:
    """Processor time: ``opening_s`` until the solver is open, ``stepping_s`` of all its steps."""

    opening_s: float
    stepping_s: float


@dataclass(frozen=True)
class PanelsWork:
    """``panels`` alike, each of ``cells`` along and across; ``resolved_cells`` of all of them
    together where the mesh follows openings, else 0.  They are moved over ``runs`` intervals of
    ``interval_s``; ``step_s`` is the largest step that the case allows, 0: the solver's own."""

    panels: int
    cells: tuple[int, int]
    resolved_cells: int
    integrator: str
    step_s: float
    interval_s: float
    runs: float


@dataclass(frozen=True)
class FramesWork:
    """``bodies`` of which ``driven`` follow a drive, on ``bushings`` (each a spring at one place),
    with ``exciters``, of which ``motors`` lag; moved over ``runs`` intervals of ``interval_s``."""

    bodies: int
    driven: int
    bushings: int
    exciters: int
    motors: int
    interval_s: float
    runs: float


@dataclass(frozen=True)
class ParticlesWork:
    """``particle_steps``: steps of all particles together; ``steps`` of the solver, in ``runs``
    intervals; ``triangles`` that they may touch; ``sticky`` where contacts have adhesion."""

    particle_steps: float
    steps: float
    runs: float
    triangles: int
    sticky: bool
