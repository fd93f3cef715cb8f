"""What a run tells of its bed: mass, speed, how it bears on the deck, overlaps, and products."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from orchestrator.case.deck.panels import single_panels
from orchestrator.output.results import events
from orchestrator.output.results.deck_figures import averaged
from orchestrator.output.results.run_data import RunData
from orchestrator.preflight.judgement.catalogue import present
from orchestrator.preflight.scene.scene import Scene, deck_m2
from orchestrator.preflight.scene.seen import Bearing, Deepest, Products

FEWEST = 30  # particles of a product whose mean size is compared: the project's own choice


def bed_kg_per_m2(data: RunData) -> float | None:
    """Largest mass on the deck at an output time, per area of the panels."""
    area_m2 = deck_m2(data.case)
    group = next((name for name in ("profile", "bed") if name in data.history), None)
    if area_m2 == 0.0 or group is None:
        return None
    mass_kg = data.read(f"{group}/mass_kg")
    return float(np.nansum(mass_kg.reshape(len(mass_kg), -1), axis=1).max() / area_m2)


def transport_m_per_s(results: Mapping[str, Any]) -> float | None:
    """Speed of the bed along the deck."""
    bed = results.get("bed")
    speed_m_per_s = bed["velocity_m_per_s"]["value"] if bed else None
    return None if speed_m_per_s is None else max(0.0, float(speed_m_per_s))


def bearing(scene: Scene, data: RunData, start_s: float, end_s: float) -> Bearing | None:
    """Means over a window of the force on all panels together; None where nothing lies on them."""
    if "bed" not in data.history or not scene.panels:
        return None
    mass_kg = data.read("bed/mass_kg")[averaged(data.read("bed/time_s"), start_s, end_s)]
    if not len(mass_kg):
        return None
    normal_N = downhill_N = normal_weight = 0.0
    panels = single_panels(data.case)
    for panel in panels:
        rows = data.cycles(f"panel_cycles/{panel.name}", start_s, end_s)
        load_N = rows["sync_points"] @ rows["load_mean_N"] / rows["sync_points"].sum()
        at = panel.rectangle
        normal_N -= float(load_N @ at.normal)
        downhill_N += float(load_N @ at.along) * (-1.0 if at.along[2] > 0 else 1.0)
        normal_weight += float(abs(at.normal[2])) / len(panels)
    weight_N = float(mass_kg.mean()) * scene.gravity_m_per_s2 * normal_weight
    if not (normal_N > 0.0 and weight_N > 0.0):
        return None
    rubs = present(data.case, "sliding-friction")
    return Bearing(normal_N / weight_N, max(0.0, downhill_N / normal_N) if rubs else None)


def deepest(data: RunData) -> Deepest | None:
    """Of all steps; None if nothing ever touched."""
    if "overlaps" not in data.history:
        return None
    names = ("between_per_diameter", "surface_per_diameter", "surface_m")
    between, surface, surface_m = (float(data.read(f"overlaps/{n}").max()) for n in names)
    if between == surface == 0.0:
        return None
    return Deepest(per_diameter=max(between, surface), surface_m=surface_m)


def products(data: RunData) -> Products | None:
    """Mean diameters by mass of what left through each exit; None with fewer than two that many
    particles left through."""
    read = events.read(data.history)
    if read is None:
        return None
    _, removed, exits = read
    found = {}
    for number, name in enumerate(exits.names):
        mine = removed.exit == number
        if mine.sum() >= FEWEST:
            found[name] = float(np.average(removed.diameter_m[mine], weights=removed.mass_kg[mine]))
    if len(found) < 2:
        return None
    fine, coarse = min(found, key=found.__getitem__), max(found, key=found.__getitem__)
    words = f"{found[coarse] * 1e3:.3g} mm through {coarse}, {found[fine] * 1e3:.3g} mm through {fine}"
    return Products(found[coarse] / found[fine], words)
