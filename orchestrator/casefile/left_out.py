"""Physics that a case, or its level, leaves out, by name.

A level that leaves out what the case has must say so: ``without = ["frame-rotation"]``.
"""

from __future__ import annotations

from orchestrator.casefile.case import Case

PANEL = {
    "rigid": {"panel-deformation": "panel.solver rigid: panels stay flat"},
    "strip": {"variation-across": "panel.solver strip: nothing varies across a panel"},
    "sheet": {},
    "solid": {},
}
FRAMES = {
    "prescribed": {
        "frame-dynamics": "frames.solver prescribed: nothing acts on the frames' motion"
    },
    "two-mass": {"frame-rotation": "frames.solver two-mass: frames translate only"},
    "exudyn": {},
}
HAND_OVER = {
    "frame_motion": "clamps stay where they are",
    "panel_motion": "particles see the surface as it was at t = 0",
    "particle_load": "panels do not feel the particles",
    "panel_reaction": "frames do not feel panels and walls",
}


def left_out(case: Case) -> dict[str, str]:
    """What solvers and hand-overs leave out of this case: name -> why."""
    found = dict(PANEL[case.panel.solver])
    if case.screen.bushings or case.screen.exciters or case.frames.solver == "two-mass":
        found |= FRAMES[case.frames.solver]
    rolling = any(contact.rolling_friction for contact in case.contacts)
    if case.particles.rolling == "none" and rolling and has_particles(case):
        found["rolling-friction"] = "particles.rolling none: no resistance to rolling"
    sticky = any(contact.work_of_adhesion_J_m2 for contact in case.contacts)
    if case.particles.adhesion == "none" and sticky and has_particles(case):
        found["adhesion"] = "particles.adhesion none: nothing sticks"
    k = case.particles.coarse_graining
    if k > 1.0 and has_particles(case):
        found["single-particles"] = f"particles.coarse_graining: one stands for {k**3:.3g}"
    if case.slice is not None:
        found["full-width"] = f"slice.width_m = {case.slice.width_m:g}: the middle of the width"
    for name, why in HAND_OVER.items():
        if not getattr(case.hand_over, name):
            found[name.replace("_", "-")] = f"hand_over.{name} is off: {why}"
    return found


def has_particles(case: Case) -> bool:
    """Whether there are or will be any."""
    return bool(case.bed.particles or case.bed.blocks or case.bed.feeds)


def absent(case: Case) -> dict[str, str]:
    """What this case does not have at all, and another might: name -> why."""
    screen = case.screen
    damped = any(m.hyperelastic and m.hyperelastic.maxwell for m in case.materials.values())
    there = {
        "particles": (has_particles(case), "the bed is empty"),
        "panel-damping": (damped, "no material has Maxwell branches"),
        "exciters": (bool(screen.exciters), "there are none"),
        "bushings": (bool(screen.bushings), "there are none"),
        "surfaces": (bool(screen.surfaces), "there are none"),
        "gravity": (any(case.gravity_m_s2), "gravity_m_s2 is zero"),
    }
    return {name: why for name, (is_there, why) in there.items() if not is_there}


def dropped(bare: Case, at_level: Case) -> dict[str, str]:
    """What the level leaves out of the bare case."""
    before, after = left_out(bare) | absent(bare), left_out(at_level) | absent(at_level)
    return {name: why for name, why in after.items() if name not in before}
