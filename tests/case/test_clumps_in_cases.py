"""Grains of several spheres in a case: its own shapes, what is refused, and what users are told of them."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from adapters.particles import liggghts
from orchestrator.case.bed import saved_bed
from orchestrator.case.bed.grains import grain, shapes
from orchestrator.case.bed.push_out import push_out
from orchestrator.case.bed.sources import initial_particles
from orchestrator.case.tables.carried_bed import CarriedBed
from orchestrator.cli import launch
from orchestrator.cli.console import WRONG
from orchestrator.ports.grains import Grain, ShapeTable
from orchestrator.preflight.check import warnings
from orchestrator.preflight.checks.surfaces import particles_at_start
from orchestrator.preflight.cost import predicted_parts_s
from tests.cases import BLOCK, CASE, FEED, case_folder, load_case, loaded, only_complaint, problems

PEAR = "bed.shapes.pear.spheres=[[0, 0, 0, 10], [0, 0, 9, 7]]"
OF_PEARS = [PEAR, BLOCK, 'bed.blocks.coal.shape="pear"', 'bed.particles.ball.shape="pear"']
ROLLS = CASE.replace("rolling_friction = 0.0", "rolling_friction = 0.25")


def test_a_case_lists_the_spheres_of_its_own_shape(tmp_path: Path) -> None:
    """Two spheres that overlap have the volume of both without that of their lens
    (https://mathworld.wolfram.com/Sphere-SphereIntersection.html); it passes as its larger one."""
    case = loaded(tmp_path, OF_PEARS).case
    assert problems(tmp_path / "checked", *OF_PEARS) == []
    R, r, d = 10.0, 7.0, 9.0
    lens = (R + r - d) ** 2 * (d**2 + 2 * d * (r + R) - 3 * (r - R) ** 2) * math.pi / (12 * d)
    volume = 4 / 3 * math.pi * (R**3 + r**3) - lens
    pear = grain(case, "coal", "pear", 0.02)
    assert pear.volume_m3 == pytest.approx(volume * 1e-9, rel=1e-9)  # 20 mm are the larger sphere's diameter
    assert [shape.name for shape in shapes(case)] == ["pear"]


def test_shapes_are_divided(tmp_path: Path) -> None:
    """A pear gets one sphere between its two; a grain of one sphere stays one, at the same sieve size."""
    case = loaded(tmp_path, [*OF_PEARS, "bed.shape_divisions=2"]).case
    (pear,) = shapes(case)
    assert len(pear.spheres) == 3
    assert max(row[3] for row in pear.spheres) == pytest.approx(0.5, rel=1e-9)
    assert problems(tmp_path / "checked", *OF_PEARS, "bed.shape_divisions=2") == []
    (ball,) = shapes(loaded(tmp_path / "ball", ["bed.shape_divisions=2"]).case)
    assert len(ball.spheres) == 1


@pytest.mark.parametrize(
    ("given", "words"),
    [
        (
            'bed.particles.ball.shape="stnoe"',
            ["bed.particles.ball.shape", "'stnoe'", 'did you mean "stone"?'],
        ),
        ('bed.particles.ball.shape="paer"', ["'paer'", 'did you mean "pear"?']),
        ("bed.shapes.two.spheres=[[0, 0, 0, 1], [0, 0, 3, 1]]", ["two.spheres", "do not hang", "(0, 0, 3)"]),
        ("bed.shapes.no.spheres=[]", ["bed.shapes.no.spheres", "one sphere at least"]),
        ("bed.shapes.flat.spheres=[[0, 0, 1]]", ["flat.spheres.0", "too few values"]),
        ("bed.shapes.hole.spheres=[[0, 0, 0, -1]]", ["hole.spheres.0.3", "-1", "greater than 0"]),
        ("bed.shapes.rod.spheres=[[0, 0, 0, 1]]", ["bed.shapes.rod", "take another one"]),
        (f"bed.shapes.many.spheres={[[0, 0, k, 1] for k in range(65)]}", ["many.spheres", "more than 64"]),
        ("bed.shape_divisions=0", ["bed.shape_divisions: must be at least 1"]),
        ("bed.shape_divisions=65", ["bed.shape_divisions: must be at most 64"]),
    ],
)
def test_bad_shapes_are_one_message_each(tmp_path: Path, given: str, words: list[str]) -> None:
    complaint = only_complaint(tmp_path, PEAR, given)
    assert all(word in complaint for word in words), complaint


def test_a_shape_of_too_many_spheres_is_refused(tmp_path: Path) -> None:
    given = ('bed.particles.ball.shape="flake"', "bed.shape_divisions=5")
    assert 'bed.shape_divisions: shape "flake" has 91 spheres then' in only_complaint(tmp_path, *given)


def test_a_grain_longer_than_its_inlet_is_refused(tmp_path: Path) -> None:
    """A rod of 60 mm is 120 mm long; the box is 100 mm wide, and a sphere of that size had room."""
    sizes = "bed.feeds.chute.sizes=[{smallest_m=0.01, largest_m=0.06, mass_fraction=1}]"
    assert problems(tmp_path / "sphere", FEED, sizes) == []
    complaint = only_complaint(tmp_path / "rod", FEED, sizes, 'bed.feeds.chute.shape="rod"')
    assert "bed.feeds.chute.box_m: particles of 0.12 m do not fit in 0.1 m; enlarge the box" in complaint


def test_nothing_is_written_for_a_bad_shape(tmp_path: Path) -> None:
    folder = case_folder(tmp_path / "case", CASE)
    given = ["bed.shapes.two.spheres=[[0, 0, 0, 1], [0, 0, 3, 1]]"]
    assert launch.run(folder, None, tmp_path / "run", given) == WRONG
    assert not (tmp_path / "run").exists()


def test_a_shape_is_left_out_only_of_spheres(tmp_path: Path) -> None:
    def left_out(*given: str) -> str | None:
        return load_case(tmp_path, CASE, given).left_out.get("grain-shape")

    assert str(left_out()).startswith("particles are spheres")
    assert str(left_out(BLOCK, 'bed.blocks.coal.shape="rod"')).startswith("some particles are spheres")
    assert left_out(*OF_PEARS) is None


def test_shape_that_counts_twice_is_told(tmp_path: Path) -> None:
    def told(*given: str) -> list[str]:
        return [line for line in warnings(load_case(tmp_path, ROLLS, given)) if "counts twice" in line]

    (line,) = told(*OF_PEARS)
    assert "coal with PU have a rolling friction of 0.25" in line
    assert 'take particles.rolling = "none"' in line
    (line,) = told(BLOCK, 'bed.blocks.coal.shape="rod"')  # the single particle is a sphere
    assert "give their contacts rolling_friction = 0" in line
    assert told() == told(*OF_PEARS, "particles.rolling=none") == []


def test_clumps_that_stick_are_told(tmp_path: Path) -> None:
    sticky = CASE.replace("rolling_friction = 0.0", "rolling_friction = 0.0\nwork_of_adhesion_J_per_m2 = 0.2")

    def told(*given: str) -> list[str]:
        return [line for line in warnings(load_case(tmp_path, sticky, given)) if "sticks by itself" in line]

    assert told() == []
    assert "of up to 2 here" in told(*OF_PEARS)[0]


def test_a_bed_of_rods_side_by_side_is_taken_over(tmp_path: Path) -> None:
    """Lying rods of 10 mm that just touch are nearer to each other than their bounding spheres allow; where
    they overlap by 1 mm they are refused, or pushed apart."""
    rods = grain(loaded(tmp_path / "case", ['bed.particles.ball.shape="rod"']).case, "coal", "rod", 0.01)
    half = math.sqrt(0.5)
    flat = np.tile([half, half, 0.0, 0.0], (2, 1))  # along y
    for apart_m, fits in ((0.00999, True), (0.009, False)):
        place_m = np.array([[0.1, 0.1, 0.1], [0.1, 0.1, 0.1 + apart_m]])
        grains, still = rods.of_sizes(np.full(2, 0.01)), np.zeros((2, 3))
        bed = CarriedBed(("coal",), place_m, still, still, grains, 0.0, 1.0, "a bed", orientation=flat)
        case = loaded(tmp_path / "other").case
        taken = case.model_copy(update={"bed": case.bed.with_carried(bed)})
        complaints = [problem.what for problem in particles_at_start(taken, tmp_path)]
        overlap = "particle 1 overlaps particle 2 by 0.001 m"
        assert complaints == [] if fits else overlap in complaints[0]
        pushed = push_out(initial_particles(taken), np.zeros((0, 3, 3)), np.array([0.0, 0.0, 1.0]))
        gap_m = np.linalg.norm(np.diff(pushed.position_m, axis=0))
        assert gap_m == pytest.approx(apart_m if fits else 0.0099, rel=1e-9)  # 1 % of overlap is wanted


def test_a_saved_bed_brings_its_shapes(tmp_path: Path) -> None:
    """The case that takes it over need not know them."""
    own = shapes(loaded(tmp_path / "case", OF_PEARS).case)
    grains = Grain(1.0, 1430.0, 0, 0, ShapeTable.of(own)).of_sizes(np.array([0.01, 0.02]))
    still = np.zeros((2, 3))
    saved_bed.write(
        tmp_path / "bed.h5", CarriedBed(("coal",), still, still, still, grains, 0.0, 1.0, source="")
    )
    read = saved_bed.read(tmp_path / "bed.h5")
    for name, values in vars(grains.shapes).items():
        np.testing.assert_array_equal(getattr(read.grains.shapes, name), values, err_msg=name)
    case = loaded(tmp_path / "other").case
    other = case.model_copy(update={"bed": case.bed.with_carried(read)})
    (taken,) = shapes(other)
    assert (taken.spheres, taken.volume, taken.inertia) == (own[0].spheres, own[0].volume, own[0].inertia)


def test_predicted_times_know_spheres_and_air(tmp_path: Path) -> None:
    """A stone has four spheres; a mixture of both has their mean, by number."""
    stones = [BLOCK, "bed.blocks.coal.count=3", 'bed.blocks.coal.shape="stone"', "air={}"]

    def predicted_s(*given: str) -> float:
        return predicted_parts_s(loaded(tmp_path, [*given, "particles.step_s=1e-5"]).case, 4)["particles"]

    plain = predicted_s(*stones[:2])
    airy = predicted_s(*stones[:2], stones[3])
    mixed = predicted_s(*stones[:3])
    every = predicted_s(*stones[:3], 'bed.particles.ball.shape="stone"')
    assert plain < airy < mixed < every
    ratio = (every - plain) / (mixed - plain)
    times = [liggghts.BODY * spheres**0.9 - 1 for spheres in (4.0, 13 / 4)]
    assert ratio == pytest.approx(times[0] / times[1], rel=1e-9)
