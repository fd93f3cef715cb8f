"""Coarse-grained particles: what is scaled, and where they are refused."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.bed.adhesion import sjkr_diameter_m
from orchestrator.case.bed.sources import initial_particles, inlets
from orchestrator.case.file.errors import CaseError
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.preflight.check import warnings
from orchestrator.preflight.judge import JudgedCase, load_judged
from tests.case.test_apertures import SLOTTED
from tests.cases import BLOCK, CASE, FEED, case_folder, kinds, load_case

BALL = CASE[CASE.index("[bed.particles.ball]") : CASE.index("[probes")]
BED = BLOCK.replace("count=1,", "count=64,")
LUMPS = BED.replace("smallest_m=0.01,", "smallest_m=0.012,")  # four openings of 3 mm
COARSE = "particles.coarse_graining=2.0"
WET = "contacts.1.work_of_adhesion_J_per_m2=0.3"


def of(folder: Path, *overrides: str) -> JudgedCase:
    """The test case without its ball."""
    return load_case(folder, CASE.replace(BALL, ""), overrides)


def test_what_is_sampled_is_scaled_too(tmp_path: Path) -> None:
    """The rate of the computed part stays: of diameters twice as large, the same share is sampled."""
    lumps = FEED.replace("smallest_m=0.01,", "smallest_m=0.012,")
    sampled = lumps.replace("sizes", "sampled_below_m=0.015, sampled_as_m=0.018, sizes")
    rates = []
    for coarse in ([], [COARSE]):
        case = of(tmp_path, sampled, *coarse).case
        rates.append(inlets(case)["chute"].rate_kg_per_s)
    assert rates[0] < 0.95
    assert rates[1] == pytest.approx(rates[0], rel=1e-12)


def test_mass_stays_and_numbers_fall(tmp_path: Path) -> None:
    masses_kg, counts = [], []
    for coarse in ([], [COARSE]):
        case = of(tmp_path, BED, *coarse).case
        made = initial_particles(case)
        counts.append(len(made))
        masses_kg.append(np.sum(np.pi / 6 * made.grains.sieve_size_m**3 * made.grains.density_kg_per_m3))
    assert counts == [64, 8]
    assert masses_kg[1] == pytest.approx(masses_kg[0], rel=0.15)  # of 8 at random


def test_sizes_and_works_of_adhesion_grow(tmp_path: Path) -> None:
    fine, coarse = (of(tmp_path, FEED, WET, *more).case for more in ([], [COARSE]))
    assert coarse.contacts[1].work_of_adhesion_J_per_m2 == pytest.approx(0.6)
    fine_inlet, coarse_inlet = (inlets(case)["chute"] for case in (fine, coarse))
    assert coarse_inlet.rate_kg_per_s == fine_inlet.rate_kg_per_s
    for small, large in zip(fine_inlet.sizes, coarse_inlet.sizes, strict=True):
        assert large.smallest_m == pytest.approx(2 * small.smallest_m)
        assert large.largest_m == pytest.approx(2 * small.largest_m)
        assert large.mass_fraction == small.mass_fraction


def test_a_mass_that_whole_numbers_change_is_told(tmp_path: Path) -> None:
    """40 particles are 5 coarse ones, 12 are 1.5, and 2 are computed."""
    for count, texts in (
        (40, []),
        (12, ["1.5 of its particles would have its mass here, and 2 are computed"]),
    ):
        lines = warnings(of(tmp_path / str(count), BED.replace("count=64", f"count={count}"), COARSE))
        changes = [line for line in lines if "its mass changes" in line]
        assert [text in line for text, line in zip(texts, changes, strict=True)] == [True] * len(texts)


def test_the_diameter_of_the_pull_off_grows_with_the_particles(tmp_path: Path) -> None:
    """The strength of sjkr is then that of the fine particles: the force grows as k squared, as JKR's."""
    given = [BED, WET, "particles.sjkr_diameter_m=0.006"]
    fine, coarse = (of(tmp_path, *given, *more).case for more in ([], [COARSE]))
    assert sjkr_diameter_m(coarse) == 2 * sjkr_diameter_m(fine) == 0.012


def test_the_resolved_case_is_the_same_case(tmp_path: Path) -> None:
    first = of(tmp_path, BED, WET, COARSE, "particles.sjkr_diameter_m=0.006")
    again = load_judged(case_folder(tmp_path / "again", resolved_case(first)))
    assert again.case.bed == first.case.bed  # and not coarser still
    assert again.case.contacts == first.case.contacts
    assert again.case.particles == first.case.particles
    assert resolved_case(again) == resolved_case(first)


def test_it_is_named_as_left_out(tmp_path: Path) -> None:
    reason = of(tmp_path, BED, COARSE).left_out["single-particles"]
    assert reason.startswith("particles.coarse_graining:")
    assert reason.endswith("8")  # of the volume, 2^3


def test_single_particles_stand_for_themselves(tmp_path: Path) -> None:
    assert kinds(tmp_path, COARSE) == ["particles.coarse_graining: conflict"]


def test_refused_across_openings(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="openings of 0"):
        of(tmp_path, BED, SLOTTED, COARSE)
    with pytest.raises(CaseError, match="openings of 0"):
        of(tmp_path, FEED, SLOTTED, COARSE)
    assert of(tmp_path, LUMPS, SLOTTED, COARSE).case.bed.blocks["coal"].count == 8
    wider = (  # openings of 4 mm: 16 mm are wanted
        'screen.panels.wide={material="PU", frames=["driving", "ground"], corner_m=[0, 0, -0.5], '
        "length_m=0.3, width_m=0.2, thickness_m=0.004, tension_m=0, "
        "apertures={length_m=0.012, width_m=0.004, pitch_along_m=0.015, pitch_across_m=0.006}}"
    )
    with pytest.raises(CaseError, match=r"of 0\.012 m: coarse ones do not meet openings of 0\.004 m"):
        of(tmp_path, LUMPS, SLOTTED, wider, COARSE)
    (tmp_path / "grains.csv").write_text("x_m,y_m,z_m,sieve_size_m,material\n0.1,0.1,0.1,0.016,coal\n")
    with pytest.raises(CaseError, match=r"the bed from .*grains\.csv has particles of 0\.008 m"):
        of(tmp_path, "bed.table=grains.csv", SLOTTED, COARSE)
