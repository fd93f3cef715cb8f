"""The FFS0827's cases: one machine and one coal in all of them."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from orchestrator.case.file.deck_layout import beams
from orchestrator.case.file.layers import read_toml
from orchestrator.case.tables.deck import Deck

CASES = Path(__file__).parents[2] / "cases"
LOADED = ("ffs0827-slice", "ffs0827", "ffs0827-panelpair", "ffs0827-effects", "banana")
OWN = {"side_plates", "cross_beams", "feed_chute"}  # what only a deck under coal has


def tables(case: str) -> dict[str, Any]:
    return read_toml(CASES / case / "case.toml")


def resolved(case: str) -> dict[str, Any]:
    """Return the tables of a case over those of the case that it names as its base."""
    own = tables(case)
    return merge(resolved(own.pop("base").removeprefix("../")), own) if "base" in own else own


def merge(below: dict[str, Any], above: dict[str, Any]) -> dict[str, Any]:
    nested = {
        key: merge(below[key], row) for key, row in above.items() if isinstance(row, dict) and key in below
    }
    return below | above | nested


@pytest.mark.parametrize("case", ["ffs0827-slice", "ffs0827"])
def test_the_machine_is_the_empty_one(case: str) -> None:
    empty, under_coal = tables("ffs0827-empty"), tables(case)
    for key in ("inclination_deg", "frames", "bushings", "exciters"):
        assert under_coal["screen"][key] == empty["screen"][key], key
    deck = {k: v for k, v in under_coal["screen"]["decks"]["deck"].items() if k not in OWN}
    assert deck == empty["screen"]["decks"]["deck"]
    assert under_coal["materials"]["PU"] == empty["materials"]["PU"]
    same = {name: probe for name, probe in empty["probes"].items() if "plate" not in name}
    assert under_coal["probes"] == same


def test_the_second_reading_is_the_same_with_and_without_material() -> None:
    empty, under_coal = tables("ffs0827-twelve-springs"), tables("ffs0827-flowing-twelve-springs")
    assert under_coal["screen"] == empty["screen"]


@pytest.mark.parametrize("case", ["ffs0827-slice", "ffs0827", "ffs0827-effects", "banana"])
def test_undersize_is_collected_as_far_as_the_deck_reaches(case: str) -> None:
    screen = tables(case)["screen"]
    deck = Deck.model_validate(screen["decks"]["deck"])
    end_m = float(beams(deck, screen["inclination_deg"])[-1][0])
    for name, row in screen["exits"].items():
        low, high = row["box_m"]
        if row["product"] == "undersize":
            assert high[0] <= end_m + 1e-3, name
        else:
            assert low[0] == pytest.approx(end_m, abs=1e-3), name


@pytest.mark.parametrize(
    ("machine", "of_two_panels"),
    [("ffs0827-empty", "ffs0827-panelpair"), ("ffs0827-twelve-springs", "ffs0827-panelpair-twelve-springs")],
)
def test_two_panels_have_a_quarter_of_the_machine(machine: str, of_two_panels: str) -> None:
    """Masses, exciter and the sums of stiffness and damping over the bushings."""
    whole, pair = (resolved(case)["screen"] for case in (machine, of_two_panels))
    for key in ("thickness_m", "length_m", "pitch_m", "apertures"):
        assert pair["decks"]["deck"][key] == whole["decks"]["deck"][key], key
    assert pair["exciters"]["shaft"]["speed_rad_per_s"] == whole["exciters"]["shaft"]["speed_rad_per_s"]
    assert pair["decks"]["deck"]["panels"] == whole["decks"]["deck"]["panels"] / 4
    for name, frame in whole["frames"].items():
        assert pair["frames"][name]["mass_kg"] == pytest.approx(frame["mass_kg"] / 4)
    for name, row in whole["bushings"].items():
        for key in ("stiffness_N_per_m", "damping_N_s_per_m"):
            ours = [len(pair["bushings"][name]["positions_m"]) * x for x in pair["bushings"][name][key]]
            theirs = [len(row["positions_m"]) * x for x in row[key]]
            assert ours == pytest.approx([x / 4 for x in theirs]), (name, key)
    moment = whole["exciters"]["shaft"]["mass_moment_kg_m"]
    assert pair["exciters"]["shaft"]["mass_moment_kg_m"] == pytest.approx(moment / 4)
    block = tables("ffs0827-panelpair")["bed"]["blocks"]["coal"]
    (size,) = block["sizes"]
    low, high = size["smallest_m"], size["largest_m"]
    each_kg = 1430.0 * 3.14159265 / 6 * (high**4 - low**4) / (4 * (high - low))
    assert block["count"] * each_kg / (0.8 * 0.675) == pytest.approx(149.0, rel=2e-3)


def test_all_coal_is_the_same() -> None:
    first = tables("ffs0827-slice")
    for case in LOADED[1:]:
        other = tables(case)
        assert other["contacts"] == first["contacts"], case
        assert other["materials"] == first["materials"], case
