"""Karra's model against King's own program, and its partition."""

import math

import numpy as np
import pytest

from orchestrator.case.tables.bed import SizeClass
from orchestrator.preflight.sheet import karra
from orchestrator.preflight.sheet.area import Openings
from orchestrator.preflight.sheet.feed_shares import FeedShares

T_PER_H = 1 / 3.6


# The equations of the subroutines KARRA and FACTOR of R. P. King's MODSIM (SCRNMODS.FOR, 1985), compiled and
# run for square openings between wires, dry, on a top deck: throughfall aperture in mm, open share, capacity
# W G in t/h and m2, d50 in mm.
@pytest.mark.parametrize(
    ("opening_mm", "wire_mm", "slope_deg", "percent", "t_per_h_m2", "bulk", "expected"),
    [
        (6.35, 2.0, 20.0, (40, 35, 22), 12.0, 1500.0, (5.84643, 0.578328, 4.94838, 5.12805)),
        (12.0, 4.0, 15.0, (20, 60, 15), 20.0, 1602.0, (11.4548, 0.5625, 16.2214, 11.1053)),
        (80.0, 15.0, 18.0, (90, 5, 5), 9.0, 2000.0, (75.3504, 0.709141, 10.9733, 77.5939)),
        (3.0, 1.0, 0.0, (10, 85, 5), 9.0, 900.0, (3.0, 0.5625, 13.2136, 3.17544)),
    ],
)
def test_as_in_modsim(
    opening_mm: float,
    wire_mm: float,
    slope_deg: float,
    percent: tuple[float, float, float],
    t_per_h_m2: float,
    bulk: float,
    expected: tuple[float, float, float, float],
) -> None:
    throughfall_mm, open_share, capacity_t_per_h, d50_mm = expected
    assert (opening_mm / (opening_mm + wire_mm)) ** 2 == pytest.approx(open_share, rel=1e-5)
    seen_mm = (opening_mm + wire_mm) * math.cos(math.radians(slope_deg)) - wire_mm
    assert seen_mm == pytest.approx(throughfall_mm, rel=1e-5)
    openings = Openings(1e-3 * opening_mm, 1e-3 * opening_mm, open_share)
    shares = FeedShares(*(share / 100 for share in percent))
    capacity = karra.capacity_kg_per_m2_s(1e-3 * throughfall_mm, openings, shares, bulk)
    assert capacity == pytest.approx(capacity_t_per_h * T_PER_H, rel=1e-4)
    d50_m = karra.cut_size_m(1e-3 * throughfall_mm, t_per_h_m2 * T_PER_H / capacity)
    assert d50_m == pytest.approx(1e-3 * d50_mm, rel=1e-4)


def test_half_of_the_grains_of_d50_pass() -> None:
    assert karra.to_oversize(np.array([0.0, 5e-3, 1.0]), 5e-3) == pytest.approx([0.0, 0.5, 1.0])


def test_a_sheet_hides_openings_on_a_slope() -> None:
    assert karra.throughfall(0.006, 0.004, math.radians(20)) == pytest.approx(
        0.006 * 0.9396926 - 0.004 * 0.3420201
    )


def test_a_higher_load_passes_less() -> None:
    rows = [SizeClass(smallest_m=1e-3, largest_m=0.02, mass_fraction=1.0)]
    square = Openings(0.012, 0.012, 0.45)
    few, many = (karra.karra_screen(load, square, 0.005, 0.3, rows, 1500.0) for load in (1.0, 30.0))
    assert few is not None
    assert many is not None
    assert few.d50_m / many.d50_m == pytest.approx(30**0.148)
    assert 0.0 < many.passing < few.passing < 1.0
    assert few.capacity_kg_per_m2_s == many.capacity_kg_per_m2_s


def test_nothing_is_said_below_a_millimetre() -> None:
    rows = [SizeClass(smallest_m=1e-4, largest_m=0.02, mass_fraction=1.0)]
    assert karra.karra_screen(1.0, Openings(1e-3, 1e-3, 0.3), 0.002, 0.3, rows, 1500.0) is None
