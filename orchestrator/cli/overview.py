"""The output of ``flipflow check``: the contents of a case in words and derived numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from orchestrator.case.bed.adhesion import adhesion_law, pull_offs
from orchestrator.case.bed.contact_times import shortest_rayleigh_s
from orchestrator.case.bed.grains import smallest_grains
from orchestrator.case.deck.openings import openings
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.deck.surface_file import read_surface
from orchestrator.case.deck.triangle_grid import surface_grids
from orchestrator.case.file.base import case_folders
from orchestrator.case.file.bushing_curve import compare_with_points
from orchestrator.case.file.characteristic import points
from orchestrator.case.file.loss_curve import compare_with_curve, curve_points, moduli
from orchestrator.case.solver_plans import meshes, particle_step_s
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.ports.clock import steps_in
from orchestrator.ports.plans import SolverMissing
from orchestrator.preflight.check import given_rates_kg_per_s, warnings
from orchestrator.preflight.checks.bed import fines
from orchestrator.preflight.checks.defaults import taken_defaults
from orchestrator.preflight.checks.steps import missing_solvers
from orchestrator.preflight.cost import (
    THICK,
    THIN,
    bed_cost,
    in_words,
    particles_at_start,
    predicted_parts_s,
    rigid_triangles,
)
from orchestrator.preflight.judge import JudgedCase
from orchestrator.preflight.judgement.account import account, lines_at_start
from orchestrator.preflight.mats.mats import mat_lines
from orchestrator.preflight.scene.scene import scene
from orchestrator.preflight.sheet.sheet import RULE, sheet
from orchestrator.preflight.stability.report import stability_report, with_scheme
from orchestrator.preflight.step_filling import step_filling_lines


def overview(loaded: JudgedCase, detail: bool = False) -> Iterator[str]:
    """Yield lines about a case without problems.

    With ``detail``, they have all limits of the sync interval in the theory's terms.
    """
    case = loaded.case
    stability = stability_report(case)
    level = f"level {loaded.level}" if loaded.level else "no level"
    yield f"{loaded.name}, {level}: {case.title}"
    if bases := [folder.name for folder in case_folders(loaded.folder)[1:]]:
        yield f"  over       {', which is over '.join(bases)}"
    yield from _machine(loaded)
    if has_particles(case):
        yield from _particles(loaded)
    yield from _sheet(loaded)
    yield from _times(loaded)
    rigid = sum(rigid_triangles(case, loaded.folder))
    yield from _cost(with_scheme(case, stability.scheme), particles_at_start(case), rigid)
    yield from lines_at_start(
        account(loaded.described, loaded.left_out, loaded.choice.pairs, loaded.choice.asked)
    )
    if loaded.choice.undecided:
        from orchestrator.run.trials.pairs import effects_to_try

        if names := effects_to_try(loaded):
            yield (
                f'effects = "auto" cannot decide about {", ".join(names)}: '
                "the run first makes short runs with and without each"
            )
    if loaded.changed:
        yield f"the level or --set changes the physics: {', '.join(loaded.changed)}"
    if defaults := [*taken_defaults(loaded.layers.merged)]:
        yield "defaults that the case takes:"
        yield from (f"  {line}" for line in defaults)
    yield "stability:"
    yield from stability.detail_lines() if detail else stability.short_lines()
    for warning in [*warnings(loaded), *stability.warnings(), *missing_solvers(case)]:
        yield f"warning: {warning}"
    yield "the case can be run"


def _machine(loaded: JudgedCase) -> Iterator[str]:
    case, screen = loaded.case, loaded.case.screen
    bushings = sum(len(bushing.positions_m) for bushing in screen.bushings.values())
    drives = sum(frame.drive is not None for frame in screen.frames.values())
    yield (
        f"  frames     {len(screen.frames)} ({case.frames.solver}), "
        f"{f'{drives} of them driven, ' if drives else ''}{bushings} bushings, "
        f"{len(screen.exciters)} exciters, deck inclined by {screen.inclination_deg:g} deg"
    )
    panels, cells = single_panels(case), " x ".join(str(count) for count in case.panel.cells)
    described = f"{len(panels)} ({case.panel.solver}), {cells} cells each" if panels else "none"
    yield f"  panels     {described}"
    yield from meshes(case)
    for line in mat_lines(scene(case)):
        yield f"             {line}"
    yield from _curves(case)
    yield from _springs(case)
    yield from _damping(case)
    yield from openings(case)
    rigid = rigid_triangles(case, loaded.folder)
    of_panels = f"{_triangles_on_panels(case)}, " if panels else ""
    if panels or rigid:
        yield f"  triangles  {of_panels}{sum(rigid)} on {len(rigid)} rigid surfaces"
    for name, surface in case.screen.surfaces.items():
        if surface.corner_m is None and (line := read_surface(surface, loaded.folder).line):
            yield f"             {name}: {line}"


def _sheet(loaded: JudgedCase) -> Iterator[str]:
    lines = sheet(scene(loaded.case.original), given_rates_kg_per_s(loaded))
    if lines:
        yield f"  designer's sheet of the whole machine ({RULE}: docs/designers-sheet.md)"
    for line in lines:
        yield f"             {line.name}: {line.text} [{line.source}]"


def _curves(case: Case) -> Iterator[str]:
    """Yield lines that compare the elements of bushings with the measured curves."""
    for name, bushing in case.screen.bushings.items():
        for curve in bushing.curves:
            elements = f"{len(curve.friction)} friction and {len(curve.maxwell)} Maxwell elements"
            yield f"  bushings   {name} along {curve.axes}: spring with {elements}"
            if not curve.points:
                continue
            off = compare_with_points(curve)
            stiffness = [point.stiffness_N_per_m for point in curve.points]
            errors = (
                f"stiffness off by {off.stiffness_error:.1%} at most, loss factor by {off.loss_error:.0%}"
            )
            yield (
                f"             measured {min(stiffness):g} to {max(stiffness):g} N/m "
                f"at {len(stiffness)} points: {errors}"
            )


def _springs(case: Case) -> Iterator[str]:
    """Yield lines about the characteristics and temperatures of bushings."""
    for name, bushing in case.screen.bushings.items():
        for row in bushing.characteristics:
            deformation_m, force_N = points(row)
            slope = np.diff(force_N) / np.diff(deformation_m)
            yield (
                f"  bushings   {name} along {row.axes}: {slope.min():g} to {slope.max():g} N/m from "
                f"{1e3 * deformation_m[0]:g} to {1e3 * deformation_m[-1]:g} mm"
            )
        if (warm := bushing.temperature) is not None:
            warmth = f"{warm.ratio:.3g} of its given stiffness"
            yield f"  bushings   {name} at {warm.works_at_degC:g} degC: {warmth}"


def _damping(case: Case) -> Iterator[str]:
    """Yield lines that compare the loss factors of Maxwell branches with the measured ones."""
    for name, material in case.materials.items():
        law = material.hyperelastic
        if law is None or not law.loss_curve:
            continue
        branches = tuple((branch.ratio, branch.relaxation_s) for branch in law.maxwell)
        off = compare_with_curve(branches, curve_points(law))
        _, fitted = moduli(branches, 2 * np.pi * np.array([p.frequency_Hz for p in law.loss_curve]))
        pairs = zip(fitted, law.loss_curve, strict=True)
        factors = ", ".join(f"{eta:.3g} ({p.loss_factor:g}) at {p.frequency_Hz:g}" for eta, p in pairs)
        yield f"  damping    {name}: loss factor of {len(branches)} Maxwell branches (measured): {factors} Hz"
        yield f"             off by {off.error:.1%} at most, at {off.at_Hz:g} Hz"


def _triangles_on_panels(case: Case) -> str:
    try:
        counts = [len(grid.triangles) for grid in surface_grids(case).values()]
    except SolverMissing:
        return "unknown number on the panels (gmsh is missing)"
    sizes = sorted(set(counts))
    return f"{' or '.join(map(str, sizes))} on each panel, {sum(counts)} on all"


def _particles(loaded: JudgedCase) -> Iterator[str]:
    case = loaded.case
    feeds = "".join(f", {feed.rate_kg_per_s:g} kg/s fed" for feed in case.bed.feeds.values())
    step_s = particle_step_s(case)
    yield f"  particles  {particles_at_start(case)} at the start{feeds} ({case.particles.solver})"
    for line in fines(case, "next-class"):
        yield f"  sizes      {line}"
    yield from rolling_lines(case)
    yield from adhesion_lines(case)
    if (carried := case.bed.carried) is not None:
        at = "" if math.isnan(carried.time_s) else f", at t = {carried.time_s:g} s"
        yield f"  bed        from {carried.source}{at}{f', {carried.note}' if carried.note else ''}"
    yield (
        f"  particles' step  {step_s:.3g} s = {step_s / shortest_rayleigh_s(case):.2g} of the "
        "smallest particle's Rayleigh time"
    )


def rolling_lines(case: Case) -> Iterator[str]:
    """Yield a line about each kind of grains: its shape, and the rolling friction of its contacts."""
    for name in smallest_grains(case):
        frictions = {
            other: row.rolling_friction
            for row in case.contacts
            for one, other in {row.between, row.between[::-1]}
            if one == name
        }
        rolls = ", ".join(f"{friction:g} on {other}" for other, friction in frictions.items())
        yield f"  shape      {name}: {case.materials[name].shape or 'not given'}; rolling friction {rolls}"


def adhesion_lines(case: Case) -> Iterator[str]:
    """Yield a line about the pull-off force of each pair of materials that stick."""
    for pair in pull_offs(case):
        yield f"  adhesion   {pair.in_words} ({adhesion_law(case)})"


def _cost(case: Case, at_start: int, rigid: int) -> Iterator[str]:
    """Yield lines about the time of the whole run, and of the parts that take more than a tenth of it."""
    ranges = [predicted_parts_s(case, at_start, bed, rigid=rigid) for bed in (THIN, THICK)]
    least, most = (sum(parts.values()) for parts in ranges)
    shortest, longest = in_words(least), in_words(most)
    fed = most > 1.1 * least and shortest != longest
    time = f"{shortest} to {longest}" if fed else longest
    larger = sorted(ranges[1].items(), key=lambda part: -part[1])
    shares = ", ".join(f"{name} {in_words(s)}" for name, s in larger if s > 0.1 * most)
    layers = ", from a thin dry bed to a thick wet one" if fed else ""
    yield f"  cost       about {time} of processor time{layers}"
    yield f"             of which {shares}; without pictures and the compilation of a first run"
    yield "             on a fast core; an older one took 2.6 times as long (docs/measured/cost.md)"
    if fed:
        few, many = (bed_cost(case, at_start, bed) for bed in (THIN, THICK))
        yield (
            f"             {few.most:.2g} to {many.most:.2g} particles at most, "
            f"{few.particle_steps:.2g} to {many.particle_steps:.2g} particle-steps"
        )


def _times(loaded: JudgedCase) -> Iterator[str]:
    case = loaded.case
    interval_s = case.coupling.sync_interval_s
    count = steps_in(case.duration_s, interval_s)
    yield (
        f"  coupling   {count} sync intervals of {interval_s:g} s "
        f"({case.coupling.scheme}), {count * interval_s:.6g} s in all"
    )
    if has_particles(case):
        yield from step_filling_lines(case)
