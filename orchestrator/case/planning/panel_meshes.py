"""How large the panels' meshes are, as their solver tells before it makes them."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.case import solvers
from orchestrator.case.planning import panel_plans
from orchestrator.case.tables.case import Case
from orchestrator.ports.plans import MeshSize

UNKNOWNS = 3  # of a node


def mesh_sizes(case: Case) -> dict[str, MeshSize]:
    """By panel; empty for solvers whose meshes are small.  ValueError for openings that the solver
    cannot resolve."""
    size = solvers.panel(case).mesh_size
    return {} if size is None else {plan.name: size(plan) for plan in panel_plans(case)}


def memory_GiB(case: Case) -> float:
    """What the meshes of all panels need together, good to a factor of two."""
    each_GiB = solvers.panel(case).memory_GiB
    return 0.0 if each_GiB is None else sum(each_GiB(plan) for plan in panel_plans(case))


def meshes(case: Case) -> Iterator[str]:
    """Lines for ``flipflow check``: panels with equal meshes together."""
    sizes = list(mesh_sizes(case).values())
    for size in dict.fromkeys(sizes):
        yield (
            f"  mesh       {size.cells} cells, {UNKNOWNS * size.nodes} unknowns and some "
            f"{size.memory_GiB:.2g} GiB on each of {sizes.count(size)} panels"
        )
