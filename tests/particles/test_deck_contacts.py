"""Contacts with a deck, counted panel by panel, and the time over it and within reach of it."""

from __future__ import annotations

import math
from contextlib import closing
from dataclasses import replace

import numpy as np
import pytest

from orchestrator.ports import Removed
from orchestrator.ports.adapters import ParticlesAdapter
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import DeckPlan, ExitPlan
from tests.particles.contract import SOLVERS, Run, particles, plan, plate, table
from tests.particles.test_openings import PANEL, SQUARES, still

ASKED = SOLVERS

HALF_M, CELLS = 0.05, 10
DIAMETER_M, ALONG_M_PER_S, GAP_M = 3e-3, 0.8, 5e-3
START_M, RESTITUTION, G_M_PER_S2, REACH_M = -0.04, 0.6, 9.81, 1.5e-3
INTERVAL_S = 5e-4
BELOW = ExitPlan("below", "undersize", np.array([0.0, 0.0, -0.07]), np.eye(3), np.array([0.5, 0.5, 0.05]))
BEHIND = ExitPlan("behind", "oversize", np.array([0.16, 0.0, 0.0]), np.eye(3), np.array([0.1, 0.5, 0.5]))


def two_panels() -> tuple[TriangleSurface, DeckPlan]:
    """A plate whose halves, upstream and downstream of x = 0, are two panels, open up to their ends."""
    surface = plate(HALF_M, CELLS)
    middle_m = surface.position_m[surface.triangles].mean(axis=1)
    surface = replace(surface, panel=(middle_m[:, 0] > 0).astype(np.int64))
    line = np.flatnonzero(np.abs(surface.position_m[:, 1]) < 1e-9)
    first, second = (line[sign * surface.position_m[line, 0] > -1e-9] for sign in (-1, 1))
    points = np.concatenate([first, second])
    deck = DeckPlan(
        along=np.array([1.0, 0.0, 0.0]),
        across=np.array([0.0, 1.0, 0.0]),
        points=points,
        panel=np.repeat([0, 1], [len(first), len(second)]),
        station_m=surface.position_m[points, 0] + HALF_M,
        open_m=np.array([[0.0, HALF_M, -HALF_M, HALF_M], [HALF_M, 2 * HALF_M, -HALF_M, HALF_M]]),
        reach_m=REACH_M,
    )
    return surface, deck


def hopping(module: ParticlesAdapter, open_m: float = HALF_M) -> Removed:
    """Return the record of a ball that hops over both panels; they are open up to ``open_m`` across."""
    surface, deck = two_panels()
    deck.open_m[:, 3] = open_m
    wanted = plan(
        surface,
        particles([START_M, 0.001, DIAMETER_M / 2 + GAP_M], (ALONG_M_PER_S, 0.0, 0.0), diameter_m=DIAMETER_M),
        deck=deck,
        exits=(BELOW, BEHIND),
        restitution=table(RESTITUTION),
        sliding_friction=table(0.0),
        sync_interval_s=INTERVAL_S,
    )
    with closing(module.build(wanted)) as solver:
        Run(solver, wanted).advance(280)
        return solver.removed()


def test_a_hopping_ball_is_counted_hop_by_hop(module: ParticlesAdapter) -> None:
    """The ball without friction keeps its speed along. It falls from 5 mm, hops to e^2 times that, 1.8 mm,
    and then to 0.65 mm, which is less than a quarter of its diameter: from the second hit on it is one
    contact. Times by free fall; each is off by two intervals at most, for a contact's length too."""
    first_s = math.sqrt(2 * GAP_M / G_M_PER_S2)
    second_s = first_s + 2 * RESTITUTION * first_s
    at_m = [START_M + ALONG_M_PER_S * hit_s for hit_s in (first_s, second_s)]
    assert at_m[0] < 0.0 < at_m[1]  # one hit on each panel
    gone = hopping(module)
    assert gone.contacts.tolist() == [[1, 1]]
    assert gone.last_panel.tolist() == [1]
    assert gone.exit.tolist() == [1]
    panels_s = np.array([-START_M, HALF_M]) / ALONG_M_PER_S
    assert gone.over_s[0] == pytest.approx(panels_s, abs=2 * INTERVAL_S)
    falls_into_reach_s = math.sqrt(2 * (GAP_M - REACH_M) / G_M_PER_S2)
    apex_s, apex_m = (first_s + second_s) / 2, RESTITUTION**2 * GAP_M
    beyond_s = math.sqrt(2 * (apex_m - REACH_M) / G_M_PER_S2)  # to either side of the apex
    within_s = [apex_s - beyond_s - falls_into_reach_s, panels_s.sum() - apex_s - beyond_s]
    assert gone.within_reach_s[0] == pytest.approx(within_s, abs=3 * INTERVAL_S)


def test_a_hit_beside_the_openings_does_not_count(module: ParticlesAdapter) -> None:
    """The ball hops 1 mm beside the middle, where the panel is solid now."""
    assert hopping(module, open_m=0.0).contacts.tolist() == [[0, 0]]


def test_passing_without_a_touch_is_a_contact_too(module: ParticlesAdapter) -> None:
    """A ball of 4 mm falls through the middle of a square of 10 mm, and another one lands on a land."""
    surface = still(SQUARES)
    line_m = np.array([[0.0, 0.15, 0.0], [0.3, 0.15, 0.0]])
    points = len(surface.position_m) + np.arange(2)
    surface = replace(
        surface,
        position_m=np.vstack([surface.position_m, line_m]),
        panel=np.zeros(len(surface.triangles), dtype=np.int64),
    )
    (from_m, left_m), (to_m, right_m) = SQUARES.region_m(PANEL)
    deck = DeckPlan(
        *np.eye(3)[:2],
        points=points,
        panel=np.zeros(2, dtype=np.int64),
        station_m=np.array([0.0, 0.3]),
        open_m=np.array([[from_m, to_m, left_m, right_m]]),
        reach_m=0.01,
    )
    hole_m = SQUARES.centres_m(PANEL)[25]
    pitch_m = np.array([SQUARES.pitch_along_m, SQUARES.pitch_across_m])
    places_m = [[*hole_m, 4e-3], [*(hole_m + pitch_m / 2), 4e-3]]
    wanted = plan(
        surface,
        particles(places_m, diameter_m=0.004),
        deck=deck,
        exits=(BELOW,),
        restitution=table(0.2),
        sync_interval_s=1e-3,
    )
    with closing(module.build(wanted)) as solver:
        Run(solver, wanted).advance(120)
        gone = solver.removed()
    assert gone.id.tolist() == [1]
    assert gone.contacts.tolist() == [[1]]
    assert gone.last_panel.tolist() == [0]
