"""The references in criteria.toml are the closed forms', recomputed from the cases themselves."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from orchestrator.case.bed.contact_times import contact_moduli, reduced_modulus_Pa
from orchestrator.case.bed.sources import initial_particles
from orchestrator.case.tables.case import Case
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.scene.scene import bed_kg
from orchestrator.studies.criteria import Criterion, read_criteria
from tests.benchmarks import closed_forms as known

FOLDER = Path(__file__).parents[2] / "cases" / "hard"
G = known.G_M_PER_S2


def case(name: str, *sets: str) -> Case:
    return load_judged(FOLDER / name, None, sets).case


def row(name: str, run: str, words: str) -> Criterion:
    rows = [
        criterion
        for criterion in read_criteria(FOLDER / name).criteria
        if criterion.run == run and words in criterion.what
    ]
    assert len(rows) == 1, [criterion.what for criterion in rows]
    return rows[0]


def reference(name: str, run: str, words: str) -> float:
    value = row(name, run, words).reference
    assert value is not None
    return value


@pytest.mark.parametrize(("name", "run"), [("heavy-bed", "bed"), ("size-ratio", "both")])
def test_weights(name: str, run: str) -> None:
    bed = initial_particles(case(name))
    weight_N = math.pi / 6 * float(bed.grains.sieve_size_m**3 @ bed.grains.density_kg_per_m3) * G
    assert reference(name, run, "force on the panel") == pytest.approx(-weight_N, rel=1e-4)


@pytest.mark.parametrize("run", ["taut", "slack"])
def test_how_deep_the_lump_goes(run: str) -> None:
    described = case("lump-drop", *read_criteria(FOLDER / "lump-drop").runs[run].sets)
    panel, lump = described.screen.panels["deck"], described.bed.particles["lump"]
    speed_m_per_s = -lump.velocity_m_per_s[2]
    assert speed_m_per_s == pytest.approx(math.sqrt(2 * G * 1.0), rel=1e-6)  # from 1 m
    assert bed_kg(described) == pytest.approx(0.5, rel=1e-5)
    section_m2 = panel.width_m * panel.thickness_m
    assert (panel.width_m, panel.thickness_m) == (known.WIDTH_M, known.THICKNESS_M)
    strip = (panel.length_m, panel.length_m + (panel.tension_m or 0.0), section_m2)
    panel_kg = known.PU_KG_PER_M3 * section_m2 * panel.length_m
    moduli = (contact_moduli(described.materials[name], None) for name in ("coal", "PU"))
    most_m = known.deepest_m(0.5, speed_m_per_s, strip)
    least_m = known.deepest_m(
        0.5,
        speed_m_per_s,
        strip,
        kept=known.shared(0.5, panel_kg) * (1 - math.pi / 2 * 0.12),  # loss factor, quarter swing
        stiffer=1.6,  # 1 + the branches' ratios
        contact=(lump.sieve_size_m / 2, reduced_modulus_Pa(*moduli)),
    )
    criterion = row("lump-drop", run, "deepest")
    assert criterion.reference == pytest.approx(-most_m, rel=1e-4)
    assert criterion.ratio == pytest.approx((least_m / most_m, 1.0), abs=5e-4)


@pytest.mark.parametrize(("run", "amplitude_m"), [("normal", 0.0059), ("triple", 0.0177)])
def test_the_pull_at_full_stretch(run: str, amplitude_m: float) -> None:
    panel = case("snapping").screen.panels["deck"]
    pull_N = known.nominal_Pa(1 + amplitude_m / panel.length_m) * panel.width_m * panel.thickness_m
    assert reference("snapping", run, "pull") == pytest.approx(pull_N, rel=1e-4)


def test_the_way_through_resonance() -> None:
    described = case("resonance")
    screen, panel = described.screen, described.screen.panels["deck"]
    section_m2 = panel.width_m * panel.thickness_m
    stretch = 1 + (panel.tension_m or 0.0) / panel.length_m
    tangent_N_per_m = known.tangent_N_per_m(stretch, section_m2, panel.length_m)
    panel_kg = known.PU_KG_PER_M3 * section_m2 * panel.length_m
    masses = [(screen.frames[name].mass_kg or 0.0) + panel_kg for name in ("driving", "driven")]

    def along(name: str) -> tuple[float, float]:
        springs = screen.bushings[name]
        number = len(springs.positions_m)
        return number * springs.stiffness_N_per_m[0], number * springs.damping_N_s_per_m[0]

    stiffness_N_per_m, damping_N_s_per_m = along("shear")
    law = described.materials["PU"].hyperelastic
    assert law is not None
    branches = tuple((branch.ratio, branch.relaxation_s) for branch in law.maxwell)
    slack_N_per_m = 2 * 6 * (law.c10_Pa + law.c01_Pa) * section_m2 / panel.length_m  # where they act
    shaft = screen.exciters["shaft"]
    largest_m = known.swept_m(
        (masses[0], masses[1]),
        along("isolation"),
        (stiffness_N_per_m + 2 * tangent_N_per_m, damping_N_s_per_m),
        shaft.mass_moment_kg_m,
        shaft.speed_rad_per_s,
        shaft.run_up_s,
        described.duration_s,
        (slack_N_per_m, branches),
    )
    assert reference("resonance", "sweep", "largest") == pytest.approx(largest_m, rel=1e-4)


def test_undamped_bushings() -> None:
    described = case("bushings")
    panel, shaft = described.screen.panels["deck"], described.screen.exciters["shaft"]
    panel_kg = known.PU_KG_PER_M3 * panel.width_m * panel.thickness_m * panel.length_m
    driving_kg, driven_kg = (described.screen.frames[n].mass_kg or 0.0 for n in ("driving", "driven"))
    speed = shaft.speed_rad_per_s
    amplitude_m = shaft.mass_moment_kg_m / (driving_kg + driven_kg + 2 * panel_kg)
    velocity_m_per_s = reference("bushings", "undamped", "velocity")
    assert velocity_m_per_s == pytest.approx(2 * speed * amplitude_m, rel=1e-4)
    shear = described.screen.bushings["shear"]
    stiffness_N_per_m = len(shear.positions_m) * shear.stiffness_N_per_m[0]
    stretch_m = (driven_kg + panel_kg) * speed**2 * amplitude_m / stiffness_N_per_m
    assert reference("bushings", "undamped", "against") == pytest.approx(2 * stretch_m, rel=1e-4)


def test_the_bond_number() -> None:
    described = case("sticky-fines")
    size = described.bed.blocks["fines"].sizes[0].largest_m
    weight_N = math.pi / 6 * size**3 * described.materials["coal"].density_kg_per_m3 * G
    for contact in described.contacts:
        pull_off_N = 1.5 * math.pi * contact.work_of_adhesion_J_per_m2 * size / 2  # on a plane
        assert pull_off_N / weight_N == pytest.approx(500, rel=1e-3)
    assert reference("sticky-fines", "dry", "share") == described.bed.blocks["fines"].count
    holes = described.screen.panels["deck"].apertures
    assert holes is not None
    landing = (holes.length_m - size) ** 2 / holes.pitch_along_m**2  # Gaudin, square openings
    least = row("sticky-fines", "dry", "share").ratio[0]
    assert least == pytest.approx(1 - (1 - landing) ** 2, abs=5e-3)


def test_what_a_squeeze_can_give() -> None:
    """Two Hertz contacts, each pressed by half of what the opening closes in a stroke."""
    described = case("jam")
    panel, ball = described.screen.panels["deck"], described.bed.particles["ball"]
    drive, holes = described.screen.frames["moving"].drive, panel.apertures
    assert drive is not None
    assert holes is not None
    soft = 1 / (1 - holes.width_m / panel.width_m)  # where an opening leaves half of the section
    share = 3 * holes.length_m / panel.length_m  # of the length
    mean = 2 * abs(drive.amplitude_m[0]) / panel.length_m
    stroke_m = holes.length_m * soft * mean / (1 + (soft - 1) * share) / 2
    cap_Pa = described.particles.largest_youngs_modulus_Pa
    moduli = (contact_moduli(described.materials[name], cap_Pa) for name in ("coal", "PU"))
    reduced_Pa = reduced_modulus_Pa(*moduli)
    overlap_J = 8 / 15 * reduced_Pa * math.sqrt(ball.sieve_size_m / 2) * stroke_m**2.5
    squeeze_J = 2 * overlap_J
    speed_m_per_s = math.sqrt(2 * squeeze_J / bed_kg(described))
    speed_m_per_s += abs(drive.amplitude_m[0]) * drive.speed_rad_per_s
    assert reference("jam", "squeezed", "created") == pytest.approx(squeeze_J, rel=0.02)
    assert reference("jam", "squeezed", "fastest") == pytest.approx(speed_m_per_s, rel=0.02)


def test_the_energy_of_the_balls() -> None:
    described = case("elastic")
    speed_m_per_s = described.bed.blocks["balls"].velocity_m_per_s[2]
    kinetic_J = bed_kg(described) * speed_m_per_s**2 / 2
    assert reference("elastic", "bouncing", "stored") == pytest.approx(kinetic_J, rel=1e-4)


def test_what_lies_at_rest() -> None:
    described = case("at-rest")
    panel = described.screen.panels["deck"]
    length_m = panel.length_m + 2 * panel.clamp_m
    panel_kg = known.PU_KG_PER_M3 * length_m * panel.width_m * panel.thickness_m
    weight_N = (panel_kg + bed_kg(described) / 2) * G
    for number in (1, 2):
        force_N = reference("at-rest", "long", f"force of panel {number}")
        assert force_N == pytest.approx(-weight_N, rel=1e-5)
    fallen_J = bed_kg(described) * G * 0.0005
    assert reference("at-rest", "long", "once at rest") == pytest.approx(fallen_J, rel=1e-3)
