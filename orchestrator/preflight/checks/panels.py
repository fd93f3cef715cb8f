"""Panels: their tables, openings, meshes, and the beams below them."""

from __future__ import annotations

import os
from collections.abc import Iterator

from orchestrator.case import solvers
from orchestrator.case.deck.panels import SinglePanel, perforated, single_panels, stiffest_Pa_per_m
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.solver_plans import UNKNOWNS, memory_GiB, mesh_sizes
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.case.tables.deck import Stop
from orchestrator.case.tables.screen import PanelTable
from orchestrator.ports.geometry import AperturePattern
from orchestrator.ports.plans import LARGEST_MESHES_GIB, SolverMissing
from orchestrator.preflight.checks.machine import right_angle

THINNEST_LAND = 0.02  # of the longer pitch: thinner ones no unit cell's mesh resolves
PLATE = 3.0  # thicknesses over an opening's larger pitch above which a panel is a block


def panel_rows(case: Case) -> Iterator[CaseProblem]:
    """One of tension and span, a pitch for a row, and directions that span a rectangle."""
    if has_particles(case) and not case.screen.panels and not case.screen.surfaces:
        yield CaseProblem(("screen", "panels"), "missing: there is nothing for particles to touch")
    for name, panel in case.screen.panels.items():
        key: Key = ("screen", "panels", name)
        yield from _one_span(key, panel)
        if panel.count > 1 and panel.pitch_m is None:
            yield CaseProblem((*key, "pitch_m"), f"missing: count = {panel.count} panels need it")
        yield from right_angle(key, "along", panel.along, "across", panel.across)


def _one_span(key: Key, panel: PanelTable) -> Iterator[CaseProblem]:
    if panel.tension_m is not None and panel.span_m is not None:
        hint = "give one of the two"
        yield CaseProblem((*key, "span_m"), "contradicts tension_m, which gives the span, too", hint)
    if panel.tension_m is None and panel.span_m is None:
        yield CaseProblem((*key, "tension_m"), "missing", "give tension_m or span_m")
    span = panel.span_m or panel.length_m + (panel.tension_m or 0.0)
    if not 0.5 * panel.length_m <= span <= 1.5 * panel.length_m:
        given = "span_m" if panel.span_m is not None else "tension_m"
        what = f"the clamps are {span:g} m apart, the free length is {panel.length_m:g} m"
        yield CaseProblem((*key, given), what, "0.5 to 1.5 of the free length is wanted")
    if panel.pitch_m is not None and panel.count > 1 and panel.pitch_m < span + 2 * panel.clamp_m:
        what = f"{panel.pitch_m:g} m lets neighbours overlap"
        hint = f"span and two clamps need {span + 2 * panel.clamp_m:g} m"
        yield CaseProblem((*key, "pitch_m"), what, hint)


def panel_integrator(case: Case) -> Iterator[CaseProblem]:
    """An integrator that the panels' solver does not have."""
    asked, able = case.panel.integrator, case.panel.adapter.integrators
    if asked not in able:
        others = solvers.those("panel", lambda panel: asked in panel.integrators)
        hint = f'take "{able[0]}", or panel.solver = {others}'
        what = f"the {case.panel.solver} is {' or '.join(able)} only"
        yield CaseProblem(("panel", "integrator"), what, hint)


def openings(case: Case) -> Iterator[CaseProblem]:
    """Openings that overlap, do not fit, leave too little land, or are too round."""
    for panel, *_ in perforated(case):
        name = panel.table_name
        key: Key = ("screen", "panels", name, "apertures")
        assert panel.apertures is not None, "only panels with apertures are perforated"
        found = [*_lands(key, panel.apertures)] or [*_room(key, panel)]
        yield from found or _thickness(key, panel, panel.apertures)


def triangles(case: Case) -> Iterator[CaseProblem]:
    """What the mesh generator makes of the openings.  One that is not installed is not asked:
    missing_solvers says so."""
    if not perforated(case):
        return
    from orchestrator.case.deck.triangle_grid import BadMesh, surface_grids

    try:
        surface_grids(case)
    except BadMesh as bad:
        yield CaseProblem(("panel", "surface_cells"), str(bad))
    except SolverMissing:
        return


def _lands(key: Key, apertures: AperturePattern) -> Iterator[CaseProblem]:
    for way, size_m, pitch_m in (
        ("along", apertures.length_m, apertures.pitch_along_m),
        ("across", apertures.width_m, apertures.pitch_across_m),
    ):
        pitch = f"pitch_{way}_m"
        land_m = pitch_m - size_m
        if land_m <= 0:
            what = f"{pitch_m:g} m leaves no land between openings of {size_m:g} m {way}"
            yield CaseProblem((*key, pitch), what, f"more than {size_m:g} m is wanted")
        elif land_m < THINNEST_LAND * max(apertures.pitch_along_m, apertures.pitch_across_m):
            what = f"leaves lands of {land_m:.3g} m, too thin for a mesh"
            hint = f"at least {THINNEST_LAND:g} of the longer pitch is wanted"
            yield CaseProblem((*key, pitch), what, hint)


def _room(key: Key, panel: SinglePanel) -> Iterator[CaseProblem]:
    apertures, rectangle = panel.apertures, panel.rectangle
    assert apertures is not None, "only panels with apertures are perforated"
    for way, count, whole_m, margin_m, pitch_m in zip(
        ("along", "across"),
        apertures.counts(rectangle),
        (rectangle.length_m, rectangle.width_m),
        (apertures.margin_along_m, apertures.margin_across_m),
        (apertures.pitch_along_m, apertures.pitch_across_m),
        strict=True,
    ):
        if count == 0 and pitch_m > whole_m:
            what = f"{pitch_m:g} m is larger than the panel, {whole_m:g} m"
            yield CaseProblem((*key, f"pitch_{way}_m"), what)
        elif count == 0:
            left_m = max(whole_m - 2 * margin_m, 0.0)
            what = f"{margin_m:g} m at both ends leaves {left_m:.3g} m of the panel's {whole_m:g} m"
            hint = f"one pitch needs {pitch_m:g} m"
            yield CaseProblem((*key, f"margin_{way}_m"), what, hint)


def _thickness(key: Key, panel: SinglePanel, apertures: AperturePattern) -> Iterator[CaseProblem]:
    """Plate theory for the lands needs a plate."""
    pitch_m = max(apertures.pitch_along_m, apertures.pitch_across_m)
    if panel.table.thickness_m > PLATE * pitch_m:
        what = (
            f"the panel is {panel.table.thickness_m:g} m thick, its openings are only "
            f"{pitch_m:g} m apart: no plate"
        )
        yield CaseProblem((*key[:-1], "thickness_m"), what, f"at most {PLATE * pitch_m:g} m is wanted")


GIB = 2**30


def too_large(case: Case) -> Iterator[CaseProblem]:
    """With what they need, and what would fit."""
    needed_GiB = memory_GiB(case)
    if needed_GiB <= LARGEST_MESHES_GIB:
        return
    allowed = f"some {needed_GiB:.0f} GiB; at most {LARGEST_MESHES_GIB:g} GiB are allowed"
    sizes = mesh_sizes(case).values()
    if not sizes:
        along, across = case.panel.cells
        panels = len(single_panels(case))
        what = f"{along} x {across} cells on each of {panels} panels need {allowed}"
        yield CaseProblem(("panel", "cells"), what, "some ten to thirty along are usual")
        return
    widest_m = max(panel.rectangle.width_m for panel in single_panels(case))
    what = (
        f"{sum(size.cells for size in sizes)} cells and "
        f"{UNKNOWNS * sum(size.nodes for size in sizes)} unknowns on all panels need {allowed}"
    )
    fits_mm = int(1e3 * widest_m * LARGEST_MESHES_GIB / needed_GiB)
    hint = f'panels {fits_mm} mm wide would fit: take a slice, or panel.solver = "sheet"'
    yield CaseProblem(("panel", "solver"), what, hint)


def beyond_this_machine(case: Case) -> Iterator[str]:
    """Where a run would be ended by the system, without a word, when its memory is used up."""
    there_GiB = os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / GIB
    needed_GiB = memory_GiB(case)
    if needed_GiB > there_GiB:
        yield (
            f"the panels' meshes need some {needed_GiB:.0f} GiB, this machine has "
            f"{there_GiB:.0f} GiB: fewer panel.cells, or a slice"
        )


def stops(case: Case) -> Iterator[CaseProblem]:
    """Each row of panels once."""
    rows = {panel.table_name: panel for panel in reversed(single_panels(case))}
    for table_name, panel in reversed(rows.items()):
        for name, stop in panel.table.stops.items():
            yield from _stop(("screen", "panels", table_name, "stops", name), case, panel, stop)


def _stop(key: Key, case: Case, panel: SinglePanel, stop: Stop) -> Iterator[CaseProblem]:
    free_m = panel.table.length_m
    if stop.to_m > free_m * (1 + 1e-9):
        what = f"lies beyond the free length of {free_m:g} m"
        yield CaseProblem((*key, "to_m"), what, "stops lie between the clamps' inner edges")
    if stop.from_m >= stop.to_m:
        yield CaseProblem((*key, "from_m"), f"is not before to_m = {stop.to_m:g} m")
    if panel.table.material not in case.materials or stop.stiffness_Pa_per_m is None:
        return
    most_Pa_per_m = stiffest_Pa_per_m(case, panel)
    if stop.stiffness_Pa_per_m > most_Pa_per_m:
        interval_s = case.coupling.sync_interval_s
        what = f"is too stiff for a sync interval of {interval_s:g} s: the panel would be kicked"
        hint = f"at most {most_Pa_per_m:.3g} Pa/m, or a shorter coupling.sync_interval_s"
        yield CaseProblem((*key, "stiffness_Pa_per_m"), what, hint)
