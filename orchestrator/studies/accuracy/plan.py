"""``flipflow plan``: which settings to take for a tolerance and a time, and what to give up where both
do not fit.

A run takes its start (importing, and part "rest" of its time: opening the solvers), and then the
same for each simulated second, but for what feeds add to the particles' share.  The study's short
run, made again here, tells the start here, and how much faster or slower this machine steps, with
whatever else it is busy with.
"""

from __future__ import annotations

import json
import math
import shlex
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from scipy.optimize import brentq

from orchestrator.case import solvers
from orchestrator.case.bed.sources import initial_particles, largest_diameter_m
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.file.slice import ENOUGH_DIAMETERS, full_width_m
from orchestrator.case.solver_plans import material_numbers
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.output.cycles import cycle_s
from orchestrator.output.records import trust
from orchestrator.ports.plans import SolverFailed
from orchestrator.preflight.cost import THICK, THIN, bed_cost, in_words
from orchestrator.preflight.judge import JudgedCase, load_judged
from orchestrator.preflight.scene.effect import TENTH, Verdict
from orchestrator.studies.accuracy.combinations import BASE, part_s
from orchestrator.studies.accuracy.convergence import Model, Option, Proposal
from orchestrator.studies.accuracy.refinement import Setting, joint_label, joint_sets
from orchestrator.studies.points import CaseStudy, RunFailed, run_in_scratch
from orchestrator.studies.quantities import DECISIVE, happens

NAME = "accuracy.json"


@dataclass(frozen=True)
class Candidate:
    """Settings, their error, and the processor time of a run as long as the study's, on its
    machine; ``measured`` or predicted."""

    label: str
    sets: tuple[str, ...]
    error: float
    processor_s: float
    measured: bool


@dataclass(frozen=True)
class StoredStudy:
    """A study of accuracy, as ``report.as_json`` wrote it into a file."""

    file: Path
    table: dict[str, Any]

    @cached_property
    def model(self) -> Model:
        """The model that predicts settings taken together."""
        table, axes = self.table, {}
        for axis, every in table["options"].items():
            settings = (Setting(one["label"], tuple(one["sets"])) for one in every)
            pairs = zip(every, settings, strict=True)
            axes[axis] = [Option(axis, setting, one["error"], one["ratio"]) for one, setting in pairs]
        return Model(axes, table["base"]["processor_by_part_s"], table["remaining"], table["judged_by"])

    @property
    def of_nothing(self) -> bool:
        """Whether nothing happened in the study: errors of unresolvable quantities promise nothing."""
        base = [one for one in self.table["points"] if one.get("point") == BASE]
        return bool(base) and not any(happens(one) for one in base)

    def measured(self) -> list[Candidate]:
        """Return the points with their errors at the upper end of their confidence intervals."""
        return [
            Candidate(
                one["settings"],
                tuple(shlex.split(one["sets"])),
                one["error"] + (one["error_half_width"] or 0.0),
                one["processor_s"],
                True,
            )
            for one in self.table["points"]
            if one["error"] is not None
        ]

    def cheapest(self, tolerance: float) -> Candidate | None:
        """Return the cheapest candidate within a tolerance: a measured candidate, or a predicted one where no
        measured candidate is so cheap."""
        within = [each for each in self.measured() if each.error <= tolerance]
        within += self._predicted(self.model.cheapest(tolerance - self._chance))
        return min(within, key=lambda each: each.processor_s, default=None)

    def best(self, budget_s: float) -> Candidate | None:
        """Return the candidate of the least error for so much processor time."""
        within = [each for each in self.measured() if each.processor_s <= budget_s]
        within += self._predicted(self.model.best(budget_s, "cheapest"))
        return min(within, key=lambda each: each.error, default=None)

    @property
    def _chance(self) -> float:
        """The uncertainty of a prediction even where all errors add up."""
        return float(self.table["chance"] or 0.0)

    def _predicted(self, proposal: Proposal | None) -> list[Candidate]:
        if proposal is None:
            return []
        label, error = joint_label(proposal.settings) or "the case as it is", proposal.error + self._chance
        return [Candidate(label, joint_sets(proposal.settings), error, proposal.processor_s, False)]


def measured_verdict(effect: str, verdict: Verdict, study: StoredStudy) -> Verdict:
    """Return the verdict on an effect with the error and cost of the model that leaves it out.

    Without a run of such a model the verdict stays as it was.
    """
    model = _model_without(effect, study.table.get("models", []))
    decisive = {name: model["error"][name] for name in DECISIVE if name in model["error"]} if model else {}
    if model is None or not decisive:
        return verdict
    told = ", ".join(f"{name} {100 * value:.2g} %" for name, value in decisive.items())
    return replace(
        verdict,
        number=f"largest error of {model['label']}",
        value=max(decisive.values()),
        threshold=f"0.1 (measured against {model['reference']})",
        matters=max(decisive.values()) > TENTH,
        why=f"measured: {told}",
        cost=f"{model['reference_processor_s']:.3g} s instead of {model['processor_s']:.3g} s of processor",
    )


def _model_without(effect: str, models: Sequence[dict[str, Any]]) -> dict[str, Any] | None:
    """Return the measured model that leaves an effect out: the case's own model, else the finest.

    For softened contacts it is the case itself, for single particles the coarser particles.
    """
    wanted = {"contact-stiffness": ("stiffness", ""), "single-particles": ("number", "")}
    ports: tuple[solvers.Port, ...] = ("panel", "frames")
    for port in ports:
        if name := solvers.without(port, effect):
            wanted[effect] = (port, name)
    if effect not in wanted:
        return None
    fitting = [
        m for m in models if (m["axis"], m["variant"]) == wanted[effect] and m["label"] != m["reference"]
    ]
    return next((model for model in fitting if not model["sets"]), fitting[-1] if fitting else None)


def find_study(loaded: JudgedCase, given: Path | None) -> StoredStudy | None:
    """Return the study in the given file, beside the case, or in its usual folder, if it belongs to this case
    and level; None where there is none.  Raises CaseError for a file that holds no study."""

    def problem(file: Path, what: str) -> CaseError:
        return CaseError([CaseProblem((), what, file=str(file))])

    if given and not given.is_file():
        raise problem(given, "no such file")
    usual = (loaded.folder / NAME, Path("runs") / f"{loaded.name}-accuracy" / NAME)
    for file in (given,) if given else filter(Path.is_file, usual):
        try:
            table = json.loads(file.read_text(encoding="utf-8"))
            case, level = table["case"], table["level"]
        except (ValueError, KeyError, TypeError):
            raise problem(file, "is no study of accuracy") from None
        if (case, level) == (loaded.name, loaded.level):
            return StoredStudy(file, table)
        if given:
            raise problem(file, f'is of case "{case}", level "{level}"')
    return None


def filling(case: Case, study_s: float) -> Callable[[float], float]:
    """Return a function that gives the mean number of particles of a run of so many seconds, relative to runs
    of ``study_s``."""
    if not case.bed.feeds:
        return lambda duration_s: 1.0
    bed = THIN if case.particles.adhesion == "none" else THICK
    at_start = len(initial_particles(case, material_numbers(case)).diameter_m)

    def mean(duration_s: float) -> float:
        return bed_cost(case.model_copy(update={"duration_s": duration_s}), at_start, bed).mean

    of_study = mean(study_s)
    return lambda duration_s: mean(duration_s) / of_study if of_study else 1.0


START = ("start", "rest")
PART = 8  # of a run that has no study: of so many parts, one is made


@dataclass(frozen=True)
class Timing:
    """The time that runs take on this machine.

    The study took ``study_start_s`` of processor time to start and simulated ``simulated_s``.  A start takes
    ``start_s`` of wall time here, and a second of the study's processor time in stepping ``factor``;
    ``particles`` is their share of its stepping, ``filling`` their number in runs of other lengths.
    """

    study_start_s: float
    simulated_s: float
    start_s: float
    factor: float
    particles: float = 0.0
    filling: Callable[[float], float] = lambda duration_s: 1.0

    def wall_s(self, processor_s: float, duration_s: float) -> float:
        """Return the wall time here of a run of ``duration_s`` with settings that took
        ``processor_s`` in the study."""
        study_s = max(processor_s - self.study_start_s, 0.0)
        return self.start_s + self.factor * study_s * self._lasts(duration_s)

    def duration_s(self, processor_s: float, wall_s: float, longest_s: float) -> float:
        """Return the longest duration of a run, at most ``longest_s``, that takes so much wall time.

        It is 0 if not even the start fits.
        """
        if self.wall_s(processor_s, longest_s) <= wall_s:
            return longest_s
        if wall_s <= self.start_s:
            return 0.0
        return float(brentq(lambda t: self.wall_s(processor_s, t) - wall_s, 0.0, longest_s))

    def affordable_s(self, wall_s: float, duration_s: float) -> float:
        """Return the study's processor time of settings that take so much wall time here."""
        stepping_s = max(wall_s - self.start_s, 0.0) / self.factor
        return self.study_start_s + stepping_s / self._lasts(duration_s)

    def _lasts(self, duration_s: float) -> float:
        """Return the stepping of a run of ``duration_s``, relative to the study's."""
        more = 1.0 + self.particles * (self.filling(duration_s) - 1.0)
        return more * duration_s / self.simulated_s


def time_run(case: Path, level: str | None, sets: Sequence[str]) -> dict[str, Any]:
    """Return the summary of a run that nobody keeps.

    Only its times count, so the run may be doubtful.  Raises CaseError, and SolverFailed if the run does not
    come to its end.
    """
    try:
        summary = run_in_scratch(case, CaseStudy(case, level, tuple(sets)).check().level, sets)
    except RunFailed as why:
        raise SolverFailed(f"the calibration run {why}") from None
    if not trust.came_to_its_end(str(summary["status"])):
        raise SolverFailed(f"the calibration run failed: {summary.get('reason', '')}")
    return summary


def time_by_study(study: StoredStudy, case: Path, level: str | None) -> Timing:
    """Return the time that runs take on this machine, from the study's short run, made again here."""
    base = study.table["base"]
    (short,) = study.table["short"].values()
    here = time_run(case, level, [*study.table["sets"], *study.table["shared"], *short["sets"]])
    wall_s = here["wall_by_part_s"]
    simulated_s, in_parts_s = base["simulated_s"], base["processor_by_part_s"]
    return Timing(
        _start_s(in_parts_s),
        simulated_s,
        _start_s(wall_s),
        _stepping_s(wall_s) / _stepping_s(short["processor_by_part_s"]),
        in_parts_s.get("particles", 0.0) / _stepping_s(in_parts_s),
        filling(load_judged(case, level, study.table["sets"]).case, simulated_s),
    )


def predict_wall_s(path: Path, level: str | None, sets: Sequence[str], case: Case) -> float:
    """Return the wall time here of a case without a study, from a short run."""
    duration_s = part_s(case, PART)
    short = [*sets, f"duration_s={duration_s!r}", "output.pictures=false"]
    wall_s = time_run(path, level, short)["wall_by_part_s"]
    return _start_s(wall_s) + case.duration_s / duration_s * _stepping_s(wall_s)


def _start_s(time_s: Mapping[str, float]) -> float:
    return sum(time_s.get(part, 0.0) for part in START)


def _stepping_s(time_s: Mapping[str, float]) -> float:
    return sum(part_s for part, part_s in time_s.items() if part not in START)


SHARED = ("particles", "panel")  # parts that ranks divide among them
MOST_RANKS = 1024


@dataclass(frozen=True)
class Plan:
    """The choice for a case by its study, a tolerance and a wall time."""

    case: Case
    study: StoredStudy
    timing: Timing
    tolerance: float
    budget_s: float

    @cached_property
    def chosen(self) -> Candidate | None:
        """The cheapest settings within the tolerance, whether or not they fit the budget."""
        return self.study.cheapest(self.tolerance)

    @property
    def wall_s(self) -> float:
        """The wall time that the chosen settings take here."""
        return math.inf if self.chosen is None else self._wall_s(self.chosen)

    @property
    def fits(self) -> bool:
        """Whether the wall time is within the budget."""
        return self.wall_s <= self.budget_s

    def _wall_s(self, candidate: Candidate) -> float:
        return self.timing.wall_s(candidate.processor_s, self.case.duration_s)

    def remedies(self) -> Iterator[str]:
        """Yield changes that would make the plan fit, in words."""
        if self.chosen is not None:
            yield from self._shorter(self.chosen)
        coarser = self.study.best(self.timing.affordable_s(self.budget_s, self.case.duration_s))
        if coarser is not None:
            sets = " ".join(f"--set {each}" for each in coarser.sets) or "the case as it is"
            takes = in_words(self._wall_s(coarser))
            yield f"coarser: {sets} is off by {100 * coarser.error:.2g} % and takes {takes}"
        if self.chosen is not None:
            yield from self._more_ranks_or_narrower()

    def _shorter(self, candidate: Candidate) -> Iterator[str]:
        longest_s, cycle = self.case.duration_s, cycle_s(self.case)
        duration_s = self.timing.duration_s(candidate.processor_s, self.budget_s, longest_s)
        if cycle < longest_s:
            cycles, every = math.floor(duration_s / cycle), round(longest_s / cycle)
            if cycles:
                yield f"fewer cycles: {cycles} of {every} (duration_s={cycles * cycle:.4g})"
        elif duration_s > 0:
            yield f"a shorter run: duration_s={duration_s:.3g}"

    def _more_ranks_or_narrower(self) -> Iterator[str]:
        """Yield more ranks, and a slice where particles and panels take most of the time."""
        case, parts_s = self.case, self.study.table["base"]["processor_by_part_s"]
        share = sum(parts_s.get(name, 0.0) for name in SHARED) / sum(parts_s.values())
        shared_s, left_s = share * self.wall_s, self.budget_s - (1 - share) * self.wall_s
        ranks = math.ceil(shared_s / left_s) if left_s > 0 else math.inf
        if ranks <= MOST_RANKS:
            yield f"more ranks: mpirun -n {max(2, ranks)}, if they share their work perfectly"
        else:
            yield "more ranks would not do: what they do not share takes too long"
        if not has_particles(case) or case.bed.particles or left_s <= 0:
            return
        try:
            low, high = full_width_m(case.whole)
        except CaseError:
            return
        now_m = case.slice.width_m if case.slice else high - low
        width_m = now_m * left_s / shared_s
        if width_m >= ENOUGH_DIAMETERS * largest_diameter_m(case):
            yield f"a slice: slice.width_m={width_m:.3g} instead of {now_m:.3g} m"
