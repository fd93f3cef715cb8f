"""Particles that stand for themselves: a bed of coarse ones must be several deep."""

from __future__ import annotations

from orchestrator.case.bed.contact_times import smallest_diameters_m
from orchestrator.case.bed.sources import largest_diameter_m
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.ports.physics import sphere_mass_kg
from orchestrator.preflight.scene.effect import Effect, Verdict
from orchestrator.preflight.scene.scene import Scene

FEWEST_LAYERS = 5.0  # of coarse particles: the project's choice


def judge(scene: Scene) -> Verdict | None:
    """None where particles are themselves."""
    k = scene.case.particles.coarse_graining
    if k == 1.0:
        return None
    diameter_m = largest_diameter_m(scene.case)
    densest = max(scene.case.materials[name].density_kg_per_m3 for name in smallest_diameters_m(scene.case))
    layers = scene.bed_kg_per_m2 / (sphere_mass_kg(diameter_m, densest) / diameter_m**2)
    return Verdict(
        number="layers of coarse particles",
        value=layers,
        threshold="fewer than 5 (own choice)",
        matters=layers < FEWEST_LAYERS,
        why=f"one of {diameter_m * 1e3:.3g} mm stands for {k**3:.3g}",
        cost=f"{k**3:.3g} times the particles, {k:.3g} times the steps",
    )


def left_out(case: Case) -> str:
    k = case.particles.coarse_graining
    coarse = k > 1.0 and has_particles(case)
    return f"particles.coarse_graining: one stands for {k**3:.3g}" if coarse else ""


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=has_particles,
    left_out=left_out,
    key="particles.coarse_graining",
    checked_by="bed_kg_per_m2",
    about=("particles",),
)
