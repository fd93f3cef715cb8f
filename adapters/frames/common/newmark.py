"""An Exudyn solver that makes Newmark steps by hand: its settings, and what it goes on from.

With ``useNewmark`` a step takes from the one before, besides the system's coordinates, only the
accelerations; algorithmic accelerations, which Exudyn gives out but does not take back, play no
part (measured: without it the next steps of a restored solver differ by 1e-4).
"""

from __future__ import annotations

import math
from typing import Any

import exudyn
import numpy as np

from adapters.frames.common.linear import LinearMachine
from orchestrator.ports import Saved
from orchestrator.ports.plans import FramesPlan, SolverFailed


def settings(plan: FramesPlan) -> Any:
    """A machine at rest has no larger residual than the rounding of all its bushings' forces."""
    stiffness_N_per_m = sum(float(bushing.stiffness_N_per_m.sum()) for bushing in plan.bushings)
    chosen = exudyn.SimulationSettings()
    chosen.solution.file.write = False
    time = chosen.timeIntegration
    time.endTime, time.numberOfSteps = 1e9, 10**12  # steps are made by hand, without end
    time.adaptiveStep = False
    time.generalizedAlpha.useNewmark = True
    time.newton.relativeTolerance = 1e-13
    time.newton.absoluteTolerance = max(1e-10, 1e-15 * stiffness_N_per_m)
    return chosen


def opened(system: Any, settings: Any) -> Any:
    """A solver of ``system`` at t = 0."""
    solver: Any = exudyn.MainSolverImplicitSecondOrder()
    if not solver.InitializeSolver(system, settings):
        raise SolverFailed(f"exudyn at 0 s: no start: {solver.GetErrorString()}")
    return solver


def start_interval(solver: Any, step_s: float) -> None:
    """Newton would keep its first Jacobian for ever, and the last bits would hang on the beginning
    of the run: each interval has its own, which halves the iterations and costs as much."""
    solver.it.currentStepSize = step_s
    solver.conv.jacobianUpdateRequested = True


def save(system: Any, solver: Any) -> Saved:
    data, at = system.systemData, solver.it
    coordinates = {str(n): np.array(part) for n, part in enumerate(data.GetSystemState())}
    return {
        "coordinates": coordinates,
        "accelerations": np.array(data.GetODE2Coordinates_tt()),
        "time_s": np.array([data.GetTime(), at.currentTime]),
    }


def restore(system: Any, solver: Any, saved: Saved) -> None:
    data, at = system.systemData, solver.it
    coordinates = saved["coordinates"]
    data.SetSystemState([coordinates[str(n)] for n in range(len(coordinates))])
    data.SetODE2Coordinates_tt(saved["accelerations"])
    time_s, at.currentTime = map(float, saved["time_s"])
    data.SetTime(time_s)


def largest_step_s(plan: FramesPlan, machine: LinearMachine) -> float:
    """``plan.step_s`` or, without, 0.05 over the fastest rate, and no longer than the interval."""
    speeds = [exciter.speed_rad_per_s for exciter in plan.exciters]
    speeds += [drive.speed_rad_per_s for drive in plan.drives]
    fastest = max([machine.fastest_rad_per_s(), *speeds])
    own_s = 0.05 / fastest if fastest > 0 else math.inf
    return plan.step_s if plan.step_s > 0 else min(own_s, plan.sync_interval_s)
