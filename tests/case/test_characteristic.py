"""Characteristics and temperatures of bushings: their files, their plans, and what a user is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.solver_plans import bushings
from orchestrator.coupling.bushing_forces import BushingForces
from orchestrator.ports import Array, Pose
from orchestrator.ports.plans import BodyPlan, CharacteristicPlan
from tests.cases import kinds, loaded, only_complaint

OF = "screen.bushings.isolation"
PROGRESSIVE = "deformation_m=[-0.01, -0.002, 0.0, 0.004, 0.006], force_N=[-440.0, -40.0, 0.0, 80.0, 480.0]"


def characteristic(row: str) -> str:
    return f"{OF}.characteristics=[{{{row}}}]"


def plan(tmp_path: Path, row: str, *sets: str) -> CharacteristicPlan:
    """The plan along x of the first isolation spring, which has 20 kN/m there."""
    (law,) = bushings(loaded(tmp_path, [characteristic(row), *sets]).case)[0].characteristics
    return law


def force_N(law: CharacteristicPlan, deformation_m: Array) -> Array:
    return law.elastic_N_per_m * deformation_m + law.gap_force_N(deformation_m)


def test_spring_and_gap_springs_give_the_points_and_go_on_beyond_them(tmp_path: Path) -> None:
    law = plan(tmp_path, PROGRESSIVE)
    at_m = np.array([-0.012, -0.01, -0.006, -0.002, 0.0, 0.003, 0.004, 0.005, 0.006, 0.007])
    expected_N = [-540.0, -440.0, -240.0, -40.0, 0.0, 60.0, 80.0, 280.0, 480.0, 680.0]
    assert force_N(law, at_m) == pytest.approx(expected_N, abs=1e-9)
    assert law.elastic_N_per_m == pytest.approx(2e4)


def test_a_stop_has_no_force_before_its_gap(tmp_path: Path) -> None:
    """One side only, in units of a data sheet, and with a corner at zero."""
    row = 'deformation_m=["0 mm", "4 mm", "5 mm"], force_N=["0 kN", "0 kN", "2 kN"]'
    law = plan(tmp_path, row)
    assert force_N(law, np.array([-0.1, 0.0, 4e-3, 6e-3])) == pytest.approx([0.0, 0.0, 0.0, 4e3])
    buffer = plan(tmp_path, "deformation_m=[-0.001, 0.0, 0.01], force_N=[-2e3, 0.0, 0.0]")
    assert force_N(buffer, np.array([-2e-3, 0.0, 1e-2])) == pytest.approx([-4e3, 0.0, 0.0])


def test_a_symmetric_characteristic_is_given_on_one_side(tmp_path: Path) -> None:
    row = "deformation_m=[0.0, 0.004, 0.006], force_N=[0.0, 80.0, 480.0], symmetric=true"
    law = plan(tmp_path, row)
    at_m = np.array([1e-3, 5e-3, 8e-3])
    assert force_N(law, at_m) == pytest.approx([20.0, 280.0, 880.0])
    assert force_N(law, -at_m) == pytest.approx([-20.0, -280.0, -880.0])


def test_a_file_is_the_same_as_its_points(tmp_path: Path) -> None:
    (tmp_path / "spring.csv").write_text("Weg [mm];Kraft [N]\n-10;-440\n-2;-40\n0;0\n4;80\n6;480\n")
    from_file, inline = plan(tmp_path, 'file="spring.csv"'), plan(tmp_path / "inline", PROGRESSIVE)
    at_m = np.linspace(-0.02, 0.02, 41)
    assert force_N(from_file, at_m) == pytest.approx(force_N(inline, at_m), abs=1e-9)
    (tmp_path / "bad.csv").write_text("Weg [mm];Temperatur\n0;1\n1;2\n")
    assert "Temperatur" in only_complaint(tmp_path, characteristic('file="bad.csv"'))


def test_a_slice_and_a_temperature_scale_the_force(tmp_path: Path) -> None:
    """Half of the width; 0.9 of the stiffness, halfway between two tests.  Gaps stay."""
    warm = f"{OF}.temperature={{works_at_degC=30, measured_degC=[20, 40], stiffness_ratio=[1.0, 0.8]}}"
    at_m = np.array([-8e-3, 3e-3, 7e-3])
    given_N = force_N(plan(tmp_path, PROGRESSIVE), at_m)
    half = plan(tmp_path, PROGRESSIVE, "slice.width_m=0.1")
    assert force_N(half, at_m) == pytest.approx(given_N / 2)
    assert force_N(plan(tmp_path, PROGRESSIVE, warm), at_m) == pytest.approx(0.9 * given_N)
    cold, hot = (bushings(loaded(tmp_path, sets).case)[0] for sets in ([], [warm]))
    assert hot.stiffness_N_per_m == pytest.approx(0.9 * cold.stiffness_N_per_m)
    assert hot.damping_N_s_per_m == pytest.approx(0.9 * cold.damping_N_s_per_m)


def test_frames_that_know_no_forces_leave_recorded_ones_to_the_characteristic(tmp_path: Path) -> None:
    """A driven frame 5 mm from the ground's end of the spring: 280 N, as in the table."""
    every = bushings(loaded(tmp_path, [characteristic(PROGRESSIVE)]).case)
    names = {name for bushing in every for name in bushing.bodies} - {"ground"}
    bodies = [BodyPlan(name, 1.0, np.eye(3), np.zeros(3)) for name in sorted(names)]
    along = every[0].axes[0]
    sign = 1.0 if every[0].bodies[0] == "ground" else -1.0
    count = len(bodies)
    moved = every[0].bodies[1] if sign > 0 else every[0].bodies[0]
    place_m = np.array([5e-3 * sign * along if body.name == moved else np.zeros(3) for body in bodies])
    still = np.zeros((count, 3))
    pose = Pose(place_m, np.tile(np.eye(3), (count, 1, 1)), still, still)
    deformation_m, recorded_N = BushingForces.of(every, bodies).at(pose)
    assert deformation_m[0, 0] == pytest.approx(5e-3)
    assert recorded_N[0, 0] == pytest.approx(280.0)


@pytest.mark.parametrize(
    ("row", "kind"),
    [
        ("deformation_m=[0.0]", "characteristics.0.force_N: conflict"),
        ('axes="x"', "characteristics.0: missing"),
        ("deformation_m=[0.0, 0.0], force_N=[0.0, 1.0]", "characteristics.0.deformation_m: conflict"),
        ("deformation_m=[0.0, 1e-3], force_N=[0.0, -20.0]", "characteristics.0.force_N: conflict"),
        ("deformation_m=[1e-3, 2e-3], force_N=[20.0, 40.0]", "characteristics.0.deformation_m: conflict"),
        ("deformation_m=[-1e-3, 1e-3], force_N=[-10.0, 30.0]", "characteristics.0.force_N: conflict"),
        (
            "deformation_m=[-1e-3, 1e-3], force_N=[-20.0, 20.0], symmetric=true",
            "characteristics.0.deformation_m: conflict",
        ),
        ("deformation_m=[0.0, 1e-3], force_N=[0.0, 2e3]", "stiffness_N_per_m: conflict"),
        (f'axes="xx", {PROGRESSIVE}', "characteristics.0.axes: conflict"),
    ],
)
def test_a_wrong_characteristic_is_refused(tmp_path: Path, row: str, kind: str) -> None:
    assert f"{OF}.{kind}" in kinds(tmp_path, characteristic(row))


@pytest.mark.parametrize(
    ("row", "kind"),
    [
        (
            "works_at_degC=50, measured_degC=[20, 40], stiffness_ratio=[1.0, 0.8]",
            "works_at_degC: out-of-range",
        ),
        ("works_at_degC=30, measured_degC=[40, 20], stiffness_ratio=[1.0, 0.8]", "measured_degC: conflict"),
        ("works_at_degC=30, measured_degC=[20, 40], stiffness_ratio=[1.0]", "stiffness_ratio: conflict"),
    ],
)
def test_a_wrong_temperature_is_refused(tmp_path: Path, row: str, kind: str) -> None:
    assert f"{OF}.temperature.{kind}" in kinds(tmp_path, f"{OF}.temperature={{{row}}}")
