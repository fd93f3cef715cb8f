"""The plan of the deck whose contacts with particles are counted."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from orchestrator.case.deck.line import deck_line, join_lines
from orchestrator.case.deck.openings import half_depths_m, smaller_sides_m
from orchestrator.case.deck.panels import SinglePanel, single_panels
from orchestrator.case.file.slice import period_m
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array, Indices
from orchestrator.ports.plans import DeckPlan

SOLID = (0.0, -1.0, 0.0, -1.0)
"""The bounds of the perforated part of a panel without openings: nothing lies between them."""


def deck_plan(
    case: Case, surface_m: Array, centre_lines: Sequence[Indices], drawn_m: Sequence[Array]
) -> DeckPlan | None:
    """Return the plan of the deck; None for a case without exits or openings, or without a single deck.

    ``surface_m`` (points, 3) is the surface at t = 0.  ``centre_lines`` has the numbers of each panel's
    points in it, in the order of the case, and ``drawn_m`` (n, 3) where these are while the panel is drawn
    straight between its clamps.
    """
    panels, widest_m = single_panels(case), max(smaller_sides_m(case), default=None)
    line = deck_line([surface_m[points] for points in centre_lines])
    if line is None or widest_m is None or not case.screen.exits:
        return None
    across = np.array([-line.along[1], line.along[0], 0.0])
    numbers = [np.full(len(points), number) for number, points in enumerate(centre_lines)]
    of_panel, places_m = join_lines(line.panels, numbers), join_lines(line.panels, drawn_m)
    order = [number for number, _ in line.panels]
    open_m = [
        _open_m(
            case, panels[number], places_m[of_panel == number], line.station_m[of_panel == number], across
        )
        for number in order
    ]
    return DeckPlan(
        along=line.along,
        across=across,
        points=join_lines(line.panels, centre_lines),
        panel=np.argsort(order)[of_panel],
        station_m=line.station_m,
        open_m=np.array(open_m),
        reach_m=widest_m,
        half_depth_m=np.array(half_depths_m(case))[order] if any(half_depths_m(case)) else None,
    )


def _open_m(
    case: Case, panel: SinglePanel, drawn_m: Array, station_m: Array, across: Array
) -> tuple[float, float, float, float]:
    """Return the lowest and highest station, then place across, of the perforated part of a panel.

    ``drawn_m`` (n, 3) and ``station_m`` (n,) belong to the points of its centre line.  A slice that goes on
    at its sides is perforated everywhere across.
    """
    if panel.apertures is None:
        return SOLID
    at = panel.rectangle
    (from_m, left_m), (to_m, right_m) = panel.apertures.region_m(at)
    s_m = (drawn_m - at.corner_m) @ at.along * (at.length_m / at.span_m)
    in_order = np.argsort(s_m)
    along_m = np.interp([from_m, to_m], s_m[in_order], station_m[in_order])
    across_m = at.corner_m @ across + np.array([left_m, right_m]) * (at.across @ across)
    sides = (-np.inf, np.inf) if period_m(case) else (float(across_m.min()), float(across_m.max()))
    return float(along_m.min()), float(along_m.max()), *sides
