"""The numbers of a scene that several effects need.

They are of the machine as the case describes it, also where its level leaves something out: a
rigid panel's would-be sag says what leaving its deformation out does.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, cast

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.bed.contact_times import impact_speed_m_per_s, smallest_diameters_m
from orchestrator.case.bed.size_distribution import classes, mean_mass_kg, share_left_out
from orchestrator.case.bed.sources import largest_diameter_m
from orchestrator.case.deck.panels import TRANSPORT_M_S, axes, single_panels, stay_s
from orchestrator.case.solver_plans import frames_plan, hyperelastic
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2, sphere_mass_kg
from orchestrator.ports.plans import FramesPlan
from orchestrator.preflight.scene.moved_panel import MovedPanel, change_of_response
from orchestrator.preflight.scene.observed import Observed
from orchestrator.preflight.scene.shaking import PanelSpring, Shaking, solve_shakings

if TYPE_CHECKING:
    from orchestrator.ports.adapters import FramesAdapter

RESONANT = (0.7, 1.4)  # of the lowest frequency: one oscillator answers twice as much or more
ROUNDS = 200  # of panels' stiffness and frames' stroke, which depend on each other
NOTHING_MOVES = "nothing moves the panels' ends: what particles do to them, only a run tells"


@dataclass(frozen=True)
class Scene:
    """``shaken`` is the frames' steady motion with the panels as springs, ``springs``; what was
    ``observed`` in a run takes the place of what is estimated here."""

    case: Case
    plan: FramesPlan
    panels: tuple[MovedPanel, ...]
    springs: tuple[PanelSpring, ...]
    shaken: tuple[Shaking, ...]
    observed: Observed = field(default_factory=Observed)

    @property
    def speed_rad_per_s(self) -> float:
        """The fastest excitation; 0 where nothing shakes."""
        return max((one.speed_rad_per_s for one in self.shaken), default=0.0)

    @property
    def gravity_m_per_s2(self) -> float:
        """Its size; the standard one where the case has none, as a unit."""
        return float(np.linalg.norm(self.case.gravity_m_per_s2)) or STANDARD_GRAVITY_M_PER_S2

    @property
    def frames_throw(self) -> float:
        """Throw intensity w^2 a / g of the frame that moves most normal to the deck."""
        if self.observed.frames_throw is not None:
            return self.observed.frames_throw
        normal = axes(self.case)[:, 2]
        names = [body.name for body in self.plan.bodies]
        found = [
            sum(one.speed_rad_per_s**2 * abs(one.amplitude_m[name] @ normal) for one in self.shaken)
            for name in names
        ]
        return float(max(found, default=0.0)) / self.gravity_m_per_s2

    @property
    def panels_throw(self) -> float:
        """Throw intensity w^2 s / g of the middle of the panel that travels farthest."""
        travel_m = max((panel.travel_m for panel in self.panels), default=0.0)
        return self.speed_rad_per_s**2 * travel_m / self.gravity_m_per_s2

    @property
    def throw(self) -> float:
        """The larger of both."""
        return max(self.frames_throw, self.panels_throw)

    @property
    def bed_kg_per_m2(self) -> float:
        """Mass of the particles per area of the deck, at most."""
        observed = self.observed.bed_kg_per_m2
        if observed is None:
            return bed_kg_per_m2(self.case)
        return max(observed, _lying_kg_per_m2(self.case))

    @property
    def transport_m_per_s(self) -> float:
        """Speed of the bed along the deck."""
        observed = self.observed.transport_m_per_s
        return TRANSPORT_M_S if observed is None else observed

    @property
    def slope(self) -> float:
        """Tangent of the flattest panel's slope against the horizontal; 0 without panels."""
        sines = [min(1.0, abs(p.panel.rectangle.along[2])) for p in self.panels]
        return math.tan(math.asin(min(sines, default=0.0)))

    def near_resonance(self, panel: MovedPanel) -> bool:
        """Whether the excitation is so near to a panel's lowest frequency that its answer is
        several times the static one."""
        ratio = self.speed_rad_per_s / panel.frequency_rad_per_s
        return RESONANT[0] < ratio < RESONANT[1]

    def change_of_response(self, loss_factor: float = 0.0, mass_ratio: float = 0.0) -> float | None:
        """Largest change of the amplitude of a panel's middle without a loss factor or a mass upon
        it (``moved_panel.change_of_response``), if all panels are taut all the time and shaken; else
        None: a slack panel is no oscillator."""
        if self.speed_rad_per_s == 0 or any(panel.sag_m > 0 for panel in self.panels):
            return None
        return max(
            change_of_response(self.speed_rad_per_s / one.frequency_rad_per_s, loss_factor, mass_ratio)
            for one in self.panels
        )

    @property
    def impact_m_per_s(self) -> float:
        """The case's own (1 m/s, or the highest it gives), or the panels' middles' speed."""
        travel_m = max((panel.travel_m for panel in self.panels), default=0.0)
        return max(impact_speed_m_per_s(self.case), self.speed_rad_per_s * travel_m)


def scene(case: Case) -> Scene:
    """Of a case whose tables fit together."""
    plan = moving_plan(case)
    panels, springs, shaken = _together(case, plan)
    return Scene(case, plan, panels, springs, shaken)


def elastic_solvers() -> str:
    """Return the panel solvers whose panels deform, as words about a cost."""
    return f"none with panel.solver {solvers.those('panel', lambda adapter: adapter.deforms)}"


def moving_plan(case: Case) -> FramesPlan:
    """Frames, bushings, exciters and drives, whatever the level solves of them."""
    able = next(name for name in solvers.names("frames") if _moves_all(name))
    case = case.model_copy(update={"frames": case.frames.model_copy(update={"solver": able})})
    return frames_plan(case, np.empty((0, 3)), (), np.empty((0, 3)))


def _moves_all(solver: str) -> bool:
    """Return whether a frames solver leaves out nothing that a plan of frames has."""
    adapter = cast("FramesAdapter", solvers.adapter("frames", solver))
    return adapter.moved_by_forces and adapter.drives and adapter.rotates and adapter.motors


def stroke_m(shaken: tuple[Shaking, ...], spring: PanelSpring) -> float:
    """Amplitude of a panel's ends against each other, along it; of several speeds the sum."""
    return float(sum(abs(one.relative_m(spring.frames) @ spring.along) for one in shaken))


def _together(
    case: Case, plan: FramesPlan
) -> tuple[tuple[MovedPanel, ...], tuple[PanelSpring, ...], tuple[Shaking, ...]]:
    """Panels pull as the stroke lets them, the stroke is as the panels let it."""
    panels = tuple(
        MovedPanel(one, hyperelastic(case.materials[one.table.material]), 0.0) for one in single_panels(case)
    )
    stiffness_N_per_m = np.array([panel.taut_stiffness_N_per_m / 2 for panel in panels])
    for _ in range(ROUNDS):
        springs = tuple(_spring(*row) for row in zip(panels, stiffness_N_per_m, strict=True))
        shaken = solve_shakings(plan, springs)
        panels = tuple(
            MovedPanel(panel.panel, panel.material, stroke_m(shaken, spring))
            for panel, spring in zip(panels, springs, strict=True)
        )
        wanted_N_per_m = np.array([panel.spring_N_per_m for panel in panels])
        if np.allclose(wanted_N_per_m, stiffness_N_per_m, rtol=1e-9, atol=0.0):
            break
        stiffness_N_per_m = (stiffness_N_per_m + wanted_N_per_m) / 2
    return panels, springs, shaken


def _spring(panel: MovedPanel, stiffness_N_per_m: float) -> PanelSpring:
    at = panel.panel.rectangle
    first_m = at.corner_m + at.across * at.width_m / 2
    ends_m = np.stack([first_m, first_m + at.span_m * at.along])
    return PanelSpring(panel.panel.frames, ends_m, at.along, float(stiffness_N_per_m), panel.free_mass_kg)


def deck_m2(case: Case) -> float:
    """Area of the panels."""
    return sum(p.rectangle.span_m * p.rectangle.width_m for p in single_panels(case))


def bed_kg_per_m2(case: Case) -> float:
    """Mass of the particles per area of the deck, at most: what is there at the start, and what a
    feed brings in the time that material stays.  At least that of the largest particle over the
    square of its diameter: so much lies where it lies.  0 without particles or panels."""
    if not has_particles(case) or not case.screen.panels:
        return 0.0
    return max(bed_kg(case) / deck_m2(case), _lying_kg_per_m2(case))


def bed_kg(case: Case) -> float:
    """Mass of the particles, at most: what is there at the start, and what a feed brings in the
    time that material stays."""
    return sum(_masses_kg(case))


def _lying_kg_per_m2(case: Case) -> float:
    """Of the largest particle."""
    densest = max(case.materials[name].density_kg_per_m3 for name in smallest_diameters_m(case))
    largest_m = largest_diameter_m(case)
    return sphere_mass_kg(largest_m, densest) / largest_m**2


def _masses_kg(case: Case) -> Iterator[float]:
    for one in case.bed.particles.values():
        yield sphere_mass_kg(one.diameter_m, case.materials[one.material].density_kg_per_m3)
    for block in case.bed.blocks.values():
        density = case.materials[block.material].density_kg_per_m3
        yield block.count * mean_mass_kg(classes(block), density)
    for feed in case.bed.feeds.values():
        stop_s = min(case.duration_s, feed.stop_s or math.inf)
        fed_s = min(stay_s(case), max(0.0, stop_s - feed.start_s))
        yield feed.rate_kg_per_s * (1 - share_left_out(feed)) * fed_s
