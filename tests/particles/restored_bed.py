"""The bed of liggghts_bed.py, stopped and taken up again by another solver, or stepping back.

Run as a program (``mpirun -n 2 python -m tests.particles.restored_bed``) it prints, as JSON, what
differs between the runs on any rank: those that are taken up again, and those that step back.
"""

from __future__ import annotations

import json
from dataclasses import replace
from typing import Any

import numpy as np

from orchestrator.case.bed.feed import Feeds, Inlet
from orchestrator.case.bed.size_distribution import size_class
from orchestrator.coupling.metered import MeteredParticles, Stopwatch
from orchestrator.ports import HermitePath, Motion
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import ExitPlan, ParticlesPlan
from orchestrator.ports.state import as_arrays
from tests.grains import one_sphere
from tests.particles.contract import solver_adapter
from tests.particles.liggghts_bed import PERIODIC, WET, bed_plan, counted, cut_often, wave
from tests.particles.liggghts_plans import INTERVAL_S, travel
from tests.saved_states import differences


def resumed(solver: str, plan: ParticlesPlan, save_at: int, intervals: int) -> list[str]:
    """Return what differs at the end between a run that never stops and one that another solver, freshly
    opened, takes over at ``save_at``; loads in between included."""
    build = solver_adapter(solver).build
    whole, first, second = build(plan), build(plan), build(plan)
    travel(whole, wave, range(save_at))
    travel(first, wave, range(save_at))
    saved = first.save()
    second.restore(saved)
    differing = differences(saved, second.save(), "restored")
    loads = [travel(particles, wave, range(save_at, intervals)) for particles in (whole, second)]
    differing += [f"load {n}" for n, (a, b) in enumerate(zip(*loads, strict=True)) if (a != b).any()]
    differing += differences(whole.save(), second.save(), "later")
    for particles in (whole, first, second):
        particles.close()
    return differing


OPEN_END = ExitPlan("end", "oversize", np.array([0.05, 0.0, 0.0]), np.eye(3), np.array([0.01, 0.1, 0.1]))
INLET = Inlet(
    sizes=(size_class(5e-3, 6e-3, 1.0),),
    rate_kg_per_s=0.15,
    box_m=np.array([[-0.04, -0.015, 0.034], [0.04, 0.015, 0.046]]),
    velocity_m_per_s=np.array([0.0, 0.0, -0.5]),
    grain=one_sphere(1.0, 1400.0),
)


def fed(solver: str, plan: ParticlesPlan) -> MeteredParticles:
    """Return particles with a feed that draws at random, and a meter."""
    feed = Feeds([INLET], 7, plan.particles)
    opened = solver_adapter(solver).build(replace(plan, feed=feed))
    return MeteredParticles(opened, feed, solver, Stopwatch())


def astray(interval: Interval) -> HermitePath:
    """The surface pushed up and along, out of its way."""
    start, end = wave(interval.start_s), wave(interval.end_s)
    off_m = np.array([1e-4, 0.0, 2e-4])
    pushed = Motion(end.position_m + off_m, end.velocity_m_per_s + off_m / INTERVAL_S)
    return HermitePath(start, pushed, INTERVAL_S)


def hesitating(solver: str, plan: ParticlesPlan, intervals: int) -> list[str]:
    """Return what differs between a run that goes straight on and one that goes astray in every interval
    and steps back: loads, whole states, accounts, who was removed and how many were fed."""
    straight, hesitant = fed(solver, plan), fed(solver, plan)
    differing = []
    for index in range(intervals):
        before = hesitant.save()
        hesitant.advance(Interval(index, INTERVAL_S), astray(Interval(index, INTERVAL_S)))
        hesitant.restore(before)
        loads = [travel(particles, wave, range(index, index + 1)) for particles in (straight, hesitant)]
        differing += [f"load {index}"] if np.any(loads[0][0] != loads[1][0]) else []
    differing += differences(straight.save(), hesitant.save(), "state")
    differing += differences(as_arrays(straight.account()), as_arrays(hesitant.account()), "account")
    removed = [as_arrays(particles.removed()) for particles in (straight, hesitant)]
    differing += differences(*removed, "removed")
    for particles in (straight, hesitant):
        particles.close()
    return differing


def main() -> None:
    from mpi4py import MPI

    world: Any = MPI.COMM_WORLD
    differing = resumed("liggghts", bed_plan(communicator=world), 60, 120)
    differing += hesitating("liggghts", bed_plan(communicator=world), 120)
    sticky = bed_plan(communicator=world, exits=(OPEN_END,), **PERIODIC, **WET, **counted())
    differing += hesitating("liggghts", sticky, 60)
    cut_often()  # where the box is cut belongs to the state
    differing += resumed("liggghts", bed_plan(communicator=world), 50, 90)
    differing += hesitating("liggghts", sticky, 50)
    everywhere = world.gather(differing)
    if world.rank == 0:
        print(json.dumps(everywhere))


if __name__ == "__main__":
    main()
