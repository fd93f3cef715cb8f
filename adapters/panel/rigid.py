"""A panel that does not deform: flat between its clamps, massive, without integration.

Each clamp is a rectangle of four points (two if it has no depth: ``clamp_m`` = 0); the surface
between the inner edges is bilinear in its four corners.  All its points are clamps, so they
move as the frames do, and the panel's reaction is what it takes to move them:

    reaction = load + m (gravity - mean acceleration)      at each point.

The mass of a cell goes in equal parts to its corners (the row sums of the consistent mass
matrix): total mass, centre of mass and linear momentum are exact, the moment of inertia about
the panel's own centre is not (edges too heavy by a factor of up to 3).
"""

from __future__ import annotations

import numpy as np
from scipy.sparse import csr_array

from adapters.panel.common import bilinear
from orchestrator.ports import (
    Account,
    Array,
    Known,
    Load,
    Motion,
    Mount,
    PanelState,
    Saved,
    check_point_count,
)
from orchestrator.ports.adapters import PanelAdapter
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import Cost, PanelPlan, PanelsWork
from orchestrator.ports.state import restore_attributes, save_attributes

_STATE = ("_now", "_elapsed_s", "_received_J")


def build(plan: PanelPlan) -> RigidPanel:
    """Uses the plan's rectangle, frames, thickness, density and gravity."""
    return RigidPanel(plan)


class RigidPanel:
    """``MeshedPanel`` whose surface points are its clamp points, row by row: y = 0, y = width."""

    def __init__(self, plan: PanelPlan) -> None:
        rectangle = plan.rectangle
        rows = [0.0, rectangle.length_m]
        if rectangle.clamp_m > 0:
            rows = [-rectangle.clamp_m, *rows, rectangle.length_m + rectangle.clamp_m]
        self._rows_m, self._width_m = np.array(rows), rectangle.width_m
        material_m = bilinear.points_m(self._rows_m, rectangle.width_m)
        per_length = plan.material.density_kg_per_m3 * plan.thickness_m * rectangle.width_m
        solid = np.ones(len(rows) - 1)
        if plan.apertures:
            solid[len(solid) // 2] = plan.apertures.material_share(rectangle)
        self._mass_kg = bilinear.half_row_mass_kg(self._rows_m, per_length * solid)[:, None]
        self._gravity_m_per_s2 = plan.gravity_m_per_s2
        end = rectangle.end(material_m).astype(int)
        position_m = rectangle.mounted(material_m)
        self.mount = Mount(position_m, tuple(plan.frames[k] for k in end))
        self._now = Motion(position_m, np.zeros_like(position_m))
        self._elapsed_s = 0.0
        self._received_J = {"load": 0.0, "clamps": 0.0}

    def initial(self) -> PanelState:
        return PanelState(self._now, Load(self._mass_kg * self._gravity_m_per_s2))

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        check_point_count("rigid panel's clamps", clamps, len(self._now))
        check_point_count("rigid panel's load", load, len(self._now))
        before, self._now = self._now, clamps
        acceleration = (clamps.velocity_m_per_s - before.velocity_m_per_s) / interval.length_s
        reaction = load.force_N + self._mass_kg * (self._gravity_m_per_s2 - acceleration)
        self._book(load, before)
        self._elapsed_s += interval.length_s
        return PanelState(clamps, Load(reaction))

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        return clamps

    def account(self) -> Account:
        mass_kg, now = self._mass_kg, self._now
        risen_m = now.position_m - self.mount.position_m
        return Account(
            (mass_kg * now.velocity_m_per_s).sum(axis=0),
            mass_kg.sum() * self._gravity_m_per_s2 * self._elapsed_s,
            stored_J={
                "kinetic": self._kinetic_J(now),
                "gravitational": -float(np.sum(mass_kg * risen_m * self._gravity_m_per_s2)),
            },
            received_J=dict(self._received_J),
        )

    def save(self) -> Saved:
        return save_attributes(self, *_STATE)

    def restore(self, saved: Saved) -> None:
        restore_attributes(self, saved, *_STATE)

    def close(self) -> None:
        pass

    def interpolation(self, coordinates_m: Array) -> csr_array:
        """Bilinear in (s, y) within each of the panel's one or three rectangles."""
        return bilinear.interpolation(self._rows_m, self._width_m, coordinates_m)

    def _kinetic_J(self, motion: Motion) -> float:
        return float(np.sum(self._mass_kg * motion.velocity_m_per_s**2) / 2)

    def _book(self, load: Load, before: Motion) -> None:
        """Work of the load, and of the clamps' force m (a - gravity) - load along their path."""
        moved_m = self._now.position_m - before.position_m
        held_N = load.force_N + self._mass_kg * self._gravity_m_per_s2
        faster_J = self._kinetic_J(self._now) - self._kinetic_J(before)
        self._received_J["load"] += float(np.sum(load.force_N * moved_m))
        self._received_J["clamps"] += faster_J - float(np.sum(held_N * moved_m))


def cost(work: PanelsWork) -> Cost:
    """A call of each panel in each interval."""
    return Cost(0.01 * work.panels, 4e-5 * work.panels * work.runs)


ADAPTER = PanelAdapter(
    about="flat between its clamps, undeformed",
    build=build,
    cost=cost,
    leaves_out={"panel-deformation": "panels stay flat"},
    deforms=False,
    yields=False,
    varies_across=False,
    fidelity=0,
)
