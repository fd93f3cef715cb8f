"""The checks of a case before anything starts: small functions, each with its own rule and test.

They run in rounds, because each round builds on the one before: first names and tables, then
files, then quantities computed from both.  A last round follows when the panels are open and their
shapes at rest are known.
"""

from __future__ import annotations

from dataclasses import replace

from orchestrator.case.bed.work_of_adhesion import move_to_given_key
from orchestrator.case.file.deck_layout import move_to_deck
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.file.plausible import unusual_sizes
from orchestrator.ports import Indices
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.penetration import Penetrations
from orchestrator.ports.plans import ParticleList
from orchestrator.preflight.checks import (
    TABLE_RULES,
    bed,
    deck,
    leaks,
    machine,
    motion,
    panels,
    slips,
    steps,
    surfaces,
)
from orchestrator.preflight.judge import JudgedCase
from orchestrator.preflight.mats.mats import mat_warnings
from orchestrator.preflight.scene.scene import scene
from orchestrator.preflight.sheet.sheet import duty_of, too_small_decks


def find_problems(loaded: JudgedCase) -> list[CaseProblem]:
    """Return the problems of a case that must be solved before it can run."""
    case, folder = loaded.case, loaded.folder
    # ``whole`` is the case as the user gave it; checks that a slice affects take the case itself.
    whole = case.whole_machine
    if problems := _rule_problems(loaded):
        return problems
    rounds = (  # generators, which start only if the rounds before have found no problem
        (
            surfaces.surface_files(whole, folder),
            surfaces.panels_inside(whole),
            surfaces.parts_in_one_place(whole),
            machine.solvers_objections(whole),
            bed.clumps(case),
            machine.inertia_tensors(whole),
            machine.frame_weights(whole),
            slips.refused_motion(whole),
            bed.written_size(case),
            bed.feeds(case),
            bed.exits(whole),
            bed.crowded_boxes(case),
            bed.narrow_slice(case),
        ),
        (panels.triangles(case), panels.mesh_memory(case), bed.adhesive_contacts(case)),
        (
            steps.particle_step(case),
            steps.panel_step(case),
            bed.fitting_bed(case),
            surfaces.particles_at_start(case, folder),
            surfaces.feeds_at_start(case, folder),
        ),
    )
    for checks in rounds:
        if problems := [problem for check in checks for problem in check]:
            return _as_given(loaded, problems)
    return []


def find_table_problems(loaded: JudgedCase) -> list[CaseProblem]:
    """Return the problems that show without reading files and placing particles."""
    return _rule_problems(loaded) or _as_given(loaded, [*bed.fitting_bed(loaded.case)])


def _rule_problems(loaded: JudgedCase) -> list[CaseProblem]:
    problems = [problem for rule in TABLE_RULES for problem in rule(loaded.case.whole_machine)]
    return _as_given(loaded, [*loaded.choice.problems, *problems])


def find_problems_at_rest(
    loaded: JudgedCase,
    surface: TriangleSurface,
    panel_of_triangle: Indices,
    penetrations: Penetrations,
    particles: ParticleList,
) -> list[CaseProblem]:
    """Return the problems of open panels at rest, which must not reach into surfaces, particles or feeds.

    ``surface`` has all the triangles that particles touch.
    """
    problems = list(surfaces.surface_penetrations(loaded.case, penetrations, surface))
    problems += surfaces.hanging_panels(loaded.case, surface, panel_of_triangle, particles)
    return _as_given(loaded, problems)


def _as_given(loaded: JudgedCase, problems: list[CaseProblem]) -> list[CaseProblem]:
    """Return the problems with the keys that the user wrote.

    A problem that several panels or surfaces of a deck share is said once, of the first of them.
    """
    given = loaded.layers.merged
    decks, contacts = given["screen"].get("decks", {}), given.get("contacts", [])
    alike: dict[tuple[Key, str, str], list[CaseProblem]] = {}
    for problem in problems:
        moved = move_to_given_key(move_to_deck(problem, decks), contacts)
        alike.setdefault((moved.key, problem.what, problem.hint), []).append(moved)
    said = [
        replace(first, what=f"{first.what} ({len(others)} more)") if others else first
        for first, *others in alike.values()
    ]
    return loaded.layers.named(said)


def given_rates_kg_per_s(loaded: JudgedCase) -> dict[str, float]:
    """Return the rates of the case's own feeds that its level reduces."""
    return bed.rates_above_the_level(loaded.origin.given, loaded.layers)


def warnings(loaded: JudgedCase) -> list[str]:
    """Return warnings, with numbers, about allowed but doubtful settings of a case without problems.

    The sync interval has its own report (stability/report.py).
    """
    case = loaded.case
    shaken = scene(case)
    slipped = [
        *slips.unusual_motion(shaken),
        *slips.late_exciters(case),
        *slips.cancelled_shafts(shaken),
        *slips.angles_in_other_units(loaded.layers.merged),
        *slips.cut_beside_all_sizes(case),
    ]
    return [
        *map(str, loaded.layers.named(slipped)),
        *unusual_sizes(case.whole_machine),
        *deck.panels_out_of_line(case),
        *deck.panels_across(case),
        *deck.openings_and_particles(case),
        *leaks.leaks(case, loaded.folder),
        *steps.rounded_times(case),
        *motion.resonances(shaken),
        *motion.slips_of_magnitude(shaken),
        *motion.normal_strokes(shaken),
        *motion.exits_in_swing(shaken),
        *motion.missing_damping(case, shaken),
        *motion.sudden_exciters(case),
        *motion.beating_speeds(shaken),
        *motion.bushings_beyond_points(case, shaken),
        *motion.loss_curves_beyond_points(case, shaken),
        *machine.sudden_drives(case),
        *bed.endless_rolling(shaken),
        *bed.shape_twice(case),
        *bed.sticky_clumps(case),
        *bed.idle_shapes(case, loaded.layers.merged),
        *bed.feeds_that_hardly_feed(case),
        *bed.probes_without_particle(case),
        *too_small_decks(duty_of(case.original, given_rates_kg_per_s(loaded))),
        *bed.reduced_feeds(loaded.origin.given, loaded.layers),
        *bed.fines(case, "leave-out"),
        *bed.other_densities(case),
        *bed.narrow_beds(case),
        *bed.doubtful_run(case),
        *bed.other_adhesion(case),
        *bed.soft_contacts(loaded.described),
        *bed.rounded_counts(case),
        *bed.doubtful_slice(case, loaded.folder),
        *panels.machine_memory(case),
        *panels.incompressible_mats(case),
        *mat_warnings(shaken),
        *loaded.choice.lacking,
    ]
