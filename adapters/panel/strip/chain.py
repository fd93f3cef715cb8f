"""A strip as a chain: rows of material joined by axial springs and bending springs.

The rows lie at s = ``rows_m`` along the strip, and the middle of each row is a point (3,).  Between two
rows of the free length acts an axial spring with the law of an incompressible Mooney-Rivlin strip (Treloar,
The Physics of Rubber Elasticity, 3rd ed. 1975, ch. 5), of which the clamps hinder the share h of the
contraction across: free to contract it is stretched uniaxially, hindered in pure shear,

    N = A P(l),    P = 2 (1 - h) (l - l^-2) (C10 + C01 / l) + 2 h (l - l^-3) (C10 + C01),

with l = length / rest length.  At small stretch it is 1 + h / 3 times as stiff as one that contracts freely.
A bending spring acts at every row but the outermost, on the second difference of positions,

    energy = 1/2 (1 + h / 3) E I  cell  |kappa|^2,    I = width thickness^3 / 12,

which does not change if the strip moves or rotates.  A clamp is rigid, so that kappa at its inner edge
belongs to the free half cell only: (first free slope - clamp's slope) / (half a cell).  Its part along
the clamp as mounted is left out, since it would resist stretching and not bending.

A moulded strip is free of bending at the curvature k0 of its stress-free shape (``common.moulding``).  With
the slopes d and d' of the rows' links before and after a row, and the unit vector a across, each bending
spring has the energy

    1/2 E I cell (|kappa|^2 + k0^2) + E I k0 a . (d x d'),

whose last term is - E I cell k0 times the signed curvature; it does not change with a turn about a, either.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from adapters.panel.common import bilinear
from adapters.panel.common.grid import clamped_rows_m, locate
from adapters.panel.common.moulding import curvature_amplitude_1_m
from orchestrator.ports import Array, Indices
from orchestrator.ports.plans import HyperelasticPlan, PanelPlan


@dataclass(frozen=True)
class StretchLaw:
    """The law of an incompressible Mooney-Rivlin strip: force over undeformed section, in Pa, over stretch l.

        P = 2 (l - l^-2) (c10 + c01 / l) + 2 (l - l^-3) sheared,

    the stress of a strip that contracts freely across, and that of one that does not.
    """

    c10_Pa: float
    c01_Pa: float
    sheared_Pa: float

    @property
    def youngs_modulus_Pa(self) -> float:
        """The stiffness at stretch 1."""
        return 6 * (self.c10_Pa + self.c01_Pa) + 8 * self.sheared_Pa

    def stress_Pa(self, stretch: Array) -> Array:
        """Return the nominal stress."""
        free = (stretch - stretch**-2) * (self.c10_Pa + self.c01_Pa / stretch)
        return np.asarray(2 * (free + (stretch - stretch**-3) * self.sheared_Pa))

    def stiffness_Pa(self, stretch: Array) -> Array:
        """Return the derivative of the nominal stress."""
        shear = self.c10_Pa + self.c01_Pa / stretch
        softening = (stretch - stretch**-2) * self.c01_Pa / stretch**2
        hindered = (1 + 3 * stretch**-4) * self.sheared_Pa
        return np.asarray(2 * ((1 + 2 * stretch**-3) * shear - softening + hindered))

    def energy_J_per_m3(self, stretch: Array) -> Array:
        """Return the energy in the undeformed volume."""
        free = self.c10_Pa * (stretch**2 + 2 / stretch - 3) + self.c01_Pa * (2 * stretch + stretch**-2 - 3)
        return np.asarray(free + self.sheared_Pa * (stretch**2 + stretch**-2 - 2))


def stretch_law(material: HyperelasticPlan, hindered_share: float) -> StretchLaw:
    """Return the law of a strip of which the clamps hinder a share, 0 to 1, of the contraction across."""
    free = 1 - hindered_share
    sheared_Pa = hindered_share * (material.c10_Pa + material.c01_Pa)
    return StretchLaw(free * material.c10_Pa, free * material.c01_Pa, sheared_Pa)


@dataclass(frozen=True)
class Chain:
    """A strip as r rows of material, c axial springs and b bending springs.

    ``rows_m`` (r,) are the rows' places along the strip, and ``mass_kg`` (r,) their masses.
    ``clamp_of_row`` (r,) is 0 or 1 for the rows of the two clamps, and -1 for free rows.  ``springs`` are
    the rows that the axial springs join; each spring has the rest length ``rest_m``, and ``area_m2`` (c,)
    are their bearing cross-sections.  ``curvature_1_m2`` (b, r) maps positions to curvatures, and
    ``bending_N_m3`` (b,) is E I times the length of each bending spring.  The curvatures with the numbers
    ``at_clamps`` (clamps,) count only across ``clamp_along`` (clamps, 3).  ``gap_m`` (r - 1,) are the lengths
    of the links between rows, ``moulded_1_m`` (b,) the stress-free curvatures, and ``across`` (3,) is the
    unit vector about which they turn.
    """

    rows_m: Array
    mass_kg: Array
    clamp_of_row: Indices
    springs: slice
    rest_m: float
    area_m2: Array
    law: StretchLaw
    curvature_1_m2: Array
    bending_N_m3: Array
    at_clamps: Indices
    clamp_along: Array
    gap_m: Array
    moulded_1_m: Array
    across: Array

    @property
    def moulded_N_m(self) -> Array:
        """The moments (b,) E I k0 of the stress-free curvatures."""
        stands_for_m = (self.gap_m[:-1] + self.gap_m[1:]) / 2
        stands_for_m[self.at_clamps] = self.rest_m / 2
        return np.asarray(self.bending_N_m3 / stands_for_m * self.moulded_1_m)

    def links(self, position_m: Array) -> Array:
        """Return the slopes (r - 1, 3) of the links between rows."""
        return np.asarray(np.diff(position_m, axis=0) / self.gap_m[:, None])

    def spring_directions(self, position_m: Array) -> tuple[Array, Array]:
        """Return the unit vectors (c, 3) along the axial springs, and their lengths (c,) in m."""
        along = np.diff(position_m[self.springs], axis=0)
        length_m = np.sqrt(np.einsum("ij,ij->i", along, along))
        return along / length_m[:, None], length_m

    def curvature_1_m(self, position_m: Array) -> Array:
        """Return the curvatures (b, 3) of the bending springs, with rows at ``position_m`` (r, 3)."""
        curvature_1_m: Array = self.curvature_1_m2 @ position_m
        at_clamps = curvature_1_m[self.at_clamps]
        for bend, number in enumerate(self.at_clamps):
            along = self.clamp_along[bend]
            curvature_1_m[number] -= (at_clamps @ along)[bend] * along
        return curvature_1_m

    def tension_N(self, length_m: Array) -> Array:
        """Return the tensions (c,) in N of axial springs of the lengths ``length_m`` (c,)."""
        return np.asarray(self.area_m2 * self.law.stress_Pa(length_m / self.rest_m))

    def rate_N_per_m(self, length_m: Array) -> Array:
        """Return the derivatives (c,) of the tensions with respect to the lengths ``length_m`` (c,)."""
        return np.asarray(self.area_m2 / self.rest_m * self.law.stiffness_Pa(length_m / self.rest_m))

    def elastic_N(self, position_m: Array) -> Array:
        """Return the elastic force (r, 3) on the rows in N."""
        along, length_m = self.spring_directions(position_m)
        moment = self.bending_N_m3[:, None] * self.curvature_1_m(position_m)
        force_N = -self.curvature_1_m2.T @ moment
        pull_N = self.tension_N(length_m)[:, None] * along
        inner = force_N[self.springs]
        inner[:-1] += pull_N
        inner[1:] -= pull_N
        if self.moulded_1_m.any():
            force_N += self._moulded_force_N(position_m)
        return np.asarray(force_N)

    def _moulded_force_N(self, position_m: Array) -> Array:
        """Return the force (r, 3) of the moments of the stress-free curvatures."""
        link, moment_N_m = self.links(position_m), self.moulded_N_m[:, None]
        by_link_N_m = np.zeros_like(link)  # derivatives of the energy with respect to the slopes
        by_link_N_m[:-1] += moment_N_m * np.cross(link[1:], self.across)
        by_link_N_m[1:] += moment_N_m * np.cross(self.across, link[:-1])
        by_link_N = by_link_N_m / self.gap_m[:, None]
        force_N = np.zeros_like(position_m)
        force_N[:-1] += by_link_N
        force_N[1:] -= by_link_N
        return force_N

    def membrane_J(self, position_m: Array) -> float:
        """Return the energy of the axial springs in J."""
        stretch = self.spring_directions(position_m)[1] / self.rest_m
        return float(self.rest_m * (self.area_m2 @ self.law.energy_J_per_m3(stretch)))

    def bending_J(self, position_m: Array) -> float:
        """Return the energy of the bending springs in J."""
        bent_J = float(self.bending_N_m3 @ (self.curvature_1_m(position_m) ** 2).sum(axis=1)) / 2
        if not self.moulded_1_m.any():
            return bent_J
        link = self.links(position_m)
        turned = np.cross(link[:-1], link[1:]) @ self.across
        return bent_J + float(self.bending_N_m3 @ self.moulded_1_m**2 / 2 + self.moulded_N_m @ turned)

    def tangent_N_per_m(self, position_m: Array) -> Array:
        """Return the second derivative of the elastic energy, (3 r, 3 r)."""
        along, length_m = self.spring_directions(position_m)
        turning_N_per_m = self.tension_N(length_m) / length_m
        outer = along[:, :, None] * along[:, None, :]
        blocks = (self.rate_N_per_m(length_m) - turning_N_per_m)[:, None, None] * outer
        blocks = blocks + turning_N_per_m[:, None, None] * np.eye(3)
        rows = len(self.rows_m)
        tangent = self._bent_N_per_m.copy()
        first = np.arange(rows)[self.springs][:-1]
        tangent[first, :, first] += blocks
        tangent[first + 1, :, first + 1] += blocks
        tangent[first, :, first + 1] -= blocks
        tangent[first + 1, :, first] -= blocks
        return np.asarray(tangent.reshape(3 * rows, 3 * rows))

    @cached_property
    def _bent_N_per_m(self) -> Array:
        """The second derivative (r, 3, r, 3) of the bending energy, the same at all positions."""
        rows = len(self.rows_m)
        across = np.tile(np.eye(3), (len(self.bending_N_m3), 1, 1))
        across[self.at_clamps] -= np.einsum("ci,cj->cij", self.clamp_along, self.clamp_along)
        bent = self.curvature_1_m2
        tangent = np.einsum("b,bi,bj,bkl->ikjl", self.bending_N_m3, bent, bent, across)
        if self.moulded_1_m.any():
            slope_1_m = np.diff(np.eye(rows), axis=0) / self.gap_m[:, None]
            turning = np.cross(np.eye(3), self.across).T  # turning @ v is v x across
            mixed = np.einsum("b,bi,bj,kl->ikjl", self.moulded_N_m, slope_1_m[:-1], slope_1_m[1:], turning)
            tangent += mixed + mixed.transpose(2, 3, 0, 1)
        return np.asarray(tangent)


def build_chain(plan: PanelPlan) -> Chain:
    """Return a chain with ``plan.cells[0]`` axial springs on the free length.

    A clamp of depth ``clamp_m`` holds position and slope; a clamp without depth is a hinge.  Raises
    ValueError with fewer than two cells.
    """
    rectangle, cells = plan.rectangle, plan.cells[0]
    if cells < 2:
        raise ValueError(f"panel {plan.name}: a strip needs at least two cells, got {cells}")
    free_m = np.linspace(0.0, rectangle.length_m, cells + 1)
    rows_m = clamped_rows_m(rectangle, free_m)
    first = (len(rows_m) - len(free_m)) // 2
    last = first + cells
    clamp_of_row = np.full(len(rows_m), -1)
    clamp_of_row[: first + 1], clamp_of_row[last:] = 0, 1
    gap = np.diff(rows_m)
    cell = rectangle.length_m / cells
    stands_for = np.where(clamp_of_row[1:-1] < 0, cell, cell / 2)
    curvature = np.zeros((len(gap) - 1, len(rows_m)))
    for k in range(len(gap) - 1):
        before, after = 1 / gap[k], 1 / gap[k + 1]
        curvature[k, k : k + 3] = np.array([before, -before - after, after]) / stands_for[k]
    area_m2 = rectangle.width_m * plan.thickness_m
    law = stretch_law(plan.material, plan.hindered_share)
    bending_N_m2 = law.youngs_modulus_Pa * area_m2 * plan.thickness_m**2 / 12
    bent_m = np.clip([rows_m[1:-1] - cell / 2, rows_m[1:-1] + cell / 2], 0, rectangle.length_m)
    _, _, bending_share = remaining_shares(plan, *bent_m)
    _, tension_share, _ = remaining_shares(plan, free_m[:-1], free_m[1:])
    mass_share, _, _ = remaining_shares(plan, rows_m[:-1], rows_m[1:])
    per_length = plan.material.density_kg_per_m3 * area_m2 * mass_share
    mass_kg = 2 * bilinear.half_row_mass_kg(rows_m, per_length)[::2]
    at_clamps = np.flatnonzero(clamp_of_row[1:-1] >= 0)
    wave = np.cos(2 * np.pi * rows_m[1:-1] / rectangle.length_m)
    return Chain(
        rows_m=rows_m,
        mass_kg=mass_kg + point_masses_kg(plan, rows_m),
        clamp_of_row=clamp_of_row,
        springs=slice(first, last + 1),
        rest_m=cell,
        area_m2=area_m2 * tension_share,
        law=law,
        curvature_1_m2=curvature,
        bending_N_m3=bending_N_m2 * bending_share * stands_for,
        at_clamps=at_clamps,
        clamp_along=rectangle.clamp_tangents[: len(at_clamps)],
        gap_m=gap,
        moulded_1_m=-curvature_amplitude_1_m(plan) * wave,
        across=rectangle.across,
    )


def point_masses_kg(plan: PanelPlan, rows_m: Array) -> Array:
    """Return the mass (r,) that point masses add to the rows, shared by the two rows beside each of them."""
    added_kg = np.zeros(len(rows_m))
    for mass in plan.point_masses:
        cell, into = locate(rows_m, np.array([mass.along_m]), slack_m=0.0)
        added_kg[cell] += (1 - into) * mass.mass_kg
        added_kg[cell + 1] += into * mass.mass_kg
    return added_kg


def remaining_shares(plan: PanelPlan, low_m: Array, high_m: Array) -> tuple[Array, Array, Array]:
    """Return the shares of mass, tension and bending stiffness that openings leave, (pieces,) each.

    The pieces of the strip extend from s = ``low_m`` to ``high_m``.  Across the strip, margins and pattern
    act in parallel; along it, the perforated and the solid part of a piece act in series.  ``unit_cell``
    gives the stiffness of the pattern, whose contraction across the clamps hinder as that of the solid.
    Raises SolverMissing without DOLFINx, which computes this stiffness.
    """
    pattern = plan.apertures
    if pattern is None:
        whole = np.ones(len(low_m))
        return whole, whole, whole
    from adapters.panel.finite_element.unit_cell import SOLID, along, cell_stiffness

    region = pattern.region_m(plan.rectangle)
    inside_m = np.minimum(high_m, region[1, 0]) - np.maximum(low_m, region[0, 0])
    length = np.clip(inside_m, 0.0, None) / (high_m - low_m)
    width = (1 - pattern.margin_share) * float(np.ptp(region[:, 1])) / plan.rectangle.width_m
    cell, hindered = cell_stiffness(pattern, plan.thickness_m), plan.hindered_share

    def in_series(stiffness: Array) -> Array:
        beside_margins = 1 - width + width * along(stiffness, hindered) / along(SOLID, hindered)
        return np.asarray(1 / (1 - length + length / beside_margins))

    mass = np.asarray(1 - length * width * (1 - pattern.solid_share))
    return mass, in_series(cell.membrane), in_series(cell.bending)
