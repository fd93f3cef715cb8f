"""Checks of a case before anything starts: small functions, each with its own rule and test.

They come in rounds, because each builds on the one before: names and tables that fit together,
then files, then what is computed from both.  A last one is made when the panels are open and their
shapes at rest are known.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from orchestrator.case.file.deck_layout import as_given
from orchestrator.case.file.errors import CaseProblem
from orchestrator.case.file.plausible import unusual_sizes
from orchestrator.preflight.checks import TABLE_RULES, bed, machine, panels, steps, surfaces

if TYPE_CHECKING:
    from orchestrator.ports import Indices
    from orchestrator.ports.geometry import TriangleSurface
    from orchestrator.ports.penetration import Penetrations
    from orchestrator.ports.plans import ParticleList
    from orchestrator.preflight.judge import JudgedCase


def find_problems(loaded: JudgedCase) -> list[CaseProblem]:
    """Return all that must be put right before the case can run."""
    case, folder = loaded.case, loaded.folder
    whole = case.whole  # as the user gave it; what counts of a slice is looked at in the case
    if problems := find_table_problems(loaded):
        return problems
    rounds = (  # of generators, each of which begins when the rounds before have found nothing
        (
            surfaces.stl_files(whole, folder),
            surfaces.panels_inside(whole),
            machine.solvers_objections(whole),
            machine.possible_inertia(whole),
            machine.held_frames(whole),
            bed.feeds(case),
            bed.exits(whole),
            bed.crowded_boxes(case),
            bed.narrow_slice(case),
            panels.own_recording(case, folder, loaded.layers.source(panels.RECORDING)),
        ),
        (
            panels.fitting_recording(case, folder),
            panels.triangles(case),
            panels.too_large(case),
            bed.adhesive_contacts(case),
        ),
        (
            steps.particle_step(case),
            steps.panel_step(case),
            surfaces.particles_at_start(case, folder),
            surfaces.feeds_at_start(case, folder),
        ),
    )
    for checks in rounds:
        if problems := [problem for check in checks for problem in check]:
            return _as_given(loaded, problems)
    return []


def find_table_problems(loaded: JudgedCase) -> list[CaseProblem]:
    """Return the problems of the first round alone, which reads no files and places no particles."""
    problems = [problem for rule in TABLE_RULES for problem in rule(loaded.case.whole)]
    return _as_given(loaded, [*loaded.choice.problems, *problems])


def find_problems_at_rest(
    loaded: JudgedCase,
    surface: TriangleSurface,
    panel_of_triangle: Indices,
    penetrations: Penetrations,
    particles: ParticleList,
) -> list[CaseProblem]:
    """Return what the panels, open and at rest, reach into; ``surface`` is all that particles touch."""
    problems = list(surfaces.beyond_surfaces(loaded.case, penetrations, surface))
    problems += surfaces.in_hanging_panels(loaded.case, surface, panel_of_triangle, particles)
    return _as_given(loaded, problems)


def _as_given(loaded: JudgedCase, problems: list[CaseProblem]) -> list[CaseProblem]:
    """Return the problems with keys as the user gave them."""
    decks = loaded.layers.merged["screen"].get("decks", {})
    return loaded.layers.named([as_given(problem, decks) for problem in problems])


def warnings(loaded: JudgedCase) -> list[str]:
    """Return what is allowed but doubtful, with numbers; for a case without problems.  The sync
    interval has a report of its own: stability/report.py."""
    case = loaded.case
    return [
        *unusual_sizes(case.whole),
        *machine.sudden_drives(case),
        *bed.feeds_that_hardly_feed(case),
        *bed.fines(case),
        *bed.too_soft(loaded.described),
        *panels.other_speed(case, loaded.folder),
        *bed.doubtful_slice(case, loaded.folder),
        *panels.beyond_this_machine(case),
        *loaded.choice.lacking,
    ]
