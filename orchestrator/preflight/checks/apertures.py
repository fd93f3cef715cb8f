"""Openings in panels: a pattern that fits, lands that hold, triangles that are good."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.case.deck.panels import SinglePanel, perforated
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.tables.case import Case
from orchestrator.ports.geometry import AperturePattern
from orchestrator.ports.plans import SolverMissing

THINNEST_LAND = 0.02  # of the longer pitch: thinner ones no unit cell's mesh resolves
PLATE = 3.0  # thicknesses over an opening's larger pitch above which a panel is a block


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
    from orchestrator.case.deck.perforated_grid import BadMesh
    from orchestrator.case.deck.surface_grids import surface_grids

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
