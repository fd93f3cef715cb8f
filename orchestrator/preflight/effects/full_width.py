"""The full width of the machine, for which a slice can stand if it is wide against the particles."""

from __future__ import annotations

from orchestrator.case.bed.grains import largest_length_m
from orchestrator.case.file.slice import ENOUGH_DIAMETERS, joins_sides, stretched_stiffness_error
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.preflight.scene.effect import Effect, Verdict
from orchestrator.preflight.scene.scene import Scene

NOTICED = 0.02  # a smaller error of a panel's stiffness is not told


def judge(scene: Scene) -> Verdict | None:
    """Return the verdict on the width over the largest particle; None without a slice or particles."""
    part = scene.case.slice
    if part is None or not has_particles(scene.case):
        return None
    ratio = part.width_m / largest_length_m(scene.case)
    narrow = ratio < ENOUGH_DIAMETERS
    return Verdict(
        number="slice / largest particle",
        value=ratio,
        threshold=f"{ENOUGH_DIAMETERS:g} (own choice)",
        matters=True if narrow else None,
        why="large particles may bridge" if narrow else "side plates and uneven feed: a run tells",
        cost="particles go with the width",
    )


def left_out(case: Case) -> str:
    """Return the width of the slice that stands for the machine; empty without a slice.

    Panels that vary across are stiffer or softer in a slice, because the clamps keep the middle of a wide
    panel from contracting across.
    """
    if case.slice is None:
        return ""
    text = f"slice.width_m = {case.slice.width_m:g}: the middle of the width"
    able = case.panel.adapter
    if not (able.varies_across and able.yields):
        return text
    can_join = able.joins_sides and case.panel.integrator == "explicit"
    errors = [
        stretched_stiffness_error(case, row.length_m, can_join and joins_sides(case, row.length_m))
        for row in case.screen.panels.values()
    ]
    worst = max(errors, key=abs, default=0.0)
    if abs(worst) < NOTICED:
        return text
    than = "stiffer" if worst > 0 else "softer"
    return f"{text}, whose panels are up to {100 * abs(worst):.0f} % {than} in stretch"


EFFECT = Effect(part="machine", judge=judge, left_out=left_out, key="slice.width_m")
