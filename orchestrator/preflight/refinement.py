"""Refinement parameters, which trade time for accuracy, and their settings in a case.

A parameter varies the intervals, steps, meshes, sizes or models of one solver (``PARAMETERS``).  Its settings
form series from coarse to fine, each of which converges to one answer.  Series that exclude each other share
an axis.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any, Literal

from orchestrator.case import solvers
from orchestrator.case.bed.grains import largest_length_m, shapes
from orchestrator.case.file.errors import CaseError, CaseProblem, did_you_mean
from orchestrator.case.file.slice import between_openings_m, full_width_m
from orchestrator.case.solver_plans import particle_step_s
from orchestrator.case.tables.bed import MOST_SPHERES
from orchestrator.case.tables.case import Case, damped_contacts, has_particles
from orchestrator.ports.clock import exact, steps_in
from orchestrator.ports.clumps import divided_spheres
from orchestrator.ports.plans import SolverFailed, SolverMissing
from orchestrator.preflight.checks.bed import FEWEST_DIAMETERS
from orchestrator.preflight.cost import TRIES
from orchestrator.preflight.stability.modes import largest_steps_s
from orchestrator.preflight.stability.report import case_with_scheme

SCHEME_ORDERS = {"particles-first": 2.0, "serial-staggered": 1.0, "aitken": 2.0, "quasi-newton": 2.0}
"""The orders of the position by scheme (docs/theory/coupling.md); no orders are derived for other schemes."""
# without particles the other schemes equal the first
WITHOUT_PARTICLES = ("particles-first", "serial-staggered")
USUAL_CELLS = (22, 8)  # a sheet's default cells
USUAL_SHARE = 0.8  # the part of the largest step that solvers choose by themselves: 0.8 or a little more
FINEST_STEPS = 3  # the case's own step, its half and its quarter
FINEST_PARTS = 3  # of the way between two spheres: the finest flake has 37
SOFTER = 10**0.5  # ratio of neighbouring moduli
COARSER = 1.5
HERTZ = 0.4  # duration of a Hertzian impact ~ (Young's modulus) ** -0.4
DAMPED_COUPLING = (
    "contacts with restitution below 1 cost particles-first an order in motion and force, not in "
    "energy (docs/theory/coupling.md)"
)
DAMPED_STEPS = (
    "contacts with restitution below 1: when a damper sets in, a fraction of a step is lost or gained, "
    "which makes an order of 1.25 (docs/theory/spheres.md)"
)


@dataclass(frozen=True)
class Setting:
    """A setting: one value of a parameter.

    ``sets`` are its ``--set`` overlays; the unchanged case has none.  ``h`` is the length with which the
    error goes to zero, in the unit of the series; it is None for a setting without a length.
    ``needs_drives`` says that the run of the unchanged case must come first, since drives then move the
    frames as in that run.
    """

    label: str
    sets: tuple[str, ...] = ()
    h: float | None = None
    needs_drives: bool = False


@dataclass(frozen=True)
class RefinementSeries:
    """A series of settings from coarse to fine that converges to one answer.

    Parameters that exclude each other share an ``axis``, from which a combination has one setting.
    ``length`` describes ``h``.  ``expected`` is the theoretical order in h, or None without a theory.  On one
    axis the series of the highest ``rank`` is nearest to the truth.  ``note`` is a remark for the reader.
    ``is_choice`` says whether its settings may be recommended, rather than only compared.  ``offer`` fills in
    the name of the ``parameter``.
    """

    axis: str
    variant: str
    settings: tuple[Setting, ...]
    length: str = ""
    expected: float | None = None
    rank: float = 0.0
    note: str = ""
    is_choice: bool = True
    parameter: str = ""

    @property
    def title(self) -> str:
        """The parameter in words."""
        return PARAMETERS[self.parameter].title

    @property
    def layer(self) -> Layer:
        """What its parameter varies: the numerics inside a model, the model, or what is sampled of it."""
        return PARAMETERS[self.parameter].layer


Layer = Literal["numerics", "model", "statistics"]


class NotOffered(Exception):
    """An error of a parameter that a case does not have; the message says why."""


@dataclass(frozen=True)
class Parameter:
    """A refinement parameter.

    ``series`` returns the series of a case with a given number of values, or raises NotOffered.  ``layer``
    is what it varies.  ``needs`` are names of ``NEEDS`` that the case must meet first.
    """

    title: str
    series: Callable[[Case, int], Iterable[RefinementSeries]]
    layer: Layer
    needs: tuple[str, ...] = ()


@dataclass(frozen=True)
class Offer:
    """The series that a case can refine; ``missing`` has the reasons for the other parameters, by name."""

    series: tuple[RefinementSeries, ...]
    missing: dict[str, str]

    @property
    def parameters(self) -> dict[str, str]:
        """The titles of all parameters that there are, by name."""
        return {name: parameter.title for name, parameter in PARAMETERS.items()}

    def of(self, axis: str) -> list[RefinementSeries]:
        """Return the series on an axis."""
        return [series for series in self.series if series.axis == axis]

    @property
    def titles(self) -> dict[str, str]:
        """The axes, each with its parameters in words."""
        titles: dict[str, list[str]] = {}
        for series in self.series:
            titles.setdefault(series.axis, []).append(series.title)
        return {axis: " or ".join(dict.fromkeys(names)) for axis, names in titles.items()}


def offer(case: Case, names: Sequence[str], points: int) -> Offer:
    """Return the series of the named parameters, with ``points`` values each.

    The name "scheme=aitken+robin" selects these variants only.  Raises CaseError for a variant that the case
    does not have.
    """
    every: list[RefinementSeries] = []
    missing = {}
    for each in names:
        name, _, only = each.partition("=")
        parameter = PARAMETERS[name]
        try:
            for is_met, why in map(NEEDS.__getitem__, parameter.needs):
                if not is_met(case):
                    raise NotOffered(why)
            series = [replace(one, parameter=name) for one in parameter.series(case, points)]
            every += _variants(series, only.split("+")) if only else series
        except NotOffered as why:
            missing[name] = str(why)
    return Offer(tuple(every), missing)


def _variants(series: Sequence[RefinementSeries], variants: Sequence[str]) -> list[RefinementSeries]:
    """Return the series of these variants.  Raises CaseError for an unknown variant."""
    known = [each.variant for each in series]
    for name in variants:
        if name not in known:
            hint = did_you_mean(name, filter(None, known))
            raise CaseError(
                [
                    CaseProblem(
                        (), f'no variant "{name}" for this case', hint, "--parameters", kind="unknown-name"
                    )
                ]
            )
    return [each for each in series if each.variant in variants]


def _degrees(points: int) -> list[int]:
    """Return the degrees of ``points`` values from coarse to fine: the numbers of times a value is halved.

    Degree 0 is the case's own value; 3 points have the degrees -1, 0, 1.
    """
    coarser = (points - 1) // 2
    return list(range(-coarser, points - coarser))


def _settings(
    values: Mapping[int, float],
    label: str,
    key: str | Callable[[float], tuple[str, ...]],
    h: Callable[[float], float] = float,
) -> tuple[Setting, ...]:
    """Return the settings of values by degree; degree 0 is the case's own value.

    ``label`` is a format of the value.  ``key`` is a format, too, or a function that returns the overlays of
    a value.  ``h`` returns the length of a value.
    """
    make = (lambda value: (key.format(value),)) if isinstance(key, str) else key
    return tuple(
        Setting(label.format(value), make(value) if degree else (), h(value))
        for degree, value in values.items()
    )


def _sync(case: Case, points: int) -> Iterable[RefinementSeries]:
    """Yield the series of sync intervals with the case's own scheme, or with the scheme chosen for it."""
    name = case_with_scheme(case).coupling.scheme
    overlay = (f"coupling.scheme={name}",) if case.coupling.scheme != name else ()
    series = _intervals(case, name, (), overlay, points)
    notes = filter(None, (series.note, _steps_with(case, series)))
    yield replace(series, rank=series.rank + 0.5, note="; ".join(notes))


def _scheme(case: Case, points: int) -> Iterable[RefinementSeries]:
    """Yield the series of every other scheme, at the same intervals.  Raises NotOffered."""
    some, own = has_particles(case), case_with_scheme(case).coupling.scheme
    if not (case.screen.panels and (some or case.screen.frames)):
        raise NotOffered("nothing is coupled: schemes differ only where panels meet others")
    for name in TRIES:
        if name != own and (some or name in WITHOUT_PARTICLES):
            overlay = (f"coupling.scheme={name}",)
            yield _intervals(case, name, overlay, overlay, points)


def _intervals(
    case: Case, name: str, at_own: tuple[str, ...], elsewhere: tuple[str, ...], points: int
) -> RefinementSeries:
    """Return a scheme's series of intervals.

    ``at_own`` are the overlays at the case's own interval, ``elsewhere`` the overlays at other intervals.
    """
    own_s = exact(case.coupling.sync_interval_s)
    settings = []
    for halved in _degrees(points):
        length_s = float(own_s / 2**halved if halved >= 0 else own_s * 2**-halved)
        sets = (*elsewhere, f"coupling.sync_interval_s={length_s!r}") if halved else at_own
        settings.append(Setting(f"{name}, {length_s:g} s", sets, length_s))
    order = SCHEME_ORDERS.get(name)
    note = DAMPED_COUPLING if name == "particles-first" and damped_contacts(case) else ""
    expected = order - 1 if order and note else order
    return RefinementSeries(
        "coupling", name, tuple(settings), "sync interval / s", expected, expected or 0.0, note
    )


def _steps_with(case: Case, series: RefinementSeries) -> str:
    """Return the remark that the panels' step becomes finer with the finest intervals; empty where it does
    not."""
    finest_s = min(setting.h or math.inf for setting in series.settings)
    try:
        step_s = min(case.coupling.sync_interval_s, _usual_panel_step_s(case)) if case.screen.panels else 0.0
    except NotOffered:
        return ""
    if step_s < finest_s * (1 + 1e-9):
        return ""
    return f"intervals below {step_s:.3g} s are the panels' step, too, so that both become finer together"


def _panel_mesh(case: Case, points: int) -> Iterable[RefinementSeries]:
    """Yield the series of meshes of the case's own model.  Raises NotOffered."""
    if not case.panel.adapter.refined_by:
        raise NotOffered(f"panels of solver {case.panel.solver} have no mesh")
    yield _meshes(case, case.panel.solver, case.panel.cells, points)


def _panel_model(case: Case, points: int) -> Iterable[RefinementSeries]:
    """Yield the series of every other model of the panels, with a few meshes each."""
    own = case.panel.adapter
    along, across = case.panel.cells if own.refined_by and own.varies_across else USUAL_CELLS
    for name in _by_fidelity("panel"):
        adapter = _adapter("panel", name)
        if name == case.panel.solver:
            continue
        if adapter.refined_by:
            wide = 1 if not adapter.varies_across else max(1, across // 2) if adapter.mesh_size else across
            yield _meshes(case, name, (along, wide), min(points, 3))
        else:
            sets = (f"panel.solver={name}", "panel.integrator=explicit", "panel.step_s=0")
            yield _model("panel", Setting(name, sets))


def _meshes(case: Case, name: str, cells: tuple[int, int], points: int) -> RefinementSeries:
    adapter, own = _adapter("panel", name), name == case.panel.solver
    solver: tuple[str, ...] = ()
    if not own:
        # explicit steps would follow the smallest cell
        integrator = "implicit" if adapter.mesh_size else "explicit"
        solver = (f"panel.solver={name}", f"panel.integrator={integrator}", "panel.step_s=0")
    settings = []
    for degree in _degrees(points):
        factor = adapter.refined_by**degree
        along = max(2, math.ceil(factor * cells[0]))
        across = max(1, math.ceil(factor * cells[1])) if adapter.varies_across else 1
        label = f"{name}, {along} x {across} cells" if across > 1 else f"{name}, {along} cells"
        sets = () if own and degree == 0 else (*solver, f"panel.cells=[{along},{across}]")
        settings.append(Setting(label, sets, cells[0] / along))
    length, rank = "cell length / own", adapter.fidelity
    return RefinementSeries("panel", name, tuple(settings), length, adapter.order, rank)


def _model(port: solvers.Port, setting: Setting) -> RefinementSeries:
    rank, is_choice = _adapter(port, setting.label).fidelity, not setting.needs_drives
    return RefinementSeries(port, setting.label, (setting,), rank=rank, is_choice=is_choice)


def _by_fidelity(port: solvers.Port) -> list[str]:
    return sorted(solvers.names(port), key=lambda name: _adapter(port, name).fidelity)


def _adapter(port: solvers.Port, name: str) -> Any:
    return solvers.adapter(port, name)


def _panel_step(case: Case, points: int) -> Iterable[RefinementSeries]:
    """Yield the series of the panels' own step, its half and its quarter.  Raises NotOffered."""
    own_s = min(case.coupling.sync_interval_s, _usual_panel_step_s(case))
    settings = _steps(case, "panel.step_s", own_s, points)
    yield RefinementSeries("panel-step", "", settings, "panel's step / s", 2.0)


def _usual_panel_step_s(case: Case) -> float:
    """Return the panels' step in the unchanged case in s.  Raises NotOffered."""
    if case.panel.step_s > 0:
        return case.panel.step_s
    if case.panel.integrator == "implicit" and case.panel.adapter.largest_step_s is not None:
        return math.inf  # the sync interval limits the step
    try:
        steps_s = largest_steps_s(case)
    except (SolverMissing, SolverFailed) as error:
        raise NotOffered(str(error)) from None
    if not steps_s:
        raise NotOffered(f"panels of solver {case.panel.solver} take no steps of their own")
    return USUAL_SHARE * min(steps_s.values())


def _steps(case: Case, key: str, own_s: float, points: int) -> tuple[Setting, ...]:
    """Return the settings of a step, its half and its quarter, which divide the sync interval."""
    interval_s = case.coupling.sync_interval_s
    first = steps_in(interval_s, own_s)
    halves = range(min(points, FINEST_STEPS))
    values = {halved: float(exact(interval_s) / (first * 2**halved)) for halved in halves}
    return _settings(values, "{:.3g} s", lambda step_s: (f"{key}={step_s * (1 + 1e-9)!r}",))


def _frames_model(case: Case, points: int) -> Iterable[RefinementSeries]:
    driven = all(frame.drive for frame in case.screen.frames.values())
    for name in _by_fidelity("frames"):
        own = name == case.frames.solver
        free = _adapter("frames", name).moved_by_forces
        sets = () if own else (f"frames.solver={name}",)
        yield _model("frames", Setting(name, sets, needs_drives=not (own or free or driven)))


def _particle_model(case: Case, points: int) -> Iterable[RefinementSeries]:
    own, without = case.particles.solver, Setting(solvers.NONE, (f"particles.solver={solvers.NONE}",))
    yield RefinementSeries("particles", solvers.NONE, (without,), rank=-1.0, is_choice=False)
    for name in _by_fidelity("particles"):
        yield _model("particles", Setting(name, () if name == own else (f"particles.solver={name}",)))


def _particle_step(case: Case, points: int) -> Iterable[RefinementSeries]:
    settings = _steps(case, "particles.step_s", particle_step_s(case), points)
    note = DAMPED_STEPS if damped_contacts(case) else ""
    yield RefinementSeries("particle-step", "", settings, "step / s", 1.25 if note else 2.0, note=note)


def _stiffness(case: Case, points: int) -> Iterable[RefinementSeries]:
    """Yield the series of the largest Young's modulus in contacts, up to the largest of the materials.

    Raises NotOffered.
    """
    used_Pa = [m.youngs_modulus_Pa for m in case.materials.values() if m.youngs_modulus_Pa]
    if not used_Pa:
        raise NotOffered("no material has a Young's modulus of its own")
    true_Pa, cap_Pa = max(used_Pa), case.particles.largest_youngs_modulus_Pa
    own_Pa = true_Pa if cap_Pa is None else min(true_Pa, cap_Pa)
    every_Pa = {degree: own_Pa * SOFTER**degree for degree in _degrees(points)}
    moduli_Pa = {
        n: min(modulus, true_Pa) for n, modulus in every_Pa.items() if modulus < true_Pa * SOFTER**0.5
    }
    key = "particles.largest_youngs_modulus_Pa={:.4g}"
    settings = _settings(moduli_Pa, "{:.3g} Pa", key, lambda modulus: float((own_Pa / modulus) ** HERTZ))
    yield RefinementSeries("stiffness", "", settings, "duration of an impact / own")


def _number(case: Case, points: int) -> Iterable[RefinementSeries]:
    """Yield the series of coarser particles, each of which stands for several real particles."""
    own = case.particles.coarse_graining
    values = {degree: own * COARSER**-degree for degree in range(1 - min(points, 3), 1)}
    settings = _settings(values, "diameters x {:.3g}", "particles.coarse_graining={:.4g}")
    yield RefinementSeries("number", "", settings, "diameters, of the real ones")


def _cut_off(case: Case, points: int) -> Iterable[RefinementSeries]:
    """Yield the series of the finest size that is fed.  Raises NotOffered."""
    rows = [
        (f"bed.{kind}.{name}.smallest_fed_m", row.smallest_fed_m)
        for kind, table in (("blocks", case.bed.blocks), ("feeds", case.bed.feeds))
        for name, row in table.items()
        if row.smallest_fed_m is not None
    ]
    if not rows:
        raise NotOffered("no block or feed has a smallest_fed_m")
    first_m = rows[0][1]
    sizes_m = {degree: COARSER ** (-degree / 2) * first_m for degree in _degrees(min(points, 3))}

    def overlays(size_m: float) -> tuple[str, ...]:
        return tuple(f"{key}={size_m / first_m * own_m:.4g}" for key, own_m in rows)

    yield RefinementSeries("cut-off", "", _settings(sizes_m, "{:.3g} m", overlays), "finest size fed / m")


def _shape(case: Case, points: int) -> Iterable[RefinementSeries]:
    """Yield the series from grains that are spheres by the shapes' own spheres to finer ones.  Raises
    NotOffered."""
    if case.bed.shape_divisions > 1:
        raise NotOffered("the grains of this case are divided already (bed.shape_divisions)")
    if all(len(each.spheres) == 1 for each in shapes(case)):
        raise NotOffered("all grains are single spheres")
    bed = case.bed
    rows = [f"{kind}.{name}" for kind in ("particles", "blocks", "feeds") for name in getattr(bed, kind)]
    settings = [Setting("1 sphere", tuple(f"bed.{row}.shape=sphere" for row in rows))]
    for parts in range(1, min(points, FINEST_PARTS + 1)):
        most = max(len(divided_spheres(each.spheres, parts)) for each in shapes(case))
        if most > MOST_SPHERES:
            break
        key = f"bed.shape_divisions={parts}"
        settings.append(Setting(f"{most} spheres", (key,) if parts > 1 else ()))
    yield RefinementSeries("shape", "", tuple(settings))


def _width(case: Case, points: int) -> Iterable[RefinementSeries]:
    """Yield the series of slices that a check allows, up to the whole width.  Raises NotOffered."""
    try:
        low, high = full_width_m(case.whole_machine)
    except CaseError as error:
        raise NotOffered(str(error.problems[0])) from None
    solver = case.particles.adapter
    if case.whole_machine.slice is None and solver is not None and not solver.periodic:
        raise NotOffered(f"solver {case.particles.solver} knows no slice between periodic sides")
    whole = case.whole_machine
    own_m = whole.slice.width_m if whole.slice else high - low
    every_m = {degree: own_m * 2.0**degree for degree in _degrees(points)}
    most_m, least_m = (high - low) * (1 + 1e-9), FEWEST_DIAMETERS * largest_length_m(case)
    widths_m = {
        degree: between_openings_m(whole, width_m) if degree else own_m
        for degree, width_m in every_m.items()
        if width_m <= most_m
    }
    widths_m = {degree: width_m for degree, width_m in widths_m.items() if not degree or width_m >= least_m}
    if len(set(widths_m.values())) < 2:
        raise NotOffered("there is one width only")
    settings = _settings(widths_m, "{:.3g} m", "slice.width_m={:.6g}", lambda width_m: own_m / width_m)
    yield RefinementSeries("slice", "", settings, "own width / width")


def _duration(case: Case, points: int) -> Iterable[RefinementSeries]:
    """Yield the series of durations up to twice the case's own: what a run says depends on how long it is."""
    own_s, every_s = exact(case.duration_s), exact(case.output.interval_s)
    values_s = {
        degree: float(max(1, round(own_s * Fraction(2) ** degree / every_s)) * every_s)
        for degree in range(2 - points, 2)
    }
    settings = _settings(values_s, "{:g} s", "duration_s={!r}", lambda time_s: case.duration_s / time_s)
    yield RefinementSeries("duration", "", settings, "own duration / duration", is_choice=False)


NEEDS: dict[str, tuple[Callable[[Case], bool], str]] = {
    "panels": (lambda case: bool(case.screen.panels), "the case has no panels"),
    "frames": (lambda case: bool(case.screen.frames), "the case has no frames"),
    "particles": (has_particles, "the case has no particles"),
    "many": (
        lambda case: not case.bed.particles and not case.bed.is_carried,
        "single particles stand for themselves, and so do those of a run or a table",
    ),
    "uncarried": (lambda case: not case.bed.is_carried, "particles of a run or a table have their shapes"),
}
"""The conditions that parameters need, by name, and the message where a case does not meet the condition."""
PARAMETERS = {
    "sync": Parameter("sync interval", _sync, "numerics"),
    "scheme": Parameter("coupling scheme", _scheme, "numerics"),
    "panel-mesh": Parameter("panel mesh", _panel_mesh, "numerics", ("panels",)),
    "panel-model": Parameter("panel model", _panel_model, "model", ("panels",)),
    "panel-step": Parameter("panel's time step", _panel_step, "numerics", ("panels",)),
    "frames-model": Parameter("model of the frames", _frames_model, "model", ("frames",)),
    "particles-model": Parameter("solver of the particles", _particle_model, "model", ("particles",)),
    "particle-step": Parameter("particles' time step", _particle_step, "numerics", ("particles",)),
    "stiffness": Parameter("stiffness of contacts", _stiffness, "numerics", ("particles",)),
    "slice": Parameter("slice of the width", _width, "statistics", ("particles", "many")),
    "duration": Parameter("duration", _duration, "statistics"),
    "number": Parameter("number of particles", _number, "model", ("particles", "many")),
    "cut-off": Parameter("finest size fed", _cut_off, "model", ("particles",)),
    "shape": Parameter("spheres in a grain", _shape, "model", ("particles", "uncarried")),
}
