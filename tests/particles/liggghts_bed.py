"""A few hundred particles of three sizes thrown about by a vibrating, bending sheet.

Run as a program (``mpirun -n 2 python -m tests.particles.liggghts_bed``) it prints what the
tests compare between one and two ranks, as JSON.
"""

from __future__ import annotations

import json
import sys
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array, Motion
from orchestrator.ports.clock import Interval
from orchestrator.ports.plans import DeckPlan, GrainMaterial, Jkr, ParticleList, ParticlesPlan
from tests import grains
from tests.particles.liggghts_plans import INTERVAL_S, make_plan, sheet, spheres, travel

LINE_M = np.linspace(-0.05, 0.05, 26)
SURFACE = sheet(lambda x, y: 0.0 * x, LINE_M, 0.4 * LINE_M)
LAWS = {"restitution": 0.5, "sliding_friction": 0.4, "rolling_friction": 0.05}


def bed(layers: int = 4) -> ParticleList:
    """Loose layers on a jittered grid, moving towards the sheet and along it."""
    random = np.random.default_rng(7)
    x, y = np.arange(-0.0455, 0.046, 0.0065), np.arange(-0.0165, 0.017, 0.0065)
    z = 0.0035 + 0.0065 * np.arange(layers)
    places = np.stack(np.meshgrid(x, y, z, indexing="ij"), axis=-1).reshape(-1, 3)
    n = len(places)
    return ParticleList(
        places + random.uniform(-2e-4, 2e-4, (n, 3)),
        random.normal((0.6, 0.0, -0.6), 0.3, (n, 3)),
        random.normal(0.0, 20.0, (n, 3)),
        grains.spheres(random.choice([5.0e-3, 5.5e-3, 6.0e-3], n), 1400.0),
    )


class Drizzle:
    """Three particles every millisecond, dropped through the bed's upper layers."""

    def due(self, interval: Interval) -> ParticleList:
        if interval.index % 20 != 5:
            return spheres(np.zeros((0, 3)))
        x = np.random.default_rng(interval.index).uniform(-0.01, 0.01)
        return spheres([[x - 0.02, 0.0, 0.04], [x, 0.0, 0.04], [x + 0.02, 0.0, 0.01]])

    def settle(self, accepted: npt.NDArray[np.bool_]) -> None:
        assert len(accepted) in (0, 3)


def bed_plan(layers: int = 4, **changes: Any) -> ParticlesPlan:
    """Particles are fed, and leave to the side; two ranks share the domain along x."""
    rest = {
        "gravity_m_per_s2": np.array([0.0, 0.0, -9.81]),
        "domain_m": np.array([[-0.056, -0.03, -0.03], [0.056, 0.03, 0.06]]),
        "feed": Drizzle(),
        "step_s": 2.5e-6,
    }
    changes = {"surface": SURFACE, **LAWS, **rest, **changes}
    return make_plan(changes.pop("surface"), bed(layers), **changes)


# as wide as the sheet
PERIODIC = {"domain_m": np.array([[-0.056, -0.02, -0.03], [0.056, 0.02, 0.06]]), "periodic_y": True}


# sticks below 0.02 m/s (pair) and 0.03 m/s
WET = {"adhesion": Jkr(np.full((2, 2), 0.5), 1e-2), "step_s": 2e-6}


# so soft that some go through the sheet
SOFT = {"materials": (GrainMaterial("grain", 2e3, 0.3), GrainMaterial("panel", 2e3, 0.25))}


def counted() -> dict[str, Any]:
    """The sheet is one panel of a deck whose contacts are counted, but near its sides."""
    line = np.flatnonzero(np.abs(SURFACE.position_m[:, 1] - 0.4 * LINE_M[13]) < 1e-9)
    deck = DeckPlan(
        *np.eye(3)[:2],
        points=line,
        panel=np.zeros(len(line), dtype=np.int64),
        station_m=LINE_M - LINE_M[0],
        open_m=np.array([[0.0, 0.1, -0.012, 0.012]]),
        reach_m=3e-3,
    )
    panel = np.zeros(len(SURFACE.triangles), dtype=np.int64)
    return {"surface": replace(SURFACE, panel=panel), "deck": deck}


def wave(time_s: float) -> Motion:
    """The sheet shaken by 1 mm at 40 Hz, and bent by a standing wave that grows with time."""
    rest, w = SURFACE.position_m, 2 * np.pi * 40.0
    shape = 1.0 + 0.5 * np.cos(60.0 * rest[:, 0])
    position, velocity = rest.copy(), np.zeros_like(rest)
    position[:, 2] += 1e-3 * np.sin(w * time_s) * shape
    velocity[:, 2] = 1e-3 * w * np.cos(w * time_s) * shape
    position[:, 0] += 2e-4 * np.sin(w * time_s)
    velocity[:, 0] = 2e-4 * w * np.cos(w * time_s)
    return Motion(position, velocity)


def impulse_N_s(forces_N: list[Array]) -> Array:
    return np.array(np.sum(forces_N, axis=0) * INTERVAL_S)


def cut_often() -> None:
    """Let the ranks' parts be made equal now and then although the bed is small."""
    from adapters.particles.liggghts import particles

    particles.FEW, particles.BALANCED_EVERY, particles.UNEVEN = 1, 20, 1.01


def main() -> None:
    from mpi4py import MPI

    from adapters.particles.liggghts import build

    changes = PERIODIC if "periodic" in sys.argv else {}
    changes = WET if "wet" in sys.argv else changes
    changes = SOFT if "soft" in sys.argv else changes
    if "cut" in sys.argv:
        cut_often()
    solver = build(bed_plan(communicator=MPI.COMM_WORLD, wear_m3_per_N_m=np.ones((2, 2)), **changes))
    owned_first = len(solver.arrays()["x"])
    forces = travel(solver, wave, range(200))
    account, snapshot, worn_m3 = solver.account(), solver.snapshot(), solver.worn_m3()
    overlaps, crossings = solver.overlaps(), solver.crossings()
    turned = account.angular
    owned = MPI.COMM_WORLD.gather((owned_first, len(solver.arrays()["x"])))
    if MPI.COMM_WORLD.rank == 0:
        result = {
            "impulse": impulse_N_s(forces).tolist(),
            "momentum": account.momentum_kg_m_per_s.tolist(),
            "stored": list(account.stored_J.values()),
            "work": account.received_J["surface"],
            "supplied": account.supplied_J["feed"],
            "removed": account.supplied_J["removal"],
            "worn": worn_m3.tolist(),
            "overlaps": list(vars(overlaps).values()),
            "crossings": [crossings.number, crossings.first_id, crossings.first_time_s],
            "angular": [] if turned is None else turned.momentum_kg_m2_per_s.tolist(),
            "given": [] if turned is None else turned.received_N_m_s["surface"].tolist(),
            "ids": snapshot.id.tolist(),
            "contacts": snapshot.contacts.tolist(),
            "owned": owned,
            "cuts": solver._engine.cuts()[0],
        }
        print(json.dumps(result))
    solver.close()


if __name__ == "__main__":
    main()
