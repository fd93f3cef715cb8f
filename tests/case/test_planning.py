"""Plans from cases: deck axes, rows of panels, drives, tables of pairs."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.bed.grains import material_numbers
from orchestrator.case.bed.sources import inlets
from orchestrator.case.deck.panels import axes, single_panels, to_world
from orchestrator.case.solver_plans import exits, frames_plan, panel_plans, particles_plan
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import FramesPlan, ParticlesPlan
from tests.cases import loaded

NO_POINTS = np.zeros((0, 3))
TURNED = "screen.inclination_deg=30"
DRIVE = (
    "screen.frames.driving.drive={speed_rad_per_s=80, amplitude_m=[0.003, 0, 0.004], "
    "phase_rad=[0, 0, 1.5707963267948966], rotation_rad=[0, 0.01, 0], center_m=[1, 0, 0]}"
)


def frames(folder: Path, *overrides: str) -> FramesPlan:
    return frames_plan(loaded(folder, overrides).case, NO_POINTS, (), NO_POINTS)


def particles(folder: Path, *overrides: str) -> ParticlesPlan:
    empty = np.zeros((0, 3), dtype=np.int64)
    plan = particles_plan(loaded(folder, overrides).case, TriangleSurface(NO_POINTS, empty, empty))
    assert plan is not None
    return plan


def test_the_deck_slopes_down_along_x_and_gravity_does_not_turn(tmp_path: Path) -> None:
    case = loaded(tmp_path, [TURNED]).case
    assert to_world(case, (1.0, 0.0, 0.0)) == pytest.approx([math.sqrt(0.75), 0.0, -0.5])
    assert axes(case) @ axes(case).T == pytest.approx(np.eye(3))
    assert np.linalg.det(axes(case)) == pytest.approx(1.0)
    assert panel_plans(case)[0].gravity_m_per_s2.tolist() == [0.0, 0.0, -9.81]


def test_a_row_of_panels_alternates_its_frames(tmp_path: Path) -> None:
    row = ["screen.panels.deck.count=3", "screen.panels.deck.pitch_m=0.34", TURNED]
    panels = single_panels(loaded(tmp_path, row).case)
    assert [p.name for p in panels] == ["deck-1", "deck-2", "deck-3"]
    assert [p.frames[0] for p in panels] == ["driving", "ground", "driving"]
    apart = panels[2].rectangle.corner_m - panels[0].rectangle.corner_m
    assert apart == pytest.approx(0.68 * panels[0].rectangle.along)
    assert panels[0].rectangle.along[2] == pytest.approx(-0.5)
    assert panels[0].rectangle.normal == pytest.approx([0.5, 0.0, math.sqrt(0.75)])


def test_tension_and_span_say_the_same(tmp_path: Path) -> None:
    (by_tension,) = single_panels(loaded(tmp_path).case)
    assert by_tension.rectangle.span_m == pytest.approx(0.302)


def test_frames_and_bushings_turn_with_the_deck(tmp_path: Path) -> None:
    turn = ["screen.bushings.isolation.rotation_deg=[0, -30, 0]", TURNED]
    plan = frames(tmp_path, *turn, "screen.frames.driving.products_of_inertia_kg_m2=[0.1, 0, 0]")
    first, second = plan.bushings
    assert (first.name, second.name) == ("isolation-1", "isolation-2")
    assert first.axes == pytest.approx(np.eye(3), abs=1e-12)  # turned back to the world's
    assert first.stiffness_N_per_m.tolist() == [2e4, 3e4, 4e4]
    along = np.array([math.sqrt(0.75), 0.0, -0.5])
    inertia = plan.bodies[0].inertia_kg_m2
    assert along @ inertia @ along == pytest.approx(2.0)
    assert along @ inertia @ [0, 1, 0] == pytest.approx(0.1)
    assert plan.exciters[0].start == pytest.approx([0.5, 0.0, math.sqrt(0.75)])


def test_the_axes_of_a_turned_bushing_are_the_rows(tmp_path: Path) -> None:
    plan = frames(tmp_path, "screen.bushings.isolation.rotation_deg=[0, 0, 90]")
    assert plan.bushings[0].axes == pytest.approx(np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]), abs=1e-12)


def test_a_drive_in_deck_axes_is_the_same_motion_in_the_world(tmp_path: Path) -> None:
    given = ["frames.solver=prescribed", DRIVE, TURNED]
    plan, case = frames(tmp_path, *given), loaded(tmp_path, given).case
    assert plan.bushings == ()
    assert plan.exciters == ()
    (drive,) = plan.drives
    for angle in np.linspace(0.0, 6.0, 7):
        in_deck = [0.003 * math.sin(angle), 0.0, 0.004 * math.cos(angle)]
        in_world = drive.amplitude_m * np.sin(angle + drive.phase_rad)
        assert in_world == pytest.approx(to_world(case, in_deck), abs=1e-15)
    assert drive.rotation_rad == pytest.approx([0.0, 0.01, 0.0])
    assert drive.center_m == pytest.approx(to_world(case, (1.0, 0.0, 0.0)))


def test_exudyn_gets_drives_along_with_bushings_and_exciters(tmp_path: Path) -> None:
    plan = frames(tmp_path, DRIVE)
    assert [drive.body for drive in plan.drives] == ["driving"]
    assert len(plan.bushings) == 2
    assert len(plan.exciters) == 1


def test_pairs_of_materials_are_symmetric(tmp_path: Path) -> None:
    plan = particles(tmp_path, "contacts.0.rolling_friction=0.09")
    assert [material.name for material in plan.materials] == ["PU", "coal"]
    assert plan.restitution.tolist() == [[1.0, 0.34], [0.34, 0.13]]
    assert plan.rolling_friction.tolist() == [[0.0, 0.09], [0.09, 0.0]]
    assert plan.particles.grains.material.tolist() == [1]
    level = ("contacts.0.rolling_friction=0.09", 'particles.rolling="none"')
    assert not particles(tmp_path, *level).rolling_friction.any()


def test_materials_that_touch_nothing_get_no_number(tmp_path: Path) -> None:
    steel = "materials.aa={density_kg_per_m3=7850, youngs_modulus_Pa=2e11, poisson_ratio=0.3}"
    assert material_numbers(loaded(tmp_path, [steel]).case) == {"PU": 0, "coal": 1}


BLOCK = (
    'bed.blocks.coal={material="coal", axes="AXES", box_m=[[0, 0, 0.2], [0.2, 0.2, 0.3]], '
    "count=20, velocity_m_per_s=[1, 0, 0], "
    "sizes=[{smallest_m=0.01, largest_m=0.02, mass_fraction=1}]}"
)


def test_a_block_lies_in_its_box_in_the_axes_it_names(tmp_path: Path) -> None:
    for name in ("deck", "world"):
        given = [BLOCK.replace("AXES", name), TURNED]
        placed, case = particles(tmp_path, *given).particles, loaded(tmp_path, given).case
        turn = axes(case) if name == "deck" else np.eye(3)
        inside = placed.position_m[1:] @ turn
        assert len(placed) == 21
        assert (inside > [0.0, 0.0, 0.2]).all()
        assert (inside < [0.2, 0.2, 0.3]).all()
        assert placed.velocity_m_per_s[1:] @ turn == pytest.approx(np.tile([1.0, 0.0, 0.0], (20, 1)))
        assert placed.velocity_m_per_s[0].tolist() == [0.0, 0.0, 0.0]


def test_an_exit_is_the_box_that_the_case_gives(tmp_path: Path) -> None:
    """The corners of a box of 0.4 m by 0.2 m by 0.1 m, in the axes of a deck that slopes by 30 degrees."""
    box = 'screen.exits.under={product="undersize", box_m=[[0, 0, -0.5], [0.4, 0.2, -0.4]]}'
    case = loaded(tmp_path, [box, TURNED]).case
    (under,) = exits(case)
    low, high = np.array([0.0, 0.0, -0.5]), np.array([0.4, 0.2, -0.4])
    for corner_m in (low, high):
        middle_m = (low + high) / 2
        inside, outside = (middle_m + times * (corner_m - middle_m) for times in (0.999, 1.001))
        assert under.holds(to_world(case, inside)[None]).all()
        assert not under.holds(to_world(case, outside)[None]).any()


def test_a_feed_without_its_fines_feeds_the_rest_of_its_rate(tmp_path: Path) -> None:
    """The 0.3 of 2 kg/s that are finer than 4 mm are not fed."""
    feed = (
        'bed.feeds.coal={material="coal", rate_kg_per_s=2, box_m=[[0, 0, 0.2], [0.1, 0.2, 0.3]], '
        "velocity_m_per_s=[0, 0, -1], smallest_fed_m=0.004, sizes=["
        "{smallest_m=0.002, largest_m=0.004, mass_fraction=0.3}, "
        "{smallest_m=0.004, largest_m=0.02, mass_fraction=0.7}]}"
    )
    case = loaded(tmp_path, [feed]).case
    inlet = inlets(case)["coal"]
    assert inlet.rate_kg_per_s == pytest.approx(1.4)
    assert inlet.due_kg(3.0) == pytest.approx(4.2)


def test_feeds_are_handed_over_as_one(tmp_path: Path) -> None:
    feed = (
        'bed.feeds.NAME={material="coal", rate_kg_per_s=1, box_m=[[X, 0, 0.2], [Y, 0.2, 0.3]], '
        "velocity_m_per_s=[0, 0, -1], sizes=[{smallest_m=0.01, largest_m=0.02, mass_fraction=1}]}"
    )
    first = feed.replace("NAME", "one").replace("X", "0").replace("Y", "0.1")
    second = feed.replace("NAME", "two").replace("X", "0.2").replace("Y", "0.3")
    plan = particles(tmp_path, first, second)
    assert plan.feed is not None
    assert plan.largest_radius_m == 0.01
    offered = plan.feed.due(Interval(1000, 1e-4))  # 0.1 s: 0.2 kg
    assert np.pi / 6 * 1430 * np.sum(offered.grains.sieve_size_m**3) == pytest.approx(0.2, abs=0.006)
    assert set(offered.grains.material.tolist()) == {1}
