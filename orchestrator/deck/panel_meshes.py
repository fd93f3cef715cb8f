"""How large the panels' meshes are, as their solver tells before it makes them."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator import adapter
from orchestrator.casefile.case import Case
from orchestrator.planning import panel_plans
from orchestrator.plans import MeshSize, SolverMissing

UNKNOWNS = 3  # of a node
GIB_PER_NODE = 3e-5
"""Memory of a panel with its factorised stiffness (docs/theory/perforated_panel.md)."""


def mesh_sizes(case: Case) -> dict[str, MeshSize]:
    """By panel; empty for solvers whose meshes are small, and where the solver is not installed:
    missing_solvers says so.  ValueError for openings that it cannot resolve."""
    if case.panel.solver != "solid":
        return {}
    try:
        solver = adapter.imported("panel", case.panel.solver)
    except SolverMissing:
        return {}
    return {plan.name: solver.mesh_size(plan) for plan in panel_plans(case)}


def memory_GiB(size: MeshSize) -> float:
    """Good to a factor of two."""
    return GIB_PER_NODE * size.nodes


def meshes(case: Case) -> Iterator[str]:
    """Lines for ``flipflow check``: panels with equal meshes together."""
    sizes = list(mesh_sizes(case).values())
    for size in dict.fromkeys(sizes):
        yield (
            f"  mesh       {size.cells} cells, {UNKNOWNS * size.nodes} unknowns and some "
            f"{memory_GiB(size):.2g} GiB on each of {sizes.count(size)} panels"
        )
