"""The same coupled run by one process and by two under mpirun, each with a panel of its own."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from tests.cases import case_folder
from tests.coupled.screen import BED, CASE, MACHINE
from tests.coupled.test_driven_frame import ROCKING
from tests.runs.outside import flipflow, left_usable, needs_mpirun, run_words

SETTINGS = ["output.pictures=false", "output.interval_s=0.001", "probes.crosser.particle=4"]


def ran(case: Path, out: Path, scheme: str, ranks: int, *more: str) -> h5py.File:
    words = run_words(str(case), out, [*SETTINGS, f"coupling.scheme={scheme}", *more])
    done = flipflow(*words, ranks=ranks)
    # loads that come late create energy here, and the run says so
    state = "doubtful" if scheme == "serial-staggered" else "done"
    assert done.returncode == (5 if state == "doubtful" else 0), done.stderr
    assert left_usable(out, state)["momentum_residual_relative"] < 1e-12
    return h5py.File(out / "history.h5")


def datasets(history: h5py.File) -> list[str]:
    """All that was recorded; ``results`` are computed from it."""
    names: list[str] = []

    def collect(name: str, item: h5py.Dataset | h5py.Group) -> None:
        if isinstance(item, h5py.Dataset) and not name.startswith("results/"):
            names.append(name)

    history.visititems(collect)
    return names


@pytest.mark.solver
@pytest.mark.slow
@needs_mpirun
@pytest.mark.parametrize("scheme", ["particles-first", "robin", "serial-staggered", "aitken"])
def test_two_ranks_give_the_run_of_one(tmp_path: Path, scheme: str) -> None:
    """20 ms in which the bed lands and is thrown, astride the border between the ranks' domains (at
    x = 0.25 m, in the middle of the second panel), which one particle crosses.

    Loads, reactions, motions and every term of the energy ledger, at every time, relative to
    each one's largest value: measured 2e-12 at most, and rounding for the first 15 ms; the sums
    over ranks are taken in another order, which colliding particles then enlarge.
    """
    case_folder(tmp_path / "case", CASE)
    with (
        ran(tmp_path / "case", tmp_path / "one", scheme, 1) as single,
        ran(tmp_path / "case", tmp_path / "two", scheme, 2) as double,
    ):
        assert "2 by 1 by 1 MPI processor grid" in (tmp_path / "two/log.liggghts").read_text()
        x_m = single["probes/crosser/position_m"][:, 0]
        assert x_m[0] < 0.25 < x_m[-1]
        compare(single, double)


@pytest.mark.solver
@pytest.mark.slow
@needs_mpirun
def test_two_ranks_have_the_same_air_and_the_same_rebound(tmp_path: Path) -> None:
    """20 ms in thick air and with a restitution over the speed of impacts, whose contacts begin on one rank
    and go on beside the border."""
    case_folder(tmp_path / "case", CASE)
    points = "[{impact_m_per_s=0.1, restitution=0.8}, {impact_m_per_s=1.0, restitution=0.3}]"
    rebound = [f"contacts.{pair}.restitution={points}" for pair in (0, 1)]
    sets = ("air={density_kg_per_m3=10.0, viscosity_Pa_s=1e-3}", *rebound)
    with (
        ran(tmp_path / "case", tmp_path / "one", "particles-first", 1, *sets) as single,
        ran(tmp_path / "case", tmp_path / "two", "particles-first", 2, *sets) as double,
    ):
        assert single["energy/lost.particles.air_drag_J"][-1] > 0.0
        compare(single, double)


@pytest.mark.solver
@pytest.mark.slow
@needs_mpirun
def test_two_ranks_know_what_is_driven_as_one_does(tmp_path: Path) -> None:
    """5 ms on a frame that a drive rocks; rigid panels, one end of which is free."""
    case_folder(tmp_path / "case", MACHINE + BED)
    driven = (ROCKING, "duration_s=5e-3", "panel.solver=rigid")
    with (
        ran(tmp_path / "case", tmp_path / "one", "particles-first", 1, *driven) as single,
        ran(tmp_path / "case", tmp_path / "two", "particles-first", 2, *driven) as double,
    ):
        compare(single, double)


def compare(single: h5py.File, double: h5py.File) -> None:
    """Every series, relative to its largest value."""
    names = datasets(single)
    assert names == datasets(double)
    for name in names:
        wanted, actual = single[name][:], double[name][:]
        scale = float(np.abs(wanted).max(initial=1e-4))  # in J: defects are small differences
        np.testing.assert_allclose(actual, wanted, rtol=0, atol=1e-10 * scale, err_msg=name)
