"""Branches fitted to a measured loss factor."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from orchestrator.case.file.loss_curve import Branches, Fit, fit_branches, moduli
from orchestrator.cli.overview import overview
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.ports import Array
from orchestrator.preflight.check import warnings
from orchestrator.preflight.judgement.catalogue import EFFECTS, has_effect
from tests.cases import complaints, kinds, load_case, loaded

FREQUENCIES_HZ = np.geomspace(10.0, 300.0, 12)
KNOWN: Branches = ((0.1, 1e-2), (0.1, 2e-3), (0.1, 4e-4), (0.1, 8e-5))


def fit_of(loss: Array, storage: Array | None = None) -> Fit:
    ratios = [None] * len(loss) if storage is None else storage.tolist()
    return fit_branches(tuple(zip(FREQUENCIES_HZ.tolist(), loss.tolist(), ratios, strict=True)))


ROWS = ", ".join(f"{{frequency_Hz={f}, loss_factor=0.12}}" for f in (10, 30, 100, 300))
CONSTANT = f"materials.PU.hyperelastic.loss_curve=[{ROWS}]"


def test_one_branch_by_hand() -> None:
    """g = 1 at w tau = 1: storage 1 + 1/2, loss 1/2 over it."""
    storage, loss = moduli(((1.0, 0.01),), np.array([100.0]))
    assert (storage[0], loss[0]) == pytest.approx((1.5, 1 / 3), rel=1e-14)


def test_a_constant_loss_factor_needs_three_branches() -> None:
    """0.12 from 10 to 300 Hz, within 3 %; between the points, too."""
    fit = fit_of(np.full(12, 0.12))
    assert len(fit.branches) == 3
    between = np.geomspace(10.0, 300.0, 200)
    loss_factor = moduli(fit.branches, 2 * np.pi * between)[1]
    assert loss_factor == pytest.approx(0.12, rel=0.03)


@pytest.mark.parametrize("with_storage", [False, True])
def test_the_curve_of_known_branches_is_met(with_storage: bool) -> None:
    """The fit is within 3 %, with at most as many branches as the curve was made of."""
    storage, loss = moduli(KNOWN, 2 * np.pi * FREQUENCIES_HZ)
    fit = fit_of(loss, storage if with_storage else None)
    assert len(fit.branches) <= len(KNOWN)
    again, loss_factor = moduli(fit.branches, 2 * np.pi * FREQUENCIES_HZ)
    assert loss_factor == pytest.approx(loss, rel=0.03)
    if with_storage:
        assert again == pytest.approx(storage, rel=0.03)


def test_one_point_is_met_exactly() -> None:
    fit = fit_branches(((50.0, 0.3, None),))
    assert moduli(fit.branches, np.array([100.0 * np.pi]))[1] == pytest.approx(0.3, rel=1e-9)


def test_a_peak_sharper_than_any_branchs_cannot_be_met(tmp_path: Path) -> None:
    peak = "{frequency_Hz=10, loss_factor=0.01}, {frequency_Hz=20, loss_factor=0.5}"
    curve = f"materials.PU.hyperelastic.loss_curve=[{peak}, {{frequency_Hz=40, loss_factor=0.01}}]"
    assert kinds(tmp_path, curve) == ["materials.PU.hyperelastic.loss_curve: conflict"]


@pytest.mark.parametrize(("measured_Hz", "warns"), [((150, 300), True), ((20, 40), False)])
def test_a_curve_measured_far_from_the_machines_speed_is_said(
    tmp_path: Path, measured_Hz: tuple[int, int], warns: bool
) -> None:
    """The machine turns at 12.5 Hz."""
    rows = ", ".join(f"{{frequency_Hz={f}, loss_factor=0.12}}" for f in measured_Hz)
    lines = warnings(loaded(tmp_path, [f"materials.PU.hyperelastic.loss_curve=[{rows}]"]))
    warning = (
        "material PU of panels works at a frequency of 12.5 Hz, and its curve was measured from 150 to 300 Hz"
    )
    assert any(line.startswith(warning) for line in lines) == warns


def test_frequencies_rise(tmp_path: Path) -> None:
    rows = "{frequency_Hz=20, loss_factor=0.1}, {frequency_Hz=10, loss_factor=0.1}"
    assert kinds(tmp_path, f"materials.PU.hyperelastic.loss_curve=[{rows}]") == [
        "materials.PU.hyperelastic.loss_curve: conflict"
    ]
    assert complaints(tmp_path, "materials.PU.hyperelastic.loss_curve=[{frequency_Hz=20}]")


def test_the_resolved_case_holds_the_branches_and_check_compares_them(tmp_path: Path) -> None:
    case = loaded(tmp_path, [CONSTANT])
    law = case.case.materials["PU"].hyperelastic
    assert law is not None
    assert len(law.maxwell) == 3
    assert has_effect(case.case, "panel-damping")
    again = resolved_case(case)["materials"]["PU"]["hyperelastic"]
    assert [row["ratio"] for row in again["maxwell"]] == [row.ratio for row in law.maxwell]
    lines = "\n".join(overview(case))
    assert "PU: loss factor of 3 Maxwell branches (measured): " in lines
    assert "(0.12) at 300 Hz" in lines


def test_given_branches_are_not_fitted_again(tmp_path: Path) -> None:
    """Three branches that meet the curve to a few per cent stay; the case's own fit has others."""
    fit = fit_of(np.full(12, 0.12))
    given = ", ".join(f"{{ratio={1.02 * g!r}, relaxation_s={tau!r}}}" for g, tau in fit.branches)
    case = loaded(tmp_path, [CONSTANT, f"materials.PU.hyperelastic.maxwell=[{given}]"])
    law = case.case.materials["PU"].hyperelastic
    assert law is not None
    assert [row.ratio for row in law.maxwell] == [1.02 * g for g, _ in fit.branches]
    assert "PU: loss factor of 3 Maxwell branches" in "\n".join(overview(case))


def test_branches_that_do_not_meet_the_curve_are_refused(tmp_path: Path) -> None:
    """The branches are those of an earlier fit beside a new curve in a resolved case."""
    assert kinds(
        tmp_path, CONSTANT, "materials.PU.hyperelastic.maxwell=[{ratio=0.3, relaxation_s=0.004}]"
    ) == ["materials.PU.hyperelastic.loss_curve: conflict"]


def test_a_new_curve_takes_fitted_branches_away(tmp_path: Path) -> None:
    """A resolved case has the curve and its branches; a new curve by --set is fitted anew."""
    resolved = resolved_case(loaded(tmp_path, [CONSTANT]))
    again = load_case(tmp_path / "again", resolved, [CONSTANT.replace("0.12", "0.30")])
    law = again.case.materials["PU"].hyperelastic
    assert law is not None
    _, loss = moduli(tuple((row.ratio, row.relaxation_s) for row in law.maxwell), 2 * np.pi * FREQUENCIES_HZ)
    assert loss == pytest.approx(0.30, rel=0.1)


def test_damping_left_out_takes_the_curve_away(tmp_path: Path) -> None:
    before = loaded(tmp_path, [CONSTANT]).case
    others = [name for name in EFFECTS if has_effect(before, name) and name != "panel-damping"]
    case = loaded(tmp_path, [CONSTANT, f"effects={others}"])
    law = case.case.materials["PU"].hyperelastic
    assert law is not None
    assert (law.maxwell, law.loss_curve) == ((), ())
    assert set(case.left_out) == {"panel-damping", "grain-shape"}
