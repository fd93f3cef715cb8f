"""The triangles that particles touch on each panel, panels of equal shape sharing theirs."""

from __future__ import annotations

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.deck.triangle_grid import TriangleGrid, grid
from orchestrator.case.file.contents import has_particles
from orchestrator.case.tables.case import Case
from orchestrator.ports.geometry import AperturePattern, Rectangle


def surface_grids(case: Case) -> dict[str, TriangleGrid]:
    """By the panel's name.  Raises SolverMissing (gmsh) and BadMesh for panels with apertures.

    Openings are resolved for particles only: without any, the surface is just looked at.
    """
    made: dict[object, TriangleGrid] = {}
    grids = {}
    for panel in single_panels(case):
        r = panel.rectangle
        apertures = panel.apertures if has_particles(case) else None
        shape = (r.length_m, r.width_m, r.clamp_m, apertures)
        if shape not in made:
            made[shape] = _grid(r, apertures, case.panel.surface_cells)
        grids[panel.name] = made[shape]
    return grids


def _grid(rectangle: Rectangle, apertures: AperturePattern | None, cells: tuple[int, int]) -> TriangleGrid:
    if apertures is None:
        return grid(rectangle, cells)
    from orchestrator.case.deck.perforated_grid import perforated_grid

    return perforated_grid(rectangle, apertures, cells)
