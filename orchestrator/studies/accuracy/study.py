"""The study of accuracy, and the order in which its points are run.

The unchanged case comes first, with a short part of it, by which ``flipflow plan`` compares machines.  Each
setting of each parameter follows alone.  These measurements propose joint settings, which are run at the end:
the reference, which is the best that the budget allows, and the diagonal, which has, for each tolerance, the
settings that should meet it at the least cost.
"""

from __future__ import annotations

from collections.abc import Generator, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from math import ceil, inf

from orchestrator.studies.accuracy.combinations import (
    ALONE,
    BASE,
    CALIBRATION,
    COMPARED,
    EXACT,
    REFERENCE,
    TOGETHER,
    Combination,
    Error,
    Scatter,
    StudyRequest,
    afford,
    answer_errors,
    errors,
    folder_name,
    happens,
    joint_sets,
    part_s,
    scatter,
    shared_sets,
    worst_error,
)
from orchestrator.studies.accuracy.convergence import (
    MeasuredSeries,
    Model,
    Option,
    Proposal,
    cost_ratio,
    measure_series,
)
from orchestrator.studies.accuracy.recommendation import recommend
from orchestrator.studies.criteria import Criterion, known_answers
from orchestrator.studies.points import Point, is_random, run_points, seed_sets
from orchestrator.workbench import Case, CaseError, CaseProblem, Offer, RefinementSeries, Run, Setting
from orchestrator.workbench.vocabulary import exact

TOLERANCES = (0.01, 0.02, 0.05, 0.1, 0.2)
RECOMMENDED = (0.01, 0.05, 0.1)
SHORT = 5  # the number of parts of the run, of which the short run has one


@dataclass(frozen=True)
class ComparedSetting:
    """A measured setting of an axis, compared with the best setting of the axis.

    ``errors`` are against the best setting; ``is_best`` says whether this setting is the best itself.
    """

    series: RefinementSeries
    setting: Setting
    point: Combination
    errors: dict[str, Error]
    is_best: bool


@dataclass(frozen=True)
class Row:
    """A point of the study with its errors.

    ``errors`` are against the reference, by quantity, and ``worst`` is the largest error that decides.
    ``answers`` are the errors against known answers.  ``proposal`` is the prediction for the point, if any.
    """

    point: Combination
    errors: dict[str, Error]
    worst: tuple[str, Error] | None
    answers: dict[str, float]
    proposal: Proposal | None

    @property
    def error(self) -> Error | None:
        """The largest error that decides, without the name of its quantity."""
        return self.worst[1] if self.worst else None

    @property
    def why(self) -> str:
        """The reason why nothing was measured; empty for a measured point."""
        if self.point.metrics:
            return ""
        states = {run.status() for run in self.point.runs}
        return self.point.omitted or f"{', '.join(sorted(states))}: {self.point.runs[0].folder}"


@dataclass(frozen=True)
class Recommendation:
    """A recommendation: the cheapest ``row`` within a tolerance, or None where there is none.

    ``is_proven`` means that the row is within the tolerance even at the upper end of its confidence interval.
    """

    tolerance: float
    row: Row | None
    is_proven: bool = False


@dataclass(frozen=True)
class AccuracyStudy:
    """A study of accuracy with the runs made so far.

    ``shared`` are the ``--set`` overlays of all points, and ``known`` the answers that are known from
    elsewhere.  ``proposals`` are the predictions for points, by name of the point.  ``reference`` is the name
    of the point that serves as reference.
    """

    request: StudyRequest
    loaded: Case
    offer: Offer
    shared: tuple[str, ...]
    known: tuple[Criterion, ...]
    points: tuple[Combination, ...] = ()
    proposals: dict[str, Proposal] = field(default_factory=dict)
    reference: str = BASE

    def combine(self, kind: str, settings: dict[str, Setting]) -> Combination:
        """Check joint settings, and return them as a point of this study with the predicted time of a run.

        Settings with which the case is wrong give a point without runs.  Raises CaseError where the unchanged
        case is wrong with one of the seeds.
        """
        name, case = folder_name(kind, settings), self.loaded
        seeds = self.request.seeds if is_random(case) and kind != CALIBRATION else 1
        runs = []
        try:
            for number in range(seeds):
                sets = (*self.shared, *joint_sets(settings), *seed_sets(case, number))
                run = self.request.study.point(name, sets, f"{name}-seed{number}" if number else name)
                runs.append(replace(run, ended=Run.is_over))
        except CaseError as error:
            if kind == BASE:
                raise
            return Combination(kind, name, settings, omitted=str(error.problems[0]))
        return Combination(kind, name, settings, tuple(runs), runs[0].loaded.predicted_s)

    def run(self, points: Sequence[Combination]) -> Generator[str, None, AccuracyStudy]:
        """Run the points that are not done, yield a line for each run, and return the study.

        The returned study has the points with their metrics.  Runs that failed for a reason that lies in
        their case are results, too, and are not made again.
        """
        yield from run_points([run for one in points for run in one.runs], self.request.study.crew)
        return self.with_points([one.with_metrics() for one in points])

    def with_points(self, points: Iterable[Combination]) -> AccuracyStudy:
        """Return the study with these points added; they replace points of the same names."""
        every = {one.name: one for one in (*self.points, *points)}
        return replace(self, points=tuple(every.values()))

    @cached_property
    def measured(self) -> dict[str, Combination]:
        """The points that have metrics, by name."""
        return {one.name: one for one in self.points if one.metrics}

    @property
    def base(self) -> Combination:
        """The measured point of the unchanged case."""
        return self.measured[BASE]

    @property
    def judged_by(self) -> list[str]:
        """The quantities that decide, as far as the case has them."""
        return [name for name in self.request.judged_by if self.base.mean(name)]

    def deciding(self, reference: Combination) -> list[str]:
        """Return the quantities that decide about errors against a reference, which has them, too."""
        return [name for name in self.judged_by if reference.mean(name)]

    @cached_property
    def spread(self) -> Scatter:
        """The chance scatter of the points, which is unknown for particles that were taken over."""
        case = self.loaded
        return scatter(
            self.measured.values(), is_random(case) or (case.tables.bed.is_carried and case.has_particles)
        )

    @property
    def would_tell(self) -> str:
        """What would tell how much is chance: other random numbers, or other particles to take over."""
        return "more --seeds" if is_random(self.loaded) else "runs with another bed"

    @cached_property
    def measured_series(self) -> list[MeasuredSeries]:
        """Every series with at least one measured setting."""
        every = (measure_series(one, self.measured, self.spread, self.known) for one in self.offer.series)
        return [one for one in every if one is not None]

    def best(self, axis: str, of_choices: bool = False) -> MeasuredSeries | None:
        """Return the measured series of an axis that is nearest to the truth; None where there is none.

        With ``of_choices``, only series whose settings may be recommended count.
        """
        mine = (one for one in self.measured_series if one.series.axis == axis)
        counted = [one for one in mine if one.series.is_choice or not of_choices]
        return max(counted, key=lambda one: one.series.rank, default=None)

    def compare_settings(
        self, axis: str, spread: Scatter | None = None, of_choices: bool = False
    ) -> list[ComparedSetting]:
        """Compare every measured setting of an axis with the best of them.

        ``spread`` is the scatter that counts as chance, by default the scatter of this study.  With
        ``of_choices``, the best is one that may be recommended.
        """
        best = self.best(axis, of_choices)
        if best is None:
            return []
        finest, reference, spread = best.settings[-1], best.points[-1], spread or self.spread
        return [
            ComparedSetting(one.series, setting, point, errors(point, reference, spread), setting is finest)
            for one in self.measured_series
            if one.series.axis == axis
            for setting, point in zip(one.settings, one.points, strict=True)
        ]

    def options(self, spread: Scatter | None = None) -> dict[str, list[Option]]:
        """Return the options of each axis; errors that chance explains count as zero.

        A setting of which a deciding error is unknown is no option.
        """
        options: dict[str, list[Option]] = {}
        for axis in self.offer.titles:
            every = self.compare_settings(axis, spread, of_choices=True)
            deciding = next((self.deciding(one.point) for one in every if one.is_best), [])
            choices = {
                one.setting: one
                for one in every
                if one.series.is_choice and one.errors.keys() >= set(deciding)
            }
            for setting, one in choices.items():
                certain = {
                    name: error.value if error.is_certain else 0.0 for name, error in one.errors.items()
                }
                ratio = cost_ratio(one.point, self.base)
                options.setdefault(axis, []).append(Option(axis, setting, certain, ratio))
        return options

    @cached_property
    def remaining_errors(self) -> dict[str, float]:
        """The sum of the errors that remain with the best setting of every axis, by quantity."""
        best = [one for axis in self.offer.titles if (one := self.best(axis, of_choices=True)) is not None]
        return {name: sum(one.remaining_error(name) for one in best) for name in COMPARED}

    def model(self, spread: Scatter | None = None) -> Model:
        """Return the model that predicts error, against the best settings, and cost of joint settings."""
        return Model(self.options(spread), self.base.processor_by_part_s, self.judged_by)

    @cached_property
    def reference_error(self) -> float | None:
        """The largest error by which the reference is estimated to be off itself.

        It is the error against the best settings and what remains in these.  None where it is unknown, since
        the parameters do not compare all settings of the reference.
        """
        options = self.model(EXACT).predict(self.measured[self.reference].settings)
        if options is None:
            return None
        every = (
            self.remaining_errors[name] + sum(one.error.get(name, 0.0) for one in options.options)
            for name in self.judged_by
        )
        return max(every, default=0.0)

    @cached_property
    def rows(self) -> list[Row]:
        """The rows of all points but the short run, in the order of the runs."""
        best, rows = self.measured[self.reference], []
        deciding = self.deciding(best)
        for one in self.points:
            if one.kind != CALIBRATION:
                differences = errors(one, best, self.spread) if one.metrics and one is not best else {}
                answers = answer_errors(one, self.known) if one.metrics else {}
                proposal = self.proposals.get(one.name)
                worst = worst_error(differences, deciding)
                rows.append(Row(one, differences, worst, answers, proposal))
        return rows

    @cached_property
    def by_cost(self) -> list[Row]:
        """The rows of measured points in ascending order of processor time."""
        return sorted((r for r in self.rows if r.point.metrics), key=lambda row: row.point.processor_s)

    def front(self) -> list[Row]:
        """Return the rows with a smaller error than all cheaper rows by more than chance, cheap rows first.

        The difference of two errors has the confidence interval of an error.  Where chance is unknown, there
        is no front.
        """
        front: list[Row] = []
        least = inf
        for row in self.by_cost:
            if row.error is None or row.error.half_width is None:
                continue
            if least - row.error.value > row.error.half_width:
                front.append(row)
                least = row.error.value
        return front

    def recommend(self, tolerance: float) -> Recommendation:
        """Recommend a measured point for a tolerance, against the reference.

        Settings that are no choice, such as a machine without its particles, are no candidates.
        """
        choices = {one.setting for every in self.options().values() for one in every}
        candidates = (
            (row, [row.errors[name] for name in self.judged_by if name in row.errors], row.point.processor_s)
            for row in self.by_cost
            if row.error and choices.issuperset(row.point.settings.values())
        )
        best = next(row for row in self.rows if row.point.name == self.reference)
        reference = best, self.reference_error, best.point.processor_s
        return Recommendation(tolerance, *recommend(candidates, reference, tolerance))


def plan_study(request: StudyRequest) -> AccuracyStudy:
    """Return the study before anything is run, with the points that need no other run.

    The first two points are the unchanged case and its short run.  Raises CaseError.
    """
    loaded = request.study.check()
    offered = loaded.refined(request.parameters, request.values)
    if request.keeps_model:
        kept = (replace(one, is_choice=one.is_choice and one.layer != "model") for one in offered.series)
        offered = replace(offered, series=tuple(kept))
    lengths_s = [one.h or 0.0 for series in offered.of("coupling") for one in series.settings]
    shared = shared_sets(loaded, max([loaded.tables.coupling.sync_interval_s, *lengths_s]))
    # the answers are for the described case: overlays that change its physics make them invalid
    numerics = all(map(Case.is_numeric, request.study.sets))
    study = AccuracyStudy(
        request, loaded, offered, shared, known_answers(request.study.case) if numerics else ()
    )
    base = study.combine(BASE, {})
    points = [base, study.combine(CALIBRATION, _short(base))]
    for series in offered.series:
        for setting in series.settings:
            if setting.sets and not setting.needs_drives:
                points.append(study.combine(ALONE, {series.axis: setting}))
    return study.with_points(points)


def _short(base: Combination) -> dict[str, Setting]:
    """Return the settings of the short run, which lasts a whole number of samples."""
    case = base.runs[0].loaded
    sample_s = exact(case.tables.output.series_s)
    short_s = float(ceil(exact(part_s(case, SHORT)) / sample_s) * sample_s)
    return {"duration": Setting(f"{short_s:g} s", (f"duration_s={short_s!r}",))}


def run_study(request: StudyRequest) -> Generator[str, None, AccuracyStudy]:
    """Run the missing points, yield a line for each run, and return the study.

    Raises FolderUnusable, and CaseError, also where the unchanged case gives nothing to compare with.
    """
    study = plan_study(request)
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
    if not study.judged_by:
        asked = ", ".join(request.judged_by)
        what = f"the run of the case as it is has none of the quantities that should decide: {asked}"
        raise _unmeasured(runs[0], what, "give others with --quantities")
    points = afford([*study.points, *_made_points(study, runs[0])], request.budget_s)
    study = yield from study.with_points(points).run(points[2:])
    proposed, existing = proposals(study), {one.name for one in study.points}
    new = {one.name: one for one, _ in proposed if one.name not in existing}  # proposals may coincide
    study = yield from study.run([*new.values()])
    predictions = {one.name: each for one, each in proposed}
    best = best_measured(study, [*predictions])
    if best is None:
        return replace(study, proposals=predictions)
    reference, prediction = best
    return replace(study, proposals=predictions | {reference: prediction}, reference=reference)


def best_measured(study: AccuracyStudy, proposed: Sequence[str]) -> tuple[str, Proposal] | None:
    """Return the name of the measured point with the least predicted error, with the prediction.

    Of points that are equally good, the first of those ``proposed`` is taken, and else the first one.  Return
    None where no point can be predicted: each has a setting that the chosen parameters do not compare.
    """
    model = study.model(EXACT)
    names = [name for name in dict.fromkeys((*proposed, *study.measured)) if name in study.measured]
    points = ((name, study.measured[name]) for name in names)
    known = {
        name: prediction
        for name, point in points
        if point.kind != CALIBRATION and (prediction := model.predict(point.settings)) is not None
    }
    return min(known.items(), key=lambda pair: pair[1].error, default=None)


def _made_points(study: AccuracyStudy, run: Point) -> Iterator[Combination]:
    """Yield the points whose settings are made from the run of the unchanged case."""
    for series in study.offer.series:
        for setting in series.settings:
            if not setting.needs_drives:
                continue
            try:
                complete = replace(setting, sets=(*setting.sets, *run.run.drives()))
                yield study.combine(ALONE, {series.axis: complete})
            except CaseError as error:
                settings = {series.axis: setting}
                why = str(error.problems[0])
                yield Combination(ALONE, folder_name(ALONE, settings), settings, omitted=why)


def _unmeasured(run: Point, why: str, hint: str) -> CaseError:
    return CaseError([CaseProblem((), why, hint, str(run.folder))])


def proposals(study: AccuracyStudy) -> list[tuple[Combination, Proposal]]:
    """Return the points of the reference and the diagonal, each within the budget, with their predictions.

    A point that exists already with the same settings is returned itself.
    """
    model, budget_s = study.model(), study.request.budget_s
    # the reference is the best point, even where chance explains its advantage
    wanted = [(REFERENCE, study.model(EXACT).best(budget_s, "finest"))]
    wanted += [(TOGETHER, model.cheapest(tolerance)) for tolerance in TOLERANCES]
    known = {one.sets: one for one in study.points if one.kind != CALIBRATION}
    proposed = []
    for kind, proposal in wanted:
        if proposal is None or proposal.processor_s > budget_s:
            continue
        sets = joint_sets(proposal.settings)
        if sets not in known:
            point = study.combine(kind, proposal.settings)
            known[sets] = replace(point, predicted_s=proposal.processor_s)
        proposed.append((known[sets], proposal))
    return proposed
