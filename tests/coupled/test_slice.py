"""A slice against the whole machine: empty, and with a load that repeats itself across."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pytest

from orchestrator.ports import Array, ParticleSnapshot
from orchestrator.preflight.check import find_problems
from tests.cases import load_case
from tests.coupled.machines import Coupled, opened
from tests.coupled.screen import EMPTY

pytestmark = pytest.mark.solver
HALF = "slice.width_m=0.05"  # of 0.1 m
WHOLE = "slice.width_m=0.1"  # periodic, too


def centres_m(machine: Coupled) -> Array:
    return machine.machine.members.frames.pose().position_m


def moved_m(folder: Path, settings: Sequence[str]) -> Array:
    with opened(load_case(folder, EMPTY, settings)) as machine:
        start_m = centres_m(machine)
        machine.advance(400)
        return centres_m(machine) - start_m


def test_sheets_of_slices_of_any_width_move_alike(tmp_path: Path) -> None:
    """Their sides are joined, so that they do not contract across.  Sides are free to turn, which a sheet
    of 1 mm hardly feels: 2e-3, 1.3e-3 by measurement.  Free sides make more than ten times as much."""
    settings = ["panel.solver=sheet", "panel.cells=[6, 2]", "screen.panels.deck.thickness_m=0.001"]
    settings += ["screen.panels.deck.width_m=0.4", "frames.solver=two-mass"]  # 2.7 times as wide as long
    narrow, wide = (moved_m(tmp_path, [*settings, f"slice.width_m={width_m}"]) for width_m in (0.02, 0.09))
    np.testing.assert_allclose(narrow, wide, rtol=0.0, atol=2e-3 * np.abs(wide).max())
    walls = moved_m(tmp_path, [*settings, 'slice={width_m=0.02, sides="walls"}'])
    assert np.abs(walls - wide).max() > 2e-2 * np.abs(wide).max()


@pytest.mark.parametrize("frames", ["two-mass", "exudyn"])
@pytest.mark.parametrize("panel", ["rigid", "strip"])
def test_empty_frames_move_as_the_whole_machines(tmp_path: Path, frames: str, panel: str) -> None:
    """20 ms, four of them after run-up."""
    settings = [f"frames.solver={frames}", f"panel.solver={panel}"]
    whole = moved_m(tmp_path, settings)
    part = moved_m(tmp_path, [*settings, "slice.width_m=0.0123"])
    assert np.abs(whole).max() > 1e-3
    np.testing.assert_allclose(part, whole, rtol=0.0, atol=1e-9 * np.abs(whole).max())


OPENINGS = (
    "screen.panels.deck.apertures={length_m=0.012, width_m=0.004, pitch_along_m=0.016, pitch_across_m=0.006, "
    "margin_along_m=0.02, margin_across_m=0.015}"
)


@pytest.mark.parametrize("panel", ["rigid", "strip"])
def test_a_slice_is_as_stiff_and_heavy_as_its_part_of_a_panel_with_margins(
    tmp_path: Path, panel: str
) -> None:
    """Margins take 30 of 100 mm, 34 with the part of a pitch that is left over."""
    settings = [f"panel.solver={panel}", OPENINGS]
    whole = moved_m(tmp_path, settings)
    part = moved_m(tmp_path, [*settings, "slice.width_m=0.012"])
    solid = moved_m(tmp_path, settings[:1])
    size_m = np.abs(whole).max()
    assert np.abs(solid - whole).max() > 1e-4 * size_m
    np.testing.assert_allclose(part, whole, rtol=0.0, atol=1e-9 * size_m)


# in mm; the half is from y = 25 to 75: a pair that meets, spheres that run out of the half, and
# some that stay; the twin of each is 50 mm away
PLACES_MM = [[40, 29, 8], [40, 40, 8], [60, 45, 8], [90, 65, 9], [90, 55, 20], [120, 32, 9]]
SPEEDS_M_S = [[0, 0.4, -0.5], [0, -0.9, -0.5], [0.3, 2, 0], [0, 0, -0.5], [0, 0.1, -1], [0, -2, -1]]
LAWS = ["contacts.0.rolling_friction=0.05", "contacts.1.rolling_friction=0.05"]


def bed(twins: bool) -> list[str]:
    place_m = np.array(PLACES_MM) / 1000.0
    speed_m_per_s = np.array(SPEEDS_M_S, dtype=float)
    rows = list(zip(place_m, speed_m_per_s, strict=True))
    if twins:
        other = place_m + np.where(place_m[:, 1:2] < 0.05, 1, -1) * np.array([0.0, 0.05, 0.0])
        rows += zip(other, speed_m_per_s, strict=True)
    return [
        f'bed.particles.p{n}={{material="coal", sieve_size_m=0.01, '
        f"position_m={x.round(6).tolist()}, velocity_m_per_s={v.tolist()}}}"
        for n, (x, v) in enumerate(rows)
    ]


def run(folder: Path, settings: Sequence[str]) -> tuple[Array, Array, ParticleSnapshot]:
    """Frames' places, the load of each interval on the panels, and the particles at the end."""
    loaded = load_case(folder, EMPTY, [*settings, *LAWS, "particles.solver=liggghts"])
    problems = [str(mistake) for mistake in find_problems(loaded)]
    assert problems == [], problems
    loads = []
    with opened(loaded) as machine:
        for _ in range(400):
            loads.append(machine.advance(1).load.force_N.sum(axis=0))
        assert max(machine.momentum_residual().values()) < 1e-11
        return centres_m(machine), np.array(loads), machine.particles()


@pytest.mark.parametrize("panel", ["rigid", "strip"])
def test_half_the_width_with_half_the_load_is_half_the_machine(tmp_path: Path, panel: str) -> None:
    """Twelve spheres on the whole width, two by two 50 mm apart, against six on half of it: equal
    but for rounding, which impacts amplify.  Frames that do not turn: about x the twins turn the
    whole machine differently."""
    settings = ["frames.solver=two-mass", f"panel.solver={panel}", "panel.surface_cells=[13, 8]"]
    all_m, all_N, twins = run(tmp_path, [*settings, *bed(True), WHOLE])
    half_m, half_N, single = run(tmp_path, [*settings, *bed(False), HALF])
    assert np.count_nonzero(half_N[:, 2]) > 10
    np.testing.assert_allclose(half_m, all_m, rtol=0.0, atol=1e-9)
    np.testing.assert_allclose(2.0 * half_N, all_N, atol=1e-6 * np.abs(all_N).max())
    for twin in (twins.velocity_m_per_s[:6], twins.velocity_m_per_s[6:]):
        np.testing.assert_allclose(single.velocity_m_per_s, twin, atol=1e-6)
    crossed = single.position_m[:, 1] - np.array(PLACES_MM)[:, 1] / 1000.0
    assert (np.abs(crossed) > 0.02).any()  # some went round
