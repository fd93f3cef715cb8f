"""The rungs: which values of a solver's keys make which model, from the cheapest up.

A rung is a name and ``--set`` overlays; everything else of the case stays as it is.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import get_args

from orchestrator.case.file.contents import has_particles
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.numerics import FramesSolver

LADDERS = ("panel", "frames", "particles")
SOFTER = 10.0
COARSER = 1.5
FINER = 1.5


@dataclass(frozen=True)
class Rung:
    """``needs``: what must be made from another run first ("recording", "motion", or nothing)."""

    ladder: str
    name: str
    sets: tuple[str, ...]
    needs: str = ""


def rungs(case: Case, ladder: str) -> tuple[Rung, ...]:
    """In order, the reference last; whether each fits the case is not looked at here."""
    found = {"panel": _panel, "frames": _frames, "particles": _particles}[ladder](case)
    return tuple(found)


def sheet_cells(case: Case) -> tuple[int, int]:
    """Those of the case's own sheet; else those that it would have by default."""
    return case.panel.cells if case.panel.solver == "sheet" else (22, 8)


def _panel(case: Case) -> Iterator[Rung]:
    if not case.screen.panels:
        return

    def rung(name: str, solver: str, cells: tuple[int, int], integrator: str = "explicit") -> Rung:
        keys = {"solver": solver, "integrator": integrator, "step_s": 0.0, "cells": list(cells)}
        return Rung("panel", name, tuple(f"panel.{key}={value}" for key, value in keys.items()))

    along, across = cells = sheet_cells(case)
    yield rung("rigid", "rigid", cells)
    recorded = rung("recorded", "recorded", cells)
    yield Rung("panel", "recorded", recorded.sets, "" if case.panel.recording else "recording")
    yield rung("strip", "strip", (max(2, along), 1))
    yield rung("sheet coarse", "sheet", (max(1, along // 2), max(1, across // 2)))
    yield rung("sheet", "sheet", cells)
    yield rung("sheet fine", "sheet", (math.ceil(FINER * along), math.ceil(FINER * across)))
    yield rung("solid", "solid", (math.ceil(FINER * along), max(1, across // 2)), "implicit")


def _frames(case: Case) -> Iterator[Rung]:
    if not case.screen.frames:
        return
    driven = all(frame.drive for frame in case.screen.frames.values())
    known = get_args(FramesSolver.model_fields["solver"].annotation)
    for solver in ("prescribed", "two-mass", "planar", "exudyn"):
        if solver in known:
            needs = "motion" if solver == "prescribed" and not driven else ""
            yield Rung("frames", solver, (f"frames.solver={solver}",), needs)


def _particles(case: Case) -> Iterator[Rung]:
    if not has_particles(case):
        return
    yield Rung("particles", "none", ("particles.solver=none",))
    yield Rung("particles", "spheres", ("particles.solver=spheres",))
    liggghts = "particles.solver=liggghts"
    coarser = COARSER * case.particles.coarse_graining
    yield Rung("particles", "coarser", (liggghts, f"particles.coarse_graining={coarser}"))
    cap = "particles.largest_youngs_modulus_Pa"
    now_Pa = stiffest_Pa(case)
    yield Rung("particles", "softer", (liggghts, f"{cap}={now_Pa / SOFTER:g}"))
    yield Rung("particles", "as it is", (liggghts,))
    if case.particles.largest_youngs_modulus_Pa is not None:
        yield Rung("particles", "stiffer", (liggghts, f"{cap}={now_Pa * SOFTER:g}"))


def stiffest_Pa(case: Case) -> float:
    """The largest Young's modulus that contacts have."""
    cap = case.particles.largest_youngs_modulus_Pa
    used = [m.youngs_modulus_Pa for m in case.materials.values() if m.youngs_modulus_Pa]
    return min(max(used, default=math.inf), cap if cap is not None else math.inf)
