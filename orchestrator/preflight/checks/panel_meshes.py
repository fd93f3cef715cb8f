"""Panels' meshes that no machine carries, or not this one."""

from __future__ import annotations

import os
from collections.abc import Iterator

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.errors import CaseProblem
from orchestrator.case.planning.panel_meshes import UNKNOWNS, memory_GiB, mesh_sizes
from orchestrator.case.tables.case import Case
from orchestrator.ports.plans import LARGEST_MESHES_GIB

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
