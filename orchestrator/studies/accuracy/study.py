"""The study: the case as it is, its refinement parameters one at a time, then what these propose together.

First the case as it is and a short part of it (``flipflow plan`` compares machines by that), then
each setting of each parameter.  From these follow the reference, the best that the budget allows, and
the diagonal: for each tolerance the settings that should meet it at the least cost.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import ceil, inf

from orchestrator.case import recordings
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.ports.clock import exact
from orchestrator.preflight.cost import particles_at_start, predicted_s
from orchestrator.preflight.judge import NUMERICS, JudgedCase
from orchestrator.studies.accuracy.combinations import (
    ALONE,
    BASE,
    CALIBRATION,
    EXACT,
    REFERENCE,
    TOGETHER,
    Asked,
    Combination,
    Error,
    Scatter,
    afford,
    answer_errors,
    errors,
    folder_name,
    part_s,
    scatter,
    shared_sets,
    worst_error,
)
from orchestrator.studies.accuracy.convergence import (
    Converged,
    Model,
    Option,
    Proposal,
    cost_ratio,
    measure_series,
)
from orchestrator.studies.accuracy.refinement import Offer, RefinementSeries, Setting, joint_sets, offer
from orchestrator.studies.criteria import Criterion, known_answers
from orchestrator.studies.points import Point, is_random, run_points, seed_sets
from orchestrator.studies.quantities import COMPARED, happens
from orchestrator.studies.record import drives, record

TOLERANCES = (0.2, 0.1, 0.05, 0.02, 0.01)
RECOMMENDED = (0.01, 0.05, 0.1)
RECORDING = "panels.h5"
SHORT = 5  # the short part is one of so many of the run


@dataclass(frozen=True)
class Compared:
    """A setting of an axis with its ``errors`` against the best of all settings; ``is_best`` marks the best
    itself."""

    series: RefinementSeries
    setting: Setting
    point: Combination
    errors: dict[str, Error]
    is_best: bool


@dataclass(frozen=True)
class Row:
    """A point with its errors against the reference by quantity.

    ``worst`` is the largest of the errors that decide; the other errors are against known answers.
    """

    point: Combination
    errors: dict[str, Error]
    worst: tuple[str, Error] | None
    answers: dict[str, float]
    proposal: Proposal | None

    @property
    def error(self) -> Error | None:
        """The largest error that decides."""
        return self.worst[1] if self.worst else None

    @property
    def why(self) -> str:
        """The reason why nothing was measured."""
        if self.point.metrics:
            return ""
        states = {run.status() for run in self.point.runs}
        return self.point.omitted or f"{', '.join(sorted(states))}: {self.point.runs[0].folder}"


@dataclass(frozen=True)
class Recommendation:
    """The cheapest row within a tolerance, None where there is none.

    ``proven`` means that the row is within the tolerance even at the upper end of its confidence interval.
    """

    tolerance: float
    row: Row | None
    proven: bool = False


@dataclass(frozen=True)
class AccuracyStudy:
    """A study of accuracy with the runs made so far.

    ``shared``: ``--set`` overlays of all points; ``known``: answers known from elsewhere; ``proposals``:
    predictions for points, by name; ``reference``: name of a point.
    """

    asked: Asked
    loaded: JudgedCase
    offer: Offer
    shared: tuple[str, ...]
    known: tuple[Criterion, ...]
    points: tuple[Combination, ...] = ()
    proposals: dict[str, Proposal] = field(default_factory=dict)
    reference: str = BASE

    def combine(self, kind: str, settings: dict[str, Setting]) -> Combination:
        """Return settings as a point of this study, checked, with the time that a run should take."""
        name, case = folder_name(kind, settings), self.loaded.case
        seeds = self.asked.seeds if is_random(case) and kind != CALIBRATION else 1
        runs = []
        try:
            for number in range(seeds):
                sets = (*self.shared, *joint_sets(settings), *seed_sets(case, number))
                runs.append(self.asked.study.point(name, sets, f"{name}-seed{number}" if number else name))
        except CaseError as error:
            return Combination(kind, name, settings, omitted=str(error.problems[0]))
        there = runs[0].loaded.case
        return Combination(kind, name, settings, tuple(runs), predicted_s(there, particles_at_start(there)))

    def run(self, points: Sequence[Combination]) -> Generator[str, None, AccuracyStudy]:
        """Run points that are not done, yield a line for each run, and return the study with them
        and their metrics.  Runs that have failed are results, too, and not run again."""
        todo = [run for one in points for run in one.runs if run.status() != "failed"]
        yield from run_points(todo, self.asked.study.crew)
        return self.with_points([one.with_metrics() for one in points])

    def with_points(self, points: Iterable[Combination]) -> AccuracyStudy:
        """Return the study with these points, which replace points of the same names or are added."""
        every = {one.name: one for one in (*self.points, *points)}
        return replace(self, points=tuple(every.values()))

    @cached_property
    def measured(self) -> dict[str, Combination]:
        """The points that have metrics, by name."""
        return {one.name: one for one in self.points if one.metrics}

    @property
    def base(self) -> Combination:
        """The case as it is."""
        return self.measured[BASE]

    @property
    def judged_by(self) -> list[str]:
        """The quantities that decide, as far as the case has them."""
        return [name for name in self.asked.judged_by if self.base.mean(name)]

    @cached_property
    def spread(self) -> Scatter:
        """The chance scatter of the points."""
        return scatter(self.measured.values(), is_random(self.loaded.case))

    @cached_property
    def converged(self) -> list[Converged]:
        """Every series that was measured."""
        every = (measure_series(one, self.measured, self.spread, self.known) for one in self.offer.series)
        return [one for one in every if one is not None]

    def best(self, axis: str) -> Converged | None:
        """Return the series on an axis that is nearest to the truth."""
        mine = [one for one in self.converged if one.series.axis == axis]
        return max(mine, key=lambda one: one.series.rank, default=None)

    def compared(self, axis: str, spread: Scatter | None = None) -> list[Compared]:
        """Return every setting of an axis that was measured, against the best of them; another
        ``spread`` says what counts as chance."""
        best = self.best(axis)
        if best is None:
            return []
        finest, reference, spread = best.settings[-1], best.points[-1], spread or self.spread
        return [
            Compared(one.series, setting, point, errors(point, reference, spread), setting is finest)
            for one in self.converged
            if one.series.axis == axis
            for setting, point in zip(one.settings, one.points, strict=True)
        ]

    def options(self, spread: Scatter | None = None) -> dict[str, list[Option]]:
        """Return the choices by axis; errors that chance explains count as none."""
        options: dict[str, list[Option]] = {}
        for axis in self.offer.titles:
            choices = {one.setting: one for one in self.compared(axis, spread) if one.series.is_choice}
            for setting, one in choices.items():
                certain = {name: error.value if error.certain else 0.0 for name, error in one.errors.items()}
                ratio = cost_ratio(one.point, self.base)
                options.setdefault(axis, []).append(Option(axis, setting, certain, ratio))
        return options

    @cached_property
    def remaining(self) -> dict[str, float]:
        """The sum of the errors where every axis has its best setting."""
        best = [one for axis in self.offer.titles if (one := self.best(axis)) is not None]
        return {name: sum(one.remaining(name) for one in best) for name in self.judged_by}

    def model(self, spread: Scatter | None = None) -> Model:
        """Return the model that predicts settings taken together."""
        return Model(self.options(spread), self.base.processor_by_part_s, self.remaining, self.judged_by)

    @cached_property
    def rows(self) -> list[Row]:
        """The points in the order in which they were run; the short part is not among them."""
        best, rows = self.measured[self.reference], []
        for one in self.points:
            if one.kind != CALIBRATION:
                off = errors(one, best, self.spread) if one.metrics and one is not best else {}
                answers = answer_errors(one, self.known) if one.metrics else {}
                proposal = self.proposals.get(one.name)
                rows.append(Row(one, off, worst_error(off, self.judged_by), answers, proposal))
        return rows

    @cached_property
    def by_cost(self) -> list[Row]:
        """The rows of points that were measured, from cheap to dear."""
        return sorted((r for r in self.rows if r.point.metrics), key=lambda row: row.point.processor_s)

    def front(self) -> list[Row]:
        """Return the rows that no other beats in both error and processor time, cheap ones first."""
        front: list[Row] = []
        least = inf
        for row in self.by_cost:
            if row.error is not None and row.error.value < least:
                front.append(row)
                least = row.error.value
        return front

    def recommend(self, tolerance: float) -> Recommendation:
        """Return the cheapest of all points that were measured.

        Where chance leaves none proven, return the point of which most is sure.  The reference is no
        candidate: nobody knows its error.
        """
        within = [(row, row.error) for row in self.by_cost if row.error and row.error.value <= tolerance]
        for row, error in within:
            if error.half_width is not None and error.at_most <= tolerance:
                return Recommendation(tolerance, row, True)
        surest = min(within, key=lambda pair: pair[1].at_most, default=None)
        return Recommendation(tolerance, surest[0] if surest else None)


def plan_study(asked: Asked) -> AccuracyStudy:
    """Return what is known before anything is run, with the points that need no other run: first the
    case as it is and its short part.  Raises CaseError."""
    loaded = asked.study.check()
    offered = offer(loaded.case, asked.parameters, asked.values)
    lengths_s = [one.h or 0.0 for series in offered.of("coupling") for one in series.settings]
    shared = shared_sets(loaded.case, max([loaded.case.coupling.sync_interval_s, *lengths_s]))
    # answers are of the case as it is described: they do not hold for another physics
    numerics = all(overlay.partition(".")[0] in NUMERICS for overlay in asked.study.sets)
    study = AccuracyStudy(asked, loaded, offered, shared, known_answers(asked.study.case) if numerics else ())
    base = study.combine(BASE, {})
    points = [base, study.combine(CALIBRATION, _short(base))]
    for series in offered.series:
        for setting in series.settings:
            if setting.sets and not setting.made_from_run:
                points.append(study.combine(ALONE, {series.axis: setting}))
    return replace(study, points=tuple(points))


def _short(base: Combination) -> dict[str, Setting]:
    """Return a whole number of samples."""
    case = base.runs[0].loaded.case
    sample_s = exact(case.output.series_s)
    short_s = float(ceil(exact(part_s(case, SHORT)) / sample_s) * sample_s)
    return {"duration": Setting(f"{short_s:g} s", (f"duration_s={short_s!r}",))}


def run_study(asked: Asked) -> Generator[str, None, AccuracyStudy]:
    """Run the missing points, yield a line for each run, and return the study.

    Raises CaseError, also where the case as it is gives nothing to compare with, and FolderUnusable.
    """
    study = plan_study(asked)
    study = yield from study.run(study.points[:2])
    runs = study.points[0].runs
    if BASE not in study.measured:
        run = next((run for run in runs if run.status() != "done"), runs[0])
        raise _unmeasured(
            run,
            f"the run of the case as it is is {run.status()}, so that there is nothing to compare with",
            f"{run.folder}.log says why",
        )
    if not happens({name: study.base.mean(name) for name in COMPARED}):
        raise _unmeasured(
            runs[0],
            "nothing happens in the case as it is: no panel, frame or particle moves by more than "
            "can be resolved (a nanometre), and no clamp's pull changes, so that there are no errors "
            "to compare",
            "let it last until something does",
        )
    points = afford([*study.points, *_made_points(study, runs[0])], asked.budget_s)
    study = yield from study.with_points(points).run(points[2:])
    proposed, there = _proposals(study), {one.name for one in study.points}
    new = {one.name: one for one, _ in proposed if one.name not in there}  # several may propose the same
    study = yield from study.run([*new.values()])
    reference = next((one.name for one, _ in proposed if one.name in study.measured), BASE)
    return replace(study, proposals={one.name: each for one, each in proposed}, reference=reference)


def _made_points(study: AccuracyStudy, run: Point) -> Iterator[Combination]:
    """Yield the points whose settings are made from the run of the case as it is."""
    for series in study.offer.series:
        for setting in series.settings:
            if not setting.made_from_run:
                continue
            try:
                if setting.made_from_run == "recording":
                    file = study.asked.study.folder / RECORDING
                    recordings.write(file, record(run.folder, None).file)
                    sets = [f"panel.recording={file.resolve()}"]
                else:
                    sets = drives(run.folder)
                made = replace(setting, sets=(*setting.sets, *sets))
                yield study.combine(ALONE, {series.axis: made})
            except CaseError as error:
                settings = {series.axis: setting}
                name, why = folder_name(ALONE, settings), str(error.problems[0])
                yield Combination(ALONE, name, settings, omitted=why)


def _unmeasured(run: Point, why: str, hint: str) -> CaseError:
    return CaseError([CaseProblem((), why, hint, str(run.folder))])


def _proposals(study: AccuracyStudy) -> list[tuple[Combination, Proposal]]:
    """Return the reference first, then the diagonal; existing points stand for themselves."""
    model, budget_s = study.model(), study.asked.budget_s
    # chance is no reason to take less than the best for what all are compared with
    wanted = [(REFERENCE, study.model(EXACT).best(budget_s, "finest"))]
    wanted += [(TOGETHER, model.cheapest(tolerance)) for tolerance in TOLERANCES]
    known = {one.sets: one for one in study.points if one.kind != CALIBRATION}
    proposed = []
    for kind, proposal in wanted:
        if proposal is None:
            continue
        sets = joint_sets(proposal.settings)
        if sets not in known:
            point = study.combine(kind, proposal.settings)
            known[sets] = replace(point, predicted_s=proposal.processor_s)
        proposed.append((known[sets], proposal))
    return proposed
