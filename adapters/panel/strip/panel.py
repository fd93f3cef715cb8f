"""A panel as a width-uniform strip: one chain of rows along the length.

Each row moves as one line; its two surface points (y = 0 and y = width) stand to either side of its middle.
The middle obeys Newton's law (``chain.py``, ``motion.py``).  The half widths have no inertia: they follow the
half widths at the clamps, linearly along the free length, and pass the difference of a row's two loads to the
clamps at once.  So linear momentum is exact and virtual work is conserved, but twist about the length is not
resolved.

Equations, limits and measurements: docs/theory/panel_strip.md.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import csr_array

from adapters.panel.common import bilinear
from adapters.panel.common.compiled_panel import CompiledPanel
from adapters.panel.common.panel import choose_step_s
from adapters.panel.strip.chain import Chain, build_chain
from adapters.panel.strip.motion import ChainMotion
from adapters.panel.strip.resting_shape import settle
from orchestrator.ports import Array, HermitePath, Inertia, Interpolation, Known, Motion, Mount
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import HyperelasticPlan, PanelPlan, SolverFailed

SANE_STRETCH = (0.2, 5.0)
MARGIN = 0.8  # part of the largest stable step, since compression stiffens the chain


def build(plan: PanelPlan) -> Strip:
    """Open the strip; ``plan.cells[1]`` is not used.

    Raises ValueError for an implicit integrator or a step above ``largest_step_s``; SolverFailed if no
    resting shape is found.
    """
    if plan.integrator != "explicit":
        raise ValueError(f"panel {plan.name}: the strip is explicit only, not {plan.integrator!r}")
    links = build_chain(plan)
    limit_s = stability_limit_s(links, plan.material)
    return Strip(plan, links, choose_step_s(plan, limit_s, MARGIN * limit_s))


def largest_step_s(plan: PanelPlan) -> float:
    """Return the largest ``step_s`` that ``build`` accepts for this plan."""
    return stability_limit_s(build_chain(plan), plan.material)


def stability_limit_s(links: Chain, material: HyperelasticPlan) -> float:
    """Return the limit 2 / w of the unstretched strip, with w^2 = w_axial^2 + w_bending^2 times 1 + the sum
    of the branches' ratios."""
    free = np.flatnonzero(links.clamp_of_row < 0)
    ends = np.diff(np.eye(len(links.mass_kg))[links.springs], axis=0)
    axial_N_per_m = links.law.youngs_modulus_Pa * links.area_m2 / links.rest_m
    axial = ends.T @ (axial_N_per_m[:, None] * ends)
    bending = links.curvature_1_m2.T @ (links.bending_N_m3[:, None] * links.curvature_1_m2)
    scale = np.sqrt(np.outer(links.mass_kg, links.mass_kg))
    square = sum(
        float(np.linalg.eigvalsh((matrix / scale)[np.ix_(free, free)])[-1]) for matrix in (axial, bending)
    )
    return 2 / math.sqrt(square * (1 + sum(ratio for ratio, _ in material.branches)))


class Strip(CompiledPanel):
    """A ``MeshedPanel`` around a compiled chain.

    Surface points are numbered row by row, y = 0 before y = width; the clamp points are the points
    of the held rows, in the same order.
    """

    _body: ChainMotion

    def __init__(self, plan: PanelPlan, links: Chain, step_s: float) -> None:
        rectangle = plan.rectangle
        self._chain, self._across, self._width_m = links, rectangle.across, rectangle.width_m
        held = np.flatnonzero(links.clamp_of_row >= 0)
        names = tuple(plan.frames[end] for end in links.clamp_of_row[held].repeat(2))
        mount_m = rectangle.mounted(bilinear.points_m(links.rows_m[held], self._width_m))
        motion = ChainMotion(links, plan, settle(links, plan), bilinear.half(mount_m), step_s)
        super().__init__(plan, Mount(mount_m, names), motion)
        self._surface = self._surface_between(self._clamps)

    def inertia(self) -> Inertia:
        """Return the inertia of the free rows.

        Both points of a row go with its middle, whose force is their sum, but not across, where the row
        follows the clamps.
        """
        free = np.flatnonzero(self._chain.clamp_of_row < 0)
        points = np.arange(2 * len(self._mass_kg))
        rows = csr_array((np.ones(len(points)), (points, points // 2)))
        across = np.broadcast_to(self._across, (len(free), 3))
        return Inertia(csr_array(rows[:, free]), self._chain.mass_kg[free], across)

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Return the motion of the held rows."""
        held = (2 * self._body.held[:, None] + np.arange(2)).ravel()
        return clamps.among(len(self._surface), held)

    def interpolation(self, coordinates_m: Array) -> Interpolation:
        """Return shape functions, bilinear in (s, y) between the rows; the normal turns evenly, as the chain
        bends at its rows."""
        rows_m = self._chain.rows_m
        slopes_1_m = bilinear.row_slopes_1_m(rows_m, self._chain.clamp_of_row >= 0)
        return bilinear.interpolation(rows_m, self._width_m, coordinates_m, slopes_1_m)

    def _static_reaction_N(self) -> Array:
        middle_N = self._body.onto_held(self._weight_N + self._body.internal_N)
        return np.asarray(middle_N.repeat(2, axis=0) / 2)

    def _move(self, interval: Interval, clamps: Motion, load_N: Array) -> tuple[Motion, Array, float]:
        turning_N = self._body.share.T @ (2 * bilinear.half(load_N))
        outside_N = 2 * bilinear.middle(load_N) + self._weight_N
        path = HermitePath(_middle(self._clamps), _middle(clamps), interval.length_s)
        on_held = self._body.move(path, outside_N, interval)
        self._check(interval, self._body.stretches())
        middle_N = on_held.impulse_N_s / interval.length_s
        turned_m = bilinear.half(clamps.position_m - self._clamps.position_m)
        clamps_J = -on_held.work_J - float(np.vdot(turning_N, turned_m))
        reaction_N = bilinear.join_halves(middle_N / 2, turning_N / 2)
        return self._surface_between(clamps), reaction_N, clamps_J

    def _check(self, interval: Interval, found: tuple[float, float]) -> None:
        """Check the smallest and the largest stretch."""
        lowest, highest = found
        if not SANE_STRETCH[0] < lowest <= highest < SANE_STRETCH[1]:  # nor is NaN
            raise SolverFailed(
                f"{self._name}: strip unstable before {interval.end_s:.6g} s: stretches are "
                f"{lowest:.3g} ... {highest:.3g}"
            )

    def _surface_between(self, clamps: Motion) -> Motion:
        """Return the rows' points: their middles now, and the halves that follow ``clamps``."""
        motion, share = self._body, self._body.share
        return Motion(
            bilinear.join_halves(motion.position_m, share @ bilinear.half(clamps.position_m)),
            bilinear.join_halves(motion.velocity_m_per_s, share @ bilinear.half(clamps.velocity_m_per_s)),
        )


def _middle(points: Motion) -> Motion:
    return Motion(bilinear.middle(points.position_m), bilinear.middle(points.velocity_m_per_s))
