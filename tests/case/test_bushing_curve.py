"""Measured curves of bushings: their points, files, fits, and what a user is told."""

from __future__ import annotations

import re
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.file.bushing_curve import Elements, fit_points, harmonic_stiffness
from orchestrator.case.file.bushing_loop import fit_loop, points_of
from orchestrator.case.file.data_table import Answers, TableError
from orchestrator.case.file.errors import CaseError
from orchestrator.case.solver_plans import bushings
from orchestrator.cli.overview import overview
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.preflight.check import warnings
from orchestrator.preflight.judge import load_judged
from tests.cases import (
    CASE,
    LEVEL,
    case_folder,
    complaints,
    keys_and_kinds,
    kinds,
    load_case,
    loaded,
    only_complaint,
)
from tests.runs.outside import ROOT

KNOWN = Elements(1.5e4, ((4e3, 3e-4), (3e3, 1.5e-3)), ((2e3, 5e-3),))
EXUDYN = 'frames.solver="exudyn"'


def measured(elements: Elements = KNOWN) -> list[tuple[float, float, float, float]]:
    tests = np.array([*product((5e-4, 1e-3, 2e-3, 4e-3, 6e-3), (5.0, 10.0, 15.0))])
    storage, ahead = harmonic_stiffness(elements, *tests.T)
    return [
        (a, f, k, loss)
        for (a, f), k, loss in zip(tests.tolist(), storage.tolist(), (ahead / storage).tolist(), strict=True)
    ]


def rows(points: list[tuple[float, float, float, float]]) -> str:
    keys = ("amplitude_m", "frequency_Hz", "stiffness_N_per_m", "loss_factor")
    return ", ".join(
        "{" + ", ".join(f"{k}={v!r}" for k, v in zip(keys, point, strict=True)) + "}" for point in points
    )


CURVE = f'screen.bushings.isolation.curves=[{{axes="x", points=[{rows(measured())}]}}]'


def test_the_elements_that_made_a_curve_are_found_again() -> None:
    """Two friction and one Maxwell element, to 1 %."""
    fit = fit_points(tuple(measured()))
    assert fit.error < 1e-3
    assert fit.elements.elastic_N_per_m == pytest.approx(KNOWN.elastic_N_per_m, rel=0.01)
    assert np.array(fit.elements.friction) == pytest.approx(np.array(KNOWN.friction), rel=0.01)
    assert np.array(fit.elements.maxwell) == pytest.approx(np.array(KNOWN.maxwell), rel=0.01)


def test_a_curve_that_does_not_vary_needs_few_elements() -> None:
    """One stiffness, one loss factor at one frequency: a spring and a Maxwell element."""
    fit = fit_points(tuple((a, 12.5, 2e4, 0.1) for a in (1e-3, 3e-3, 6e-3)))
    assert (len(fit.elements.friction), len(fit.elements.maxwell)) == (0, 1)
    assert fit.error < 1e-6


def test_one_friction_element_by_hand() -> None:
    """A = 2 s: t = pi / 2, so k' = k / 2 and k'' = k / pi."""
    storage, ahead = harmonic_stiffness(Elements(0.0, ((1e3, 1e-3),), ()), np.array([2e-3]), np.array([1.0]))
    assert (storage[0], ahead[0]) == pytest.approx((500.0, 1e3 / np.pi))


def test_a_file_is_the_same_as_its_points(tmp_path: Path) -> None:
    """Damping in place of a loss factor, too; the resolved case holds points and elements, and is not fitted
    again."""
    text = "amplitude_m, frequency_Hz, stiffness_N_per_m, damping_N_s_per_m\n" + "".join(
        f"{a},{f},{k},{loss * k / (2 * np.pi * f)}\n" for a, f, k, loss in measured()
    )
    (tmp_path / "spring.csv").write_text(text)
    from_file = loaded(tmp_path, ['screen.bushings.isolation.curves=[{axes="x", file="spring.csv"}]'])
    inline = loaded(tmp_path / "inline", [CURVE])
    curve, other = (case.case.screen.bushings["isolation"].curves[0] for case in (from_file, inline))
    assert curve.elastic_N_per_m == pytest.approx(other.elastic_N_per_m)
    assert len(curve.points) == 15
    again = load_case(tmp_path / "again", resolved_case(from_file))
    assert again.case.screen.bushings["isolation"].curves[0] == curve


def test_check_says_how_well_the_curve_is_met(tmp_path: Path) -> None:
    lines = "\n".join(overview(loaded(tmp_path, [CURVE])))
    assert re.search(r"isolation along x:.*\b2 friction.*\b1 Maxwell", lines)
    assert re.search(r"\b15\b.*\b0\.0%.*\b0%", lines)


@pytest.mark.parametrize(("amplitude_m", "warns"), [("[0.004, 0, 0.03]", True), ("[0.03, 0, 0.004]", False)])
def test_a_turned_bushing_is_judged_along_its_own_axis(amplitude_m: str, warns: bool) -> None:
    """Measured from 1 to 8 mm along its x, which stands upright."""
    turned = "screen.bushings.spring.rotation_deg=[0, 90, 0]"
    along = "screen.bushings.spring.curves.0.axes=x"
    sets = [turned, along, f"screen.frames.plate.drive.amplitude_m={amplitude_m}"]
    lines = warnings(load_judged(ROOT / "cases/shear-spring", None, sets))
    assert any("works at an amplitude of 30 mm" in line for line in lines) == warns


def test_plans_have_the_elements_where_the_solver_has(tmp_path: Path) -> None:
    """exudyn has them; two-mass has the linear numbers, and says so, or its level must."""
    curved = loaded(tmp_path, [CURVE, EXUDYN])
    plan = bushings(curved.case)[0]
    assert plan.hysteresis[0].friction_N_per_m == pytest.approx([4e3, 3e3], rel=0.01)
    assert plan.beside_elements().stiffness_N_per_m == pytest.approx([1.5e4, 3e4, 4e4], rel=0.01)
    assert plan.stiffness_N_per_m[0] == 2e4
    linear = loaded(tmp_path, [CURVE, 'frames.solver="two-mass"'])
    assert bushings(linear.case)[0].hysteresis == ()
    assert "one stiffness and one damping" in linear.left_out["bushing-hysteresis"]
    assert (
        bushings(loaded(tmp_path, [CURVE, EXUDYN, "effects=['frame-dynamics', 'frame-rotation']"]).case)[
            0
        ].hysteresis
        == ()
    )


def test_a_slice_has_its_share(tmp_path: Path) -> None:
    """Half of the width: half of every stiffness, at the same slips."""
    whole = bushings(loaded(tmp_path, [CURVE, EXUDYN]).case)[0].hysteresis[0]
    half = bushings(loaded(tmp_path, [CURVE, EXUDYN, "slice.width_m=0.1"]).case)[0].hysteresis[0]
    assert half.elastic_N_per_m == pytest.approx(whole.elastic_N_per_m / 2)
    assert half.friction_N_per_m == pytest.approx(whole.friction_N_per_m / 2)
    assert half.slip_m.tolist() == whole.slip_m.tolist()


@pytest.mark.parametrize(
    ("curve", "kind"),
    [
        ('{axes="x"}', "curves.0: missing"),
        (f'{{axes="xx", points=[{rows(measured())}]}}', "curves.0.axes: conflict"),
        (f'{{axes="z", points=[{rows(measured())}]}}', "stiffness_N_per_m: conflict"),
        ('{axes="x", friction=[{stiffness_N_per_m=1.0, slip_m=1.0}]}', "curves.0: missing"),
        (
            '{axes="x", points=[{amplitude_m=0.001, frequency_Hz=10, stiffness_N_per_m=2e4}]}',
            "curves.0.points.0: conflict",
        ),
        (f"{{points=[{rows([(1e-3, 10, 1.5e4, 0.1), (6e-3, 10, 2.5e4, 0.1)])}]}}", "curves.0: conflict"),
        (
            f"{{points=[{rows([(1e-3, f, 2e4, 0.3 if f == 10 else 0.05) for f in (5, 10, 20)])}]}}",
            "curves.0: conflict",
        ),
        (f"{{elastic_N_per_m=2e4, points=[{rows(measured())}]}}", "curves.0: conflict"),
    ],
)
def test_a_wrong_curve_is_refused(tmp_path: Path, curve: str, kind: str) -> None:
    refused = kinds(tmp_path, f"screen.bushings.isolation.curves=[{curve}]")
    assert f"screen.bushings.isolation.{kind}" in refused


def test_a_progressive_spring_is_told_from_points_that_scatter(tmp_path: Path) -> None:
    """No friction element makes a stiffness that rises with the amplitude."""
    progressive = [(1e-3, 10.0, 1.5e4, 0.1), (3e-3, 10.0, 2e4, 0.1), (6e-3, 10.0, 2.5e4, 0.1)]
    scattered = [(1e-3, 10.0, 2e4, loss) for loss in (0.03, 0.3)]
    for points, clue in (
        (progressive, "rises with the amplitude, from 15000 to 25000"),
        (scattered, "off by"),
    ):
        curve = f'screen.bushings.isolation.curves=[{{axes="x", points=[{rows(points)}]}}]'
        assert clue in only_complaint(tmp_path, curve)


def test_new_points_take_fitted_elements_away(tmp_path: Path) -> None:
    """A resolved case has the points and the elements; new points by --set are fitted anew."""
    resolved = resolved_case(load_case(tmp_path, CASE, [CURVE, EXUDYN]))
    stiffer = [(a, f, 1.5 * k, loss) for a, f, k, loss in measured()]
    new = f"screen.bushings.isolation.curves.0.points=[{rows(stiffer)}]"
    again = load_case(tmp_path / "again", resolved, [new])
    curve = again.case.screen.bushings["isolation"].curves[0]
    assert curve.elastic_N_per_m == pytest.approx(1.5 * KNOWN.elastic_N_per_m, rel=0.02)


def test_all_mistakes_in_a_file_are_told(tmp_path: Path) -> None:
    head = "amplitude_m,frequenzy_Hz,loss_factor\n"
    lines = []
    for text in (head + "0.001,10,0.1\n", head + "1,2\n", head.replace("zy", "cy") + "0.001,ten,0.1\n"):
        (tmp_path / "bad.csv").write_text(text)
        lines += complaints(tmp_path, 'screen.bushings.isolation.curves=[{axes="x", file="bad.csv"}]')
    assert any(
        "bad.csv" in line and """no column 'frequenzy_Hz'; did you mean "frequency_Hz"?""" in line
        for line in lines
    )
    assert any("line 2: 2 cells instead of 3" in line for line in lines)
    assert any("line 2: frequency_Hz = 'ten' is not a number" in line for line in lines)
    missing = only_complaint(tmp_path, 'screen.bushings.isolation.curves=[{axes="x", file="none.csv"}]')
    assert "none.csv" in missing
    assert "cannot be read: No such file" in missing
    outside = only_complaint(tmp_path, 'screen.bushings.isolation.curves=[{axes="x", file="../x.csv"}]')
    assert "outside of the case's folder" in outside


def test_a_level_that_leaves_curves_out_says_so(tmp_path: Path) -> None:
    level = LEVEL.replace('["variation-across"]', '["variation-across", "frame-rotation", "motor-slip"]')
    text = CASE.replace(
        "stiffness_N_per_m = [2e4, 3e4, 4e4]", f"stiffness_N_per_m = [2e4, 3e4, 4e4]\n{CURVE[26:]}"
    )
    folder = case_folder(tmp_path, text, light=level + '[frames]\nsolver = "two-mass"\n')
    missing, needless = _refused(folder).problems
    assert keys_and_kinds([missing, needless]) == ["without: conflict"] * 2
    assert '"bushing-hysteresis"' in missing.what
    assert '"motor-slip"' in needless.what


def _refused(folder: Path) -> CaseError:
    from orchestrator.preflight.judge import load_judged

    with pytest.raises(CaseError) as raised:
        load_judged(folder, "light", [EXUDYN.replace("exudyn", "two-mass")])
    return raised.value


def loop(frequency_Hz: float = 12.5, cycles: float = 2.5, sign: float = 1.0, offset_kN: float = 2.0) -> str:
    """Return a loop of KNOWN's linear part by hand: 4 mm, 20 kN/m in phase and 2 kN/m a quarter ahead."""
    angle = np.arange(200) / 200 * 2 * np.pi * cycles
    columns = [angle / (2 * np.pi * frequency_Hz), 4 * np.sin(angle) + 1]
    columns.append(sign * (0.08 * np.sin(angle) + 0.008 * np.cos(angle)) + offset_kN)
    lines = [
        "Zeit [s];Weg [mm];Kraft [kN]",
        *(";".join(f"{cell:.9f}" for cell in row) for row in np.array(columns).T),
    ]
    return "\n".join(lines).replace(".", ",")


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_loop_is_a_point(sign: float) -> None:
    """A mean force and place drop out, and a force that is counted the other way."""
    (point,) = points_of(loop(sign=sign), Answers())
    expected = {"amplitude_m": 4e-3, "frequency_Hz": 12.5, "stiffness_N_per_m": 2e4, "loss_factor": 0.1}
    assert point == pytest.approx(expected, rel=1e-5)


def test_a_loop_of_friction_has_its_first_harmonic() -> None:
    """The law's own closed form at A = 2 s, from a force in small steps."""
    x_m = 2e-3 * np.sin(2 * np.pi * np.arange(4001) / 1000)
    force_N = [0.0]
    for step_m in np.diff(x_m):
        force_N.append(float(np.clip(force_N[-1] + 1e3 * step_m, -1.0, 1.0)))
    fit = fit_loop(np.arange(3000) / 1000, x_m[1001:], np.array(force_N[1001:]))
    storage, ahead = harmonic_stiffness(Elements(0.0, ((1e3, 1e-3),), ()), np.array([2e-3]), np.array([1.0]))
    assert fit.stiffness_N_per_m == pytest.approx(storage[0], rel=1e-3)
    assert fit.loss_factor == pytest.approx(ahead[0] / storage[0], rel=2e-3)
    assert 0.05 < fit.residual < 0.3


def test_a_case_has_loops_of_several_files(tmp_path: Path) -> None:
    """One without times, whose frequency the case says."""
    (tmp_path / "one.csv").write_text(loop())
    rows = [line.split(";", 1)[1] for line in loop().splitlines()]
    (tmp_path / "two.csv").write_text("\n".join(rows))
    curve = '{axes="x", file=["one.csv", "two.csv"], frequency_Hz="12.5 Hz"}'
    (read,) = (
        loaded(tmp_path, [f"screen.bushings.isolation.curves=[{curve}]"])
        .case.screen.bushings["isolation"]
        .curves
    )
    assert [point.loss_factor for point in read.points] == pytest.approx([0.1, 0.1], rel=1e-5)
    assert [point.frequency_Hz for point in read.points] == pytest.approx([12.5, 12.5])


@pytest.mark.parametrize(
    ("text", "clue"),
    [
        (loop(cycles=0.6), "cycle"),
        ("\n".join(line.split(";", 1)[1] for line in loop().splitlines()), "frequency_Hz = "),
        (loop().replace("Kraft [kN]", "Kraft"), "unit.*'Kraft'"),
        ("Weg [mm];Zeit [s]\n1;0\n2;1\n", "'force_N'"),
        ("displacement_mm,force_N,frequency_Hz\n" + "1,1,5\n" * 20, "moves"),
        ("amplitude_m,frequency_Hz,dynamic stiffness [N/mm],loss_factor\n0.001,10,262,0.1\n", "modulus"),
        ("amplitude_m,frequency_Hz,stiffness,loss_factor\n0.001,10,262,0.1\n", "unit.*'stiffness'"),
        ("amplitude_m,frequency_Hz,stiffness_N_per_m,loss_factor\n0.001,10,2e5,9%\n0.002,10,2e5,0.1\n", "%"),
        ("amplitude_m,frequency_Hz,complex stiffness [N/mm]\n0.001,10,262\n", "loss"),
    ],
)
def test_a_test_that_leaves_something_open(text: str, clue: str) -> None:
    with pytest.raises(TableError, match=clue):
        points_of(text, Answers())


def test_a_test_in_other_words() -> None:
    """A peak-to-peak amplitude is halved; a modulus and an angle are k' and a loss factor."""
    head = "Amplitude peak-to-peak [mm];Frequency [Hz];Complex stiffness [N/mm];Loss angle [deg]\n"
    (point,) = points_of(head + "2;10;100;60\n", Answers())
    assert point == pytest.approx(
        {"amplitude_m": 1e-3, "frequency_Hz": 10.0, "stiffness_N_per_m": 5e4, "loss_factor": np.sqrt(3)}
    )


@pytest.mark.parametrize(
    "head", ["time\taxial displacement\taxial force\nsec\tmm\tkN", "Zeit [s]\tFederweg [mm]\tFederkraft [kN]"]
)
def test_a_loop_in_the_words_of_a_machine(head: str) -> None:
    _, *lines = loop().replace(";", "\t").splitlines()
    assert points_of("\n".join([head, *lines]), Answers()) == points_of(loop(), Answers())


@pytest.mark.parametrize(
    ("head", "cell"),
    [
        ("tan d", "0.1"),
        ("loss_factor", "10%"),
        ("loss_factor", "10 %"),
        ("Loss factor [%]", "10"),
        ("tan delta", "0.1"),
    ],
)
def test_a_loss_factor_in_per_cent(head: str, cell: str) -> None:
    (point,) = points_of(
        f"amplitude_m,frequency_Hz,stiffness_N_per_m,{head}\n0.001,10,2e5,{cell}\n", Answers()
    )
    assert point["loss_factor"] == pytest.approx(0.1)
