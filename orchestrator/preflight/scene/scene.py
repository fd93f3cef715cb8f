"""The numbers of a scene that several effects need.

They describe the machine of the case even if its level leaves something out.  The sag that a rigid
panel would have, for example, tells how much its missing deformation changes.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.bed.contact_times import impact_speed_m_per_s
from orchestrator.case.bed.grains import grain, largest_grains, sieve_sizes_m
from orchestrator.case.bed.size_distribution import (
    classes,
    classes_of_grains,
    mean_mass_kg,
    share_left_out,
    size_class,
)
from orchestrator.case.deck.openings import smaller_sides_m
from orchestrator.case.deck.panels import TRANSPORT_M_PER_S, axes, single_panels, stay_s
from orchestrator.case.solver_plans import frames_plan, hyperelastic
from orchestrator.case.tables.bed import Feed, SizeClass
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.ports.plans import FramesPlan
from orchestrator.preflight.scene.moved_panel import MovedPanel, change_of_response
from orchestrator.preflight.scene.observed import Observed
from orchestrator.preflight.scene.shaking import PanelSpring, Shaking, solve_shakings

RESONANT = (0.7, 1.4)  # over the lowest frequency: an oscillator may respond twice as much or more
ROUNDS = 200  # largest number of iterations between panels' stiffness and frames' stroke
NOTHING_MOVES = "nothing moves the panels' ends: what particles do to them, only a run tells"


@dataclass(frozen=True)
class Scene:
    """A case with the estimated motion of its machine.

    ``shaken`` is the steady motion of the frames with the panels as ``springs``.  Numbers ``observed``
    in a run replace the estimates.
    """

    case: Case
    plan: FramesPlan
    panels: tuple[MovedPanel, ...]
    springs: tuple[PanelSpring, ...]
    shaken: tuple[Shaking, ...]
    observed: Observed = field(default_factory=Observed)

    @property
    def openings_m(self) -> list[float]:
        """The smaller side of the openings of each panel that has openings."""
        return list(smaller_sides_m(self.case))

    @property
    def finest_m(self) -> float:
        """The smallest sieve size of the real particles, even if the case computes coarse ones."""
        return sieve_sizes_m(self.case)[0] / self.case.particles.coarse_graining

    @property
    def falls_through(self) -> bool:
        """Whether some particles are smaller than the largest openings."""
        return bool(self.openings_m) and self.finest_m < max(self.openings_m)

    @property
    def speed_rad_per_s(self) -> float:
        """The highest speed of an excitation; 0 if nothing shakes."""
        return max((shaking.speed_rad_per_s for shaking in self.shaken), default=0.0)

    @cached_property
    def gravity_m_per_s2(self) -> float:
        """The size of gravity; standard gravity, as a unit, if the case has none."""
        return float(np.linalg.norm(self.case.gravity_m_per_s2)) or STANDARD_GRAVITY_M_PER_S2

    @cached_property
    def frames_throw(self) -> float:
        """The throw intensity w^2 a / g of the frame that moves most normal to the deck."""
        if self.observed.frames_throw is not None:
            return self.observed.frames_throw
        normal = axes(self.case)[:, 2]
        names = [body.name for body in self.plan.bodies]
        accelerations_m_per_s2 = [
            sum(row.speed_rad_per_s**2 * abs(row.amplitude_m[name] @ normal) for row in self.shaken)
            for name in names
        ]
        return float(max(accelerations_m_per_s2, default=0.0)) / self.gravity_m_per_s2

    @cached_property
    def panels_throw(self) -> float:
        """The throw intensity w^2 s / g of the middle of the panel whose middle travels farthest."""
        travel_m = max((panel.travel_m for panel in self.panels), default=0.0)
        return self.speed_rad_per_s**2 * travel_m / self.gravity_m_per_s2

    @property
    def throw(self) -> float:
        """The larger throw intensity of frames and panels."""
        return max(self.frames_throw, self.panels_throw)

    @cached_property
    def bed_kg_per_m2(self) -> float:
        """The largest mass of the particles per area of the deck, as estimated or of a run.

        It is at least the mass of one layer of the largest particles, and 0 without particles or panels.
        """
        if not has_particles(self.case) or not self.case.screen.panels:
            return 0.0
        observed = self.observed.bed_kg_per_m2
        whole = bed_kg(self.case) / deck_m2(self.case) if observed is None else observed
        return max(whole, layer_kg_per_m2(self.case))

    @property
    def transport_m_per_s(self) -> float:
        """The speed of the bed along the deck."""
        observed = self.observed.transport_m_per_s
        return TRANSPORT_M_PER_S if observed is None else observed

    @property
    def slope(self) -> float:
        """The tangent of the flattest panel's angle to the horizontal; 0 without panels."""
        sines = [min(1.0, abs(p.panel.rectangle.along[2])) for p in self.panels]
        return math.tan(math.asin(min(sines, default=0.0)))

    def near_resonance(self, panel: MovedPanel) -> bool:
        """Return whether the excitation is close to a panel's lowest frequency.

        The panel may then respond several times as much as it would to a static load.
        """
        ratio = self.speed_rad_per_s / panel.frequency_rad_per_s
        return RESONANT[0] < ratio < RESONANT[1]

    def change_of_response(self, loss_factor: float = 0.0, mass_ratio: float = 0.0) -> float | None:
        """Return the largest change of a middle's amplitude without a loss factor or a mass on the panel.

        ``moved_panel.change_of_response`` computes it.  Return None if nothing shakes, or if a panel is
        ever slack, because a slack panel is no oscillator.
        """
        if self.speed_rad_per_s == 0 or any(panel.sag_m > 0 for panel in self.panels):
            return None
        return max(
            change_of_response(self.speed_rad_per_s / panel.frequency_rad_per_s, loss_factor, mass_ratio)
            for panel in self.panels
        )

    @cached_property
    def impact_m_per_s(self) -> float:
        """The speed of impacts: the larger of the case's own speed and the speed of the panels' middles.

        The case's own speed is 1 m/s, or the highest speed that it gives.
        """
        travel_m = max((panel.travel_m for panel in self.panels), default=0.0)
        return max(impact_speed_m_per_s(self.case), self.speed_rad_per_s * travel_m)


def scene(case: Case) -> Scene:
    """Return the scene of a case without problems in its tables.

    An iteration finds the panels' stiffness and the frames' stroke, which depend on each other.
    """
    plan = _moving_plan(case)
    panels = tuple(
        MovedPanel(panel, hyperelastic(case.materials[panel.table.material]), 0.0)
        for panel in single_panels(case)
    )
    stiffness_N_per_m = np.array([panel.taut_stiffness_N_per_m / 2 for panel in panels])
    for _ in range(ROUNDS):
        springs = tuple(_spring(*row) for row in zip(panels, stiffness_N_per_m, strict=True))
        shaken = solve_shakings(plan, springs)
        panels = tuple(
            replace(panel, stroke_m=stroke_m(shaken, spring))
            for panel, spring in zip(panels, springs, strict=True)
        )
        wanted_N_per_m = np.array([panel.spring_N_per_m for panel in panels])
        if np.allclose(wanted_N_per_m, stiffness_N_per_m, rtol=1e-9, atol=0.0):
            break
        stiffness_N_per_m = (stiffness_N_per_m + wanted_N_per_m) / 2
    return Scene(case, plan, panels, springs, shaken)


def _moving_plan(case: Case) -> FramesPlan:
    """Return the plan of a solver that leaves out no frames' motion, whatever the level's solver does."""
    every = (case.frames.model_copy(update={"solver": name}) for name in solvers.names("frames"))
    able = next(
        frames
        for frames in every
        if (can := frames.adapter).moved_by_forces and can.drives and can.rotates and can.motors
    )
    case = case.model_copy(update={"frames": able})
    return frames_plan(case, np.empty((0, 3)), (), np.empty((0, 3)))


def _spring(panel: MovedPanel, stiffness_N_per_m: float) -> PanelSpring:
    at = panel.panel.rectangle
    first_m = at.corner_m + at.across * at.width_m / 2
    ends_m = np.stack([first_m, first_m + at.span_m * at.along])
    return PanelSpring(panel.panel.frames, ends_m, at.along, float(stiffness_N_per_m), panel.free_mass_kg)


def stroke_m(shaken: tuple[Shaking, ...], spring: PanelSpring) -> float:
    """Return the amplitude of a panel's ends against each other along the panel, summed over all speeds."""
    return float(sum(abs(shaking.relative_m(spring.frames) @ spring.along) for shaking in shaken))


def elastic_solvers() -> str:
    """Return a text about the cost, which is none with the panel solvers whose panels deform."""
    return f"none with panel.solver {solvers.names_able_to('panel', lambda adapter: adapter.deforms)}"


def deck_m2(case: Case) -> float:
    """Return the total area of the panels."""
    return sum(p.rectangle.span_m * p.rectangle.width_m for p in single_panels(case))


def bed_kg(case: Case) -> float:
    """Return the largest mass of the particles.

    It is the mass at the start plus the mass that feeds bring in the time that material stays.
    """

    def fed_kg(feed: Feed) -> float:
        stop_s = min(case.duration_s, feed.stop_s or math.inf)
        fed_s = min(stay_s(case), max(0.0, stop_s - feed.start_s))
        return feed.rate_kg_per_s * (1 - share_left_out(feed)) * fed_s

    return sum(mass_kg for mass_kg, _ in bed_parts(case, fed_kg))


def bed_parts(case: Case, fed_kg: Callable[[Feed], float]) -> Iterator[tuple[float, tuple[SizeClass, ...]]]:
    """Yield the mass and the size classes of each single particle, each block, the carried particles of
    each material and, with the mass that ``fed_kg`` gives, each feed."""
    for row in case.bed.particles.values():
        size_m = row.sieve_size_m
        yield grain(case, row.material, row.shape, size_m).mass_kg, (size_class(size_m, size_m, 1.0),)
    for block in case.bed.blocks.values():
        sizes = classes(block)
        yield block.count * mean_mass_kg(sizes, grain(case, block.material, block.shape)), sizes
    for feed in case.bed.feeds.values():
        yield fed_kg(feed), classes(feed)
    if (carried := case.bed.carried) is not None:
        for name in carried.materials:
            grains = carried.of_material(name)
            mass_kg = case.materials[name].density_kg_per_m3 * float(grains.volume_m3.sum())
            yield mass_kg, classes_of_grains(grains)


def layer_kg_per_m2(case: Case) -> float:
    """Return the mass per area of one layer of the largest particles, side by side."""
    return max(each.mass_kg / (2 * each.bounding_radius_m) ** 2 for each in largest_grains(case).values())
