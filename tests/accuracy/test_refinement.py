"""The settings of each case that a study can change: every one is a right case, and a missing one has a
reason."""

from __future__ import annotations

import pytest

from orchestrator.case.bed.grains import shapes
from orchestrator.case.file.errors import CaseError
from orchestrator.coupling.schemes import SCHEMES
from orchestrator.ports.clock import exact, steps_in
from orchestrator.preflight.check import find_problems
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.refinement import PARAMETERS, offer
from orchestrator.studies.accuracy.combinations import shared_sets
from orchestrator.studies.points import seed_sets
from orchestrator.workbench import Case
from tests.runs.outside import ROOT

QUICKSTART = ROOT / "cases/quickstart"


def test_every_setting_but_the_own_is_another_right_case() -> None:
    """The case has particles on strips. The scheme and model variants cover the registry."""
    case = load_judged(QUICKSTART, "draft").case
    there = offer(case, [*PARAMETERS], 3)
    assert there.missing == {
        "cut-off": "no block or feed has a smallest_fed_m",
        "shape": "all grains are single spheres",
    }
    assert {series.variant for series in there.of("coupling")} == set(SCHEMES)
    assert {series.variant for series in there.of("panel")} == {"rigid", "strip", "sheet", "solid"}
    assert {series.variant for series in there.of("frames")} == {"prescribed", "two-mass", "planar", "exudyn"}
    for series in there.series:
        lengths = [setting.h for setting in series.settings if setting.h is not None]
        assert lengths == sorted(lengths, reverse=True)
        for setting in series.settings:
            if setting.sets and series.variant not in ("solid", "two-mass") and not setting.needs_drives:
                loaded = load_judged(QUICKSTART, "draft", setting.sets)
                assert loaded.case != case
                assert not find_problems(loaded), setting
    for axis in there.titles:
        assert any(not setting.sets for series in there.of(axis) for setting in series.settings)


def test_a_step_fills_the_sync_interval_as_often_as_its_label_says() -> None:
    case = load_judged(QUICKSTART, "draft").case
    for name, key in (("particle-step", "particles"), ("panel-step", "panel")):
        (series,) = offer(case, [name], 3).series
        counts = [
            steps_in(case.coupling.sync_interval_s, float(setting.sets[0].partition("=")[2]))
            for setting in series.settings[1:]
        ]
        own = round(float(exact(case.coupling.sync_interval_s)) / (series.settings[0].h or 0))
        assert counts == [2 * own, 4 * own]
        assert all(setting.sets[0].startswith(f"{key}.step_s=") for setting in series.settings[1:])


@pytest.mark.parametrize(
    ("sets", "order"),
    [
        ((), 1.25),  # dampers
        (("contacts.0.restitution=1", "contacts.1.restitution=1"), 2.0),
    ],
)
def test_the_particles_step_is_of_second_order_but_for_dampers_that_set_in(
    sets: tuple[str, ...], order: float
) -> None:
    case = load_judged(ROOT / "cases/ball-on-panel", "draft", sets).case
    (series,) = offer(case, ["particle-step"], 3).series
    assert (series.expected, bool(series.note)) == (order, order == 1.25)


@pytest.mark.parametrize(
    ("case", "missing"),
    [
        (
            "panel-cycle",
            {"particles-model", "particle-step", "stiffness", "slice", "number", "cut-off", "shape"},
        ),
        ("ball-on-panel", {"frames-model", "slice", "number", "cut-off", "shape"}),
        ("bushing-hysteresis", set(PARAMETERS) - {"sync", "frames-model", "duration"}),
    ],
)
def test_what_a_case_has_not_is_not_offered(case: str, missing: set[str]) -> None:
    there = offer(load_judged(ROOT / "cases" / case, "draft").case, [*PARAMETERS], 3)
    assert set(there.missing) == missing
    assert all(there.missing.values())


def test_grains_are_spheres_or_of_more_and_more_spheres() -> None:
    """A stone has 4; one between each two and three of them makes 9 and 16, as those within others go.  The
    sphere is of the same sieve size."""
    own = "bed.blocks.coal.shape=stone"
    (series,) = offer(load_judged(QUICKSTART, "draft", [own]).case, ["shape"], 4).series
    counts = []
    for setting in series.settings:
        loaded = load_judged(QUICKSTART, "draft", [own, *setting.sets])
        assert find_problems(loaded) == []
        counts.append(max(len(shape.spheres) for shape in shapes(loaded.case)))
        assert setting.label == f"{counts[-1]} sphere{'s' * (counts[-1] > 1)}"
    assert counts == [1, 4, 9, 16]
    assert [bool(setting.sets) for setting in series.settings] == [True, False, True, True]


@pytest.mark.parametrize("own_m", [0.042, 0.048, 0.084])
def test_every_slice_that_is_proposed_passes_the_check(own_m: float) -> None:
    """Openings every 6 mm, grains up to 9 mm: 42 mm are 7 pitches, of which half is none, and half of 48 mm
    are less than three grains."""
    folder, own = ROOT / "cases/ffs0827-slice", f"slice.width_m={own_m}"
    (series,) = offer(load_judged(folder, "draft", [own]).case, ["slice"], 3).series
    assert len(series.settings) >= 2
    for setting in series.settings:
        assert find_problems(load_judged(folder, "draft", [own, *setting.sets])) == []


def test_all_points_write_at_the_same_times_and_keep_their_intervals() -> None:
    judged = load_judged(QUICKSTART, "draft")
    case, shared = judged.case, shared_sets(Case(judged), 2e-4)
    at = load_judged(QUICKSTART, "draft", shared).case
    assert "shorten" not in at.monitor.model_dump().values()
    for time_s in (at.duration_s, at.output.interval_s, at.output.shapes_s):
        assert exact(time_s) % exact(at.output.series_s) == 0
    assert exact(at.output.series_s) % exact(2e-4) == 0
    assert at.duration_s == pytest.approx(case.duration_s, abs=at.output.series_s)


def test_seeds_change_the_random_numbers_and_nothing_else() -> None:
    case = Case(load_judged(QUICKSTART, "draft"))
    assert seed_sets(case, 0) == ()
    assert seed_sets(case, 2) == ("bed.blocks.coal.seed=3",)


def test_variants_can_be_chosen() -> None:
    case = load_judged(QUICKSTART, "draft").case
    there = offer(case, ["scheme=aitken+serial-staggered"], 2)
    assert {series.variant for series in there.series} == {"aitken", "serial-staggered"}
    with pytest.raises(CaseError, match=r'--parameters: no variant "sheat" .*; did you mean "sheet"\?'):
        offer(case, ["scheme=aitken", "panel-model=sheat"], 2)


def test_no_contact_is_stiffer_than_its_material() -> None:
    """The label and the length say what is run: 3.16 times this cap would be 1.2 times the material's own."""
    sets = ["particles.largest_youngs_modulus_Pa=3.8e8"]
    case = load_judged(ROOT / "cases/ball-on-panel", "draft", sets).case
    (series,) = offer(case, ("stiffness",), 3).series
    finest, own_Pa = series.settings[-1], case.materials["coal"].youngs_modulus_Pa
    assert finest.label == "9.9e+08 Pa"
    assert finest.h == pytest.approx((3.8e8 / own_Pa) ** 0.4)


@pytest.mark.parametrize(
    ("restitution", "order", "best"), [(0.34, 1.0, "aitken"), (1.0, 2.0, "particles-first")]
)
def test_damped_contacts_cost_particles_first_an_order(restitution: float, order: float, best: str) -> None:
    """The order falls in motion, by which settings are judged; iterated schemes keep theirs, and are nearer
    to the truth (docs/theory/coupling.md)."""
    sets = ["coupling.scheme=particles-first", *(f"contacts.{n}.restitution={restitution}" for n in (0, 1))]
    case = load_judged(ROOT / "cases/ball-on-panel", "draft", sets).case
    every = offer(case, ("sync", "scheme"), 2).series
    assert max(every, key=lambda series: series.rank).variant == best
    expected = {series.variant: series.expected for series in every}
    assert expected["particles-first"] == order
    assert (expected["aitken"], expected["serial-staggered"]) == (2.0, 1.0)


@pytest.mark.parametrize(("step_s", "is_said"), [("5e-5", True), ("2.5e-5", False)])
def test_a_panels_step_that_follows_the_interval_is_named(step_s: str, is_said: bool) -> None:
    """The finest interval is 2.5e-5 s, and no step is longer."""
    sets = ["panel.solver=strip", "panel.cells=[20,1]", f"panel.step_s={step_s}"]
    case = load_judged(ROOT / "cases/panel-cycle", "default", sets).case
    (series,) = offer(case, ("sync",), 4).series
    assert ("intervals below 5e-05 s are the panels' step" in series.note) == is_said
