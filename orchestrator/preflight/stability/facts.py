"""The numbers behind a card, in words."""

from __future__ import annotations

import math
from collections.abc import Iterator

from orchestrator.case.bed.contact_times import shortest_rayleigh_s
from orchestrator.case.file.contents import has_particles
from orchestrator.preflight.scene.moved_panel import loss_factor
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.stability.frame_modes import FrameMatrices


def facts(
    scene: Scene, modes_rad_per_s: dict[str, float], unknown: str, frames: FrameMatrices | None
) -> dict[str, str]:
    """Times, masses, modes and damping of a scene, by name."""
    found: dict[str, str] = {}
    if has_particles(scene.case):
        found |= dict(_of_particles(scene))
    if scene.panels:
        found |= dict(_of_panels(scene, modes_rad_per_s, unknown))
    if frames is not None:
        speeds = frames.modes()[0] / (2 * math.pi)
        found["frames' modes"] = f"{speeds[0]:.3g} to {speeds[-1]:.3g} Hz, panels as springs"
    return found


def _of_particles(scene: Scene) -> Iterator[tuple[str, str]]:
    yield "Rayleigh time", f"{shortest_rayleigh_s(scene.case):.3g} s, the smallest particle's"
    if scene.panels:
        bed = scene.bed_kg_per_m2
        ratio = bed / min(panel.mass_kg_per_m2 for panel in scene.panels)
        yield "bed on panel", f"{ratio:.3g} times the panel's mass, up to {bed:.3g} kg/m2"
    restitution = [row.restitution for row in scene.case.contacts]
    if restitution:
        yield "restitution", f"{min(restitution):g} to {max(restitution):g}"


def _of_panels(scene: Scene, modes_rad_per_s: dict[str, float], unknown: str) -> Iterator[tuple[str, str]]:
    lowest = min(panel.frequency_rad_per_s for panel in scene.panels) / (2 * math.pi)
    highest = max(modes_rad_per_s.values(), default=0.0) / (2 * math.pi)
    shown = f"{highest:.3g} Hz, as their mesh and steps make it"
    if not modes_rad_per_s:
        shown = unknown or "what their solver does not resolve step by step"
    yield "panels' modes", f"{lowest:.3g} Hz (mounted, empty) to {shown}"
    factors = [loss_factor(panel.material, panel.frequency_rad_per_s) for panel in scene.panels]
    yield "panels' loss factor", f"{min(factors):.2g} at the lowest"
