"""The bed of liggghts_bed.py with rods, stones and spheres in place of its spheres, half as wide.

Run as a program (``mpirun -n 2 python -m tests.particles.clump_bed``) it prints, as JSON, what the tests
compare between one and two ranks, and what differs between runs that stop or step back and those that do not.
"""

from __future__ import annotations

import json
import sys
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from orchestrator.case import solvers
from orchestrator.ports.clock import Interval
from orchestrator.ports.grains import ShapeTable
from orchestrator.ports.plans import ParticleFeed, ParticleList, ParticlesPlan
from tests.particles.contract import solver_adapter
from tests.particles.liggghts_bed import WET, bed_plan, counted, cut_often, impulse_N_s, wave
from tests.particles.liggghts_plans import travel
from tests.particles.restored_bed import OPEN_END, resumed

SHAPES = tuple(solvers.shape(name) for name in ("rod", "sphere", "stone"))


def mixed(given: ParticleList) -> ParticleList:
    """Such grains in turn, of half the size."""
    old = given.grains
    shape = np.arange(len(given)) % len(SHAPES)
    size_m = 0.5 * old.sieve_size_m
    return replace(given, grains=replace(old, sieve_size_m=size_m, shape=shape, shapes=ShapeTable.of(SHAPES)))


@dataclass
class MixedFeed:
    """A feed of such grains in place of its spheres."""

    feed: ParticleFeed

    def due(self, interval: Interval) -> ParticleList:
        return mixed(self.feed.due(interval))

    def settle(self, accepted: npt.NDArray[np.bool_]) -> None:
        self.feed.settle(accepted)


def clump_plan(**changes: Any) -> ParticlesPlan:
    """The plan with such grains."""
    plan = bed_plan(layers=3, **changes)
    assert plan.feed is not None
    given = mixed(plan.particles)
    largest_m = float(given.grains.bounding_radius_m.max())
    return replace(
        plan, shapes=SHAPES, particles=given, feed=MixedFeed(plan.feed), largest_radius_m=largest_m
    )


def main() -> None:
    from mpi4py import MPI

    world: Any = MPI.COMM_WORLD
    cut_often()
    if "resumed" in sys.argv:
        changes = {"exits": (OPEN_END,), **WET, **counted()}
        differing = resumed("liggghts", clump_plan(communicator=world, **changes), 37, 60)
        everywhere = world.gather(differing)
        if world.rank == 0:
            print(json.dumps(everywhere))
        return
    solver: Any = solver_adapter("liggghts").build(clump_plan(communicator=world, exits=(OPEN_END,)))
    before = solver.account()
    forces = travel(solver, wave, range(200))
    account, snapshot, removed = solver.account(), solver.snapshot(), solver.removed()
    owned = world.gather(len(solver.arrays()["x"]))
    if world.rank == 0:
        result = {
            "impulse": impulse_N_s(forces).tolist(),
            "before": before.momentum_kg_m_per_s.tolist(),
            "momentum": account.momentum_kg_m_per_s.tolist(),
            "outside": account.outside_impulse_N_s.tolist(),
            "moved": account.moved_N_s,
            "stored": list(account.stored_J.values()),
            "angular": account.angular.momentum_kg_m2_per_s.tolist(),
            "turned": (
                account.angular.momentum_kg_m2_per_s
                - before.angular.momentum_kg_m2_per_s
                - account.angular.outside_impulse_N_m_s
                + before.angular.outside_impulse_N_m_s
                - account.angular.received_N_m_s["surface"]
                + before.angular.received_N_m_s["surface"]
            ).tolist(),
            "ids": snapshot.id.tolist(),
            "shapes": snapshot.grains.shape.tolist(),
            "contacts": snapshot.contacts.tolist(),
            "removed": removed.id.tolist(),
            "owned": owned,
        }
        print(json.dumps(result))
    solver.close()


if __name__ == "__main__":
    main()
