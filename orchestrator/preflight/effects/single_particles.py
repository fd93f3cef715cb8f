"""Single particles instead of coarse ones; a bed of coarse particles must have several layers."""

from __future__ import annotations

from orchestrator.case.bed.grains import sieve_sizes_m
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.preflight.scene.effect import Effect, Verdict
from orchestrator.preflight.scene.scene import Scene, layer_kg_per_m2

FEWEST_LAYERS = 5.0  # of coarse particles; the project's own choice


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the layers of coarse particles; None without coarse graining."""
    k = scene.case.particles.coarse_graining
    if k == 1.0:
        return None
    layers = scene.bed_kg_per_m2 / layer_kg_per_m2(scene.case)
    return Verdict(
        number="layers of coarse particles",
        value=layers,
        threshold=f"fewer than {FEWEST_LAYERS:g} (own choice)",
        matters=layers < FEWEST_LAYERS,
        why=f"one of {sieve_sizes_m(scene.case)[1] * 1e3:.3g} mm stands for {k**3:.3g}",
        cost=f"{k**3:.3g} times the particles, {k:.3g} times the steps",
    )


def left_out(case: Case) -> str:
    """Return the number of particles that a coarse one stands for; empty without coarse ones."""
    k = case.particles.coarse_graining
    coarse = k > 1.0 and has_particles(case)
    return f"particles.coarse_graining: one stands for {k**3:.3g}" if coarse else ""


EFFECT = Effect(
    part="particles",
    judge=judge,
    left_out=left_out,
    key="particles.coarse_graining",
    checked_by="bed_kg_per_m2",
    about=("particles",),
)
