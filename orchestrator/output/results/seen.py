"""What a run tells of the numbers by which its effects were judged."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py

from orchestrator.case.tables.case import Case
from orchestrator.output.results.run_data import RunData, run_data
from orchestrator.output.results.sampling import rows_too_seldom
from orchestrator.output.results.seen_bed import bearing, bed_kg_per_m2, deepest, products, transport_m_per_s
from orchestrator.output.results.seen_motion import SeenMotion
from orchestrator.preflight.judgement.account import Entry
from orchestrator.preflight.judgement.catalogue import EFFECTS, present
from orchestrator.preflight.scene.scene import Scene, scene
from orchestrator.preflight.scene.seen import Seen
from orchestrator.preflight.scene.shaking import shakings
from orchestrator.preflight.scene.turning import out_of_plane, turned


def checked(
    entries: Mapping[str, Entry], described: Case, folder: Path, results: Mapping[str, Any]
) -> dict[str, Entry]:
    """The entries with the verdicts that the run's own numbers give, where it has them.

    ``described``: the case with all that it describes; ``results``: those of the run in ``folder``.
    """
    with h5py.File(folder / "history.h5") as history:
        seen = seen_scene(scene(described), run_data(folder, history), results)
    found = dict(entries)
    for name, entry in entries.items():
        what = EFFECTS[name].checked_by
        if entry.before is not None and what and getattr(seen.seen, what) is not None:
            found[name] = replace(entry, after=EFFECTS[name].judge(seen))
    return found


def seen_scene(estimated: Scene, data: RunData, results: Mapping[str, Any]) -> Scene:
    """The scene with the numbers of the run: motion over the window of ``results``, bed over all
    of it.  Nothing is said of motion where the series do not show it."""
    bed = Seen(
        bed_kg_per_m2=bed_kg_per_m2(data),
        transport_m_per_s=transport_m_per_s(results),
        deepest=deepest(data),
        products=products(data),
        closed=not present(data.case, "apertures"),
    )
    window = results.get("motion")
    interval_s = data.case.coupling.sync_interval_s
    seldom = rows_too_seldom(data.series_s(), data.cycle_s, interval_s)
    if window is None or seldom or not estimated.speed_rad_per_s > 0:
        return replace(estimated, seen=bed)
    motion = SeenMotion(estimated, data, window["start_s"], window["end_s"])
    springs = motion.springs()
    seen = replace(
        bed,
        frames_throw=motion.frames_throw(),
        rotation=motion.outermost("frame-rotation", turned),
        sideways=motion.outermost("sideways-motion", out_of_plane),
        panels_N_per_m=sum(spring.stiffness_N_per_m for spring in springs) if springs else None,
        loss_factor=motion.loss_factor(),
        turned=motion.turned(),
        bearing=bearing(estimated, data, window["start_s"], window["end_s"]),
    )
    moved = replace(estimated, panels=motion.panels(), seen=seen)
    if not springs:
        return moved
    return replace(moved, springs=springs, shaken=shakings(moved.plan, springs))
