"""The start of a machine in the preflight, against the frames of a run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from adapters.frames.two_mass import TwoMassFrames
from orchestrator.ports import Load
from orchestrator.ports.clock import Interval
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.scene.scene import Scene, scene
from orchestrator.preflight.scene.shaking import carry_panels
from orchestrator.preflight.scene.starting import STEPS, find_transients_m

TURNS = 12


def machine() -> Scene:
    """Two frames on bushings and two panels.  Their shaft runs up within two turns: it ends in the phase in
    which it starts."""
    described = scene(load_judged(Path("cases/empty-machine")).case)
    (shaft,) = described.plan.exciters
    run_up_s = 4 * np.pi / shaft.speed_rad_per_s
    exciters = (replace(shaft, run_up_s=run_up_s),)
    return replace(described, plan=replace(described.plan, exciters=exciters))


def test_frames_start_as_the_solver_of_a_run_moves_them() -> None:
    """Every place agrees within a thousandth of the largest displacement, with panels as springs."""
    described = machine()
    (shaking,) = described.shaken
    names = [body.name for body in described.plan.bodies]
    whole = carry_panels(described.plan, described.springs)
    points_m = np.array([body.center_of_mass_m for body in whole.bodies])
    still = np.zeros_like(points_m)
    whole = replace(whole, points_m=points_m, carrier=tuple(names), reaction_N=still)
    frames = TwoMassFrames(whole)
    start_m, interval_s = frames.initial().position_m, 2 * np.pi / shaking.speed_rad_per_s / STEPS
    run_m = [
        frames.advance(Interval(number, interval_s), Load(still)).position_m - start_m
        for number in range(TURNS * STEPS)
    ]
    transients_m = find_transients_m(described.plan, described.springs, shaking, TURNS)
    wave = np.exp(2j * np.pi * np.arange(1, TURNS * STEPS + 1) / STEPS)
    for number, name in enumerate(names):
        ours_m = np.outer(wave, shaking.amplitude_m[name]).real + transients_m[name][1:]
        assert ours_m == pytest.approx(np.array(run_m)[:, number], abs=1e-3 * np.abs(run_m).max())
