"""The mats that ``flipflow new`` proposes hang down in every turn, whoever computes them."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

from orchestrator.cli import launch
from orchestrator.cli.proposal import mounting
from orchestrator.cli.proposal.proposal import Proposal
from orchestrator.cli.proposal.propose import propose
from orchestrator.cli.proposal.wishes import ImpossibleWishes, read_wishes
from orchestrator.ports.adapters import PanelAdapter
from orchestrator.ports.panel import MeshedPanel
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.mats.mats import trials_of
from orchestrator.preflight.mats.regime import PHASES, Regime
from orchestrator.preflight.mats.trial import INTERVAL_S, Trial, regimes
from orchestrator.preflight.scene.scene import scene

pytestmark = pytest.mark.solver


@cache
def proposed() -> Proposal:
    return propose(read_wishes("flip-flow", {}), "mine")


def own_trials() -> list[Trial]:
    """The mats that open while they are lifted, and their neighbours."""
    trials = [trial for _, trial in trials_of(proposed().scene)]
    assert len(trials) == 2
    return trials


def written(folder: Path) -> Path:
    """The folder with the proposed case."""
    for file, text in proposed().files.items():
        (folder / file).parent.mkdir(parents=True, exist_ok=True)
        (folder / file).write_text(text, encoding="utf-8")
    return folder


class Sheets(Trial):
    """Trials with sheets of two cells across."""

    def open(self, adapter: PanelAdapter, cells: int) -> MeshedPanel:
        plan = replace(self.plan, cells=(cells, 2), integrator="explicit", step_s=0.0)
        return adapter.build(replace(plan, sync_interval_s=INTERVAL_S))


def joined(trial: Trial) -> Trial:
    """The same mat as a slice of four rows of openings from its middle, with joined sides."""
    plan, pattern = trial.plan, trial.plan.apertures
    assert pattern is not None
    at = replace(plan.rectangle, width_m=4 * pattern.pitch_across_m)
    plan = replace(plan, rectangle=at, apertures=replace(pattern, margin_across_m=0.0), joined_sides=True)
    return Sheets(plan, trial.amplitude_m, trial.speed_rad_per_s, trial.transient_m)


def test_the_default_hangs_at_30_to_50_g_with_room_to_either_side() -> None:
    chosen = proposed().mounting
    assert chosen is not None
    assert chosen.has_room
    for regime in chosen.regimes:
        assert regime.side == "down"
        assert 30.0 <= regime.mean_peak_g <= 50.0
    (mats_remark,) = [remark for remark in proposed().remarks if remark.startswith("mats: ")]
    assert "hangs down in all of" in mats_remark


@pytest.mark.parametrize("neighbour", [0, 1])
def test_strips_and_sheets_agree_about_the_default(neighbour: int) -> None:
    """Mean peaks of strips of 16 to 48 cells and of a sheet with joined sides: 30 to 50 g, within 15 %.

    At the stroke of coupled runs, 5.8 mm.
    """
    wished = own_trials()[neighbour]
    trial = wished.at(0.0058, wished.speed_rad_per_s, wished.plan.rectangle.span_m)
    strips = {cells: regimes([trial], cells)[0] for cells in (16, 24, 32, 48)}
    (sheet,) = regimes([joined(trial)], 22, 16, "sheet")
    assert {regime.side for regime in (*strips.values(), sheet)} == {"down"}
    for strip in strips.values():
        assert 30.0 <= strip.mean_peak_g <= 50.0
        assert strip.mean_peak_g == pytest.approx(sheet.mean_peak_g, rel=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("cells", [16, 48])
def test_coupled_panels_of_the_default_hang_at_30_to_50_g(cells: int, tmp_path: Path) -> None:
    """Empty, with the frames that the mats pull at: within 15 % of the trial at the run's own stroke."""
    sets = (
        'particles.solver="none"',
        "duration_s=1.52",
        "coupling.sync_interval_s=1e-4",
        f"panel.cells=[{cells},1]",
        "panel.surface_cells=[8,2]",
    )
    launch.run(written(tmp_path / "mine"), "draft", tmp_path / "run", sets)
    motion = json.loads((tmp_path / "run" / "summary.json").read_text())["results"]["motion"]
    assert {panel["turns_up_share"] for panel in motion["panels"].values()} == {0.0}
    stroke_m = motion["relative"]["driven-driving"]["along_m"]["value"]
    points = [motion["panel_points"][name]["cycle_peak_g"]["value"] for name in ("panel-1", "panel-2")]
    at_stroke = [
        trial.at(stroke_m, trial.speed_rad_per_s, trial.plan.rectangle.span_m) for trial in own_trials()
    ]
    for peak_g, tried in zip(points, regimes(at_stroke, cells), strict=True):
        assert 30.0 <= peak_g <= 50.0
        assert peak_g == pytest.approx(tried.mean_peak_g, rel=0.15)


def test_as_soft_as_its_free_edges_the_default_hangs_too() -> None:
    """Strips with free sides of 16, 32 and 48 cells."""
    soft = [replace(trial, plan=replace(trial.plan, hindered_share=0.0)) for trial in own_trials()]
    assert {regime.side for cells in (16, 32, 48) for regime in regimes(soft, cells)} == {"down"}


def test_mats_of_a_slice_are_tried_between_the_frames_of_the_whole_machine(tmp_path: Path) -> None:
    case = load_judged(written(tmp_path / "mine"), "draft").case
    assert case.whole_machine is not case
    for (_, of_slice), of_whole in zip(trials_of(scene(case)), own_trials(), strict=True):
        assert of_slice.amplitude_m == pytest.approx(of_whole.amplitude_m, rel=1e-6)
        assert of_slice.plan.rectangle.width_m < of_whole.plan.rectangle.width_m


def flat(peak_g: float, side: float) -> Regime:
    heights_m = np.full((12, PHASES), 0.03 * side)
    return Regime(0.3, heights_m, np.full(12, peak_g), np.full(12, peak_g))


def test_a_stroke_at_which_no_mat_hangs_is_refused_with_one_at_which_some_do(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """All mats are taken to arch up above a stroke of 4.5 mm: the largest share that is tried below is
    0.7."""

    def regimes_of(trials: Sequence[Trial], cells: int, turns: int) -> tuple[Regime, ...]:
        return tuple(flat(40.0, 1.0 if trial.stroke_m > 0.0045 else -1.0) for trial in trials)

    monkeypatch.setattr(mounting, "remembered_regimes", regimes_of)
    with pytest.raises(ImpossibleWishes) as refused:
        propose(read_wishes("flip-flow", {}), "mine")
    (problem,) = refused.value.problems
    assert (problem.file, problem.kind) == ("--stroke", "out-of-range")
    assert {"6", "750"} <= {*problem.what.split()}  # mm, rpm
    assert "4.2" in problem.what_helps.split()
