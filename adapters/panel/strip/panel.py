"""A panel as a width-uniform strip: one chain of rows along the length.

Each row moves as one line; its two surface points (y = 0 and y = width) stand to either side of
its middle.  The middle obeys Newton's law (``chain.py``, ``motion.py``).  The half widths
have no inertia: they follow the clamps', linearly along the free length, and hand the difference
of a row's two loads to the clamps at once.  So linear momentum is exact and virtual work is
conserved, while twist about the length is not resolved.

Equations, limits and measurements: docs/theory/panel_strip.md.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.sparse import csr_array

from adapters.panel.common import bilinear
from adapters.panel.common.body import Action
from adapters.panel.perforation.strip import left
from adapters.panel.strip.at_rest import first_guess_m, settled
from adapters.panel.strip.chain import Chain, chain
from orchestrator.ports import (
    Account,
    Array,
    HermitePath,
    Inertia,
    Known,
    Load,
    Motion,
    Mount,
    PanelState,
    Saved,
    check_point_count,
)
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import PanelPlan, SolverFailed, SolverMissing
from orchestrator.ports.state import restore_attributes, save_attributes

try:
    from adapters.panel.strip.motion import ChainMotion, shares
except ImportError as missing:
    raise SolverMissing(
        f"panel solver 'strip' needs its compiled part, which docker/setup.sh builds: {missing}"
    ) from missing

_STATE = ("_clamps", "_surface", "_elapsed_s", "_received_J")
SANE_STRETCH = (0.2, 5.0)
MARGIN = 0.8  # of the largest stable step, for compression, which stiffens the chain


def build(plan: PanelPlan) -> Strip:
    """Open the strip.  ValueError for an implicit integrator or a step above ``largest_step_s``; SolverFailed
    if no resting shape is found.  ``plan.cells[1]`` is not used."""
    if plan.integrator != "explicit":
        raise ValueError(f"panel {plan.name}: the strip is explicit only, not {plan.integrator!r}")
    limit_s = largest_step_s(plan)
    if plan.step_s > limit_s:
        raise ValueError(
            f"panel {plan.name}: a step of {plan.step_s} s is above the strip's limit "
            f"{limit_s:.3g} s; take {MARGIN * limit_s:.3g} s, or 0 for just that"
        )
    return Strip(plan)


def largest_step_s(plan: PanelPlan) -> float:
    """Return the stability limit 2 / w of the unstretched strip with w^2 = w_axial^2 + w_bending^2, times 1 +
    the sum of the branches' ratios."""
    links = chain(plan)
    mass_kg = row_mass_kg(plan, links)
    free = np.flatnonzero(links.held < 0)
    joined = np.diff(np.eye(len(mass_kg))[links.springs], axis=0)
    axial_N_per_m = plan.material.youngs_modulus_Pa * links.area_m2 / links.rest_m
    axial = joined.T @ (axial_N_per_m[:, None] * joined)
    bending = links.curvature_1_m2.T @ (links.bending_N_m3[:, None] * links.curvature_1_m2)
    scale = np.sqrt(np.outer(mass_kg, mass_kg))
    square = sum(
        float(np.linalg.eigvalsh((matrix / scale)[np.ix_(free, free)])[-1]) for matrix in (axial, bending)
    )
    return 2 / math.sqrt(square * (1 + sum(ratio for ratio, _ in plan.material.branches)))


def row_mass_kg(plan: PanelPlan, links: Chain) -> Array:
    """Return the lumped mass (r,) of the rows."""
    area_m2 = plan.rectangle.width_m * plan.thickness_m
    solid = left(plan, links.rows_m[:-1], links.rows_m[1:]).mass
    per_length = plan.material.density_kg_per_m3 * area_m2 * solid
    return 2 * bilinear.half_row_mass_kg(links.rows_m, per_length)[::2]


class Strip:
    """``MeshedPanel``; surface points row by row, y = 0 before y = width; the clamp points are
    those of the held rows, in the same order."""

    def __init__(self, plan: PanelPlan) -> None:
        self._name, self._width_m = plan.name, plan.rectangle.width_m
        self._chain = links = chain(plan)
        self._across = plan.rectangle.across
        self._step_s = plan.step_s if plan.step_s > 0 else MARGIN * largest_step_s(plan)
        self._mass_kg = row_mass_kg(plan, links)
        self._gravity_m_per_s2 = plan.gravity_m_per_s2
        self._weight_N = np.outer(self._mass_kg, plan.gravity_m_per_s2)
        guess_m = first_guess_m(links, plan.rectangle, plan.gravity_m_per_s2)
        self._rest_m = settled(links, guess_m, self._weight_N, plan.rectangle, plan.name)
        self._motion = ChainMotion(
            links, self._mass_kg, self._rest_m, plan.material.branches, plan.rectangle.across
        )
        held = self._motion.held
        material_m = bilinear.points_m(links.rows_m[held], self._width_m)
        names = tuple(plan.frames[end] for end in links.held[held].repeat(2))
        self.mount = Mount(plan.rectangle.mounted(material_m), names)
        self._clamps = Motion(self.mount.position_m, np.zeros_like(self.mount.position_m))
        self._halves = shares(links)
        self._surface = self._surface_now()
        self._elapsed_s, self._received_J = 0.0, {"load": 0.0, "clamps": 0.0}

    def inertia(self) -> Inertia:
        """Return the inertia of the free rows: both points of a row go with its middle, whose force is their
        sum, and not across, where it follows the clamps."""
        free = np.flatnonzero(self._chain.held < 0)
        points = np.arange(2 * len(self._mass_kg))
        rows = csr_array((np.ones(len(points)), (points, points // 2)))
        across = np.broadcast_to(self._across, (len(free), 3))
        return Inertia(csr_array(rows[:, free]), self._mass_kg[free], across)

    def initial(self) -> PanelState:
        reaction_N = self._motion.onto_held(self._weight_N + self._motion.internal_N)
        return PanelState(self._surface, Load(reaction_N.repeat(2, axis=0) / 2))

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        check_point_count(f"panel {self._name}: clamps", clamps, len(self._clamps))
        check_point_count(f"panel {self._name}: load", load, len(self._surface))
        motion = self._motion
        turning_N = self._halves.T @ (2 * bilinear.half(load.force_N))
        outside_N = 2 * bilinear.middle(load.force_N) + self._weight_N
        path = HermitePath(_middle(self._clamps), _middle(clamps), interval.length_s)
        on_held = motion.move(Action(path, outside_N), interval.steps(self._step_s))
        lowest, highest = motion.stretches()
        if not SANE_STRETCH[0] < lowest <= highest < SANE_STRETCH[1]:  # nor is NaN
            raise SolverFailed(
                f"panel {self._name}: strip unstable before {interval.end_s} s: stretches are "
                f"{lowest:.3g} ... {highest:.3g}"
            )
        middle_N = on_held.impulse_N_s / interval.length_s
        self._book(clamps, load, turning_N, on_held.work_J)
        self._elapsed_s += interval.length_s
        return PanelState(self._surface, Load(bilinear.joined(middle_N / 2, turning_N / 2)))

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        """Return the motion of the held rows."""
        held = (2 * self._motion.held[:, None] + np.arange(2)).ravel()
        return clamps.among(len(self._surface), held)

    def account(self) -> Account:
        motion, mass_kg = self._motion, self._mass_kg
        risen_J = -np.sum(self._weight_N * (motion.position_m - self._rest_m))
        kinetic_J = mass_kg @ (motion.velocity_m_per_s**2).sum(axis=1) / 2
        return Account(
            mass_kg @ motion.velocity_m_per_s,
            mass_kg.sum() * self._gravity_m_per_s2 * self._elapsed_s,
            stored_J={"kinetic": float(kinetic_J), "gravitational": float(risen_J), **motion.stored_J()},
            lost_J={"panel_damping": motion.lost_J()},
            received_J=dict(self._received_J),
        )

    def save(self) -> Saved:
        return save_attributes(self, *_STATE) | {"motion": self._motion.save()}

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_STATE)
        self._motion.restore(saved["motion"])

    def close(self) -> None:
        pass

    def interpolation(self, coordinates_m: Array) -> csr_array:
        """Return shape functions, bilinear in (s, y) between the rows."""
        return bilinear.interpolation(self._chain.rows_m, self._width_m, coordinates_m)

    def _surface_now(self) -> Motion:
        position_m = self._halves @ bilinear.half(self._clamps.position_m)
        velocity_m_per_s = self._halves @ bilinear.half(self._clamps.velocity_m_per_s)
        return Motion(
            bilinear.joined(self._motion.position_m, position_m),
            bilinear.joined(self._motion.velocity_m_per_s, velocity_m_per_s),
        )

    def _book(self, clamps: Motion, load: Load, turning_N: Array, work_J: float) -> None:
        """``work_J`` that the rows' middles did on the clamps; the halves' is added here."""
        moved_m = bilinear.half(clamps.position_m - self._clamps.position_m)
        before, self._clamps = self._surface, clamps
        self._surface = self._surface_now()
        along_m = self._surface.position_m - before.position_m
        self._received_J["load"] += float(np.vdot(load.force_N, along_m))
        self._received_J["clamps"] -= work_J + float(np.vdot(turning_N, moved_m))


def _middle(points: Motion) -> Motion:
    return Motion(bilinear.middle(points.position_m), bilinear.middle(points.velocity_m_per_s))
