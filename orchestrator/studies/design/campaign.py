"""The course of a study: the centre, the plan, the search, and the winner measured again."""

from __future__ import annotations

import statistics
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from orchestrator.studies.design import plans
from orchestrator.studies.design.data import Data
from orchestrator.studies.design.models import SURROGATES
from orchestrator.studies.design.optimisers import OPTIMISERS, predict_each, recommend
from orchestrator.studies.design.scales import SCALES, Scale
from orchestrator.studies.design.study_file import Study
from orchestrator.studies.design.surrogates import Fitted, TooFewPoints
from orchestrator.studies.design.trials import Evaluator, Journal, Outcome, Stage, Trial

Array = npt.NDArray[np.float64]
FOR_CONFIRMING = 0.2  # of the hours
NARROW = 0.02  # of a goal's range over all data: half an interval that is narrow enough
REPEATS = (2, 6)  # runs of each setting that is confirmed: at least, at most
FIRST_NEW_SEED, CONFIRMING = 1000, 2  # of runs that confirm; of the choice of what they confirm
FEWEST_EXPLAINED = 0.5  # of a goal's variance, by leave-one-out
NEAR_A_FAILURE = 0.1  # of the coded range: there nothing more is proposed


@dataclass
class Campaign:
    """A study under way: what is known, and what is to be run next."""

    study: Study
    evaluator: Evaluator
    journal: Journal
    outcomes: list[Outcome] = field(default_factory=list)
    _trials: list[Trial] = field(default_factory=list)

    def __post_init__(self) -> None:
        self._trials = self.journal.read()

    def run(self) -> Iterator[Outcome]:
        """Run all stages, and yield what came of each trial; those that were done before come at once."""
        for stage in (self._centre, self._plan, self._search, self._confirm):
            for outcome in self.evaluator.outcomes(stage()):
                self.outcomes.append(outcome)
                yield outcome

    @property
    def scales(self) -> dict[str, Scale]:
        """The scale of each response, in order."""
        return {name: SCALES[table.scale] for name, table in self.study.file.responses.items()}

    def data(self) -> Data:
        """Collect what the surrogates may see."""
        return Data.of(self.outcomes, self.scales)

    def fit(self, name: str = "") -> Fitted:
        """Fit a surrogate, by default the study's own, to all data.

        Raises
        ------
        TooFewPoints : there is less data than the surrogate has terms.
        """
        data = self.data()
        surrogate = SURROGATES[name or self.study.file.search.surrogate]()
        return surrogate.fit(data.x, data.y, data.variance, self.study.file.seed)

    def spent_s(self) -> float:
        """Compute the wall time of all runs so far, side by side as they are made."""
        return sum(outcome.wall_s for outcome in self.outcomes) / self.evaluator.side_by_side

    def _stage(self, stage: Stage, new: Callable[[int], Iterator[Trial]]) -> Iterator[Trial]:
        """Yield the stored trials of a stage, then new ones, which are stored first; ``new`` is given the number
        of those stored."""
        stored = [trial for trial in self._trials if trial.stage == stage]
        yield from stored
        for trial in new(len(stored)):
            self._trials.append(trial)
            self.journal.write(trial)
            yield trial

    def _next(self, stage: Stage, setting: Array, seed: int = 0, **more: object) -> Trial:
        return Trial(len(self._trials) + 1, stage, tuple(map(float, setting)), seed, **more)  # type: ignore[arg-type]

    def _centre(self) -> Iterator[Trial]:
        centre = self.study.space.ordered(np.zeros((1, self.study.space.factors)))[0]

        def new(stored: int) -> Iterator[Trial]:
            if not stored:
                yield self._next("centre", centre)

        return self._stage("centre", new)

    def _plan(self) -> Iterator[Trial]:
        """The plan's settings, and more runs of the centre with other seeds."""
        settings = planned_settings(self.study)
        repeats = self.study.file.plan.centres - 1
        wanted = [(setting, 0) for setting in settings]
        wanted += [(np.array(self._trials[0].setting), seed) for seed in range(1, repeats + 1)]

        def new(stored: int) -> Iterator[Trial]:
            for setting, seed in wanted[stored:]:
                if not self._can_afford(1.0 - FOR_CONFIRMING):
                    return
                yield self._next("plan", setting, seed)

        return self._stage("plan", new)

    def _search(self) -> Iterator[Trial]:
        most = self.study.file.search.runs

        def new(stored: int) -> Iterator[Trial]:
            while (most is None or stored < most) and self._can_afford(1.0 - FOR_CONFIRMING) and self.study.aim.goals:
                try:
                    fitted = self.fit()
                except TooFewPoints:
                    return
                yield self._proposed("search", self._propose(fitted), fitted)
                stored += 1
                if most is None and self.study.file.hours is None:
                    return

        return self._stage("search", new)

    def _propose(self, fitted: Fitted) -> Array:
        """Ask the optimiser, again where it comes near to a setting whose run failed."""
        done = np.array([trial.setting for trial in self._trials])
        failed = [each.trial.setting for each in self.outcomes if not each.is_data]
        optimiser = OPTIMISERS[self.study.file.search.optimiser]()
        for attempt in range(10):
            rng = np.random.default_rng([self.study.file.seed, len(self._trials), attempt])
            setting = optimiser.propose(fitted, self.study.aim, self.study.space, done, rng)
            if not failed or np.abs(np.array(failed) - setting).max(axis=1).min() > NEAR_A_FAILURE:
                break
        return setting

    def _proposed(self, stage: Stage, setting: Array, fitted: Fitted, seed: int = 0, role: str = "") -> Trial:
        mean, deviation = predict_each(fitted, setting[None])
        predicted = {
            name: (float(mean[i, 0]), float(deviation[i, 0])) for i, name in enumerate(self.study.file.responses)
        }
        return self._next(stage, setting, seed, role=role, predicted=predicted)

    def _confirm(self) -> Iterator[Trial]:
        """The recommended setting, the centre and the best simpler design, each with new seeds."""

        def new(stored: int) -> Iterator[Trial]:
            if not self.study.aim.goals or self.support():
                return
            settings = self.candidates()
            for repeat in range(REPEATS[1]):
                for role, setting in settings.items():
                    done = [t for t in self._trials if t.stage == "confirm" and t.role == role]
                    if len(done) > repeat:
                        continue
                    if not self._can_afford(1.0) or (repeat >= REPEATS[0] and self._is_narrow(settings)):
                        return
                    yield self._proposed("confirm", setting, self.fit(), FIRST_NEW_SEED + repeat, role)

        return self._stage("confirm", new)

    def candidates(self) -> dict[str, Array]:
        """Choose the settings that are measured again, by their roles; those chosen before stay."""
        chosen = {t.role: np.array(t.setting) for t in self._trials if t.stage == "confirm"}
        if "winner" not in chosen:
            fitted, done = self.fit(), np.array([trial.setting for trial in self._trials])
            rng = np.random.default_rng([self.study.file.seed, CONFIRMING])
            space, aim = self.study.space, self.study.aim
            chosen = {"winner": recommend(fitted, aim, space, done, rng), "centre": done[0]}
            if self.study.simpler:
                chosen["simpler"] = recommend(fitted, aim, self.study.simpler_space(), done, rng)
        return chosen

    def support(self) -> str:
        """Say why no optimum can be stated from the data; empty where one can.

        That is so where the surrogate explains less than half of a goal's variance (Q2 < 0.5), where no setting
        is expected to keep the limits, or where half of all runs failed.
        """
        file, data = self.study.file, self.data()
        failed = sum(not each.is_data for each in self.outcomes)
        if 2 * failed >= len(self.outcomes):
            return f"{failed} of {len(self.outcomes)} runs gave no data"
        try:
            fitted = self.fit()
        except TooFewPoints as error:
            return str(error)
        names = list(file.responses)
        for goal in self.study.aim.goals:
            if (q2 := explained(data.y[:, goal.response], fitted.left_out()[0][:, goal.response])) < FEWEST_EXPLAINED:
                return f"the surrogate explains {100 * max(q2, 0):.0f} % of the variance of {names[goal.response]}"
        mean, _ = predict_each(fitted, self.study.space.sample(2000, 1))
        if not self.study.aim.kept(mean).any() and not self.study.aim.kept(data.y.T).any():
            return "no setting is expected to keep all limits"
        return ""

    def _is_narrow(self, settings: Mapping[str, Array]) -> bool:
        """Whether the mean of each setting's runs is known well enough."""
        data = self.data()
        for goal in self.study.aim.goals:
            y = data.y[:, goal.response]
            span = float(np.nanmax(y) - np.nanmin(y))
            for setting in settings.values():
                same = np.isfinite(y) & (np.abs(data.x - setting).max(axis=1) < 1e-9)
                error = np.sqrt(data.variance[same, goal.response].sum()) / max(same.sum(), 1)
                if not same.any() or 1.96 * error > NARROW * span:
                    return False
        return True

    def _can_afford(self, share: float) -> bool:
        """Tell whether one more run ends within a share of the hours, if it takes as long as those before."""
        if self.study.file.hours is None:
            return True
        wall_s = [outcome.wall_s for outcome in self.outcomes if outcome.wall_s > 0]
        return self.spent_s() + (statistics.fmean(wall_s) if wall_s else 0.0) <= 3600 * share * self.study.file.hours


def explained(y: Array, left_out: Array) -> float:
    """Compute the share of a response's variance, (n,), that its leave-one-out predictions explain (Q2)."""
    known = np.isfinite(y) & np.isfinite(left_out)
    total = ((y[known] - y[known].mean()) ** 2).sum() if known.any() else 0.0
    return float(1.0 - ((y[known] - left_out[known]) ** 2).sum() / total) if total > 0 else 0.0


def planned_settings(study: Study) -> Array:
    """List the plan's settings, coded, (runs, factors), without the centre."""
    plan, space = study.file.plan, study.space
    runs = plan.runs or 4 * space.factors + 1
    if plan.kind == "none":
        return np.empty((0, space.factors))
    if plan.kind == "box-behnken":
        return plans.box_behnken(space.factors, centres=0)
    if plan.kind == "factorial":
        return plans.factorial(space, plan.levels)
    make = plans.sobol if plan.kind == "sobol" else plans.latin_hypercube
    return make(space, runs, study.file.seed)[plan.kind == "sobol" :]
