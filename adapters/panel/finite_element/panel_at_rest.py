"""A panel at rest between its clamps: its shape, and how long its steps may be.

Both are the same for all panels that differ in their place alone, and finding them takes most of the time
in which a panel is opened.  So they are found once, for a panel whose corner is the origin.
"""

from __future__ import annotations

import pickle
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np

from adapters.panel.common.moulding import side_of_sag
from adapters.panel.finite_element.integrators import step_limits_s
from adapters.panel.finite_element.resting_shape import first_guess_m, settle
from adapters.panel.finite_element.structure import Structure
from adapters.panel.finite_element.tangent import Tangent
from orchestrator.ports import Array
from orchestrator.ports.plans import PanelPlan, SolverFailed

REMEMBERED = 64  # kinds of panels: a large study has as many in one process

MakeStructure = Callable[[PanelPlan], tuple[Structure, Any, Any]]
"""A function that makes a plan's structure, the grid of its surface, and the grid's nodes."""


@dataclass(frozen=True)
class PanelAtRest:
    """The nodes (nodes, 3) of a panel at rest, relative to its corner, and the largest and the usual step."""

    from_corner_m: Array
    step_limits_s: tuple[float, float]


def at_rest(plan: PanelPlan, make_structure: MakeStructure) -> PanelAtRest:
    """Return the panel of ``plan`` at rest.

    Raises SolverFailed if no resting shape is found, and ValueError if there is no such integrator.
    """
    try:
        return _at_rest(pickle.dumps(_without_place(plan)), make_structure)
    except SolverFailed as failure:
        raise SolverFailed(f"panel {plan.name}, t = 0: {failure}") from failure
    except ValueError as wrong:
        raise ValueError(f"panel {plan.name}: {wrong}") from wrong


def _without_place(plan: PanelPlan) -> PanelPlan:
    """Return the plan of an equal panel whose corner is the origin, without what does not matter at rest."""
    rectangle = replace(plan.rectangle, corner_m=np.zeros(3))
    return replace(
        plan, name="", rectangle=rectangle, frames=("", ""), step_s=0.0, sync_interval_s=0.0, stops=()
    )


@lru_cache(REMEMBERED)
def _at_rest(pickled_plan: bytes, make_structure: MakeStructure) -> PanelAtRest:
    """Return the panel of a plan whose bytes tell it from all that are not equal."""
    plan: PanelPlan = pickle.loads(pickled_plan)
    structure = make_structure(plan)[0]
    with closing(structure), closing(Tangent(structure)) as tangent:
        start_m = first_guess_m(plan.rectangle, side_of_sag(plan), structure.material_m)
        weight_N = structure.mass_kg[:, None] * plan.gravity_m_per_s2
        resting_m = settle(structure, tangent, start_m, weight_N)
        resting_m.setflags(write=False)  # all equal panels share it
        return PanelAtRest(resting_m, step_limits_s(plan, tangent))
