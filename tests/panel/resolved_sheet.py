"""A sheet whose own mesh has the openings (rectangles), to compare the homogenised one with."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
from dolfinx import fem
from scipy.sparse.linalg import LinearOperator, eigsh

from adapters.panel.common.moulding import side_of_sag
from adapters.panel.finite_element import sheet_forms
from adapters.panel.finite_element.compiled import function_space, linear_mesh
from adapters.panel.finite_element.resting_shape import first_guess_m, settle
from adapters.panel.finite_element.structure import Structure
from adapters.panel.finite_element.tangent import Tangent


def lines_m(length_m, centres_m, size_m, clamp_m, per_opening, per_land):
    """Cell borders along one direction: at the openings' edges, and between."""
    edges = np.unique(np.round([c + h for c in centres_m for h in (-size_m / 2, size_m / 2)], 9))
    stops = [*([-clamp_m] if clamp_m else []), 0.0, *edges, length_m]
    stops += [length_m + clamp_m] if clamp_m else []
    lines = [np.array(stops[:1])]
    for low, high in pairwise(stops):
        inside = any(low < c < high for c in centres_m)
        pieces = per_opening if inside else per_land
        lines.append(np.linspace(low, high, pieces + 1)[1:])
    return np.concatenate(lines)


def resolved(plan, pieces_along, pieces_across):
    """The structure of a sheet with the plan's openings in its mesh; pieces per (opening, land)
    in each direction."""
    pattern, rectangle = plan.apertures, plan.rectangle
    centres = pattern.centres_m(rectangle)
    s = lines_m(
        rectangle.length_m, np.unique(centres[:, 0]), pattern.length_m, rectangle.clamp_m, *pieces_along
    )
    y = lines_m(rectangle.width_m, np.unique(centres[:, 1]), pattern.width_m, 0.0, *pieces_across)
    number = np.arange(len(s) * len(y)).reshape(len(s), len(y))
    cells = np.stack([number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]], axis=-1).reshape(
        -1, 4
    )
    points = np.column_stack([np.repeat(s, len(y)), np.tile(y, len(s))])
    middle = points[cells].mean(axis=1)
    half = np.array([pattern.length_m, pattern.width_m]) / 2
    hole = (np.abs(middle[:, None] - centres[None]) < half).all(axis=2).any(axis=1)
    used, cells = np.unique(cells[~hole], return_inverse=True)
    flat = linear_mesh("quadrilateral", points[used], cells.reshape(-1, 4))
    space, scalars = function_space(flat, "Lagrange", 2, 3), function_space(flat, "Lagrange", 2)
    material_m = space.tabulate_dof_coordinates()
    held = np.flatnonzero(~np.isnan(rectangle.end(material_m)))
    bending = sheet_forms.bending(plan, scalars, material_m)
    return Structure(
        sheet_forms.law(plan, fem.Function(space)),
        plan.material.density_kg_per_m3 * plan.thickness_m,
        held,
        bending,
    )


class Found:
    """A structure at rest: ``pull_N`` on the second clamp, the mean and the greatest ``sag_m``,
    and its first ``frequencies_Hz``."""

    def __init__(self, plan, structure):
        tangent = Tangent(structure)
        start = first_guess_m(plan.rectangle, side_of_sag(plan), structure.material_m)
        weight = structure.mass_kg[:, None] * plan.gravity_m_per_s2
        rest = settle(structure, tangent, start, weight)
        force = structure.force_N(rest)
        second = structure.material_m[structure.held, 0] > plan.rectangle.length_m / 2
        self.mass_kg = structure.mass_kg.sum()
        self.pull_N = force[structure.held][second, 0].sum()
        self.sag_m = np.abs(rest[:, 2] - start[:, 2]).max()
        self.nodes = len(rest)
        tangent.factorise(0.0, 1.0)
        root = np.zeros((len(rest), 1))
        root[structure.free, 0] = structure.mass_kg[structure.free] ** 0.5

        def softened(values):
            return (root * tangent.solve(root * values.reshape(-1, 3))).ravel()

        size = rest.size
        flexible = LinearOperator((size, size), matvec=softened, dtype=float)
        start = np.random.default_rng(1).standard_normal(size)
        lowest = eigsh(flexible, k=6, v0=start, return_eigenvectors=False)
        self.frequencies_Hz = np.sort(1 / np.sqrt(lowest)) / (2 * np.pi)
        tangent.close()
        structure.close()
