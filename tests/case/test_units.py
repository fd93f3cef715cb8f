"""Numbers with units: what they become, where they may stand, and what is said of wrong ones."""

from __future__ import annotations

import math
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from orchestrator.case.file import hardness
from orchestrator.case.file.errors import CaseError, dotted_key
from orchestrator.case.file.units import KINDS, USUAL, in_own_units, parse_quantity, why_refused
from orchestrator.case.tables.quantities import unit_of
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.preflight.judge import load_judged
from orchestrator.studies.points import parse_vary
from orchestrator.studies.sweep_plan import Arrangement, plan_sweep
from tests.case.test_tables import FLOATS
from tests.cases import CASE, case_folder, complaints, kinds, load_case, loaded, only_complaint, problems

TURN_RAD = 2 * math.pi
FACTORS = (
    ("length_m", "mm", 1e-3),
    ("length_m", "in", 0.0254),
    ("mass_kg", "t", 1e3),
    ("mass_kg", "g", 1e-3),
    ("duration_s", "min", 60.0),
    ("duration_s", "us", 1e-6),
    ("wall_min", "h", 60.0),
    ("speed_rad_per_s", "rpm", TURN_RAD / 60),
    ("speed_rad_per_s", "Hz", TURN_RAD),
    ("speed_rad_per_s", "deg/s", TURN_RAD / 360),
    ("frequency_Hz", "rpm", 1 / 60),
    ("frequency_Hz", "rad/s", 1 / TURN_RAD),
    ("inclination_deg", "rad", 360 / TURN_RAD),
    ("phase_rad", "°", TURN_RAD / 360),
    ("rate_kg_per_s", "t/h", 1 / 3.6),
    ("density_kg_per_m3", "g/cm3", 1e3),
    ("velocity_m_per_s", "mm/s", 1e-3),
    ("gravity_m_per_s2", "m/s^2", 1.0),
    ("stiffness_N_per_m", "N/mm", 1e3),
    ("damping_N_s_per_m", "kN s/m", 1e3),
    ("c10_Pa", "MPa", 1e6),
    ("c10_Pa", "N/mm²", 1e6),
    ("stiffness_Pa_per_m", "MPa/mm", 1e9),
    ("mass_moment_kg_m", "kg mm", 1e-3),
    ("inertia_kg_m2", "kg mm2", 1e-6),
    ("work_of_adhesion_J_per_m2", "mJ/m2", 1e-3),
    ("specific_wear_m3_per_N_m", "mm3/(N m)", 1e-9),
    ("bearing_loss_N_m_s", "N·m·s", 1.0),
    ("rated_power_W", "kW", 1e3),
)


@settings(deadline=None)
@given(
    st.sampled_from(FACTORS),
    st.floats(-1e12, 1e12).filter(lambda x: x == 0 or abs(x) > 1e-12),
    st.sampled_from(["{0!r} {1}", "{0:g}{1}", " {0:.17e}  {1} "]),
)
def test_a_number_with_a_unit_is_the_number_times_the_factor(
    row: tuple[str, str, float], number: float, form: str
) -> None:
    key, unit, factor = row
    text = form.format(number, unit)
    written = float(text.strip().removesuffix(unit))
    assert parse_quantity(text, key) == pytest.approx(written * factor, rel=1e-14)


@settings(deadline=None)
@given(st.text(max_size=12), st.sampled_from(["length_m", "youngs_modulus_Pa", "speed_rad_per_s"]))
def test_any_text_becomes_a_finite_number_or_stays_a_text(text: str, key: str) -> None:
    value = in_own_units({key: text})[key]
    assert value is text or math.isfinite(value)


def test_decimals_are_converted_without_rounding() -> None:
    assert parse_quantity("10 us", "sync_interval_s") == 1e-5
    assert parse_quantity("0.1 mm", "length_m") == 1e-4


def test_every_unit_of_a_key_has_a_kind_and_an_example() -> None:
    assert {unit_of(key) for key in FLOATS} - {"1"} == set(KINDS)
    own = {unit_of(key): key for key in FLOATS}
    for unit, (_, example) in KINDS.items():
        assert parse_quantity(example, own[unit]) > 0


@pytest.mark.parametrize("unit", USUAL)
def test_every_proposed_unit_is_a_unit_of_some_key(unit: str) -> None:
    value = in_own_units({key: f"1 {unit}" for key in FLOATS})
    assert any(isinstance(number, float) for number in value.values())


def test_units_stand_in_a_case_a_level_and_set_alike(tmp_path: Path) -> None:
    text = (
        CASE.replace("speed_rad_per_s = 78.5", 'speed_rad_per_s = "750 rpm"')
        .replace("[0.15, 0.1, 0.05]", '["150 mm", 0.1, "5 cm"]')
        .replace("[[-1.0, -1.0, -1.0]", '[["-100 cm", -1.0, -1.0]')
        .replace("tension_m = 0.002", 'tension_m = "2 mm"')
        .replace("c10_Pa = 0.7e6", 'c10_Pa = "0.7 MPa"')
    )
    folder = case_folder(tmp_path, text, fine='[coupling]\nsync_interval_s = "50 us"\n')
    overrides = ["duration_s=100 ms", "bed.particles.ball.position_m.2=60 mm"]
    judged = load_judged(folder, "fine", overrides)
    case = judged.case
    assert case.screen.exciters["shaft"].speed_rad_per_s == pytest.approx(25 * math.pi, rel=1e-15)
    assert case.bed.particles["ball"].position_m == (0.15, 0.1, 0.06)
    assert case.domain_m[0] == (-1.0, -1.0, -1.0)
    assert case.screen.panels["deck"].tension_m == 0.002
    assert case.coupling.sync_interval_s == 5e-5
    assert case.duration_s == 0.1
    assert "screen.exciters.shaft.speed_rad_per_s" not in judged.changed
    assert load_case(tmp_path / "again", resolved_case(judged)).case == case
    numbers = resolved_case(judged)["screen"]["exciters"]["shaft"]
    assert isinstance(numbers["speed_rad_per_s"], float)


def test_a_deck_takes_its_tension_in_millimetres(tmp_path: Path) -> None:
    same = [loaded(tmp_path, [f"screen.panels.deck.tension_m={tension}"]) for tension in ("2 mm", "0.002")]
    assert same[0].case == same[1].case


@pytest.mark.parametrize(
    ("override", "wanted"),
    [
        ("screen.panels.deck.thickness_m=12 Hz", "screen.panels.deck.thickness_m: unit"),
        ("screen.panels.deck.thickness_m=4 m^0", "screen.panels.deck.thickness_m: unit"),
        ("screen.panels.deck.thickness_m=4 m/(", "screen.panels.deck.thickness_m: unit"),
        ("screen.panels.deck.thickness_m=1e9999999999999999999 m", "screen.panels.deck.thickness_m: unit"),
        ("screen.panels.deck.thickness_m=4 m/", "screen.panels.deck.thickness_m: unit"),
        ("screen.panels.deck.thickness_m=4 mn", "screen.panels.deck.thickness_m: unit"),
        ("screen.frames.driving.mass_kg=76 kgs", "screen.frames.driving.mass_kg: unit"),
        ("screen.exciters.shaft.speed_rad_per_s=78.5 deg-1", "screen.exciters.shaft.speed_rad_per_s: unit"),
        ("duration_s=0,1 s", "duration_s: unit"),
        ("duration_s='0.1'", "duration_s: unit"),
        ("duration_s='1e-3'", "duration_s: unit"),
        ("screen.panels.deck.thickness_m='5'", "screen.panels.deck.thickness_m: unit"),
        *(
            (f"screen.exciters.shaft.speed_rad_per_s=78{unit}", "screen.exciters.shaft.speed_rad_per_s: unit")
            for unit in (" 1/s", "/s", " s-1", " s^-1")
        ),
        ("screen.exciters.shaft.speed_rad_per_s=750 1/min", "screen.exciters.shaft.speed_rad_per_s: unit"),
        ("screen.panels.deck.thickness_m=78 1/s", "screen.panels.deck.thickness_m: unit"),
        ("duration_s=fast", "duration_s: wrong-type"),
        ("panel.cells=fast", "panel.cells: wrong-type"),
        ("gravity_m_per_s2.2=-1.6", "gravity_m_per_s2: wrong-type"),
        ("contacts.0.restitution=3 mm", "contacts.0.restitution: wrong-type"),
        ("contacts.0.restitution=34 %", "contacts.0.restitution: unit"),
        ("screen.panels.deck.thickness_m=5/32 in", "screen.panels.deck.thickness_m: unit"),
        ("screen.panels.deck.thickness_m=5/0 in", "screen.panels.deck.thickness_m: wrong-type"),
        (
            "screen.frames.driving.inertia_kg_m2=[2.0, '6 kg', 6.0]",
            "screen.frames.driving.inertia_kg_m2.1: unit",
        ),
        ("screen.panels.deck.tension_m=2 kJ", "screen.panels.deck.tension_m: unit"),
        ("screen.panels.deck.length_m=95 Shore A", "screen.panels.deck.length_m: unit"),
        ("materials.PU.hyperelastic.c10_Pa=95 Shore A", "materials.PU.hyperelastic.c10_Pa: unit"),
        ("materials.coal.youngs_modulus_Pa=99 Shore A", "materials.coal.youngs_modulus_Pa: unit"),
        ("screen.panels.deck.thickness_m=-4 mm", "screen.panels.deck.thickness_m: out-of-range"),
    ],
)
def test_wrong_units_are_refused_with_file_and_key(tmp_path: Path, override: str, wanted: str) -> None:
    (problem,) = problems(tmp_path, override.replace("'", '"'))
    assert problem.file == "--set"
    assert f"{dotted_key(problem.key)}: {problem.kind}" == wanted


@pytest.mark.parametrize(
    ("text", "key", "value"),
    [
        ("5/32 in", "thickness_m", "'0.15625 in'"),
        ("1 1/4 in", "thickness_m", "'1.25 in'"),
        ("34 %", "restitution", "0.34"),
    ],
)
def test_a_fraction_is_told_as_a_decimal(text: str, key: str, value: str) -> None:
    assert why_refused(text, (key,)).endswith(f"; write {value}")


def test_a_unit_is_not_guessed_at_where_one_was_given(tmp_path: Path) -> None:
    """A number without a unit, in a later layer, is guessed at again."""
    key, problem = "screen.panels.deck.thickness_m", "0.5 is out of the range 0.0002 to 0.05 m"
    assert only_complaint(tmp_path, f"{key}=500 mm").endswith(f"{key}: {problem}")
    assert kinds(tmp_path, f"{key}=0.5") == ["screen.panels.deck.thickness_m: out-of-range"]
    assert kinds(tmp_path, f"{key}=500 mm", f"{key}=0.5") == ["screen.panels.deck.thickness_m: out-of-range"]
    in_list = only_complaint(tmp_path, 'gravity_m_per_s2=["0 m/s2", 0, "-98100 cm/s2"]')
    assert in_list.endswith("-981 is out of the range up to 100 m/s2")


def test_units_of_keys_that_no_table_has_are_named(tmp_path: Path) -> None:
    assert kinds(tmp_path, "duration_h=12 Hz") == ["duration_h: unknown-key"]


def test_all_wrong_units_come_in_one_message(tmp_path: Path) -> None:
    wrong = ["duration_s=1 m", "screen.panels.deck.width_m=1 s", "particles.coarse_graining=2 mm"]
    assert len(complaints(tmp_path, *wrong)) == 3


def test_a_machine_by_an_angle_of_zero_is_not_by_hertz() -> None:
    """12 Hz are 24 pi rad/s: pint's own registry, in which an angle is no dimension, has 12 rad/s."""
    assert parse_quantity("12 Hz", "speed_rad_per_s") == pytest.approx(24 * math.pi, rel=1e-15)


@pytest.mark.parametrize(
    ("text", "modulus_MPa"),
    [
        # Gent's formula evaluated by hand: 0.0981 (56 + 7.62336 S) / (0.137505 (254 - 2.54 S))
        ("60 Shore A", 0.0981 * 513.4016 / (0.137505 * 101.6)),
        ("95 shore a", 0.0981 * 780.2192 / (0.137505 * 12.7)),
        ("50 Shore D", 10**1.7097),
    ],
)
def test_hardness_is_a_youngs_modulus(text: str, modulus_MPa: float) -> None:
    assert parse_quantity(text, "youngs_modulus_Pa") == pytest.approx(1e6 * modulus_MPa, rel=1e-6)


def test_scales_of_hardness_agree_where_both_are_used() -> None:
    """90 Shore A and 39 Shore D are the same hardness by ASTM D2240's usual comparison; a factor of 1.5."""
    by_a, by_d = hardness.youngs_modulus_Pa(90, "A"), hardness.youngs_modulus_Pa(39, "D")
    assert 1 / 1.5 < by_a / by_d < 1.5


@pytest.mark.parametrize(
    ("text", "values"),
    [
        ("screen.panels.deck.thickness_m=4 mm,5 mm", ("0.004", "0.005")),
        ("screen.panels.deck.thickness_m=4:6:1 mm", ("0.004", "0.005", "0.006")),
        ("screen.panels.deck.thickness_m=4 mm:5 mm:0.5 mm", ("0.004", "0.0045", "0.005")),
        ("screen.panels.deck.thickness_m=1e-3:3e-3:1e-3", ("0.001", "0.002", "0.003")),
        ("bed.particles.ball.position_m.2=5 cm", ("0.05",)),
        ("screen.panels.deck.thickness_m=4,5 mm", ("0.004", "0.005")),
        ("screen.panels.deck.thickness_m=4 mm,5", ("0.004", "0.005")),
        ("screen.panels.deck.thickness_m=4 mm,0.5 cm", ("0.004", "0.005")),
        ("title=4,5 mm", ("4", "5 mm")),
        ("screen.panels.deck.thickness_m=0.004,0.005", ("0.004", "0.005")),
        ("panel.solver=strip,rigid", ("strip", "rigid")),
    ],
)
def test_sweeps_take_units(text: str, values: tuple[str, ...]) -> None:
    assert parse_vary(text).values == values


@pytest.mark.parametrize("ends", ["4 mm:6 mm", "4:6 mm", "0.004:0.006"])
def test_random_sweeps_take_units(ends: str) -> None:
    plan = plan_sweep([f"screen.panels.deck.thickness_m={ends}"], Arrangement.RANDOM, 3, 1)
    assert all(0.004 <= float(value) <= 0.006 for (value,) in plan.settings)


@pytest.mark.parametrize(
    "text",
    [
        "screen.panels.deck.thickness_m=4 mm:6 cm:1 mm",  # several units
        "screen.panels.deck.thickness_m=4,5 mm,0.6 cm",  # several units, and a number without one
        "screen.panels.deck.thickness_m=4 mm,0.4 cm",  # one value twice
        "title=a b,a_b",  # folders of one name
    ],
)
def test_sweeps_with_wrong_units(text: str) -> None:
    with pytest.raises(CaseError) as refused:
        parse_vary(text)
    (problem,) = refused.value.problems
    assert (problem.file, problem.kind) == (f"--vary {text}", "wrong-type")


@pytest.mark.process
def test_pint_is_not_imported_without_a_unit(tmp_path: Path) -> None:
    """Loading pint takes longer than reading a case."""
    case_folder(tmp_path)
    script = (
        "import sys; from pathlib import Path; from orchestrator.cli import main; "
        "from orchestrator.preflight.judge import load_judged; "
        f"load_judged(Path({str(tmp_path)!r}), None, sys.argv[1:]); print('pint' in sys.modules)"
    )
    for overrides, imported in (((), "False"), (("duration_s=100 ms",), "True")):
        done = subprocess.run(
            [sys.executable, "-c", script, *overrides], capture_output=True, encoding="utf-8", check=True
        )
        assert done.stdout.strip() == imported
