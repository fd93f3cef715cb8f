"""The checks of panels: their tables, openings and meshes, and the beams below them."""

from __future__ import annotations

import math
import os
from collections.abc import Iterator

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.deck.panels import SinglePanel, perforated_panels, single_panels, stiffest_Pa_per_m
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.solver_plans import UNKNOWNS, memory_GiB, mesh_sizes
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.case.tables.deck import DrawnApertures
from orchestrator.case.tables.screen import PanelTable
from orchestrator.ports.geometry import AperturePattern
from orchestrator.ports.plans import LARGEST_MESHES_GIB, SolverMissing
from orchestrator.preflight.checks.machine import right_angle
from orchestrator.preflight.checks.names import rows

DEEPEST_SAG = 0.2  # moulded, over the free length: its slope is 40 degrees
THINNEST_LAND = 0.02  # over the longer pitch: no unit cell's mesh resolves thinner lands
COMPRESSES = 0.01  # relative error of Young's modulus by which a compressible material is told
PLATE = 3.0  # ratio of thickness to the openings' longer pitch above which a panel is a block, no plate
DRAWN_M = 1e-5  # distance between a size in a drawing and the same in a case
GIB = 2**30


def panel_rows(case: Case) -> Iterator[CaseProblem]:
    """Check that each row gives one of tension and span, a pitch, and the directions of a rectangle that does
    not lie on its back."""
    if has_particles(case) and not case.screen.panels and not case.screen.surfaces:
        yield CaseProblem(
            ("screen", "panels"), "missing: there is nothing for particles to touch", kind="missing"
        )
    for key, panel in rows(case, "screen.panels"):
        yield from _one_span(key, panel)
        if panel.count > 1 and panel.pitch_m is None:
            yield CaseProblem(
                (*key, "pitch_m"), f"missing: count = {panel.count} panels need it", kind="missing"
            )
        yield from right_angle(key, panel, "along", "across")
        normal = np.cross(panel.along, panel.across)
        if normal[2] < -1e-9 * np.linalg.norm(normal):
            what = "makes the panel's upper side (along x across) face down"
            hint = "reverse it, and give the corner at the panel's other side"
            yield CaseProblem((*key, "across"), what, hint)


def _one_span(key: Key, panel: PanelTable) -> Iterator[CaseProblem]:
    if panel.tension_m is not None and panel.span_m is not None:
        what = "contradicts tension_m, which gives the span, too"
        yield CaseProblem((*key, "span_m"), what, "give one of the two")
    if panel.tension_m is None and panel.span_m is None:
        yield CaseProblem((*key, "tension_m"), "missing", "give tension_m or span_m", kind="missing")
    span = panel.span_m or panel.length_m + (panel.tension_m or 0.0)
    yield from _mounting(key, panel)
    if not 0.5 * panel.length_m <= span <= 1.5 * panel.length_m:
        given = "span_m" if panel.span_m is not None else "tension_m"
        what = f"the clamps are {span:g} m apart, the free length is {panel.length_m:g} m"
        yield CaseProblem((*key, given), what, "0.5 to 1.5 times that is possible", kind="out-of-range")
    needed_m = span + 2 * panel.clamp_m * math.cos(math.radians(panel.clamp_angle_deg))
    if panel.pitch_m is not None and panel.count > 1 and panel.pitch_m < needed_m:
        what = f"with {panel.pitch_m:g} m neighbouring panels overlap"
        hint = f"give at least {needed_m:g} m, which span and two clamps take"
        yield CaseProblem((*key, "pitch_m"), what, hint, kind="misplaced")


def _mounting(key: Key, panel: PanelTable) -> Iterator[CaseProblem]:
    """Check that only clamps with a depth hold an angle, and that a moulded sag is not too deep."""
    if panel.clamp_angle_deg and not panel.clamp_m:
        what = "is the angle of a clamp, and clamp_m = 0 is a hinge, which holds none"
        yield CaseProblem((*key, "clamp_angle_deg"), what, "give clamp_m, the length under each clamp")
    deepest_m = DEEPEST_SAG * panel.length_m
    if panel.moulded_sag_m > deepest_m:
        what = f"{panel.moulded_sag_m:g} m is too deep for a free length of {panel.length_m:g} m"
        yield CaseProblem(
            (*key, "moulded_sag_m"), what, f"at most {deepest_m:.3g} m is allowed", kind="out-of-range"
        )


def panel_integrator(case: Case) -> Iterator[CaseProblem]:
    """Check that the panels' solver has the integrator that the case names."""
    asked, able = case.panel.integrator, case.panel.adapter.integrators
    if asked not in able:
        others = solvers.names_able_to("panel", lambda panel: asked in panel.integrators)
        hint = f'take "{able[0]}", or panel.solver = {others}'
        what = f"the {case.panel.solver} is {' or '.join(able)} only"
        yield CaseProblem(("panel", "integrator"), what, hint, kind="solver")


def drawings(case: Case) -> Iterator[CaseProblem]:
    """Check that drawings fit their panels, and that all openings are within them and not half in a clamp."""
    for key, row in rows(case, "screen.panels"):
        if not isinstance(row.apertures, DrawnApertures):
            continue
        drawing, whole_m = row.apertures.drawing, (row.length_m + 2 * row.clamp_m, row.width_m)
        named = f'"{row.apertures.file}"'
        if drawing.sheet_m and not np.allclose(drawing.sheet_m, whole_m, rtol=0.0, atol=DRAWN_M):
            drawn, given = (f"{one_m:.6g} x {two_m:.6g} m" for one_m, two_m in (drawing.sheet_m, whole_m))
            what = f"{named} has a panel of {drawn}, the case has {given} with clamp_m at both ends"
            hint = "change length_m, width_m or clamp_m; or is it another unit, or turned (rotation_deg)?"
            yield CaseProblem((*key, "apertures", "file"), what, hint, kind="misplaced")
            continue
        corners_m = [np.array(outline) for outline in drawing.outlines_m]
        low_m, high_m = (np.array([pick(at, axis=0) for at in corners_m]) for pick in (np.min, np.max))
        leaves = ((low_m <= 0.0) | (high_m >= whole_m)).any(axis=1)
        edges_m = np.array([row.clamp_m, row.clamp_m + row.length_m])
        cut = ((low_m[:, :1] <= edges_m) & (high_m[:, :1] >= edges_m)).any(axis=1)
        under = (high_m[:, 0] < edges_m[0]) | (low_m[:, 0] > edges_m[1])
        for wrong, why, hint in (
            (leaves, "leave the panel or touch its edge", "the drawing begins at the clamp's outer edge"),
            (cut & (row.clamp_m > 0), "lie across the inner edge of a clamp", "change clamp_m, or move them"),
            (np.full(1, under.all()), "lie under the clamps, all of them", "change clamp_m, or turn it"),
        ):
            if wrong.any():
                s_mm, y_mm = 1e3 * (low_m + high_m)[np.argmax(wrong)] / 2
                many = f"{wrong.sum()} openings" if len(wrong) > 1 else "openings"
                what = f"{named}: {many} {why}, the first at ({s_mm:.4g}, {y_mm:.4g}) mm"
                yield CaseProblem((*key, "apertures", "file"), what, hint, kind="misplaced")
                break


def openings(case: Case) -> Iterator[CaseProblem]:
    """Check that openings leave enough land and fit into the panel, and that the panel is a plate."""
    for panel, *_ in perforated_panels(case):
        key: Key = ("screen", "panels", panel.table_name)
        pattern, thickness_m = panel.apertures, panel.table.thickness_m
        assert pattern is not None, "only panels with apertures are perforated"
        longest_m = max(pattern.pitch_along_m, pattern.pitch_across_m)
        in_pattern: Key = (*key, "apertures")
        regular = pattern.drawn is None
        if problems := (
            (regular and [*_lands(in_pattern, pattern, longest_m)])
            or (regular and [*_room(in_pattern, pattern, panel)])
            or [*_relief(in_pattern, pattern, longest_m)]
        ):
            yield from problems
        elif thickness_m > PLATE * longest_m:  # the theory for the lands only holds for plates
            what = (
                f"the panel is {thickness_m:g} m thick, its openings are only {longest_m:g} m apart: no plate"
            )
            yield CaseProblem(
                (*key, "thickness_m"), what, f"give at most {PLATE * longest_m:g} m", kind="out-of-range"
            )


def _lands(key: Key, pattern: AperturePattern, longest_m: float) -> Iterator[CaseProblem]:
    for way, size_m, pitch_m in (
        ("along", pattern.length_m, pattern.pitch_along_m),
        ("across", pattern.width_m, pattern.pitch_across_m),
    ):
        land_m = pitch_m - size_m
        if land_m <= 0:
            what = f"{pitch_m:g} m leaves no land between openings of {size_m:g} m {way}"
            yield CaseProblem(
                (*key, f"pitch_{way}_m"), what, f"give more than {size_m:g} m", kind="out-of-range"
            )
        elif land_m < THINNEST_LAND * longest_m:
            what = f"leaves lands of {land_m:.3g} m, too thin for a mesh"
            hint = f"leave at least {THINNEST_LAND:g} of the longer pitch"
            yield CaseProblem((*key, f"pitch_{way}_m"), what, hint, kind="out-of-range")


def _relief(key: Key, pattern: AperturePattern, longest_m: float) -> Iterator[CaseProblem]:
    """Yield a problem if the relief closes the openings, or leaves too little land below."""
    over = f"over {pattern.depth_m:g} m"
    smallest_m, _ = pattern.spheres_m
    land_m, least_m = pattern.land_m, THINNEST_LAND * longest_m
    widening_m = pattern.widening_m(pattern.depth_m)
    if smallest_m + 2 * widening_m <= 0:
        closed_deg = math.degrees(math.atan(smallest_m / 2 / pattern.depth_m))
        what = f"{pattern.relief_deg:g} degrees {over} closes openings of {smallest_m:g} m"
        hint = f"give more than -{closed_deg:.3g} degrees; with a positive angle openings widen downwards"
        yield CaseProblem((*key, "relief_deg"), what, hint, kind="out-of-range")
    elif land_m - 2 * widening_m < least_m:
        most_deg = math.degrees(math.atan((land_m - least_m) / 2 / pattern.depth_m))
        left_m = max(land_m - 2 * widening_m, 0.0)
        what = f"{pattern.relief_deg:g} degrees {over} leaves {left_m:.3g} m of lands of {land_m:.3g} m below"
        hint = f"give at most {most_deg:.3g} degrees, or a smaller depth_m"
        yield CaseProblem((*key, "relief_deg"), what, hint, kind="out-of-range")


def rims(case: Case) -> Iterator[CaseProblem]:
    """Check that openings with thin rims have no keys of deep ones."""
    for name, row in case.screen.panels.items():
        if row.apertures is None or row.apertures.rims == "deep":
            continue
        for field in ("depth_m", "relief_deg"):
            if getattr(row.apertures, field) is not None:
                key: Key = ("screen", "panels", name, "apertures", field)
                what = "is given, but the openings have thin rims, which have no depth"
                yield CaseProblem(key, what, 'take rims = "deep"')


def _room(key: Key, pattern: AperturePattern, panel: SinglePanel) -> Iterator[CaseProblem]:
    along, across = pattern.counts(panel.rectangle)
    length_m, width_m = panel.rectangle.length_m, panel.rectangle.width_m
    for way, count, whole_m, margin_m, pitch_m in (
        ("along", along, length_m, pattern.margin_along_m, pattern.pitch_along_m),
        ("across", across, width_m, pattern.margin_across_m, pattern.pitch_across_m),
    ):
        if count == 0 and pitch_m > whole_m:
            what = f"{pitch_m:g} m is larger than the panel, {whole_m:g} m"
            yield CaseProblem((*key, f"pitch_{way}_m"), what, kind="out-of-range")
        elif count == 0:
            left_m = max(whole_m - 2 * margin_m, 0.0)
            what = f"{margin_m:g} m at both ends leaves {left_m:.3g} m of the panel's {whole_m:g} m"
            yield CaseProblem(
                (*key, f"margin_{way}_m"), what, f"one pitch needs {pitch_m:g} m", kind="out-of-range"
            )


def triangles(case: Case) -> Iterator[CaseProblem]:
    """Check that the mesh generator can make triangles around the openings.

    If it is not installed, nothing is checked, and missing_solvers reports it.
    """
    if not perforated_panels(case):
        return
    from orchestrator.case.deck.triangle_grid import BadMesh, surface_grids

    try:
        surface_grids(case)
    except BadMesh as bad:
        yield CaseProblem(("panel", "surface_cells"), str(bad), kind="out-of-range")
    except SolverMissing:
        return


def mesh_memory(case: Case) -> Iterator[CaseProblem]:
    """Check that the panels' meshes fit into the allowed memory; the hint says what would fit."""
    needed_GiB = memory_GiB(case)
    if needed_GiB <= LARGEST_MESHES_GIB:
        return
    allowed = f"some {needed_GiB:.0f} GiB; at most {LARGEST_MESHES_GIB:g} GiB are allowed"
    sizes, panels = mesh_sizes(case).values(), single_panels(case)
    if not sizes:
        along, across = case.panel.cells
        what = f"{along} x {across} cells on each of {len(panels)} panels need {allowed}"
        yield CaseProblem(("panel", "cells"), what, "some ten to thirty along are usual", kind="out-of-range")
        return
    cells, unknowns = sum(size.cells for size in sizes), UNKNOWNS * sum(size.nodes for size in sizes)
    fits = max(panel.rectangle.width_m for panel in panels) * LARGEST_MESHES_GIB / needed_GiB
    hint = f'panels {int(1e3 * fits)} mm wide would fit: take a slice, or panel.solver = "sheet"'
    what = f"{cells} cells and {unknowns} unknowns on all panels need {allowed}"
    yield CaseProblem(("panel", "solver"), what, hint, kind="out-of-range")


def machine_memory(case: Case) -> Iterator[str]:
    """Yield a warning if meshes need more memory than the machine has.

    The system would end such a run without a message.
    """
    there_GiB = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / GIB
    needed_GiB = memory_GiB(case)
    if needed_GiB > there_GiB:
        yield (
            f"the panels' meshes need some {needed_GiB:.0f} GiB, this machine has "
            f"{there_GiB:.0f} GiB: fewer panel.cells, or a slice"
        )


def incompressible_mats(case: Case) -> Iterator[str]:
    """Yield a warning for each compressible material of panels whose solver keeps its volume.

    Such a solver has Young's modulus 3 mu in place of 9 K mu / (3 K + mu).
    """
    adapter = case.panel.adapter
    if adapter.compresses or not adapter.deforms:
        return
    for name in dict.fromkeys(panel.material for panel in case.screen.panels.values()):
        law = case.materials[name].hyperelastic
        assert law is not None, "complete_materials has passed"
        shear_Pa, bulk_Pa = 2.0 * (law.c10_Pa + law.c01_Pa), law.bulk_modulus_Pa
        kept_Pa, youngs_Pa = 3.0 * shear_Pa, 9.0 * bulk_Pa * shear_Pa / (3.0 * bulk_Pa + shear_Pa)
        if kept_Pa > (1.0 + COMPRESSES) * youngs_Pa:
            yield (
                f"materials.{name}.hyperelastic.bulk_modulus_Pa: {case.panel.solver} takes panels as "
                f"incompressible, with Young's modulus {kept_Pa:.3g} Pa; that of this material is "
                f"{youngs_Pa:.3g} Pa"
            )


def stops(case: Case) -> Iterator[CaseProblem]:
    """Check that stops lie between the clamps, and are not too stiff for the sync interval.

    The check takes the first panel of each row.
    """
    first = {panel.table_name: panel for panel in reversed(single_panels(case))}
    for key, stop in rows(case, "screen.panels.stops"):
        panel = first[str(key[2])]
        free_m = panel.table.length_m
        if stop.to_m > free_m * (1 + 1e-9):
            what = f"lies beyond the free length of {free_m:g} m"
            yield CaseProblem(
                (*key, "to_m"), what, "stops lie between the clamps' inner edges", kind="out-of-range"
            )
        if stop.from_m >= stop.to_m:
            yield CaseProblem((*key, "from_m"), f"is not before to_m = {stop.to_m:g} m", kind="out-of-range")
        if panel.table.material not in case.materials or stop.stiffness_Pa_per_m is None:
            continue
        most_Pa_per_m = stiffest_Pa_per_m(case, panel)
        if stop.stiffness_Pa_per_m > most_Pa_per_m:
            interval_s = case.coupling.sync_interval_s
            what = f"is too stiff for a sync interval of {interval_s:g} s: the panel would be kicked"
            hint = f"at most {most_Pa_per_m:.3g} Pa/m, or a shorter coupling.sync_interval_s"
            yield CaseProblem((*key, "stiffness_Pa_per_m"), what, hint, kind="out-of-range")
