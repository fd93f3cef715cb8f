"""Assembly of a machine from a case: its plans, its open solvers, and the places of its points."""

from __future__ import annotations

from contextlib import ExitStack
from pathlib import Path
from typing import Any, cast

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.bed.feed import Feeds
from orchestrator.case.bed.material_book import MaterialBook, MaterialMonitor
from orchestrator.case.bed.packing import no_particles
from orchestrator.case.deck.openings import smaller_sides_m
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.solver_plans import bushings, frames_plan, particles_plan
from orchestrator.case.tables.case import Case
from orchestrator.coupling.ablation import (
    PanelBetweenStillClamps,
    ParticlesOnStillSurface,
    UnloadedPanel,
    UnpushedFrames,
)
from orchestrator.coupling.bushing_forces import BushingForces
from orchestrator.coupling.machine import Machine
from orchestrator.coupling.metered import (
    MeteredFrames,
    MeteredPanel,
    MeteredParticles,
    MeteredSolvers,
    Stopwatch,
)
from orchestrator.coupling.mpi import FramesOnFirstRank
from orchestrator.coupling.schemes import create_scheme
from orchestrator.coupling.schemes.iterated import case_effort
from orchestrator.coupling.schemes.scheme import Solvers
from orchestrator.coupling.surface_parts import OpenSurface
from orchestrator.ports import Frames, Panel, Particles, Wearing
from orchestrator.ports.plans import FramesPlan, ParticlesPlan
from orchestrator.preflight.check import find_problems_at_rest
from orchestrator.preflight.judge import JudgedCase
from orchestrator.preflight.stability.report import case_with_scheme


def build(loaded: JudgedCase, folder: Path, world: Any, stopwatch: Stopwatch) -> Machine:
    """Return the machine of a case, with its solvers open.

    Solvers keep files in the run's ``folder``; ``world`` is an MPI communicator, or None in a run of one
    process; ``stopwatch`` measures the time of every solver.  Raises SolverMissing or SolverFailed where a
    solver cannot be opened (the solvers opened before it are closed), and CaseError for a case that is wrong
    in a way that only open panels show, or that a solver refuses.
    """
    with ExitStack() as opened:
        machine = _open_machine(loaded, folder, world, stopwatch, opened)
        opened.pop_all()  # the machine closes them from here on
        return machine


def _open_machine(
    loaded: JudgedCase, folder: Path, world: Any, stopwatch: Stopwatch, opened: ExitStack
) -> Machine:
    case = case_with_scheme(loaded.case)
    # panels first: how they rest decides what particles and frames begin with
    opened_surface = OpenSurface.of(case, loaded.folder, stopwatch, world)
    surface_panel = opened_surface.together
    opened.callback(surface_panel.close)
    surface = opened_surface.triangle_surface()
    # plans of the other solvers
    plan_of_particles = particles_plan(case, surface, world, folder, opened_surface.deck())
    if problems := _problems_at_rest(loaded, opened_surface, plan_of_particles):
        raise CaseError(problems)
    plan_of_frames = _plan_frames(case, surface_panel)
    # solvers
    material, particles, wearing = _particles(case, plan_of_particles, stopwatch)
    if particles is not None:
        opened.callback(particles.close)
    opened_frames = _frames(case, plan_of_frames, world)
    members = MeteredSolvers(
        MeteredFrames(opened_frames, f"frames ({case.frames.solver})", stopwatch),
        MeteredPanel(surface_panel, "panels", "mapping", stopwatch),
        particles,
    )
    return Machine(
        solvers=_ablate_exchanges(case, members),
        members=members,
        scheme=create_scheme(case.coupling.scheme, case_effort(case)),
        stopwatch=stopwatch,
        surface=surface,
        panel_of_triangle=opened_surface.panel_of_triangle(),
        panels=opened_surface.panel_points(),
        penetrations=opened_surface.penetrations(),
        frames=tuple(case.screen.frames),
        probes=opened_surface.probes(),
        bushings=BushingForces.of(bushings(case), plan_of_frames.bodies),
        material=material,
        wearing=wearing,
    )


def find_problems_when_open(loaded: JudgedCase) -> list[CaseProblem]:
    """Return the problems of a case that only open panels show, whose shapes at rest gravity makes.

    The case has no other problem.  Only panels that hang slack or may lie on a stop are opened: all others
    are, but for a small sag, where the checks before have taken them to be.  Raises SolverMissing or
    SolverFailed where a panel cannot be opened.
    """
    panels = single_panels(loaded.case)
    if not any(panel.table.stops or panel.rectangle.span_m < panel.rectangle.length_m for panel in panels):
        return []
    try:
        opened = OpenSurface.of(loaded.case, loaded.folder, Stopwatch(), None)
    except CaseError as error:  # a panel that lies on a stop
        return list(error.problems)
    try:
        return _problems_at_rest(loaded, opened, particles_plan(loaded.case, opened.triangle_surface()))
    finally:
        opened.together.close()


def _problems_at_rest(
    loaded: JudgedCase, opened: OpenSurface, plan: ParticlesPlan | None
) -> list[CaseProblem]:
    start_list = plan.particles if plan is not None else no_particles()
    return find_problems_at_rest(
        loaded, opened.triangle_surface(), opened.panel_of_triangle(), opened.penetrations(), start_list
    )


def _plan_frames(case: Case, surface_panel: Panel) -> FramesPlan:
    reaction_N = surface_panel.initial().reaction.force_N
    if not case.exchange.panel_reaction:  # frames at rest do not hold what they do not feel
        reaction_N = np.zeros_like(reaction_N)
    return frames_plan(case, surface_panel.mount.position_m, surface_panel.mount.frame, reaction_N)


def _frames(case: Case, plan: FramesPlan, world: Any) -> Frames:
    def open_frames() -> Frames:
        return cast(Frames, solvers.open_solver("frames", case.frames.solver, plan))

    return open_frames() if world is None else FramesOnFirstRank(world, open_frames)


def _particles(
    case: Case, plan: ParticlesPlan | None, stopwatch: Stopwatch
) -> tuple[MaterialBook | None, MeteredParticles | None, Wearing | None]:
    if plan is None:
        return None, None, None
    feed = cast(Feeds, plan.feed or Feeds([], first=plan.particles))
    solver = case.particles.solver
    opened = solvers.open_solver("particles", solver, plan)
    metered = MeteredParticles(cast(Particles, opened), feed, f"particles ({solver})", stopwatch)
    widest_m = max(smaller_sides_m(case), default=None)
    book = MaterialBook(feed, plan.exits, MaterialMonitor(case.monitor, widest_m))
    return book, metered, None if plan.wear_m3_per_N_m is None else cast(Wearing, opened)


def _ablate_exchanges(case: Case, members: MeteredSolvers) -> Solvers:
    """Return the solvers as the coupling sees them, with the exchanges that the case wants."""
    exchange = case.exchange
    frames: Frames = members.frames
    panel: Panel = members.panel
    particles: Particles | None = members.particles
    if not exchange.panel_reaction:
        frames = UnpushedFrames(frames)
    if not exchange.frame_motion:
        panel = PanelBetweenStillClamps(panel)
    if not exchange.particle_load:
        panel = UnloadedPanel(panel)
    if particles is not None and not exchange.panel_motion:
        particles = ParticlesOnStillSurface(particles, panel.initial().surface)
    return Solvers(frames, panel, particles)
