"""The masses and modes of free frames and of panels."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from scipy.linalg import eigh

from orchestrator.case.deck.panels import aperture_pattern, single_panels
from orchestrator.case.solver_plans import panel_plans
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.screen import PanelTable
from orchestrator.ports import Array, linear_frames
from orchestrator.ports.plans import BushingPlan, SolverFailed, SolverMissing
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import free_frames


@dataclass(frozen=True)
class FrameMatrices:
    """Square matrices over all coordinates of the free frames, 3 for each frame or 6 with rotations.

    ``mass`` is the mass of the frames alone, and ``carried`` the mass of the panels whose ends they
    carry.  ``panels_N_per_m`` is the stiffness of the taut panels at their stiffest,
    ``bushings_N_per_m`` the stiffness of the bushings, and ``damping_N_s_per_m`` their damping.
    """

    mass: Array
    carried: Array
    panels_N_per_m: Array
    bushings_N_per_m: Array
    damping_N_s_per_m: Array
    freedoms: int

    @property
    def lightest_kg(self) -> float:
        """The mass of the lightest frame."""
        return float(np.min(np.diag(self.mass)[:: self.freedoms]))

    def modes(self) -> tuple[Array, Array]:
        """Return the angular frequencies of the frames with their panels, and the shapes as columns."""
        square, shapes = eigh(self.panels_N_per_m + self.bushings_N_per_m, self.mass + self.carried)
        return np.sqrt(np.maximum(square, 0.0)), shapes


def frame_matrices(scene: Scene) -> FrameMatrices | None:
    """Return the matrices of a scene; None if forces move none of its frames."""
    case, plan = scene.case, scene.plan
    solver = case.frames.adapter
    if not (solver.moved_by_forces and free_frames(plan)):
        return None
    coordinates = linear_frames.SPACE if solver.rotates else linear_frames.TRANSLATIONS
    machine = linear_frames.linearise(plan, coordinates)
    yields = case.panel.adapter.yields
    springs, halves = [], []
    for spring, panel in zip(scene.springs, scene.panels, strict=True):
        stiffest_N_per_m = panel.taut_stiffness_N_per_m * panel.stiffening if yields else 0.0
        springs.append(replace(spring, stiffness_N_per_m=stiffest_N_per_m).bushing())
        half_kg = panel.whole_mass_kg / 2 * np.ones(3)
        for name, end_m in zip(spring.frames, spring.ends_m, strict=True):
            halves.append(BushingPlan("", ("ground", name), end_m, np.eye(3), half_kg, np.zeros(3)))

    def assemble(bushings: list[BushingPlan]) -> Array:
        return linear_frames.linearise(replace(plan, bushings=tuple(bushings)), coordinates).stiffness

    return FrameMatrices(
        mass=machine.mass,
        carried=assemble(halves),
        panels_N_per_m=assemble(springs),
        bushings_N_per_m=machine.stiffness,
        damping_N_s_per_m=machine.damping,
        freedoms=len(coordinates),
    )


FREQUENCY_RATIO = 2 * math.sqrt(2) / math.pi
"""The smallest ratio of a frequency to its numerical value under velocity Verlet, whose steps h turn w
into (2 / h) arcsin(w h / 2).  It counts two steps to half a period."""


def largest_steps_s(case: Case) -> dict[str, float]:
    """Return the solver's largest step for each row of panels; empty if stability does not limit it.

    Raises SolverMissing, and SolverFailed if the solver finds no resting shape.
    """
    limit = case.panel.adapter.largest_step_s
    if limit is None or case.panel.integrator != "explicit":
        return {}
    plans = zip(single_panels(case), panel_plans(case), strict=True)
    rows = {panel.table_name: plan for panel, plan in plans}
    return {name: float(limit(plan)) for name, plan in rows.items()}


def highest_rad_per_s(case: Case) -> tuple[dict[str, float], str]:
    """Return the highest numerical frequency of each row of panels, and an error text if it is unknown.

    Implicit steps longer than the mesh's periods have no frequency that matters here, because their
    phase stays below half a turn; the solver then has no largest step, and the result is empty.
    """
    try:
        steps_s = largest_steps_s(case)
    except (SolverMissing, SolverFailed) as error:
        return {}, str(error)
    return {name: 2 / step_s / FREQUENCY_RATIO for name, step_s in steps_s.items()}, ""


def areal_kg_per_m2(case: Case, panel: PanelTable) -> float:
    """Return the mass of a panel's perforated part per area."""
    pattern = aperture_pattern(panel)
    solid = pattern.mean_section.solid_share if pattern else 1.0
    return solid * case.materials[panel.material].density_kg_per_m3 * panel.thickness_m


def lightest_point_kg(case: Case, name: str) -> float:
    """Return the effective mass of the lightest surface point of the panels ``name``.

    If their solver does not tell it, return the mass under one cell of the surface.
    """
    panel, lightest_kg = case.screen.panels[name], case.panel.adapter.lightest_kg
    if lightest_kg is None:
        cell_m2 = panel.width_m * panel.length_m / math.prod(case.panel.surface_cells)
        return areal_kg_per_m2(case, panel) * cell_m2
    plans = zip(single_panels(case), panel_plans(case), strict=True)
    return min(lightest_kg(plan, case.panel.surface_cells) for p, plan in plans if p.table_name == name)
