"""Checks of a case before anything starts: small functions, each with its own rule and test.

They come in three rounds, because each builds on the one before: names and tables that fit
together, then files, then what is computed from both.
"""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.case_errors import CaseError, Mistake
from orchestrator.checks import machine, materials, names, plausible, start, steps, surfaces
from orchestrator.levels import LoadedCase

OF_TABLES = (
    names.unknown_names,
    names.shared_names,
    materials.complete_materials,
    materials.complete_contacts,
    materials.boxes_and_sizes,
    machine.frames_and_their_solver,
    machine.bushings_and_exciters,
    machine.panels,
    machine.probes,
    plausible.wrong_sizes,
    steps.whole_times,
)


def check(loaded: LoadedCase) -> list[str]:
    """Raises CaseError with every mistake found; returns warnings.

    Raises SolverMissing if a panel step is given and the panel's solver is not installed.
    """
    case = loaded.case
    _raise_any(loaded, (mistake for rule in OF_TABLES for mistake in rule(case)))
    _raise_any(loaded, [*surfaces.stl_files(case, loaded.folder), *surfaces.panels_inside(case)])
    computed = [*steps.particle_step(case), *steps.panel_step(case)]
    _raise_any(loaded, [*computed, *start.particles_at_start(case, loaded.folder)])
    return list(steps.long_interval(case))


def _raise_any(loaded: LoadedCase, mistakes: Iterator[Mistake] | list[Mistake]) -> None:
    found = loaded.layers.named(list(mistakes))
    if found:
        raise CaseError(found)
