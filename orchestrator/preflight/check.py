"""Checks of a case before anything starts: small functions, each with its own rule and test.

They come in three rounds, because each builds on the one before: names and tables that fit
together, then files, then what is computed from both.  A last one is made when the panels are open
and their shapes at rest are known.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from orchestrator.case.file.deck_layout import as_given
from orchestrator.case.file.errors import CaseProblem
from orchestrator.case.file.plausible import unusual_sizes
from orchestrator.preflight.checks import (
    TABLE_RULES,
    feeds,
    machine,
    materials,
    panels,
    recordings,
    slices,
    start,
    steps,
    surfaces,
)

if TYPE_CHECKING:
    from orchestrator.ports import Indices
    from orchestrator.ports.geometry import TriangleSurface
    from orchestrator.ports.penetration import Penetrations
    from orchestrator.ports.plans import ParticleList
    from orchestrator.preflight.judge import JudgedCase


def find_problems(loaded: JudgedCase) -> list[CaseProblem]:
    """All that must be put right before the case can run; empty if nothing."""
    case, folder = loaded.case, loaded.folder
    whole = case.whole  # as the user gave it; what counts of a slice is looked at in the case
    found = [*loaded.choice.problems, *(m for rule in TABLE_RULES for m in rule(whole))]
    if not found:
        found = [*surfaces.stl_files(whole, folder), *surfaces.panels_inside(whole)]
        found += [*machine.solvers_objections(whole), *machine.possible_inertia(whole)]
        found += machine.held_frames(whole)
        found += [*feeds.feeds(case), *feeds.exits(whole)]
        found += [*materials.larger_than_the_box(case), *materials.crowded_blocks(case)]
        found += slices.too_narrow(case)
        source = loaded.layers.source(recordings.KEY)
        found += recordings.own_recording(case, folder, source)
    if not found:
        found += recordings.fitting_recording(case, folder)
        found += panels.triangles(case)
        found += panels.too_large(case)
        found += [*materials.adhesive_contacts(case), *materials.sjkr_materials(case)]
    if not found:
        found = [*steps.particle_step(case), *steps.adhesive_step(case)]
        found += steps.panel_step(case)
        found += start.particles_at_start(case, folder)
        found += start.feeds_at_start(case, folder)
    return _as_given(loaded, found)


def find_problems_at_rest(
    loaded: JudgedCase,
    surface: TriangleSurface,
    panel_of_triangle: Indices,
    penetrations: Penetrations,
    particles: ParticleList,
) -> list[CaseProblem]:
    """What the panels, open and at rest, reach into; ``surface`` is all that particles touch."""
    found = list(start.beyond_surfaces(loaded.case, penetrations, surface))
    found += start.in_hanging_panels(loaded.case, surface, panel_of_triangle, particles)
    return _as_given(loaded, found)


def find_table_problems(loaded: JudgedCase) -> list[CaseProblem]:
    """The first round alone, which reads no files and places no particles."""
    found = [problem for rule in TABLE_RULES for problem in rule(loaded.case.whole)]
    return _as_given(loaded, [*loaded.choice.problems, *found])


def _as_given(loaded: JudgedCase, found: list[CaseProblem]) -> list[CaseProblem]:
    """With keys as the user gave them."""
    decks = loaded.layers.merged["screen"].get("decks", {})
    return loaded.layers.named([as_given(problem, decks) for problem in found])


def warnings(loaded: JudgedCase) -> list[str]:
    """What is allowed but doubtful, with numbers; for a case without problems.  The sync interval
    has a report of its own: stability/report.py."""
    case = loaded.case
    return [
        *unusual_sizes(case.whole),
        *machine.sudden_drives(case),
        *feeds.feeds_that_hardly_feed(case),
        *feeds.rounded_feed_interval(case),
        *materials.fines(case),
        *materials.too_soft(loaded.described),
        *recordings.other_speed(case, loaded.folder),
        *slices.doubtful_slice(case, loaded.folder),
        *panels.beyond_this_machine(case),
        *loaded.choice.lacking,
    ]
