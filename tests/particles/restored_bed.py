"""The bed of liggghts_bed.py, stopped and taken up again by another solver.

Run as a program (``mpirun -n 2 python -m tests.particles.restored_bed``) it prints, as JSON, what
differs between the runs on any rank, and how many particles each rank has.
"""

from __future__ import annotations

import json
from importlib import import_module
from typing import Any

from orchestrator.plans import ParticlesPlan
from tests.particles.liggghts_bed import bed_plan, wave
from tests.particles.liggghts_plans import travel
from tests.saved_states import differences


def resumed(solver: str, plan: ParticlesPlan, save_at: int, intervals: int) -> list[str]:
    """What differs at the end between a run that never stops and one that another solver, freshly
    opened, takes over at ``save_at``; loads in between included."""
    build = import_module(f"adapters.particles.{solver}").build
    whole, first, second = build(plan), build(plan), build(plan)
    travel(whole, wave, range(save_at))
    travel(first, wave, range(save_at))
    saved = first.save()
    second.restore(saved)
    found = differences(saved, second.save(), "restored")
    loads = [travel(one, wave, range(save_at, intervals)) for one in (whole, second)]
    found += [f"load {n}" for n, (a, b) in enumerate(zip(*loads, strict=True)) if (a != b).any()]
    found += differences(whole.save(), second.save(), "later")
    for one in (whole, first, second):
        one.close()
    return found


def main() -> None:
    from mpi4py import MPI

    world: Any = MPI.COMM_WORLD
    found = resumed("liggghts", bed_plan(communicator=world), 60, 120)
    everywhere = world.gather(found)
    if world.rank == 0:
        print(json.dumps(everywhere))


if __name__ == "__main__":
    main()
