"""Each check, by a case with just that mistake."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestrator.ports.plans import PanelPlan, SolverFailed
from orchestrator.preflight.check import find_problems, warnings
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.stability.report import stability_report
from tests.cases import BLOCK, CASE, FEED, case_folder, complaints, loaded, only_complaint
from tests.runs.outside import ROOT

EXIT = 'screen.exits.under={product="undersize", box_m=[[-1, -1, -0.5], [1, 1, -0.3]]}'
FRAME = "mass_kg=1, inertia_kg_m2=[1, 1, 1], center_of_mass_m=[0, 0.1, 0]"
TWIN = (
    'screen.panels.twin={material="PU", frames=["driving", "ground"], corner_m=CORNER, along=ALONG, '
    "length_m=0.3, width_m=0.2, thickness_m=0.004, clamp_m=0.019, tension_m=0.002}"
)
LID = (
    'screen.surfaces.lid={frame="ground", material="PU", corner_m=CORNER, edges_m=[[0.1, 0, 0], [0, 0.1, 0]]}'
)


def test_the_test_case_itself_has_no_mistake(tmp_path: Path) -> None:
    assert complaints(tmp_path) == []


@pytest.mark.parametrize(
    ("override", "said"),
    [
        # names
        ("probes.middle.panel=dekc", 'no panel "dekc"; did you mean "deck"?'),
        ("probes.middle.panel=deck-1", 'no panel "deck-1"; did you mean "deck"?'),
        ("screen.exciters.shaft.frame=driven", 'no frame "driven"; did you mean "driving"?'),
        ('screen.panels.deck.frames=["x", "ground"]', 'no frame "x"; frames: driving, ground'),
        ("bed.particles.ball.material=coat", 'no material "coat"; did you mean "coal"?'),
        (f"screen.frames.ground={{{FRAME}}}", 'the name "ground" is the ground\'s'),
        (f"screen.frames.deck={{{FRAME}}}", 'the name "deck" is taken by frames'),
        ('probes.driving={panel="deck", at=[0, 0]}', 'the name "driving" is a frame\'s'),
        # materials and contacts
        ("contacts.1.between.1=PU", "coal and PU are given twice"),
        ("contacts=[]", 'give [[contacts]] with between = ["coal", "PU"]'),
        ("screen.panels.deck.material=coal", "hyperelastic: missing: panel deck is made of it"),
        ("materials.slag.density_kg_per_m3=2900", "materials.slag.poisson_ratio: missing"),
        ("materials.PU.hyperelastic={c10_Pa=0, c01_Pa=0}", "no stiffness"),
        # mounting
        ("screen.panels.deck.clamp_angel_deg=5", 'unknown key (its value: 5); did you mean "clamp_angle'),
        ("screen.panels.deck.moulded_sag_m=0.08", "too deep for a free length of 0.3 m; at most 0.06 m"),
        # machine
        ("screen.frames.driven={inertia_kg_m2=[1, 1, 1]}", "mass_kg: missing: frames.solver exudyn"),
        ("screen.frames.driven.mass_kg=1", "inertia_kg_m2: missing: frames.solver exudyn"),
        (
            f"screen.frames.driven={{{FRAME.rsplit(',', 3)[0]}}}",
            "driven.center_of_mass_m: missing: it decides how the frame turns",
        ),
        ("screen.frames.driving.drive.speed_rad_per_s=78.5", '"driving" has a drive, which leaves no'),
        (
            "screen.frames.driving.drive={speed_rad_per_s=9, amplitude_m=[0.1, 0, 0], phase_rad=[0.5, 0, 0]}",
            "drive.phase_rad: the frame would jump by 0.0479 m at t = 0; give run_up_s, or 0",
        ),
        (
            "screen.frames.driving.drive={speed_rad_per_s=9, rotation_rad=[0, 0.1, 0], center_m=[0, 0, 0], "
            "rotation_phase_rad=[0, 0.5, 0]}",
            "drive.rotation_phase_rad: the frame would jump by 0.0479 rad",
        ),
        ("screen.frames.driving.inertia_kg_m2=[1, 1, 3]", "no body has the principal moments"),
        ('screen.bushings.isolation.between=["driving", "driving"]', '"driving" twice'),
        ("screen.bushings.isolation.stiffness_N_per_m=[0, 0, 0]", "zero in every direction"),
        ("screen.exciters.shaft.frame=ground", "the ground cannot be excited"),
        ("screen.exciters.shaft.start=[0, 1, 1]", "start: is not at right angles to axis"),
        ("screen.exciters.shaft.axis=[0, 0, 0]", "axis: is zero"),
        ("screen.panels.deck.span_m=0.31", "contradicts tension_m"),
        ("screen.panels.deck.tension_m=-0.2", "0.5 to 1.5 of the free length"),
        ("screen.panels.deck.across=[1, 1, 0]", "across: is not at right angles to along"),
        ("materials.PU.hyperelastic.bulk_modulus_Pa=1e5", "Poisson's ratio is negative"),
        ("screen.panels.deck.across=[0, -1, 0]", "across: turns the panel's upper side"),
        ("probes.middle.particle=1", "is on panel and particle; give one of"),
        ("probes.end.point_m=[0, 0, 0]", "is on nothing"),
        ("probes.end.frame=driving", "point_m: missing: where on the frame?"),
        ("probes.end={frame='ground', point_m=[0, 0, 0]}", "the ground does not move"),
        (f"screen.frames.driven={{{FRAME}}}", "frames.driven: no bushing holds its weight"),
        ("screen.bushings.isolation.stiffness_N_per_m.2=0", "frames.driving: no bushing holds its"),
        # boxes and sizes
        ("domain_m=[[-1, -1, -1], [1, -1, 1]]", "is not below"),
        (BLOCK.replace("smallest_m=0.01", "smallest_m=0.03"), "is larger than largest_m"),
        (BLOCK.replace("fraction=1", "fraction=0.5"), "add up to 0.5, not to 1"),
        (BLOCK.replace("[0.1, 0.1, 0.2]", "[0.1, 0.1, 0]"), "is not below"),
        (BLOCK.replace("count=1", "count=1000000"), "count: 1000000 particles fill"),
        (BLOCK.replace("count=1", "count=300"), "count: the box has room for"),
        (BLOCK.replace("0.1], [0.1, 0.1, 0.2", "-0.01], [0.1, 0.1, 0.01"), "inside panel deck"),
        (BLOCK.replace("0.1], [0.1, 0.1, 0.2", "1.2], [0.1, 0.1, 1.3"), "coal.box_m: particle 2 at"),
        # counts that no machine could hold
        (BLOCK.replace("count=1", "count=1000000000"), "less than or equal to 10000000"),
        ("screen.panels.deck.count=1000000000", "less than or equal to 1000 is wanted"),
        ("panel.cells=[22, 100000]", "panel.cells.1: 100000 is wrong"),
        # feeds
        (FEED.replace("rate_kg_per_s=1", "rate_kg_per_s=10"), "the largest rate is 2.86 kg/s; a larger"),
        (FEED.replace("0, -1]", "0, 0]"), "the largest rate is 0 kg/s"),
        (FEED.replace("sizes", "start_s=1, stop_s=0.5, sizes"), "0.5 s is not after start_s = 1"),
        (FEED.replace("0.1, 0.2]]", "0.1, 1.2]]"), "is not inside domain_m"),
        (FEED.replace("0, 0.1]", "0, -0.1]"), "chute.box_m: panel deck reaches into it"),
        (FEED.replace("sizes", "start_s=0.1, sizes"), "start_s: 0.1 s is not before the end"),
        (FEED.replace("0.02, mass", "0.12, mass"), "box_m: particles of 0.12 m do not fit in 0.1 m"),
        (FEED.replace("sizes=", "curve=[{sieve_size_m=0.1, passing=1}], sizes="), "contradicts sizes"),
        # exits
        (EXIT.replace("-0.3]]", "-0.6]]"), "under.box_m: is empty"),
        (EXIT.replace("-0.5], [1, 1, -0.3", "-1.5], [1, 1, -1.3"), "is outside domain_m"),
        (EXIT.replace("-0.3]]", "0.1]]"), "under.box_m: panel deck reaches into it"),
        (EXIT.replace("-0.3]]", "-0.49]]"), "0.01 m thin: the fastest particles may go through it"),
        # sizes of values
        ("screen.panels.deck.thickness_m=4", "looks like mm: that is 0.004 in thickness_m"),
        ("materials.coal.density_kg_per_m3=1.43", "looks like g/cm3: that is 1430"),
        ("screen.bushings.isolation.stiffness_N_per_m.0=0.225", "looks like N/mm: that is 225"),
        ("materials.coal.youngs_modulus_Pa=990", "looks like MPa: that is 9.9e+08"),
        ("materials.PU.hyperelastic.c10_Pa=0.7", "looks like MPa: that is 700000"),
        ("bed.particles.ball.sieve_size_m=20", "looks like mm: that is 0.02"),
        ("screen.exciters.shaft.speed_rad_per_s=1500", "looks like rpm: that is 157.08"),
        ("duration_s=2e4", "looks like ms: that is 20"),
        ("bed.particles.ball.spin_rad_per_s=[0, 1e300, 0]", "1e+300 is out of the range"),
        # times
        ("duration_s=1e-5", "is shorter than coupling.sync_interval_s"),
        ("output.interval_s=1e-6", "is shorter than coupling.sync_interval_s"),
        ("particles.rayleigh_fraction=0.0", "greater than 0 is wanted"),
        ("particles.step_s=2e-4", "particles.step_s: a step of 0.0002 s is 0.31 of the"),
        # the start
        ("bed.particles.ball.position_m=[0.15, 0.1, 0.009]", '"ball" is 0.001 m inside panel deck'),
        ("bed.particles.ball.position_m=[0, 0, 2]", '"ball" at [0.0, 0.0, 2.0] is outside domain_m'),
        ("screen.panels.deck.corner_m=[0.8, 0, 0]", "panel deck: reaches 0.121 m out of domain_m"),
    ],
)
def test_one_mistake_is_found_and_said(tmp_path: Path, override: str, said: str) -> None:
    found = complaints(tmp_path, override)
    assert any(said in complaint for complaint in found), found


def test_a_share_of_the_rayleigh_time_above_the_limit_is_refused(tmp_path: Path) -> None:
    said = only_complaint(tmp_path, "particles.rayleigh_fraction=0.3", "coupling.sync_interval_s=1e-3")
    assert "particles.rayleigh_fraction: a step of" in said
    assert "the limit is" in said


def test_a_hinge_holds_no_angle(tmp_path: Path) -> None:
    said = only_complaint(tmp_path, "screen.panels.deck.clamp_m=0.0", "screen.panels.deck.clamp_angle_deg=5")
    assert "deck.clamp_angle_deg: is the angle of a clamp, and clamp_m = 0 is a hinge" in said


def test_a_row_of_panels_needs_a_pitch_without_overlap(tmp_path: Path) -> None:
    row = "screen.panels.deck.count=2"
    assert "pitch_m: missing" in only_complaint(tmp_path, row, "probes.middle.panel=deck-1")
    close = complaints(tmp_path, row, "screen.panels.deck.pitch_m=0.3", "probes.middle.panel=deck-2")
    assert "span and two clamps need 0.34 m" in close[0]
    assert not complaints(tmp_path, row, "screen.panels.deck.pitch_m=0.34", "probes.middle.panel=deck-2")


def test_only_two_mass_knows_no_drives(tmp_path: Path) -> None:
    alone = CASE.replace('frame = "driving"', 'frame = "driven"')
    folder = case_folder(tmp_path, alone)
    given = [
        f"screen.frames.driven={{{FRAME.replace('mass_kg=1', 'mass_kg=76')}}}",
        "screen.frames.driving={drive={speed_rad_per_s=78.5, amplitude_m=[0.01, 0, 0]}}",
        'screen.bushings.isolation.between=["driving", "driven"]',
        "screen.largest_acceleration_m_per_s2=1e4",
    ]

    def said(*overrides: str) -> list[str]:
        return [str(mistake) for mistake in find_problems(load_judged(folder, None, [*given, *overrides]))]

    assert said() == []  # exudyn: one driven without a mass, one free that hangs on it
    assert said("frames.solver=prescribed") == []
    (refusal,) = said("frames.solver=two-mass")
    assert "frames.solver two-mass knows no drives; take the drive out" in refusal
    assert said("frames.solver=planar") == []
    centre = "screen.frames.driving.drive.center_m=[0, 0, 0]"
    for leaving in ("amplitude_m=[0.0, 0.01, 0.0]", "rotation_rad=[0.01, 0.0, 0.0]"):
        drive = f"screen.frames.driving.drive.{leaving}"
        (refusal,) = said("frames.solver=planar", drive, centre)
        assert "drive: leaves the vertical plane, to which frames.solver planar" in refusal
    drive = "screen.frames.driving.drive.rotation_rad=[1, 1, 0.5]"
    (refusal,) = said(drive)
    assert "drive.center_m: missing: rotation_rad turns the frame about it" in refusal
    (refusal,) = said(drive, centre)
    assert "rotation_rad: may add up to 1.5 rad; exudyn's limit is 1.4" in refusal
    assert said(drive, centre, "frames.solver=prescribed") == []


def test_exudyn_may_drive_every_frame() -> None:
    case = Path(__file__).parents[2] / "cases" / "bushing-hysteresis"
    assert find_problems(load_judged(case, "draft", ["frames.solver=exudyn"])) == []


def test_a_drive_that_runs_up_may_have_any_phase(tmp_path: Path) -> None:
    drive = "screen.frames.driving.drive={speed_rad_per_s=9, amplitude_m=[0.1, 0, 0], run_up_s=1"
    said = complaints(tmp_path, drive + ", phase_rad=[0.5, 0, 0]}")
    assert said
    assert not any("jump" in complaint for complaint in said)


def test_feeds_may_not_share_a_box(tmp_path: Path) -> None:
    other = FEED.replace("chute", "second")
    assert 'second.box_m: overlaps the box of feed "chute"' in only_complaint(tmp_path, FEED, other)
    assert not complaints(tmp_path, FEED)


def test_a_feed_may_stand_on_a_panel(tmp_path: Path) -> None:
    assert not complaints(tmp_path, FEED.replace("0, 0.1]", "0, 0]"))


def test_tension_or_span_must_be_given(tmp_path: Path) -> None:
    folder = case_folder(tmp_path, CASE.replace("tension_m = 0.002", ""))
    (said,) = find_problems(load_judged(folder))
    assert said.what == "missing"
    assert said.hint == "give tension_m or span_m"


def test_overlapping_particles_are_named(tmp_path: Path) -> None:
    other = 'bed.particles.other={position_m=[0.15, 0.1, 0.069], sieve_size_m=0.02, material="coal"}'
    said = only_complaint(tmp_path, other)
    assert '"ball" overlaps "other" by 0.001 m' in said
    assert not complaints(tmp_path, other.replace("0.069", "0.0701"))


def test_a_sync_interval_above_a_tenth_of_the_contact_is_a_warning(tmp_path: Path) -> None:
    slow = loaded(tmp_path, ["coupling.sync_interval_s=5e-4"])
    (said,) = [line for line in stability_report(slow.case).warnings() if "accurate" in line]
    assert "should last ten exchanges" in said
    fast = loaded(tmp_path, ["coupling.sync_interval_s=1.5e-5"])
    assert list(stability_report(fast.case).warnings()) == []


def test_settings_that_a_strip_does_not_have(tmp_path: Path) -> None:
    strip = "panel.solver=strip"
    assert "explicit only" in only_complaint(tmp_path, strip, "panel.integrator=implicit")
    assert "at least two cells" in only_complaint(tmp_path, strip, "panel.cells=[1, 1]")


def test_frames_may_hang_on_each_other_and_drop_when_not_drawn_at_rest(tmp_path: Path) -> None:
    frame = f"screen.frames.driven={{{FRAME}}}"
    shear = (
        'screen.bushings.shear={between=["driving", "driven"], positions_m=[[0, 0.1, 0]], '
        "stiffness_N_per_m=[0, 0, 2e4], rotation_deg=[0, -30, 0]}"  # upright again
    )
    assert not complaints(tmp_path, frame, shear, "screen.inclination_deg=30")
    assert "frames.driven" in only_complaint(tmp_path, frame, shear)
    assert not complaints(tmp_path, frame, "screen.drawn_at_rest=false")


@pytest.mark.parametrize("solver", ["exudyn", "planar"])
def test_bushings_must_keep_frames_from_tipping(tmp_path: Path, solver: str) -> None:
    """The run used to refuse such frames, after a check that had found nothing."""
    turns, beside = f"frames.solver={solver}", "screen.frames.driving.center_of_mass_m=[0.1, 0.1, 0]"
    one = "screen.bushings.isolation.positions_m=[[0, 0.1, 0]]"
    assert complaints(tmp_path, turns, one) == complaints(tmp_path, turns, beside) == []
    assert "frames.driving: no bushing holds its weight, or keeps" in only_complaint(
        tmp_path, turns, one, beside
    )
    assert complaints(tmp_path, turns, one, beside, "screen.drawn_at_rest=false") == []
    # Only frames that stay upright are not tipped by bushings along one side.
    aside = complaints(tmp_path, turns, "screen.frames.driving.center_of_mass_m=[0, 0, 0]")
    assert len(aside) == (solver == "exudyn")


@pytest.mark.parametrize(
    ("corner_m", "along", "meets"),
    [
        ([0, 0, 0], [1, 0, 0], True),
        ([0.1, 0.1, 0.001], [1, 0, 0], True),
        ([0.1, 0, -0.1], [0.7, 0, 0.7], True),
        ([0.34, 0, 0], [1, 0, 0], False),  # end to end
        ([0.34, 0, 0], [0.9, 0, -0.3], False),
        ([0, 0.2, 0], [1, 0, 0], False),  # side by side
        ([0, 0, 0.1], [1, 0, 0], False),  # one above the other
    ],
)
def test_two_panels_in_one_place_are_refused(
    tmp_path: Path, corner_m: list[float], along: list[float], meets: bool
) -> None:
    twin = TWIN.replace("CORNER", str(corner_m)).replace("ALONG", str(along))
    sets = (twin, "bed.particles.ball.position_m=[-0.5, 0, 0.5]", "screen.drawn_at_rest=false")
    if meets:
        assert "twin.corner_m: panel twin lies in the place of panel deck, or" in only_complaint(
            tmp_path, *sets
        )
    else:
        assert complaints(tmp_path, *sets) == []


def test_each_pair_of_panels_in_one_place_is_named(tmp_path: Path) -> None:
    two = TWIN.replace("CORNER", "[0, 0, 0]").replace("ALONG", "[1, 0, 0]")
    assert len(complaints(tmp_path, two, two.replace("twin", "third"))) == 3


@pytest.mark.parametrize(
    ("corner_m", "meets"),
    [
        ([0.1, 0.05, 0.0], True),
        ([0.25, 0.15, 0.0], True),  # in part
        ([0.302, 0.0, 0.0], False),  # over the clamp
        ([0.1, 0.2, 0.0], False),  # beside it
        ([0.1, 0.05, -0.001], False),  # where the run sees the panel go through it
    ],
)
def test_a_plate_in_the_plane_of_a_panel_is_refused(
    tmp_path: Path, corner_m: list[float], meets: bool
) -> None:
    lid = LID.replace("CORNER", str(corner_m))
    ball = "bed.particles.ball.position_m=[-0.5, 0, 0.5]"
    if meets:
        assert "lid.corner_m: surface lid lies in the plane of panel deck and" in only_complaint(
            tmp_path, lid, ball
        )
    else:
        assert complaints(tmp_path, lid, ball) == []


def test_a_panel_step_above_the_solvers_limit_is_refused_with_the_limit(tmp_path: Path) -> None:
    strip = ("panel.solver=strip", "panel.cells=[22, 1]")
    said = only_complaint(tmp_path, *strip, "panel.step_s=1e-3")
    assert "panel.step_s: 0.001 s is above the limit" in said
    assert "or 0 for the solver's own" in said
    assert not complaints(tmp_path, *strip, "panel.step_s=1e-6")


def test_a_solver_without_a_resting_shape_is_not_asked_for_its_limit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def restless(plan: PanelPlan) -> float:
        raise SolverFailed(f"panel {plan.name}: no resting shape")

    monkeypatch.setattr("adapters.panel.strip.panel.largest_step_s", restless)
    assert not complaints(tmp_path, "panel.solver=strip", "panel.step_s=1e-3")


def test_exits_are_apart_but_may_share_a_face(tmp_path: Path) -> None:
    beside = EXIT.replace("under", "over", 1).replace(
        "[-1, -1, -0.5], [1, 1, -0.3]", "[1, -1, -0.5], [2, 1, 0]"
    )
    assert complaints(tmp_path, EXIT, beside, "domain_m.1.0=3") == []
    across = beside.replace("[1, -1, -0.5]", "[0.9, -1, -0.5]")
    assert 'over.box_m: overlaps exit "under"' in only_complaint(tmp_path, EXIT, across, "domain_m.1.0=3")


def test_fines_left_out_are_said(tmp_path: Path) -> None:
    feed = FEED.replace("sizes", "smallest_fed_m=0.015, sizes")
    found = warnings(loaded(tmp_path, [feed]))
    assert any("chute: 27.1% of the mass is finer than" in line for line in found)


def test_what_a_sample_leaves_out_is_said(tmp_path: Path) -> None:
    feed = FEED.replace("sizes", "sampled_below_m=0.015, sampled_as_m=0.02, sizes")
    found = warnings(loaded(tmp_path, [feed]))
    (line,) = (line for line in found if "is sampled" in line)
    assert "chute: 27.1% of the mass, of 10 to 15 mm, is sampled: one in 3.94 of its particles" in line
    assert "the others, 20.2% of the mass or" in line
    assert "kg/s, are left out" in line


def test_a_sample_that_cannot_be_is_refused(tmp_path: Path) -> None:
    feed = FEED.replace("sizes", "sampled_below_m=0.015, sampled_as_m=0.01, sizes")
    assert "chute.sampled_as_m: 0.01 m is less than sampled_below_m" in only_complaint(tmp_path, feed)
    block = BLOCK.replace("sizes", "sampled_below_m=0.015, sizes")
    assert "sampled_below_m: unknown key" in only_complaint(tmp_path, block)


def warned(folder: Path, *overrides: str) -> list[str]:
    """What a case without mistakes is warned of."""
    given = loaded(folder, overrides)
    assert find_problems(given) == []
    return warnings(given)


def test_steel_panels_are_said_to_be_unusual_and_taken(tmp_path: Path) -> None:
    """E = 6 (c10 + c01) = 216 GPa; no unit makes a soft panel of it."""
    key = "materials.PU.hyperelastic.c10_Pa"
    stiff = f"{key}=35.97e9", "materials.PU.hyperelastic.bulk_modulus_Pa=1.6e11"
    said = [line for line in warned(tmp_path, *stiff) if key in line]
    assert said == [f"{key}: 3.597e+10 is out of the usual range 1000 to 1e+09; taken as meant"]
    assert [line for line in warned(tmp_path) if "usual range" in line] == []


@pytest.mark.parametrize(
    ("override", "said"),
    [
        ("materials.PU.hyperelastic.c10_Pa=0.7", "looks like MPa: that is 700000 in c10_Pa"),
        ("materials.PU.hyperelastic.c10_Pa=1e13", "1e+13 is out of the range 1000 to 1e+09"),
        ("gravity_m_per_s2=[0, 0, -981]", "looks like cm/s2: that is -9.81 in gravity_m_per_s2"),
        ("screen.inclination_deg=100", "100 is out of the range up to 90"),
    ],
)
def test_slips_of_units_and_what_is_out_of_all_proportion_are_refused(
    tmp_path: Path, override: str, said: str
) -> None:
    assert said in only_complaint(tmp_path, override)


def test_a_feed_that_never_feeds_is_said(tmp_path: Path) -> None:
    """The run of 0.1 s has one batch at t = 0, when nothing is due; then 50 of them."""
    slow = FEED.replace("rate_kg_per_s=1,", "rate_kg_per_s=0.5,")
    found = warned(tmp_path, slow, "particles.feed_interval_s=0.5")
    (said,) = [line for line in found if 'feed "chute"' in line]
    assert said.startswith('feed "chute" feeds nothing in 0.1 s: its batches come every 0.5 s')
    assert [line for line in warned(tmp_path, slow) if 'feed "chute"' in line] == []


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (("rate_kg_per_s=1,", "rate_kg_per_s=1e-4,"), '"chute" feeds nothing in 0.1 s'),
        (("rate_kg_per_s=1,", "rate_kg_per_s=1, start_s=0.0995,"), '"chute" feeds nothing in 0.1 s'),
        (("rate_kg_per_s=1,", "rate_kg_per_s=1, start_s=0.08,"), None),
    ],
)
def test_a_feed_that_brings_no_particle_before_the_end_is_said(
    tmp_path: Path, change: tuple[str, str], said: str | None
) -> None:
    """Too slow for one particle, or begun after the last batch."""
    found = [line for line in warned(tmp_path, FEED.replace(*change)) if 'feed "chute"' in line]
    assert len(found) == (said is not None)
    assert all(said in line for line in found if said)


@pytest.mark.parametrize(("duration_s", "told"), [("0.1", True), ("30", False)])
def test_a_feed_that_brings_nothing_of_its_coarsest_sizes_is_said(
    tmp_path: Path, duration_s: str, told: bool
) -> None:
    """Lumps of 90 mm are a tenth of the mass: half of the first is due when five times its mass have come."""
    lumps = FEED.replace("mass_fraction=1", "mass_fraction=0.9").replace(
        "}]", "}, {smallest_m=0.09, largest_m=0.09, mass_fraction=0.1}]"
    )
    found = warned(tmp_path, lumps, f"duration_s={duration_s}")
    said = 'feed "chute" brings no particle of 90 to 90 mm in 0.1 s, which are 10 % of its mass'
    assert any(line.startswith(said) for line in found) == told


@pytest.mark.parametrize(("count", "told"), [(40, True), (188, False)])
def test_a_block_that_loses_its_coarsest_sizes_is_said(tmp_path: Path, count: int, told: bool) -> None:
    """Half of the mass each, and mean cubes of 167.75 and 15 650 mm3: one in 1 + 93.3 particles is large."""
    sizes = "{smallest_m=0.005, largest_m=0.006, mass_fraction=0.5}, "
    sizes += "{smallest_m=0.024, largest_m=0.026, mass_fraction=0.5}"
    block = BLOCK[: BLOCK.index("[{") + 1] + sizes + BLOCK[BLOCK.index("}]") + 1 :]
    found = warned(tmp_path, block.replace("count=1,", f"count={count},"))
    said = (
        "40 particles cannot have its sizes: 0 % of their mass is of 24 to 26 mm instead of 50 %; one in 94.3"
    )
    assert any(said in line for line in found) == told


@pytest.mark.parametrize(
    ("overrides", "wanted"),
    [
        (["probes.grain.particle=1"], ""),
        (["probes.grain.particle=2"], "it is on particle 2, but the bed has 1 at t = 0; give a lower number"),
        (["probes.grain.particle=2", BLOCK], ""),
        (["probes.grain.particle=20", FEED], ""),
        (["probes.grain.particle=200", FEED], "but the bed has 1 at t = 0 and some 36 are fed; give"),
        (["probes.grain.particle=1", "particles.solver=none"], "but the bed has 0 at t = 0; give"),
    ],
)
def test_a_probe_on_a_particle_that_never_comes_is_said(
    tmp_path: Path, overrides: list[str], wanted: str
) -> None:
    found = warned(tmp_path, *overrides)
    said = [line for line in found if line.startswith('probe "grain" records nothing: ')]
    assert len(said) == bool(wanted)
    assert wanted in "".join(said)


def test_a_feed_whose_last_batch_is_long_before_the_end_is_said(tmp_path: Path) -> None:
    found = warned(tmp_path, FEED, "particles.feed_interval_s=0.06")
    (said,) = [line for line in found if 'feed "chute"' in line]
    assert 'feed "chute" feeds 0.06 of the 0.1 kg that are due in 0.1 s' in said


def test_a_feed_interval_that_is_rounded_is_said(tmp_path: Path) -> None:
    sets = (FEED, "particles.feed_interval_s=7e-5", "coupling.sync_interval_s=5e-5")
    (said,) = [line for line in warned(tmp_path, *sets) if "feed_interval_s" in line]
    assert "particles.feed_interval_s = 7e-05 s is taken as 5e-05 s" in said


def test_a_drive_without_run_up_under_a_panel_is_said(tmp_path: Path) -> None:
    """5 mm at 78.5 rad/s from t = 0: 0.39 m/s."""
    driven = (
        "frames.solver=prescribed",
        "screen.frames.driving.drive={amplitude_m=[0.003, 0, 0.004], speed_rad_per_s=78.5}",
    )
    (said,) = [line for line in warned(tmp_path, *driven) if "run_up_s" in line]
    assert 'frame "driving" moves at 0.393 m/s from t = 0, while panel deck on it is at rest' in said
    assert "two cycles are 0.16 s" in said
    smooth = "screen.frames.driving.drive.run_up_s=0.16"
    assert [line for line in warned(tmp_path, *driven, smooth) if "run_up_s" in line] == []


@pytest.mark.parametrize(("youngs_modulus_Pa", "said"), [(1e4, True), (1e6, False)])
def test_contacts_that_cannot_carry_an_impact_are_a_warning(
    tmp_path: Path, youngs_modulus_Pa: float, said: bool
) -> None:
    soft = f"particles.largest_youngs_modulus_Pa={youngs_modulus_Pa}"
    found = warnings(loaded(tmp_path, [soft]))
    assert any("particles are expected to sink into what they meet" in one for one in found) is said


def test_times_that_are_rounded_to_sync_intervals_are_said(tmp_path: Path) -> None:
    sets = ("coupling.sync_interval_s=1.3e-4", "output.series_s=7e-4", "output.interval_s=0.0143")
    said = [line for line in warned(tmp_path, *sets) if "is taken as" in line]
    assert said == [
        "output.series_s = 0.0007 s is taken as 0.00078 s, a whole number of sync intervals of 0.00013 s"
    ]


@pytest.mark.parametrize("solver", ["exudyn", "planar", "two-mass"])
def test_a_solver_of_frames_wants_frames(solver: str) -> None:
    """The strip is clamped to the ground on both sides."""
    strip = ROOT / "tools/bench/scenes/strip-drop"
    (refusal,) = find_problems(load_judged(strip, None, [f"frames.solver={solver}"]))
    assert f"frames.solver: {solver} has no frame to move; frames.solver = " in str(refusal)
