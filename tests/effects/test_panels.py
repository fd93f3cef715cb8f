"""Effects in the panels: each deciding number against a value worked out by hand, and what
follows from it."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.cases import BLOCK
from tests.effects.verdicts import APERTURES, of_driven, verdict


def test_load_by_hand(tmp_path: Path) -> None:
    """14.97 kg/m2 under the ball on 4.6 kg/m2."""
    judged = verdict(tmp_path, "particle-load")
    assert judged.verdict.value == pytest.approx(14.97 / 4.6, rel=1e-3)
    assert (judged.present, judged.verdict.matters) == (True, True)
    assert verdict(tmp_path, "particle-load", "exchange.particle_load=false").is_lacking
    assert verdict(tmp_path, "particle-load", "panel.solver=rigid").is_lacking


def test_deformation_and_deflection_by_hand(tmp_path: Path) -> None:
    """Sag 11.03 mm against 2 mm of the frame normal to the deck, and 4 mm of thickness."""
    sag_m = 2 / math.pi * math.sqrt(0.3e-3)
    judged = of_driven(tmp_path, "panel-deformation")
    assert judged.verdict.value == pytest.approx(sag_m / 0.002, rel=1e-9)
    assert of_driven(tmp_path, "panel-deformation", "panel.solver=rigid").is_lacking
    large = of_driven(tmp_path, "large-deflection").verdict
    assert large.value == pytest.approx(sag_m / 0.004, rel=1e-9)


def test_inertia_by_hand(tmp_path: Path) -> None:
    """80 rad/s against 123.9 rad/s."""
    judged = of_driven(tmp_path, "panel-inertia")
    assert judged.verdict.value == pytest.approx((80 / 123.9) ** 2, rel=2e-3)
    assert judged.verdict.matters


def test_hyperelasticity_by_hand(tmp_path: Path) -> None:
    """Stretched by 5 mm on 300: 2 (l - l^-2)(0.7 + 2.8 / l) / (21 (l - 1)) with l = 1.016667."""
    stretch = 1 + 0.005 / 0.3
    stress = 2 * (stretch - stretch**-2) * (0.7 + 2.8 / stretch)
    judged = of_driven(tmp_path, "hyperelasticity")
    assert judged.verdict.value == pytest.approx(1 - stress / (21 * 0.005 / 0.3), rel=1e-9)
    assert judged.verdict.value == pytest.approx(0.0293, rel=0.01)
    assert judged.verdict.matters is False
    assert not judged.is_spare, "no key takes it out"


def test_damping_needs_branches_to_be_judged(tmp_path: Path) -> None:
    assert of_driven(tmp_path, "panel-damping").verdict.matters is None
    branch = "materials.PU.hyperelastic.maxwell=[{ratio=0.2, relaxation_s=0.0125}]"
    judged = of_driven(tmp_path, "panel-damping", branch)
    assert judged.verdict.value == pytest.approx(2 * math.pi * 0.2 / 2.2, rel=1e-9)  # w tau = 1
    assert (judged.present, judged.verdict.matters) == (True, True)


def test_openings_against_the_smallest_particle(tmp_path: Path) -> None:
    assert verdict(tmp_path, "apertures").verdict.matters is None
    judged = verdict(tmp_path, "apertures", APERTURES, BLOCK)
    assert judged.verdict.value == pytest.approx(0.010 / 0.012)
    assert judged.verdict.matters


def test_openings_that_nothing_passes_still_take_mass(tmp_path: Path) -> None:
    """12 x 10 openings of 20 x 12 mm in 300 x 200 mm: 48 %."""
    judged = verdict(tmp_path, "apertures", APERTURES)
    assert judged.verdict.value == pytest.approx(0.48, rel=1e-9)
    assert judged.verdict.matters


def test_width_over_length(tmp_path: Path) -> None:
    narrow = verdict(tmp_path, "variation-across", "panel.solver=strip")
    assert narrow.verdict.value == pytest.approx(0.2 / 0.3)
    assert (narrow.present, narrow.verdict.matters) == (False, None)
    wide = verdict(tmp_path, "variation-across", "panel.solver=strip", "screen.panels.deck.width_m=0.8")
    assert wide.is_lacking


def test_a_beam_below_is_reached_where_the_sag_exceeds_the_gap(tmp_path: Path) -> None:
    """The gap in the middle of the length is measured by the sag itself; without beams there is no
    verdict."""
    assert of_driven(tmp_path, "beam-contact").verdict.matters is None
    slack = "screen.panels.deck.tension_m=-0.002"
    bar = "screen.panels.deck.stops.bar={from_m=0.14, to_m=0.16, gap_m=0.01}"
    judged = of_driven(tmp_path, "beam-contact", slack, bar)
    sag_m = 2 / math.pi * math.sqrt(0.3 * (0.003 + 0.002))
    assert judged.verdict.value == pytest.approx(sag_m / 0.01, rel=1e-3)
    assert (judged.present, judged.verdict.matters) == (True, True)
