"""All effects that a scene may call for, by the part they belong to."""

from __future__ import annotations

from collections.abc import Callable

from orchestrator.casefile.left_out import has_particles
from orchestrator.casefile.levels import LoadedCase
from orchestrator.effects import frames, machine, panel, particles, softness
from orchestrator.effects.scene import Scene, scene
from orchestrator.effects.verdict import Verdict

Effect = Callable[[Scene], Verdict | None]
PARTICLES: tuple[Effect, ...] = (
    particles.sliding_friction,
    particles.rolling_friction,
    particles.adhesion,
    softness.contact_stiffness,
    softness.stiffness_at_openings,
    particles.size_distribution,
    particles.single_particles,
)
PANEL: tuple[Effect, ...] = (
    panel.particle_load,
    panel.panel_deformation,
    panel.large_deflection,
    panel.panel_inertia,
    panel.hyperelasticity,
    panel.panel_damping,
    panel.apertures,
    panel.variation_across,
)
FRAMES: tuple[Effect, ...] = (
    frames.frame_dynamics,
    frames.panel_reaction,
    frames.bushing_damping,
    frames.frame_rotation,
    frames.run_up,
)
MACHINE: tuple[Effect, ...] = (
    machine.feed,
    machine.removal,
    machine.gravity,
    machine.full_width,
)
NAMES = frozenset(
    effect.__name__.replace("_", "-") for effect in (*PARTICLES, *PANEL, *FRAMES, *MACHINE)
)
"""Of all effects: where casefile/left_out.py knows one, as there."""


def explained(loaded: LoadedCase) -> dict[str, list[Verdict]]:
    """Verdicts by part: "particles", "panels", "frames", "machine".  A part that the case does not
    have is empty.  For a case whose tables fit together (``checks.table_mistakes``)."""
    there = scene(loaded)
    parts = {
        "particles": PARTICLES if has_particles(loaded.case) else (),
        "panels": PANEL if there.panels else (),
        "frames": FRAMES if there.plan.bodies else (),
        "machine": MACHINE,
    }
    return {
        name: [verdict for effect in effects if (verdict := effect(there)) is not None]
        for name, effects in parts.items()
    }
