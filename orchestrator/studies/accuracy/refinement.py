"""Refinement parameters: what buys accuracy, and which values of it a case has.

A parameter is intervals, steps, meshes, sizes or models of one solver.  Its settings form series from
coarse to fine, each of which goes to one answer; series that exclude each other share an axis.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Literal, cast

from orchestrator.case import solvers
from orchestrator.case.file.errors import CaseError, did_you_mean
from orchestrator.case.file.slice import full_width_m
from orchestrator.case.solver_plans import particle_step_s
from orchestrator.case.tables.case import Case, damped_contacts, has_particles
from orchestrator.coupling.schemes import SCHEMES
from orchestrator.ports.clock import exact, steps_in
from orchestrator.ports.plans import SolverFailed, SolverMissing
from orchestrator.preflight.stability.modes import largest_steps_s
from orchestrator.preflight.stability.report import case_with_scheme

if TYPE_CHECKING:
    from orchestrator.ports.adapters import FramesAdapter, PanelAdapter

SCHEME_ORDERS = {"particles-first": 2.0, "serial-staggered": 1.0, "aitken": 2.0, "quasi-newton": 2.0}
"""Of the position (docs/theory/coupling.md); those of the other schemes are nowhere derived."""
WITHOUT_PARTICLES = ("particles-first", "serial-staggered")  # the others repeat the first then
USUAL_CELLS = (22, 8)  # of a sheet, by default
PLAYED_BACK = 0.5  # above a rigid panel, below any that bends
USUAL_SHARE = 0.8  # of the largest step, that solvers take by themselves: 0.8 or a little more
FINEST_STEPS = 3  # own, half, quarter
SOFTER = 10**0.5  # between neighbours
COARSER = 1.5
HERTZ = 0.4  # duration of a Hertzian impact ~ (Young's modulus) ** -0.4
DAMPED_COUPLING = (
    "contacts with restitution below 1 cost particles-first an order in motion and force, not in "
    "energy (docs/theory/coupling.md)"
)
DAMPED_STEPS = (
    "contacts with restitution below 1: their dampers go by velocities of half a step ago, which "
    "makes an order of 1 (docs/theory/spheres.md)"
)
JUMPING = (
    "the surface is corrected at every sync point, and the particles feel it half a step later, "
    "which makes an order of 1 (docs/theory/spheres.md)"
)


@dataclass(frozen=True)
class Setting:
    """A value of a parameter.

    ``sets`` are ``--set`` overlays, none for the case as it is; ``h`` is what its error goes to zero
    with, in the unit of its series, None where it is no matter of degree; ``made_from_run`` says what
    must be made from the run of the case as it is before this one can be run: a recording of the
    panels, or drives that move the frames alike.
    """

    label: str
    sets: tuple[str, ...] = ()
    h: float | None = None
    made_from_run: Literal["", "recording", "motion"] = ""


def joint_sets(settings: Mapping[str, Setting]) -> tuple[str, ...]:
    """Returns the ``--set`` overlays of settings by axis, in the order of the axes."""
    return tuple(overlay for setting in settings.values() for overlay in setting.sets)


def joint_label(settings: Mapping[str, Setting]) -> str:
    """Returns settings by axis in words."""
    return "; ".join(f"{axis}: {setting.label}" for axis, setting in settings.items())


@dataclass(frozen=True)
class RefinementSeries:
    """Settings from coarse to fine that go to one answer.

    ``axis``: parameters that exclude each other share one, and one of all their settings is taken;
    ``length``: what ``h`` is; ``expected``: order in h that theory gives, None where there is none;
    ``rank``: on one axis the series of the highest is nearest to the truth; ``note``: what a reader
    must know; ``is_choice``: whether one of its settings may be recommended, rather than only
    compared.
    """

    parameter: str
    axis: str
    variant: str
    settings: tuple[Setting, ...]
    length: str = ""
    expected: float | None = None
    rank: float = 0.0
    note: str = ""
    is_choice: bool = True


class NotOffered(Exception):
    """A parameter that this case does not have; the message says why."""


@dataclass(frozen=True)
class Parameter:
    """``series``: of a case, with so many values each; raises NotOffered."""

    title: str
    series: Callable[[Case, int], list[RefinementSeries]]


@dataclass(frozen=True)
class Offer:
    """What a case can refine, and why it cannot refine the rest: parameter -> reason."""

    series: tuple[RefinementSeries, ...]
    missing: dict[str, str]

    def of(self, axis: str) -> list[RefinementSeries]:
        """Returns the series on an axis."""
        return [series for series in self.series if series.axis == axis]

    @property
    def titles(self) -> dict[str, str]:
        """Of each axis: its parameters, in words."""
        return {
            axis: " or ".join(dict.fromkeys(PARAMETERS[one.parameter].title for one in self.of(axis)))
            for axis in self.axes
        }

    @property
    def axes(self) -> list[str]:
        """The names of the axes."""
        return list(dict.fromkeys(series.axis for series in self.series))


def offer(case: Case, names: Sequence[str], points: int) -> Offer:
    """Returns the series of the parameters named, ``points`` values each;
    "scheme=aitken+robin" has these variants only."""
    every: list[RefinementSeries] = []
    missing = {}
    for each in names:
        name, _, only = each.partition("=")
        try:
            series = PARAMETERS[name].series(case, points)
            every += _chosen(series, only.split("+")) if only else series
        except NotOffered as why:
            missing[name] = str(why)
    return Offer(tuple(every), missing)


def _chosen(series: Sequence[RefinementSeries], variants: Sequence[str]) -> list[RefinementSeries]:
    """Raises NotOffered for a variant that there is not."""
    known = [each.variant for each in series]
    for name in variants:
        if name not in known:
            raise NotOffered(f'no variant "{name}"; {did_you_mean(name, known)}')
    return [each for each in series if each.variant in variants]


def _degrees(points: int) -> list[int]:
    """Returns how often a value is halved, from coarse to fine, for ``points`` values: 0 is the
    case's own; 3 gives -1, 0, 1."""
    coarser = (points - 1) // 2
    return list(range(-coarser, points - coarser))


def _sync(case: Case, points: int) -> list[RefinementSeries]:
    """The interval of the case's own scheme, or of the one that is taken for it, halved and
    doubled."""
    name = case_with_scheme(case).coupling.scheme
    overlay = f"coupling.scheme={name}" if case.coupling.scheme != name else ""
    return [_intervals("sync", case, name, overlay, points)]


def _scheme(case: Case, points: int) -> list[RefinementSeries]:
    """Every other scheme, at the same intervals.  Raises NotOffered."""
    if not (case.screen.panels and (has_particles(case) or case.screen.frames)):
        raise NotOffered("nothing is coupled: schemes differ only where panels meet others")
    some, own = has_particles(case), case_with_scheme(case).coupling.scheme
    return [
        _intervals("scheme", case, name, f"coupling.scheme={name}", points)
        for name in SCHEMES
        if name != own and (some or name in WITHOUT_PARTICLES)
    ]


def _intervals(parameter: str, case: Case, name: str, overlay: str, points: int) -> RefinementSeries:
    own_s = exact(case.coupling.sync_interval_s)
    settings = []
    for halved in _degrees(points):
        length_s = float(own_s / 2**halved if halved >= 0 else own_s * 2**-halved)
        sets = (f"coupling.sync_interval_s={length_s!r}",) if halved else ()
        label = f"{name}, {length_s:g} s"
        named = (overlay,) if overlay and (sets or parameter == "scheme") else ()
        settings.append(Setting(label, (*named, *sets), length_s))
    order = SCHEME_ORDERS.get(name)
    rank = (order or 0.0) + (0.5 if parameter == "sync" else 0.0)
    note = DAMPED_COUPLING if name == "particles-first" and damped_contacts(case) else ""
    return RefinementSeries(
        parameter, "coupling", name, tuple(settings), "sync interval / s", order, rank, note
    )


def _panel_mesh(case: Case, points: int) -> list[RefinementSeries]:
    """Cells of the case's own model.  Raises NotOffered."""
    _need_panels(case)
    if not case.panel.adapter.refined_by:
        raise NotOffered(f"panels of solver {case.panel.solver} have no mesh")
    return [_meshes("panel-mesh", case, case.panel.solver, case.panel.cells, points)]


def _panel_model(case: Case, points: int) -> list[RefinementSeries]:
    """Every other model, at a few meshes each.  Raises NotOffered."""
    _need_panels(case)
    own = case.panel.adapter
    along, across = case.panel.cells if own.refined_by and own.varies_across else USUAL_CELLS
    every = []
    for name in _by_fidelity("panel"):
        adapter = _panel_adapter(name)
        if name == case.panel.solver:
            continue
        if adapter.refined_by:
            wide = 1 if not adapter.varies_across else max(1, across // 2) if adapter.mesh_size else across
            every.append(_meshes("panel-model", case, name, (along, wide), min(points, 3)))
        elif own.deforms or not adapter.plays_back:
            sets = (f"panel.solver={name}", "panel.integrator=explicit", "panel.step_s=0")
            made = adapter.plays_back and not case.panel.recording
            every.append(_model("panel", Setting(name, sets, made_from_run="recording" if made else "")))
    return every


def _need_panels(case: Case) -> None:
    if not case.screen.panels:
        raise NotOffered("the case has no panels")


def _meshes(parameter: str, case: Case, name: str, cells: tuple[int, int], points: int) -> RefinementSeries:
    adapter = _panel_adapter(name)
    settings = []
    for degree in _degrees(points):
        factor = adapter.refined_by**degree
        along = max(2, math.ceil(factor * cells[0]))
        across = max(1, math.ceil(factor * cells[1])) if adapter.varies_across else 1
        label = f"{name}, {along} x {across} cells" if across > 1 else f"{name}, {along} cells"
        own = name == case.panel.solver and degree == 0
        sets = () if own else _mesh_overlays(name, along, across, case)
        settings.append(Setting(label, sets, cells[0] / along))
    length, rank = "cell length / own", _fidelity("panel", name)
    return RefinementSeries(parameter, "panel", name, tuple(settings), length, adapter.order, rank)


def _mesh_overlays(name: str, along: int, across: int, case: Case) -> tuple[str, ...]:
    """Returns a mesh, and with another model the solver with its own step."""
    mesh = f"panel.cells=[{along},{across}]"
    if name == case.panel.solver:
        return (mesh,)
    integrator = "implicit" if _panel_adapter(name).mesh_size else "explicit"  # cells of any size
    return (f"panel.solver={name}", f"panel.integrator={integrator}", "panel.step_s=0", mesh)


def _model(port: solvers.Port, setting: Setting, is_choice: bool = True) -> RefinementSeries:
    """Returns the series of one setting, a model, which is named after its solver."""
    name = setting.label
    is_choice = is_choice and not setting.made_from_run
    return RefinementSeries(
        f"{port}-model", port, name, (setting,), rank=_fidelity(port, name), is_choice=is_choice
    )


def _by_fidelity(port: solvers.Port) -> list[str]:
    """Returns the solvers of a port, the better the later."""
    return sorted(solvers.names(port), key=lambda name: _fidelity(port, name))


def _fidelity(port: solvers.Port, name: str) -> float:
    """Returns the place of a solver; one that plays another's motion back is the better one of two
    that nothing bends."""
    fidelity = solvers.adapter(port, name).fidelity
    return PLAYED_BACK if fidelity is None else fidelity


def _panel_adapter(name: str) -> PanelAdapter:
    return cast("PanelAdapter", solvers.adapter("panel", name))


def _panel_step(case: Case, points: int) -> list[RefinementSeries]:
    """The panels' own step, its half and its quarter.  Raises NotOffered."""
    _need_panels(case)
    own_s = min(case.coupling.sync_interval_s, _usual_panel_step_s(case))
    settings = _steps(case, "panel.step_s", own_s, points)
    return [RefinementSeries("panel-step", "panel-step", "", settings, "panel's step / s", 2.0)]


def _usual_panel_step_s(case: Case) -> float:
    """Returns the step that the panels take as the case is."""
    if case.panel.step_s > 0:
        return case.panel.step_s
    if case.panel.integrator == "implicit" and case.panel.adapter.largest_step_s is not None:
        return math.inf  # a step for each interval, at most
    try:
        steps_s = largest_steps_s(case)
    except (SolverMissing, SolverFailed) as error:
        raise NotOffered(str(error)) from None
    if not steps_s:
        raise NotOffered(f"panels of solver {case.panel.solver} take no steps of their own")
    return USUAL_SHARE * min(steps_s.values())


def _steps(case: Case, key: str, own_s: float, points: int) -> tuple[Setting, ...]:
    """Returns a step, its half and its quarter, whole parts of the sync interval."""
    interval_s = case.coupling.sync_interval_s
    first = steps_in(interval_s, own_s)
    settings = []
    for halved in range(min(points, FINEST_STEPS)):
        step_s = float(exact(interval_s) / (first * 2**halved))
        sets = (f"{key}={step_s * (1 + 1e-9)!r}",) if halved else ()
        settings.append(Setting(f"{step_s:.3g} s", sets, step_s))
    return tuple(settings)


def _frames_model(case: Case, points: int) -> list[RefinementSeries]:
    """Every model of the frames.  Raises NotOffered."""
    if not case.screen.frames:
        raise NotOffered("the case has no frames")
    driven = all(frame.drive for frame in case.screen.frames.values())
    every = []
    for name in _by_fidelity("frames"):
        own = name == case.frames.solver
        free = cast("FramesAdapter", solvers.adapter("frames", name)).moved_by_forces
        made: Literal["", "motion"] = "" if own or free or driven else "motion"
        sets = () if own else (f"frames.solver={name}",)
        every.append(_model("frames", Setting(name, sets, made_from_run=made)))
    return every


def _particle_model(case: Case, points: int) -> list[RefinementSeries]:
    """No particles at all, and every solver of them.  Raises NotOffered."""
    _need_particles(case)
    own, empty = case.particles.solver, Setting(solvers.NONE, (f"particles.solver={solvers.NONE}",))
    without = RefinementSeries(
        "particles-model", "particles", solvers.NONE, (empty,), rank=-1.0, is_choice=False
    )
    every = [
        _model("particles", Setting(name, () if name == own else (f"particles.solver={name}",)))
        for name in _by_fidelity("particles")
    ]
    return [without, *every]


def _particle_step(case: Case, points: int) -> list[RefinementSeries]:
    """The particles' step, its half and its quarter.  Raises NotOffered."""
    _need_particles(case)
    settings = _steps(case, "particles.step_s", particle_step_s(case), points)
    note = DAMPED_STEPS if damped_contacts(case) else JUMPING if _surface_jumps(case) else ""
    name, order = "particle-step", 1.0 if note else 2.0
    return [RefinementSeries(name, name, "", settings, "step / s", order, note=note)]


def _surface_jumps(case: Case) -> bool:
    """Returns whether an interval's path may begin elsewhere than the last one's ended: where the
    surface is extrapolated, and of some with robin (docs/theory/coupling.md)."""
    rigid = not (case.screen.panels and case.panel.adapter.deforms)
    extrapolated = {"particles-first": True, "robin": rigid or bool(case.screen.surfaces)}
    moves = bool(case.screen.frames) or not rigid
    return moves and extrapolated.get(case_with_scheme(case).coupling.scheme, False)


def _stiffness(case: Case, points: int) -> list[RefinementSeries]:
    """The largest Young's modulus in contacts, up to the materials' own.  Raises NotOffered."""
    _need_particles(case)
    used_Pa = [m.youngs_modulus_Pa for m in case.materials.values() if m.youngs_modulus_Pa]
    if not used_Pa:
        raise NotOffered("no material has a Young's modulus of its own")
    true_Pa, cap_Pa = max(used_Pa), case.particles.largest_youngs_modulus_Pa
    own_Pa = true_Pa if cap_Pa is None else min(true_Pa, cap_Pa)
    settings = []
    for degree in _degrees(points):
        modulus_Pa = own_Pa * SOFTER**degree
        if modulus_Pa < true_Pa * SOFTER**0.5:
            sets = (f"particles.largest_youngs_modulus_Pa={modulus_Pa:.4g}",) if degree else ()
            settings.append(Setting(f"{modulus_Pa:.3g} Pa", sets, (own_Pa / modulus_Pa) ** HERTZ))
    name, length = "stiffness", "duration of an impact / own"
    return [RefinementSeries(name, name, "", tuple(settings), length)]


def _number(case: Case, points: int) -> list[RefinementSeries]:
    """Coarser particles, each for several.  Raises NotOffered."""
    _need_many_particles(case)
    own = case.particles.coarse_graining
    settings = []
    for degree in range(1 - min(points, 3), 1):
        k = own * COARSER**-degree
        sets = (f"particles.coarse_graining={k:.4g}",) if degree else ()
        settings.append(Setting(f"diameters x {k:.3g}", sets, k))
    length = "diameters, of the real ones"
    return [RefinementSeries("number", "number", "", tuple(settings), length)]


def _cut_off(case: Case, points: int) -> list[RefinementSeries]:
    """The finest size that is fed.  Raises NotOffered."""
    _need_particles(case)
    rows = [
        (f"bed.{kind}.{name}.smallest_fed_m", row.smallest_fed_m)
        for kind, table in (("blocks", case.bed.blocks), ("feeds", case.bed.feeds))
        for name, row in table.items()
        if row.smallest_fed_m is not None
    ]
    if not rows:
        raise NotOffered("no block or feed has a smallest_fed_m")
    settings = []
    for degree in _degrees(min(points, 3)):
        factor = COARSER ** (-degree / 2)
        sets = tuple(f"{key}={factor * size_m:.4g}" for key, size_m in rows) if degree else ()
        settings.append(Setting(f"{factor * rows[0][1]:.3g} m", sets, factor * rows[0][1]))
    return [RefinementSeries("cut-off", "cut-off", "", tuple(settings), "finest size fed / m")]


def _width(case: Case, points: int) -> list[RefinementSeries]:
    """A slice, up to the whole width.  Raises NotOffered."""
    _need_many_particles(case)
    try:
        low, high = full_width_m(case.whole)
    except CaseError as error:
        raise NotOffered(str(error.problems[0])) from None
    solver = case.particles.adapter
    if case.whole.slice is None and solver is not None and not solver.periodic:
        raise NotOffered(f"solver {case.particles.solver} knows no slice between periodic sides")
    own_m = case.whole.slice.width_m if case.whole.slice else high - low
    settings = []
    for degree in _degrees(points):
        width_m = own_m * 2.0**degree
        if width_m <= (high - low) * (1 + 1e-9):
            sets = (f"slice.width_m={width_m:.6g}",) if degree else ()
            settings.append(Setting(f"{width_m:.3g} m", sets, own_m / width_m))
    if len(settings) < 2:
        raise NotOffered("there is one width only")
    return [RefinementSeries("slice", "slice", "", tuple(settings), "own width / width")]


def _need_particles(case: Case) -> None:
    if not has_particles(case):
        raise NotOffered("the case has no particles")


def _need_many_particles(case: Case) -> None:
    _need_particles(case)
    if case.bed.particles:
        raise NotOffered("single particles stand for themselves")


PARAMETERS = {
    "sync": Parameter("sync interval", _sync),
    "scheme": Parameter("coupling scheme", _scheme),
    "panel-mesh": Parameter("panel mesh", _panel_mesh),
    "panel-model": Parameter("panel model", _panel_model),
    "panel-step": Parameter("panel's time step", _panel_step),
    "frames-model": Parameter("model of the frames", _frames_model),
    "particles-model": Parameter("solver of the particles", _particle_model),
    "particle-step": Parameter("particles' time step", _particle_step),
    "stiffness": Parameter("stiffness of contacts", _stiffness),
    "slice": Parameter("slice of the width", _width),
    "number": Parameter("number of particles", _number),
    "cut-off": Parameter("finest size fed", _cut_off),
}
