"""Each check, by a case with just that mistake."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from orchestrator.case.solver_plans import panel_plans
from orchestrator.cli.overview import overview
from orchestrator.ports.plans import PanelPlan, SolverFailed
from orchestrator.preflight.check import find_problems, warnings
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.stability.report import stability_report
from tests.cases import (
    BLOCK,
    CASE,
    FEED,
    case_folder,
    complaints,
    keys_and_kinds,
    kinds,
    loaded,
    only_complaint,
)
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
    ("override", "wanted"),
    [
        # names
        ("probes.middle.panel=dekc", "probes.middle.panel: unknown-name"),
        ("probes.middle.panel=deck-1", "probes.middle.panel: unknown-name"),
        ("screen.exciters.shaft.frame=driven", "screen.exciters.shaft.frame: unknown-name"),
        ('screen.panels.deck.frames=["x", "ground"]', "screen.panels.deck.frames.0: unknown-name"),
        ("bed.particles.ball.material=coat", "bed.particles.ball.material: unknown-name"),
        (f"screen.frames.ground={{{FRAME}}}", "screen.frames.ground: conflict"),
        (f"screen.frames.deck={{{FRAME}}}", "screen.panels.deck: conflict"),
        ('probes.driving={panel="deck", at=[0, 0]}', "probes.driving: conflict"),
        # materials and contacts
        ("contacts.1.between.1=PU", "contacts.1.between: conflict"),
        ("contacts=[]", "contacts: missing"),
        ("screen.panels.deck.material=coal", "materials.coal.hyperelastic: missing"),
        ("materials.slag.density_kg_per_m3=2900", "materials.slag.poisson_ratio: missing"),
        ("materials.PU.hyperelastic={c10_Pa=0, c01_Pa=0}", "materials.PU.hyperelastic.c10_Pa: out-of-range"),
        # mounting
        ("screen.panels.deck.clamp_angel_deg=5", "screen.panels.deck.clamp_angel_deg: unknown-key"),
        ("screen.panels.deck.moulded_sag_m=0.08", "screen.panels.deck.moulded_sag_m: out-of-range"),
        # machine
        ("screen.frames.driven={inertia_kg_m2=[1, 1, 1]}", "screen.frames.driven.mass_kg: missing"),
        ("screen.frames.driven.mass_kg=1", "screen.frames.driven.inertia_kg_m2: missing"),
        (
            f"screen.frames.driven={{{FRAME.rsplit(',', 3)[0]}}}",
            "screen.frames.driven.center_of_mass_m: missing",
        ),
        ("screen.frames.driving.drive.speed_rad_per_s=78.5", "screen.exciters.shaft.frame: conflict"),
        (
            "screen.frames.driving.drive={speed_rad_per_s=9, amplitude_m=[0.1, 0, 0], phase_rad=[0.5, 0, 0]}",
            "screen.frames.driving.drive.phase_rad: conflict",
        ),
        (
            "screen.frames.driving.drive={speed_rad_per_s=9, rotation_rad=[0, 0.1, 0], center_m=[0, 0, 0], "
            "rotation_phase_rad=[0, 0.5, 0]}",
            "screen.frames.driving.drive.rotation_phase_rad: conflict",
        ),
        ("screen.frames.driving.inertia_kg_m2=[1, 1, 3]", "screen.frames.driving.inertia_kg_m2: conflict"),
        (
            'screen.bushings.isolation.between=["driving", "driving"]',
            "screen.bushings.isolation.between: conflict",
        ),
        (
            "screen.bushings.isolation.stiffness_N_per_m=[0, 0, 0]",
            "screen.bushings.isolation.stiffness_N_per_m: out-of-range",
        ),
        ("screen.exciters.shaft.frame=ground", "screen.exciters.shaft.frame: conflict"),
        ("screen.exciters.shaft.start=[0, 1, 1]", "screen.exciters.shaft.start: conflict"),
        ("screen.exciters.shaft.axis=[0, 0, 0]", "screen.exciters.shaft.axis: out-of-range"),
        ("screen.panels.deck.span_m=0.31", "screen.panels.deck.span_m: conflict"),
        ("screen.panels.deck.tension_m=-0.2", "screen.panels.deck.tension_m: out-of-range"),
        ("screen.panels.deck.across=[1, 1, 0]", "screen.panels.deck.across: conflict"),
        (
            "materials.PU.hyperelastic.bulk_modulus_Pa=1e5",
            "materials.PU.hyperelastic.bulk_modulus_Pa: out-of-range",
        ),
        ("screen.panels.deck.across=[0, -1, 0]", "screen.panels.deck.across: conflict"),
        ("probes.middle.particle=1", "probes.middle: conflict"),
        ("probes.end.point_m=[0, 0, 0]", "probes.end: conflict"),
        ("probes.end.frame=driving", "probes.end.point_m: missing"),
        ("probes.end={frame='ground', point_m=[0, 0, 0]}", "probes.end.frame: conflict"),
        (f"screen.frames.driven={{{FRAME}}}", "screen.frames.driven: conflict"),
        ("screen.bushings.isolation.stiffness_N_per_m.2=0", "screen.frames.driving: conflict"),
        # boxes and sizes
        ("domain_m=[[-1, -1, -1], [1, -1, 1]]", "domain_m: out-of-range"),
        (
            BLOCK.replace("smallest_m=0.01", "smallest_m=0.03"),
            "bed.blocks.coal.sizes.0.smallest_m: out-of-range",
        ),
        (BLOCK.replace("fraction=1", "fraction=0.5"), "bed.blocks.coal.sizes: out-of-range"),
        (BLOCK.replace("[0.1, 0.1, 0.2]", "[0.1, 0.1, 0]"), "bed.blocks.coal.box_m: out-of-range"),
        (BLOCK.replace("count=1", "count=1000000"), "bed.blocks.coal.count: out-of-range"),
        (BLOCK.replace("count=1", "count=300"), "bed.blocks.coal.count: misplaced"),
        (
            BLOCK.replace("0.1], [0.1, 0.1, 0.2", "-0.01], [0.1, 0.1, 0.01"),
            "bed.blocks.coal.box_m: misplaced",
        ),
        (BLOCK.replace("0.1], [0.1, 0.1, 0.2", "1.2], [0.1, 0.1, 1.3"), "bed.blocks.coal.box_m: misplaced"),
        # counts that no machine could hold
        (BLOCK.replace("count=1", "count=1000000000"), "bed.blocks.coal.count: out-of-range"),
        ("screen.panels.deck.count=1000000000", "screen.panels.deck.count: out-of-range"),
        ("panel.cells=[22, 100000]", "panel.cells.1: out-of-range"),
        # feeds
        (FEED.replace("rate_kg_per_s=1", "rate_kg_per_s=10"), "bed.feeds.chute.rate_kg_per_s: out-of-range"),
        (FEED.replace("0, -1]", "0, 0]"), "bed.feeds.chute.rate_kg_per_s: out-of-range"),
        (FEED.replace("sizes", "start_s=1, stop_s=0.5, sizes"), "bed.feeds.chute.stop_s: out-of-range"),
        (FEED.replace("0.1, 0.2]]", "0.1, 1.2]]"), "bed.feeds.chute.box_m: misplaced"),
        (FEED.replace("0, 0.1]", "0, -0.1]"), "bed.feeds.chute.box_m: misplaced"),
        (FEED.replace("sizes", "start_s=0.1, sizes"), "bed.feeds.chute.start_s: out-of-range"),
        (FEED.replace("0.02, mass", "0.12, mass"), "bed.feeds.chute.box_m: out-of-range"),
        (
            FEED.replace("sizes=", "curve=[{sieve_size_m=0.1, passing=1}], sizes="),
            "bed.feeds.chute.curve: conflict",
        ),
        # exits
        (EXIT.replace("-0.3]]", "-0.6]]"), "screen.exits.under.box_m: out-of-range"),
        ("bulk.heap.box_m=[[0, 0, 0], [0.1, 0.1, 0]]", "bulk.heap.box_m: out-of-range"),
        (EXIT.replace("-0.5], [1, 1, -0.3", "-1.5], [1, 1, -1.3"), "screen.exits.under.box_m: misplaced"),
        (EXIT.replace("-0.3]]", "0.1]]"), "screen.exits.under.box_m: misplaced"),
        (EXIT.replace("-0.3]]", "-0.49]]"), "screen.exits.under.box_m: out-of-range"),
        # sizes of values
        ("screen.panels.deck.thickness_m=4", "screen.panels.deck.thickness_m: out-of-range"),
        ("materials.coal.density_kg_per_m3=1.43", "materials.coal.density_kg_per_m3: out-of-range"),
        (
            "screen.bushings.isolation.stiffness_N_per_m.0=0.225",
            "screen.bushings.isolation.stiffness_N_per_m.0: out-of-range",
        ),
        ("materials.coal.youngs_modulus_Pa=990", "materials.coal.youngs_modulus_Pa: out-of-range"),
        ("materials.PU.hyperelastic.c10_Pa=0.7", "materials.PU.hyperelastic.c10_Pa: out-of-range"),
        ("bed.particles.ball.sieve_size_m=20", "bed.particles.ball.sieve_size_m: out-of-range"),
        ("screen.exciters.shaft.speed_rad_per_s=1500", "screen.exciters.shaft.speed_rad_per_s: out-of-range"),
        ("duration_s=2e4", "duration_s: out-of-range"),
        (
            "bed.particles.ball.spin_rad_per_s=[0, 1e300, 0]",
            "bed.particles.ball.spin_rad_per_s.1: out-of-range",
        ),
        # times
        ("duration_s=1e-5", "duration_s: out-of-range"),
        ("output.interval_s=1e-6", "output.interval_s: out-of-range"),
        ("particles.rayleigh_fraction=0.0", "particles.rayleigh_fraction: out-of-range"),
        ("particles.step_s=2e-4", "particles.step_s: out-of-range"),
        # the start
        ("bed.particles.ball.position_m=[0.15, 0.1, 0.009]", "bed.particles.ball.position_m: misplaced"),
        ("bed.particles.ball.position_m=[0, 0, 2]", "bed.particles.ball.position_m: misplaced"),
        ("screen.panels.deck.corner_m=[0.8, 0, 0]", "screen.panels.deck.corner_m: misplaced"),
    ],
)
def test_one_mistake_is_found_at_its_key(tmp_path: Path, override: str, wanted: str) -> None:
    assert wanted in kinds(tmp_path, override)


def test_a_share_of_the_rayleigh_time_above_the_limit_is_refused(tmp_path: Path) -> None:
    assert kinds(tmp_path, "particles.rayleigh_fraction=0.3", "coupling.sync_interval_s=1e-3") == [
        "particles.rayleigh_fraction: out-of-range"
    ]


def test_a_hinge_holds_no_angle(tmp_path: Path) -> None:
    sets = ("screen.panels.deck.clamp_m=0.0", "screen.panels.deck.clamp_angle_deg=5")
    assert kinds(tmp_path, *sets) == ["screen.panels.deck.clamp_angle_deg: conflict"]


def test_a_row_of_panels_needs_a_pitch_without_overlap(tmp_path: Path) -> None:
    row = "screen.panels.deck.count=2"
    assert kinds(tmp_path, row, "probes.middle.panel=deck-1") == ["screen.panels.deck.pitch_m: missing"]
    close = complaints(tmp_path, row, "screen.panels.deck.pitch_m=0.3", "probes.middle.panel=deck-2")
    assert "at least 0.34 m, which span and two clamps take" in close[0]
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

    def problems_of(*overrides: str) -> list[str]:
        return [str(mistake) for mistake in find_problems(load_judged(folder, None, [*given, *overrides]))]

    assert problems_of() == []  # exudyn: one driven without a mass, one free that hangs on it
    assert problems_of("frames.solver=prescribed") == []
    (refusal,) = problems_of("frames.solver=two-mass")
    assert "frames.solver two-mass knows no drives; take the drive out" in refusal
    centre = "screen.frames.driving.drive.center_m=[0, 0, 0]"
    drive = "screen.frames.driving.drive.rotation_rad=[1, 1, 0.5]"
    (refusal,) = problems_of(drive)
    assert "drive.center_m: missing: rotation_rad turns the frame about it" in refusal
    (refusal,) = problems_of(drive, centre)
    assert "rotation_rad: may add up to 1.5 rad; exudyn's limit is 1.4" in refusal
    assert problems_of(drive, centre, "frames.solver=prescribed") == []


def test_exudyn_may_drive_every_frame() -> None:
    case = Path(__file__).parents[2] / "cases" / "bushing-hysteresis"
    assert find_problems(load_judged(case, "draft", ["frames.solver=exudyn"])) == []


def test_a_drive_that_runs_up_may_have_any_phase(tmp_path: Path) -> None:
    drive = "screen.frames.driving.drive={speed_rad_per_s=9, amplitude_m=[0.1, 0, 0], run_up_s=1"
    messages = complaints(tmp_path, drive + ", phase_rad=[0.5, 0, 0]}")
    assert messages
    assert not any("jump" in complaint for complaint in messages)


def test_feeds_may_not_share_a_box(tmp_path: Path) -> None:
    other = FEED.replace("chute", "second")
    assert kinds(tmp_path, FEED, other) == ["bed.feeds.second.box_m: misplaced"]
    assert not complaints(tmp_path, FEED)


def test_a_feed_may_stand_on_a_panel(tmp_path: Path) -> None:
    assert not complaints(tmp_path, FEED.replace("0, 0.1]", "0, 0]"))


def test_tension_or_span_must_be_given(tmp_path: Path) -> None:
    folder = case_folder(tmp_path, CASE.replace("tension_m = 0.002", ""))
    (problem,) = find_problems(load_judged(folder))
    assert problem.what == "missing"
    assert problem.hint == "give tension_m or span_m"


def test_overlapping_particles_are_named(tmp_path: Path) -> None:
    other = 'bed.particles.other={position_m=[0.15, 0.1, 0.069], sieve_size_m=0.02, material="coal"}'
    complaint = only_complaint(tmp_path, other)
    assert '"ball" overlaps "other" by 0.001 m' in complaint
    assert not complaints(tmp_path, other.replace("0.069", "0.0701"))


def test_a_sync_interval_above_a_tenth_of_the_contact_is_a_warning(tmp_path: Path) -> None:
    slow = loaded(tmp_path, ["coupling.sync_interval_s=5e-4"])
    (warning,) = [line for line in stability_report(slow.case).warnings() if "accuracy" in line]
    assert "should last ten exchanges" in warning
    fast = loaded(tmp_path, ["coupling.sync_interval_s=1.5e-5"])
    assert list(stability_report(fast.case).warnings()) == []


def test_settings_that_a_strip_does_not_have(tmp_path: Path) -> None:
    strip = "panel.solver=strip"
    assert kinds(tmp_path, strip, "panel.integrator=implicit") == ["panel.integrator: solver"]
    assert kinds(tmp_path, strip, "panel.cells=[1, 1]") == ["panel.cells.0: solver"]


def test_frames_may_hang_on_each_other_and_drop_when_not_drawn_at_rest(tmp_path: Path) -> None:
    frame = f"screen.frames.driven={{{FRAME}}}"
    shear = (
        'screen.bushings.shear={between=["driving", "driven"], positions_m=[[0, 0.1, 0]], '
        "stiffness_N_per_m=[0, 0, 2e4], rotation_deg=[0, -30, 0]}"  # upright again
    )
    assert not complaints(tmp_path, frame, shear, "screen.inclination_deg=30")
    assert kinds(tmp_path, frame, shear) == ["screen.frames.driven: conflict"]
    assert not complaints(tmp_path, frame, "screen.drawn_at_rest=false")


def test_bushings_must_keep_frames_from_tipping(tmp_path: Path) -> None:
    """The run used to refuse such frames, after a check that had found nothing."""
    turns, beside = "frames.solver=exudyn", "screen.frames.driving.center_of_mass_m=[0.1, 0.1, 0]"
    bushing = "screen.bushings.isolation.positions_m=[[0, 0.1, 0]]"
    assert complaints(tmp_path, turns, bushing) == complaints(tmp_path, turns, beside) == []
    assert kinds(tmp_path, turns, bushing, beside) == ["screen.frames.driving: conflict"]
    assert complaints(tmp_path, turns, bushing, beside, "screen.drawn_at_rest=false") == []
    aside = "screen.frames.driving.center_of_mass_m=[0, 0, 0]"
    assert "keeps it from tipping" in only_complaint(tmp_path, turns, aside)


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
        assert kinds(tmp_path, *sets) == ["screen.panels.twin.corner_m: misplaced"]
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
        assert kinds(tmp_path, lid, ball) == ["screen.surfaces.lid.corner_m: misplaced"]
    else:
        assert complaints(tmp_path, lid, ball) == []


def test_a_panel_step_above_the_solvers_limit_is_refused_with_the_limit(tmp_path: Path) -> None:
    strip = ("panel.solver=strip", "panel.cells=[22, 1]")
    complaint = only_complaint(tmp_path, *strip, "panel.step_s=1e-3")
    assert "panel.step_s: 0.001 s is above the limit" in complaint
    assert "or 0 for the solver's own" in complaint
    assert not complaints(tmp_path, *strip, "panel.step_s=1e-6")


def test_the_shortest_panel_limits_the_step(tmp_path: Path) -> None:
    """A strip's limit is that of a wave through a cell: cells of half the length have half of it."""
    sets = ["panel.solver=strip", "panel.cells=[22, 1]"]
    short = (
        'screen.panels.short={material="PU", frames=["driving", "ground"], corner_m=[0, 0, -0.5], '
        "length_m=0.15, width_m=0.2, thickness_m=0.004, clamp_m=0.019, tension_m=0.001}"
    )
    case = loaded(tmp_path, sets).case
    limit = case.panel.adapter.largest_step_s
    assert limit is not None
    (limit_s,) = map(limit, panel_plans(case))
    step = f"panel.step_s={0.8 * limit_s}"
    assert not complaints(tmp_path, *sets, step)
    assert only_complaint(tmp_path, *sets, short, step).startswith("--set panel.step_s: ")


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
    assert kinds(tmp_path, EXIT, across, "domain_m.1.0=3") == ["screen.exits.over.box_m: misplaced"]


def test_fines_left_out_are_said(tmp_path: Path) -> None:
    feed = FEED.replace("sizes", "smallest_fed_m=0.015, sizes")
    lines = warnings(loaded(tmp_path, [feed]))
    assert any({"chute:", "27.1%"} <= {*line.split()} for line in lines)


def test_what_a_sample_leaves_out_is_said(tmp_path: Path) -> None:
    feed = FEED.replace("sizes", "sampled_below_m=0.015, sampled_as_m=0.02, sizes")
    lines = warnings(loaded(tmp_path, [feed]))
    (line,) = (line for line in lines if line.startswith("chute:"))
    assert re.findall(r"[\d.]+", line)[:5] == ["10", "15", "27.1", "3.94", "20.2"]


def test_a_sample_that_cannot_be_is_refused(tmp_path: Path) -> None:
    feed = FEED.replace("sizes", "sampled_below_m=0.015, sampled_as_m=0.01, sizes")
    assert "chute.sampled_as_m: 0.01 m is less than sampled_below_m" in only_complaint(tmp_path, feed)
    block = BLOCK.replace("sizes", "sampled_below_m=0.015, sizes")
    assert kinds(tmp_path, block) == ["bed.blocks.coal.sampled_below_m: unknown-key"]


def warned(folder: Path, *overrides: str) -> list[str]:
    """Return the warnings of a case without mistakes."""
    given = loaded(folder, overrides)
    assert find_problems(given) == []
    return warnings(given)


def test_steel_panels_are_said_to_be_unusual_and_taken(tmp_path: Path) -> None:
    """E = 6 (c10 + c01) = 216 GPa; no unit makes a soft panel of it."""
    key = "materials.PU.hyperelastic.c10_Pa"
    stiff = f"{key}=35.97e9", "materials.PU.hyperelastic.bulk_modulus_Pa=1.6e11"
    lines = [line for line in warned(tmp_path, *stiff) if key in line]
    assert lines == [f"{key}: 3.597e+10 is out of the usual range 1000 to 1e+09 Pa; taken as meant"]
    assert [line for line in warned(tmp_path) if "usual range" in line] == []


def test_a_solver_that_keeps_the_volume_says_what_it_makes_of_a_compressible_panel(tmp_path: Path) -> None:
    """E = 20 MPa and nu = 0.3 are mu = 7.692 MPa and K = 16.67 MPa; with nu = 0.5 it is 3 mu = 23.1 MPa."""
    law = "materials.PU.hyperelastic"
    given = f"{law}.c10_Pa=3.846e6", f"{law}.c01_Pa=0", f"{law}.bulk_modulus_Pa=16.667e6"
    (line,) = [line for line in warned(tmp_path, *given) if "incompressible" in line]
    assert line.endswith("with Young's modulus 2.31e+07 Pa; that of this material is 2e+07 Pa")
    assert [line for line in warned(tmp_path, *given, "panel.solver=solid") if "incompressible" in line] == []
    assert [line for line in warned(tmp_path) if "incompressible" in line] == []


@pytest.mark.parametrize(
    ("override", "wanted"),
    [
        ("materials.PU.hyperelastic.c10_Pa=0.7", "materials.PU.hyperelastic.c10_Pa: out-of-range"),
        ("materials.PU.hyperelastic.c10_Pa=1e13", "materials.PU.hyperelastic.c10_Pa: out-of-range"),
        ("gravity_m_per_s2=[0, 0, -981]", "gravity_m_per_s2.2: out-of-range"),
        ("screen.inclination_deg=100", "screen.inclination_deg: out-of-range"),
    ],
)
def test_slips_of_units_and_what_is_out_of_all_proportion_are_refused(
    tmp_path: Path, override: str, wanted: str
) -> None:
    assert kinds(tmp_path, override) == [wanted]


def test_a_feed_that_never_feeds_is_said(tmp_path: Path) -> None:
    """The run of 0.1 s has one batch at t = 0, when nothing is due; then 50 of them."""
    slow = FEED.replace("rate_kg_per_s=1,", "rate_kg_per_s=0.5,")
    lines = warned(tmp_path, slow, "particles.feed_interval_s=0.5")
    (warning,) = [line for line in lines if 'feed "chute"' in line]
    assert warning.startswith('feed "chute" feeds nothing in 0.1 s: its batches come every 0.5 s')
    assert [line for line in warned(tmp_path, slow) if 'feed "chute"' in line] == []


@pytest.mark.parametrize(
    ("change", "warning"),
    [
        (("rate_kg_per_s=1,", "rate_kg_per_s=1e-4,"), '"chute" feeds nothing in 0.1 s'),
        (("rate_kg_per_s=1,", "rate_kg_per_s=1, start_s=0.0995,"), '"chute" feeds nothing in 0.1 s'),
        (("rate_kg_per_s=1,", "rate_kg_per_s=1, start_s=0.08,"), None),
    ],
)
def test_a_feed_that_brings_no_particle_before_the_end_is_said(
    tmp_path: Path, change: tuple[str, str], warning: str | None
) -> None:
    """The feed is too slow for one particle, or begins after the last batch."""
    lines = [line for line in warned(tmp_path, FEED.replace(*change)) if 'feed "chute"' in line]
    assert len(lines) == (warning is not None)
    assert all(warning in line for line in lines if warning)


@pytest.mark.parametrize(("duration_s", "warns"), [("0.1", True), ("30", False)])
def test_a_feed_that_brings_nothing_of_its_coarsest_sizes_is_said(
    tmp_path: Path, duration_s: str, warns: bool
) -> None:
    """Lumps of 90 mm are a tenth of the mass: half of the first is due when five times its mass have come."""
    lumps = FEED.replace("mass_fraction=1", "mass_fraction=0.9").replace(
        "}]", "}, {smallest_m=0.09, largest_m=0.09, mass_fraction=0.1}]"
    )
    lines = warned(tmp_path, lumps, f"duration_s={duration_s}")
    warning = 'feed "chute" brings no particle of 90 to 90 mm in 0.1 s, which are 10 % of its mass'
    assert any(line.startswith(warning) for line in lines) == warns


@pytest.mark.parametrize(("count", "warns"), [(40, True), (188, False)])
def test_a_block_that_loses_its_coarsest_sizes_is_said(tmp_path: Path, count: int, warns: bool) -> None:
    """Half of the mass each, and mean cubes of 167.75 and 15 650 mm3: one in 1 + 93.3 particles is large."""
    sizes = "{smallest_m=0.005, largest_m=0.006, mass_fraction=0.5}, "
    sizes += "{smallest_m=0.024, largest_m=0.026, mass_fraction=0.5}"
    block = BLOCK[: BLOCK.index("[{") + 1] + sizes + BLOCK[BLOCK.index("}]") + 1 :]
    lines = warned(tmp_path, block.replace("count=1,", f"count={count},"))
    warning = (
        "40 particles cannot have its sizes: 0 % of their mass is of 24 to 26 mm instead of 50 %; one in 94.3"
    )
    assert any(warning in line for line in lines) == warns


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
    lines = warned(tmp_path, *overrides)
    warning = [line for line in lines if line.startswith('probe "grain" records nothing: ')]
    assert len(warning) == bool(wanted)
    assert wanted in "".join(warning)


def test_a_feed_whose_last_batch_is_long_before_the_end_is_said(tmp_path: Path) -> None:
    lines = warned(tmp_path, FEED, "particles.feed_interval_s=0.06")
    (warning,) = [line for line in lines if '"chute"' in line]
    assert re.findall(r"[\d.]+", warning)[:3] == ["0.06", "0.1", "0.1"]


def test_a_feed_interval_that_is_rounded_is_said(tmp_path: Path) -> None:
    sets = (FEED, "particles.feed_interval_s=7e-5", "coupling.sync_interval_s=5e-5")
    (warning,) = [line for line in warned(tmp_path, *sets) if "feed_interval_s" in line]
    assert re.findall(r"\S+e-05", warning) == ["7e-05", "5e-05", *re.findall(r"\S+e-05", warning)[2:]]


def test_a_drive_without_run_up_under_a_panel_is_said(tmp_path: Path) -> None:
    """5 mm at 78.5 rad/s from t = 0: 0.39 m/s."""
    driven = (
        "frames.solver=prescribed",
        "screen.frames.driving.drive={amplitude_m=[0.003, 0, 0.004], speed_rad_per_s=78.5}",
    )
    (warning,) = [line for line in warned(tmp_path, *driven) if "run_up_s" in line]
    assert 'frame "driving" moves at 0.393 m/s from t = 0, while panel deck on it is at rest' in warning
    assert "two cycles are 0.16 s" in warning
    smooth = "screen.frames.driving.drive.run_up_s=0.16"
    assert [line for line in warned(tmp_path, *driven, smooth) if "run_up_s" in line] == []


@pytest.mark.parametrize(("youngs_modulus_Pa", "warns"), [(1e4, True), (1e6, False)])
def test_contacts_that_cannot_carry_an_impact_are_a_warning(
    tmp_path: Path, youngs_modulus_Pa: float, warns: bool
) -> None:
    soft = f"particles.largest_youngs_modulus_Pa={youngs_modulus_Pa}"
    lines = warnings(loaded(tmp_path, [soft]))
    assert any("particles are expected to sink into what they meet" in line for line in lines) is warns


def test_times_that_are_rounded_to_sync_intervals_are_said(tmp_path: Path) -> None:
    sets = ("coupling.sync_interval_s=1.3e-4", "output.series_s=7e-4", "output.interval_s=0.0143")
    (line,) = [line for line in warned(tmp_path, *sets) if line.startswith("output.")]
    assert {"output.series_s", "0.0007", "0.00078", "0.00013"} <= {*line.split()}


@pytest.mark.parametrize(
    ("duration_s", "taken_s"), [("0.1000001", "0.1001"), ("0.10005", "0.1001"), ("0.1001", "")]
)
def test_a_duration_that_is_a_little_longer_is_said(tmp_path: Path, duration_s: str, taken_s: str) -> None:
    """It ends in an interval of its own, and the overview has the length of the run."""
    judged = loaded(tmp_path, ["coupling.sync_interval_s=1e-4", f"duration_s={duration_s}"])
    lines = [line for line in warnings(judged) if line.startswith("duration_s")]
    assert [{duration_s, taken_s} <= {*line.split()} for line in lines] == [True] * bool(taken_s)
    assert any("1001 sync intervals" in line and "0.1001 s in all" in line for line in overview(judged))


@pytest.mark.parametrize("solver", ["exudyn", "two-mass"])
def test_a_solver_of_frames_wants_frames(solver: str) -> None:
    """The strip is clamped to the ground on both sides."""
    strip = ROOT / "tools/bench/scenes/strip-drop"
    refused = find_problems(load_judged(strip, None, [f"frames.solver={solver}"]))
    assert keys_and_kinds(refused) == ["frames.solver: solver"]
