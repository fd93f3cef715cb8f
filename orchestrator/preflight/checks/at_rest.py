"""What only the open panels can tell, before anything is computed: how they hang at rest, and what
they reach into."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.errors import CaseProblem
from orchestrator.case.tables.case import Case
from orchestrator.ports import Indices
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.penetration import Penetrations
from orchestrator.ports.plans import ParticleList
from orchestrator.preflight.checks.start import in_feed_box, in_surface


def beyond_surfaces(
    case: Case, penetrations: Penetrations, surface: TriangleSurface
) -> Iterator[CaseProblem]:
    """A panel that hangs through a surface or another panel, where the watch would stop the run."""
    found = penetrations.deepest(surface.position_m)
    if found is None or case.monitor.penetrated_surfaces != "stop":
        return
    if found.thicknesses > case.monitor.largest_penetration:
        table = {one.name: one.table_name for one in single_panels(case)}[found.panel]
        what = (
            f"panel {found.panel} hangs {found.depth_m:.3g} m through {found.surface} before anything moves"
        )
        hint = "tighten it, move one of them, or give the panel a stop where it is to lie"
        yield CaseProblem(("screen", "panels", table), what, hint)


def in_hanging_panels(
    case: Case, surface: TriangleSurface, panel_of_triangle: Indices, particles: ParticleList
) -> Iterator[CaseProblem]:
    """Particles, and boxes of feeds, that a panel at rest reaches into."""
    corners_m = surface.position_m[surface.triangles]
    for number, panel in enumerate(single_panels(case)):
        at_rest = f"panel {panel.name} as it hangs at rest"
        own_m = corners_m[panel_of_triangle == number]
        yield from in_surface(case, particles, at_rest, own_m)
        yield from in_feed_box(case, at_rest, own_m)
