"""The study: the case as it is, its refinement parameters one at a time, then what these propose together.

First the case as it is and a short part of it (``flipflow plan`` compares machines by that), then
each setting of each parameter.  From these follow the reference, the best that the budget allows, and
the diagonal: for each tolerance the settings that should meet it at the least cost.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, replace
from math import ceil
from pathlib import Path

from orchestrator.case import recording_file
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.ports.clock import exact
from orchestrator.preflight.judge import NUMERICS, JudgedCase
from orchestrator.studies.accuracy.combinations import (
    ALONE,
    BASE,
    CALIBRATION,
    REFERENCE,
    TOGETHER,
    Asked,
    Combination,
    combination,
    common,
    named,
    part_s,
    scale,
)
from orchestrator.studies.accuracy.convergence import Converged, all_converged, options, remaining
from orchestrator.studies.accuracy.measured import EXACT, Measured, Scatter, read, scatter
from orchestrator.studies.accuracy.model import Model, Option, Proposal
from orchestrator.studies.accuracy.refinement import Offer, Setting, joint_sets, offer
from orchestrator.studies.criteria import known_answers
from orchestrator.studies.criterion import Criterion
from orchestrator.studies.metrics import QUANTITIES, happens
from orchestrator.studies.points import Point, check_case, is_random, run_points
from orchestrator.studies.record import drives, record

TOLERANCES = (0.2, 0.1, 0.05, 0.02, 0.01)
RECORDING = "panels.h5"
SHORT = 5  # the short part is one of so many of the run


@dataclass(frozen=True)
class Listed:
    """What is known before anything is run; ``shared``: ``--set`` overlays of all points."""

    asked: Asked
    loaded: JudgedCase
    offer: Offer
    shared: tuple[str, ...]
    points: list[Combination]
    known: tuple[Criterion, ...]

    @property
    def random(self) -> bool:
        return is_random(self.loaded.case)


@dataclass(frozen=True)
class Study:
    """All that was found.  ``reference``: name of a point; ``proposals``: what was predicted of
    points, by name."""

    listed: Listed
    points: list[Combination]
    measured: dict[str, Measured]
    spread: Scatter
    families: list[Converged]
    options: dict[str, list[Option]]
    remaining: dict[str, float]
    judged_by: list[str]
    proposals: dict[str, Proposal]
    reference: str

    @property
    def base(self) -> Measured:
        return self.measured[BASE]

    def model(self) -> Model:
        return Model(self.options, self.base.processor_by_part_s, self.remaining, self.judged_by)


def listed(asked: Asked) -> Listed:
    """Raises CaseError."""
    loaded = check_case(asked.case, asked.level, asked.sets)
    there = offer(loaded.case, asked.parameters, asked.values)
    lengths_s = [one.h or 0.0 for series in there.of("coupling") for one in series.settings]
    shared = common(loaded.case, max([loaded.case.coupling.sync_interval_s, *lengths_s]))
    base = combination(asked, loaded.case, shared, BASE, {})
    points = [base, combination(replace(asked, seeds=1), loaded.case, shared, CALIBRATION, _short(base))]
    for series in there.series:
        for setting in series.settings:
            if setting.sets and not setting.made_from_run:
                points.append(combination(asked, loaded.case, shared, ALONE, {series.axis: setting}))
    return Listed(asked, loaded, there, shared, points, _known(asked))


def _known(asked: Asked) -> tuple[Criterion, ...]:
    """Answers are of the case as it is described: they do not hold for another physics."""
    numerics = all(one.partition(".")[0] in NUMERICS for one in asked.sets)
    return known_answers(asked.case) if numerics else ()


def _short(base: Combination) -> dict[str, Setting]:
    """A whole number of samples."""
    case = base.runs[0].loaded.case
    sample_s = exact(case.output.series_s)
    short_s = float(ceil(exact(part_s(case, SHORT)) / sample_s) * sample_s)
    return {"duration": Setting(f"{short_s:g} s", (f"duration_s={short_s!r}",))}


def studied(asked: Asked) -> Generator[str, None, Study]:
    """Runs what is not done yet, yields a line for each run, and returns what was found.  Raises
    CaseError, also where the case as it is gives nothing to compare with, and FolderUnusable."""
    there = listed(asked)
    start = there.points[:2]
    yield from _run(start, asked)
    first = read(start)
    if BASE not in first:
        one = next((run for run in start[0].runs if run.status() != "done"), start[0].runs[0])
        raise _unmeasured(
            one,
            f"the run of the case as it is is {one.status()}, so that there is nothing to compare with",
            f"{one.folder}.log says why",
        )
    if not happens({name: first[BASE].mean(name) for name in QUANTITIES}):
        raise _unmeasured(
            start[0].runs[0],
            "nothing happens in the case as it is: no panel, frame or particle moves by more than "
            "can be resolved (a nanometre), and no clamp's pull changes, so that there are no errors "
            "to compare",
            "let it last until something does",
        )
    points = afford([*there.points, *_made_points(there, start[0].runs[0].folder)], asked, first)
    yield from _run(points[2:], asked)
    before = _evaluated(there, points, {}, BASE)
    proposed = _proposed(before)
    there_already = {one.name for one in points}
    new = list({one.name: one for one, _ in proposed if one.name not in there_already}.values())
    yield from _run(new, asked)
    reference = next((one.name for one, _ in proposed if one.done), BASE)
    proposals = {one.name: proposal for one, proposal in proposed}
    return _evaluated(there, [*points, *new], proposals, reference)


def _made_points(there: Listed, run: Path) -> list[Combination]:
    """Returns the points whose settings are made from the run of the case as it is."""
    points = []
    for series in there.offer.series:
        for setting in series.settings:
            if not setting.made_from_run:
                continue
            try:
                if setting.made_from_run == "recording":
                    file = there.asked.out / RECORDING
                    recording_file.write(file, record(run, None).file)
                    sets = [f"panel.recording={file.resolve()}"]
                else:
                    sets = list(drives(run))
                made = replace(setting, sets=(*setting.sets, *sets))
                point = combination(there.asked, there.loaded.case, there.shared, ALONE, {series.axis: made})
            except CaseError as error:
                name = named(ALONE, {series.axis: setting})
                point = Combination(ALONE, name, {series.axis: setting}, omitted=str(error.problems[0]))
            points.append(point)
    return points


def _unmeasured(run: Point, why: str, hint: str) -> CaseError:
    return CaseError([CaseProblem((), why, hint, str(run.folder))])


def _evaluated(
    there: Listed, points: list[Combination], proposals: dict[str, Proposal], reference: str
) -> Study:
    measured = read(points)
    spread = scatter([*measured.values()], there.random)
    families = all_converged(there.offer, measured, spread, there.known)
    judged_by = [name for name in there.asked.judged_by if measured[BASE].mean(name)]
    return Study(
        there,
        points,
        measured,
        spread,
        families,
        options(there.offer, families, measured[BASE], spread),
        remaining(there.offer, families, judged_by),
        judged_by,
        proposals,
        reference,
    )


def _proposed(before: Study) -> list[tuple[Combination, Proposal]]:
    """The reference first, then the diagonal; a point that is there already stands for itself."""
    asked, model = before.listed.asked, before.model()
    # chance is no reason to take less than the best for what all are compared with
    careful = options(before.listed.offer, before.families, before.base, EXACT)
    finest = replace(before, options=careful).model().best(asked.budget_s, "finest")
    wanted = [(REFERENCE, finest)]
    wanted += [(TOGETHER, model.cheapest(tolerance)) for tolerance in TOLERANCES]
    known = {one.sets: one for one in before.points if one.kind != CALIBRATION}
    found = []
    for kind, proposal in wanted:
        if proposal is None:
            continue
        sets = joint_sets(proposal.settings)
        if sets not in known:
            case, shared = before.listed.loaded.case, before.listed.shared
            known[sets] = combination(asked, case, shared, kind, proposal.settings)
            known[sets] = replace(known[sets], predicted_s=proposal.processor_s)
        found.append((known[sets], proposal))
    return found


def afford(points: Sequence[Combination], asked: Asked, measured: dict[str, Measured]) -> list[Combination]:
    """Those predicted to take more than the budget are left out, if they have not been run."""
    factor = scale(points, {name: one.processor_s for name, one in measured.items()})
    return [_affordable(one, factor * one.predicted_s, asked.budget_s) for one in points]


def _affordable(one: Combination, cost_s: float, budget_s: float) -> Combination:
    if one.ended or one.omitted or one.kind in (BASE, CALIBRATION) or cost_s <= budget_s:
        return replace(one, predicted_s=cost_s)
    why = f"predicted {cost_s:.0f} s of processor time, more than --budget {budget_s:g}"
    return replace(one, runs=(), predicted_s=cost_s, omitted=why)


def _run(points: Sequence[Combination], asked: Asked) -> Iterator[str]:
    """Runs that have failed are results, too, and not run again."""
    todo = [run for one in points for run in one.runs if run.status() != "failed"]
    yield from run_points(todo, asked.crew)
