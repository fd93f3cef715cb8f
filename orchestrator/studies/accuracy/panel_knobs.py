"""The panels' knobs: model, mesh and step."""

from __future__ import annotations

import math

from orchestrator.case.tables.case import Case
from orchestrator.ports.clock import exact, steps_in
from orchestrator.ports.plans import SolverFailed, SolverMissing
from orchestrator.preflight.stability.panel_modes import largest_steps_s
from orchestrator.studies.accuracy.setting import Family, NotOffered, Setting, degrees
from orchestrator.studies.ladder.rungs import sheet_cells

MODELS = ("rigid", "strip", "sheet", "solid")  # the better the later
REFINED = {"strip": 2.0, "sheet": 1.5, "solid": 1.5}
ORDERS = {"strip": 2.0, "sheet": 2.0}
"""Chain: central differences.  Sheet: C0 interior penalty of biquadratic elements, whose bending
is of second order (Engel et al., Comput. Methods Appl. Mech. Engrg. 191, 2002, 3669-3750)."""
USUAL_SHARE = 0.8  # of the largest step, that solvers take by themselves: 0.8 or a little more
FINEST_STEPS = 3  # own, half, quarter


def mesh(case: Case, points: int) -> list[Family]:
    """Cells of the case's own model.  Raises NotOffered."""
    _there(case)
    if case.panel.solver not in REFINED:
        raise NotOffered(f"panels of solver {case.panel.solver} have no mesh")
    return [_meshes("panel-mesh", case, case.panel.solver, case.panel.cells, points)]


def model(case: Case, points: int) -> list[Family]:
    """Every other model that is one, at a few meshes each.  Raises NotOffered."""
    _there(case)
    along, across = sheet_cells(case)
    cells = {"strip": (along, 1), "sheet": (along, across), "solid": (along, max(1, across // 2))}
    found = []
    for name in MODELS:
        if name == case.panel.solver:
            continue
        if name == "rigid":
            still = Setting("rigid", ("panel.solver=rigid", "panel.step_s=0"))
            found.append(Family("panel-model", "panel", name, (still,)))
        else:
            found.append(_meshes("panel-model", case, name, cells[name], min(points, 3)))
    return found


def _there(case: Case) -> None:
    if not case.screen.panels:
        raise NotOffered("the case has no panels")


def _meshes(knob: str, case: Case, name: str, cells: tuple[int, int], points: int) -> Family:
    settings = []
    for degree in degrees(points):
        factor = REFINED[name] ** degree
        along = max(2, math.ceil(factor * cells[0]))
        across = 1 if name == "strip" else max(1, math.ceil(factor * cells[1]))
        label = f"{name}, {along} x {across} cells" if across > 1 else f"{name}, {along} cells"
        own = name == case.panel.solver and degree == 0
        sets = () if own else _overlays(name, along, across, case)
        settings.append(Setting(label, sets, cells[0] / along))
    order, rank = ORDERS.get(name), float(MODELS.index(name))
    return Family(knob, "panel", name, tuple(settings), "cell length / own", order, rank)


def _overlays(name: str, along: int, across: int, case: Case) -> tuple[str, ...]:
    """A mesh, and with another model the solver with its own step."""
    mesh = f"panel.cells=[{along},{across}]"
    if name == case.panel.solver:
        return (mesh,)
    integrator = "implicit" if name == "solid" else "explicit"
    return (f"panel.solver={name}", f"panel.integrator={integrator}", "panel.step_s=0", mesh)


def step(case: Case, points: int) -> list[Family]:
    """The panels' own step, its half and its quarter.  Raises NotOffered."""
    _there(case)
    interval_s = case.coupling.sync_interval_s
    first = steps_in(interval_s, min(interval_s, _usual_s(case)))
    settings = []
    for halved in range(min(points, FINEST_STEPS)):
        steps = first * 2**halved
        step_s = float(exact(interval_s) / steps)
        sets = (f"panel.step_s={step_s * (1 + 1e-9)!r}",) if halved else ()
        settings.append(Setting(f"{step_s:.3g} s", sets, step_s))
    return [Family("panel-step", "panel-step", "", tuple(settings), "panel's step / s", 2.0)]


def _usual_s(case: Case) -> float:
    """The step that the panels take as the case is."""
    if case.panel.step_s > 0:
        return case.panel.step_s
    if case.panel.integrator == "implicit" and case.panel.solver in ("sheet", "solid"):
        return math.inf  # a step for each interval, at most
    try:
        steps_s = largest_steps_s(case)
    except (SolverMissing, SolverFailed) as error:
        raise NotOffered(str(error)) from None
    if not steps_s:
        raise NotOffered(f"panels of solver {case.panel.solver} take no steps of their own")
    return USUAL_SHARE * min(steps_s.values())
