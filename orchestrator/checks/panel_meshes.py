"""Panels' meshes that no machine carries."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.casefile.case import Case
from orchestrator.casefile.errors import Mistake
from orchestrator.deck.panel_meshes import UNKNOWNS, mesh_sizes
from orchestrator.deck.panels import single_panels
from orchestrator.plans import LARGEST_MESHES_GIB


def too_large(case: Case) -> Iterator[Mistake]:
    """With what they need, and how wide panels could be."""
    sizes = mesh_sizes(case).values()
    needed_GiB = sum(size.memory_GiB for size in sizes)
    if needed_GiB <= LARGEST_MESHES_GIB:
        return
    widest_m = max(panel.rectangle.width_m for panel in single_panels(case))
    what = (
        f"{sum(size.cells for size in sizes)} cells and "
        f"{UNKNOWNS * sum(size.nodes for size in sizes)} unknowns on all panels need some "
        f"{needed_GiB:.0f} GiB; at most {LARGEST_MESHES_GIB:g} GiB are allowed"
    )
    fits_mm = int(1e3 * widest_m * LARGEST_MESHES_GIB / needed_GiB)
    hint = f'panels {fits_mm} mm wide would fit: take a slice, or panel.solver = "sheet"'
    yield Mistake(("panel", "solver"), what, hint)
