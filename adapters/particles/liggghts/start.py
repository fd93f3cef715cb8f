"""LIGGGHTS with a plan's laws, surface and particles, before its first force evaluation."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from adapters.particles._liggghts import Engine
from adapters.particles.liggghts.input import FIRST_EVALUATION, input_text
from adapters.particles.liggghts.laws import contact_distance_factor, set_laws
from orchestrator.ports import Indices
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import ParticleList, ParticlesPlan

SAME_PLACE = 1e-6  # of the period: points closer than this, one period on, are joined


def start(plan: ParticlesPlan, communicator: Any, folder: Path) -> Engine:
    """LIGGGHTS with the plan's laws and surface, before the first particle."""
    text = input_text(plan)
    if communicator.rank == 0:
        (folder / "in.liggghts").write_text(text + FIRST_EVALUATION + "\n", encoding="utf-8")
    screen, log = folder / "screen.liggghts", folder / "log.liggghts"
    engine = Engine(communicator.py2f(), str(screen), str(log), contact_distance_factor(plan))
    for line in text.splitlines():
        engine.command(line)
    engine.set_surface(
        plan.surface.position_m,
        plan.surface.triangles.astype(np.int32),
        plan.surface.material.astype(np.int32) + 1,
        0.5 * plan.largest_diameter_m,
    )
    set_laws(engine, plan)
    if plan.wear_m3_per_N_m is not None:
        engine.set_wear(plan.wear_m3_per_N_m.ravel().tolist())
    if plan.responds:
        engine.ask_response()
    if plan.periodic_y:
        period_m = float(plan.domain_m[1, 1] - plan.domain_m[0, 1])
        engine.repeat_surface(period_m, joined_across(plan.surface, period_m).astype(np.int32))
    engine.set_exits(
        np.array([one.center_m for one in plan.exits]).reshape(-1, 3),
        np.array([one.axes for one in plan.exits]).reshape(-1, 3, 3),
        np.array([one.half_m for one in plan.exits]).reshape(-1, 3),
        plan.domain_m,
    )
    return engine


def joined_across(surface: TriangleSurface, period_m: float) -> Indices:
    """The triangles (m, 3), with points that are the same place one period along y further on
    given the number of the lower one."""
    number = np.arange(len(surface.position_m))
    used = np.unique(surface.triangles)
    place_m = surface.position_m[used]
    lower = cKDTree(place_m).query(
        place_m - [0.0, period_m, 0.0], distance_upper_bound=SAME_PLACE * period_m
    )[1]
    found = lower < len(used)
    number[used[found]] = used[lower[found]]
    return np.asarray(number[surface.triangles])


def create(engine: Engine, new: ParticleList, first_id: int) -> None:
    """Particles from memory, with ids in order from ``first_id``."""
    engine.create(
        new.position_m,
        new.velocity_m_per_s,
        new.spin_rad_per_s,
        new.diameter_m,
        new.density_kg_per_m3,
        new.material.astype(np.int32) + 1,
        first_id,
    )
