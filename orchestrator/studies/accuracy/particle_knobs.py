"""The particles' knobs: step, stiffness, number, finest size, and the width that they lie on."""

from __future__ import annotations

from orchestrator.case.bed.particle_step import particle_step_s
from orchestrator.case.file.contents import damped_contacts, has_particles
from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.slice import full_width_m
from orchestrator.case.tables.case import Case
from orchestrator.ports.clock import exact, steps_in
from orchestrator.preflight.stability.choice import settled
from orchestrator.studies.accuracy.setting import Family, NotOffered, Setting, degrees
from orchestrator.studies.ladder.rungs import stiffest_Pa

SOFTER = 10**0.5  # between neighbours
COARSER = 1.5
FINEST_STEPS = 3  # own, half, quarter
HERTZ = 0.4  # duration of a Hertzian impact ~ (Young's modulus) ** -0.4

DAMPED = (
    "contacts with restitution below 1: their dampers go by velocities of half a step ago, which "
    "makes an order of 1 (docs/theory/spheres.md)"
)
JUMPING = (
    "the surface is corrected at every sync point, and the particles feel it half a step later, "
    "which makes an order of 1 (docs/theory/spheres.md)"
)


def step(case: Case, points: int) -> list[Family]:
    """The particles' step, its half and its quarter.  Raises NotOffered."""
    _there(case)
    interval_s = case.coupling.sync_interval_s
    first = steps_in(interval_s, particle_step_s(case))
    settings = []
    for halved in range(min(points, FINEST_STEPS)):
        steps = first * 2**halved
        step_s = float(exact(interval_s) / steps)
        sets = (f"particles.step_s={step_s * (1 + 1e-9)!r}",) if halved else ()
        settings.append(Setting(f"{step_s:.3g} s", sets, step_s))
    note = DAMPED if damped_contacts(case) else JUMPING if _jumps(case) else ""
    name, order = "particle-step", 1.0 if note else 2.0
    return [Family(name, name, "", tuple(settings), "step / s", order, note=note)]


def stiffness(case: Case, points: int) -> list[Family]:
    """The largest Young's modulus in contacts, up to the materials' own.  Raises NotOffered."""
    _there(case)
    used_Pa = [m.youngs_modulus_Pa for m in case.materials.values() if m.youngs_modulus_Pa]
    if not used_Pa:
        raise NotOffered("no material has a Young's modulus of its own")
    own_Pa, true_Pa = stiffest_Pa(case), max(used_Pa)
    settings = []
    for degree in degrees(points):
        modulus_Pa = own_Pa * SOFTER**degree
        if modulus_Pa < true_Pa * SOFTER**0.5:
            sets = (f"particles.largest_youngs_modulus_Pa={modulus_Pa:.4g}",) if degree else ()
            settings.append(Setting(f"{modulus_Pa:.3g} Pa", sets, (own_Pa / modulus_Pa) ** HERTZ))
    return [Family("stiffness", "stiffness", "", tuple(settings), "duration of an impact / own")]


def number(case: Case, points: int) -> list[Family]:
    """Coarser particles, each for several.  Raises NotOffered."""
    _many(case)
    own = case.particles.coarse_graining
    settings = []
    for degree in range(1 - min(points, 3), 1):
        k = own * COARSER**-degree
        sets = (f"particles.coarse_graining={k:.4g}",) if degree else ()
        settings.append(Setting(f"diameters x {k:.3g}", sets, k))
    return [Family("number", "number", "", tuple(settings), "diameters, of the real ones")]


def cut_off(case: Case, points: int) -> list[Family]:
    """The finest size that is fed.  Raises NotOffered."""
    _there(case)
    rows = [
        (f"bed.{kind}.{name}.smallest_fed_m", row.smallest_fed_m)
        for kind, table in (("blocks", case.bed.blocks), ("feeds", case.bed.feeds))
        for name, row in table.items()
        if row.smallest_fed_m is not None
    ]
    if not rows:
        raise NotOffered("no block or feed has a smallest_fed_m")
    settings = []
    for degree in degrees(min(points, 3)):
        factor = COARSER ** (-degree / 2)
        sets = tuple(f"{key}={factor * size_m:.4g}" for key, size_m in rows) if degree else ()
        settings.append(Setting(f"{factor * rows[0][1]:.3g} m", sets, factor * rows[0][1]))
    return [Family("cut-off", "cut-off", "", tuple(settings), "finest size fed / m")]


def width(case: Case, points: int) -> list[Family]:
    """A slice, up to the whole width.  Raises NotOffered."""
    _many(case)
    try:
        low, high = full_width_m(case.whole)
    except CaseError as error:
        raise NotOffered(str(error.mistakes[0])) from None
    if case.whole.slice is None and case.particles.solver == "spheres":
        raise NotOffered("solver spheres knows no slice between periodic sides")
    own_m = case.whole.slice.width_m if case.whole.slice else high - low
    settings = []
    for degree in degrees(points):
        width_m = own_m * 2.0**degree
        if width_m <= (high - low) * (1 + 1e-9):
            sets = (f"slice.width_m={width_m:.6g}",) if degree else ()
            settings.append(Setting(f"{width_m:.3g} m", sets, own_m / width_m))
    if len(settings) < 2:
        raise NotOffered("there is one width only")
    return [Family("slice", "slice", "", tuple(settings), "own width / width")]


def _jumps(case: Case) -> bool:
    """Whether an interval's path may begin elsewhere than the last one's ended: where the surface
    is extrapolated, and of some with robin (docs/theory/coupling.md)."""
    rigid = case.panel.solver == "rigid" or not case.screen.panels
    extrapolated = {"particles-first": True, "robin": rigid or bool(case.screen.surfaces)}
    moves = bool(case.screen.frames) or not rigid
    return moves and extrapolated.get(settled(case).coupling.scheme, False)


def _there(case: Case) -> None:
    if not has_particles(case):
        raise NotOffered("the case has no particles")


def _many(case: Case) -> None:
    _there(case)
    if case.bed.particles:
        raise NotOffered("single particles stand for themselves")
