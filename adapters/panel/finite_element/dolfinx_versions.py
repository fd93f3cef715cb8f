"""DOLFINx 0.5 (Debian 12) and DOLFINx 0.9 (Debian 13): all that differs between them.

Elements are UFL's in the first and Basix's in the second.
"""

from __future__ import annotations

from importlib import import_module
from typing import Any

import numpy as np
import ufl

from orchestrator.ports import Array, Indices

fem: Any = import_module("dolfinx.fem")
IS_0_9 = hasattr(fem, "functionspace")


def code_options() -> dict[str, Any]:
    """Return FFCx's own defaults; what is not given, it takes from a file in the folder that the program is
    started in."""
    module, table, value = ("options", "OPTIONS", 1) if IS_0_9 else ("parameters", "PARAMETERS", 0)
    defaults = getattr(import_module(f"ffcx.{module}"), f"FFCX_DEFAULT_{table}")
    return {name: about[value] for name, about in defaults.items()}


def compiling(compiler: dict[str, Any]) -> dict[str, Any]:
    """Return the keywords with which DOLFINx compiles; ``compiler`` are the options of the C compiler."""
    kind = "options" if IS_0_9 else "params"
    return {f"form_compiler_{kind}": code_options(), f"jit_{kind}": compiler}


def element(cell: str, family: str, degree: int, size: int = 0) -> Any:
    """Return a UFL element on a kind of cell: of scalars, or of vectors with ``size`` components.

    The family "Quadrature" has values at the points of the default rule of ``degree``.
    """
    if IS_0_9:
        shape = (size,) if size else ()
        if family == "Quadrature":
            return import_module("basix.ufl").quadrature_element(cell, shape, degree=degree)
        return import_module("basix.ufl").element(family, cell, degree, shape=shape)
    scheme = "default" if family == "Quadrature" else None
    if size:
        return ufl.VectorElement(family, cell, degree, dim=size, quad_scheme=scheme)
    return ufl.FiniteElement(family, cell, degree, quad_scheme=scheme)


def space(mesh: Any, element: Any, keywords: dict[str, Any]) -> Any:
    """Return the finite-element space of an element on a mesh."""
    return (fem.functionspace if IS_0_9 else fem.FunctionSpace)(mesh, element, **keywords)


def evaluated(expression: Any, mesh: Any, cells: Indices, out: Array | None = None) -> Array:
    """Return the values (cells, points * components) of an expression, in ``out`` if it is given."""
    values: Array = expression.eval(mesh, cells, out) if IS_0_9 else expression.eval(cells, out)
    return values


def cell_corners(mesh: Any) -> Indices:
    """Return the numbers of the points at the corners of each cell (cells, corners)."""
    points = mesh.geometry.dofmap
    return np.asarray(points if IS_0_9 else points.array.reshape(points.num_nodes, -1))
