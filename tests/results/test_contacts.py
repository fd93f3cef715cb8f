"""The causes of a share that passes, against a stream whose contacts and chances are known."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from orchestrator.figures.material import Contacts
from orchestrator.output.results.contacts import contacts, fit_rate, rebuilt
from orchestrator.output.results.events import Events, EventTable, Exits
from orchestrator.ports.geometry import AperturePattern

EXITS = Exits(("under", "over"), ("undersize", "oversize"))
SLOTS = AperturePattern("slot", 0.020, 0.003, 0.025, 0.006)
NAMES, OPENINGS = ("deck-1", "deck-2"), (SLOTS, SLOTS)
CUT_M, GRAINS = 0.003, 20_000
SIZES_M, CHANCES = np.array([0.0015, 0.0022, 0.0028]), np.array([0.35, 0.20, 0.08])
CONTACTS_PER_S, STAY_S = np.array([4.0, 2.5]), np.array([0.45, 0.30])
WITHIN = 0.12  # of all time


def stream(chances: Any = CHANCES) -> Events:
    """Grains of three sizes over two panels; contacts come at random, and each lets one pass by the chance of
    its size, until the grain goes on after the panel's stay."""
    rng = np.random.default_rng(3)
    size = rng.integers(0, len(SIZES_M), GRAINS)
    hit = np.zeros((GRAINS, 2), dtype=int)
    over_s, last_panel, passed = np.zeros((GRAINS, 2)), np.full(GRAINS, -1), np.zeros(GRAINS, dtype=bool)
    for panel in range(2):
        for grain in np.flatnonzero(~passed):
            time_s = 0.0
            while (time_s := time_s + rng.exponential(1 / CONTACTS_PER_S[panel])) < STAY_S[panel]:
                hit[grain, panel] += 1
                last_panel[grain] = panel
                if rng.random() < chances[size[grain]]:
                    passed[grain] = True
                    break
            over_s[grain, panel] = min(time_s, STAY_S[panel])
    diameter_m = SIZES_M[size] * rng.uniform(0.999, 1.001, GRAINS)
    ids, came_s = np.arange(GRAINS), np.linspace(0.01, 9.0, GRAINS)
    mass_kg = diameter_m**3
    fed = EventTable(ids, came_s, diameter_m, mass_kg)
    removed = EventTable(
        *(ids, came_s + over_s.sum(axis=1), diameter_m, mass_kg, np.zeros((GRAINS, 3))),
        np.where(passed, 0, 1),
        *(hit, over_s, WITHIN * over_s, last_panel),
    )
    return Events(fed, removed, EXITS, np.arange(0.0, 10.1, 0.1))


@pytest.fixture(scope="module")
def result() -> Contacts:
    table = contacts(stream(), CUT_M, NAMES, OPENINGS)
    assert isinstance(table, Contacts)
    return table


def expected() -> float:
    """The share by mass that passes: contacts at random leave exp(-chance x their mean number)."""
    mass = SIZES_M**3
    left = np.exp(-CHANCES * float(CONTACTS_PER_S @ STAY_S))
    return 1.0 - float(mass @ left / mass.sum())


def test_what_was_put_in_comes_out(result: Contacts) -> None:
    """Tolerances are three standard deviations by counting of some 10^4 contacts."""
    along = {name: [getattr(row, name) for row in result.along] for name in vars(result.along[0])}
    assert along["panel"] == [*NAMES]
    assert along["contacts_per_s"] == pytest.approx(CONTACTS_PER_S, rel=0.03)
    assert along["stay_s"] == pytest.approx(STAY_S, rel=1e-9)
    assert along["within_reach_percent"] == pytest.approx([100 * WITHIN] * 2, rel=1e-9)
    there = result.sizes.particles > 0
    assert result.sizes.mean_m[there] == pytest.approx(SIZES_M, rel=1e-3)
    assert result.sizes.chance_percent[there] == pytest.approx(100 * CHANCES, rel=0.06)
    geometric = [(0.020 - d) * (0.003 - d) - (1 - math.pi / 4) * (0.003 - d) ** 2 for d in SIZES_M]
    gaudin = 100 * np.array(geometric) / (0.025 * 0.006)
    assert result.sizes.geometric_percent[there] == pytest.approx(gaudin, rel=5e-3)
    assert result.stay_s.value == pytest.approx(STAY_S.sum(), rel=1e-9)


def test_the_share_that_passes_is_rebuilt_from_stay_contacts_and_chance(result: Contacts) -> None:
    """The share is within a point of the closed form: three standard deviations of 20 000 grains by
    counting."""
    assert result.counted_percent == pytest.approx(100 * expected(), abs=1.0)
    assert result.rebuilt_percent == pytest.approx(100 * expected(), abs=1.0)
    assert result.rebuilt_percent == pytest.approx(result.counted_percent, abs=0.7)


def test_one_rate_fits_one_size() -> None:
    """Shares on the curve of one rate give it back; and four contacts a second for half a second, each with a
    chance of a quarter, leave exp(-0.5)."""
    time_s = np.array([0.2, 0.5, 0.9])
    rate_per_s, rms = fit_rate(time_s, 1 - np.exp(-0.77 * time_s))
    assert rate_per_s == pytest.approx(0.77, rel=1e-6)
    assert rms < 1e-8
    assert rebuilt(np.ones(1), np.array([0.25]), np.array([4.0]), np.array([0.5])) == pytest.approx(
        1 - math.exp(-0.5), rel=1e-12
    )


def test_too_few_fines_have_no_table() -> None:
    events = stream()
    few = Events(events.fed, events.removed.part(np.arange(GRAINS) < 60), EXITS, events.edges_s)
    reason = contacts(few, CUT_M, NAMES, OPENINGS)
    assert isinstance(reason, str)
    assert {"60", "100"} <= {*reason.split()}
    assert isinstance(contacts(stream(np.zeros(3)), CUT_M, NAMES, OPENINGS), str)


def test_where_all_that_left_had_passed_nothing_tells_how_long_others_stay() -> None:
    events = stream()
    through = events.removed.part((events.removed.last_panel == 0) & (events.removed.exit == 0))
    only_through = Events(events.fed, through, EXITS, events.edges_s)
    assert isinstance(contacts(only_through, CUT_M, NAMES, OPENINGS), str)
