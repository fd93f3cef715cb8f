"""The course of a study: the centre, the plan, the search, and the best settings measured again."""

from __future__ import annotations

import itertools
import math
import statistics
import time
from collections.abc import Callable, Generator, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial

import numpy as np

from orchestrator.studies.design import plans
from orchestrator.studies.design.aim import Aim
from orchestrator.studies.design.data import Data
from orchestrator.studies.design.models import SURROGATES
from orchestrator.studies.design.optimisers import OPTIMISERS, ExpectedImprovement, predict_each
from orchestrator.studies.design.scales import SCALES, Scale
from orchestrator.studies.design.space import Space, SpaceWithout
from orchestrator.studies.design.study_file import Study
from orchestrator.studies.design.surrogates import Fitted, Surrogate, TooFewPoints, calibrated
from orchestrator.studies.design.trials import Evaluator, Journal, Outcome, Prediction, Stage, Trial
from orchestrator.studies.design.two_levels import TwoLevels
from orchestrator.workbench import FolderUnusable
from orchestrator.workbench.vocabulary import NORMAL_95, Array

FOR_CONFIRMING = 0.2  # of the hours
NARROW = 0.02  # of a goal's range over all data: half an interval that is narrow enough
REPEATS = (2, 6)  # runs of each setting that is confirmed: at least, at most
FIRST_NEW_SEED = 1000  # of runs that confirm; equal for all settings, so that they are compared in pairs
CONFIRMING = 2  # stream of random numbers that choose what is confirmed
FEWEST_EXPLAINED = 0.5  # of a goal's variance, by leave-one-out
NEAR_A_FAILURE = 0.1  # coded, a twentieth of the range: there nothing more is proposed
SAME = 1e-6  # coded: settings no farther apart are one
NEEDS_ALL = "every setting is needed for the fit: none can be left out to judge it"
BEST, CENTRE, SIMPLER = "best", "centre", "simpler"


@dataclass
class Campaign:
    """A study under way: its results so far, and its next trial.

    ``stored`` is the number of trials that were stored when it was called.
    """

    study: Study
    evaluator: Evaluator
    journal: Journal
    outcomes: list[Outcome] = field(default_factory=list)
    _trials: list[Trial] = field(default_factory=list)
    _fits: dict[tuple[str, bool, int], Fitted] = field(default_factory=dict)
    stored: int = 0
    _began_s: float = field(default_factory=time.monotonic)

    def read_trials(self) -> list[Trial]:
        """Read the stored trials; those that were made with other ranges are coded for the present ones.

        Predictions of another result, or on another scale, than a response has now are left out.  Raises
        FolderUnusable where the trials are of other factors.
        """
        self._trials = [self._comparable(self._coded(trial)) for trial in self.journal.read()]
        self._began_s = time.monotonic()
        return self._trials

    def _comparable(self, trial: Trial) -> Trial:
        """Leave out the predictions of a trial that cannot be compared with the responses as they are now."""
        predicted = {
            name: told
            for name, told in trial.predicted.items()
            if name in self.study.file.responses and (told.scale, told.result) == self._meaning(name)
        }
        return replace(trial, predicted=predicted)

    def _meaning(self, name: str) -> tuple[str, str]:
        response = self.study.file.responses[name]
        return response.scale, response.result or name

    def _coded(self, trial: Trial) -> Trial:
        names = list(self.study.file.factors)
        if sorted(trial.values) != sorted(names):
            raise FolderUnusable(
                f"{self.journal.folder}: holds runs of other factors ({', '.join(trial.values)}, not "
                f"{', '.join(names)}); give another folder with --out"
            )
        values = {name: trial.values[name] for name in names}
        if self.study.actual(np.array(trial.setting)) == values:
            return replace(trial, values=values)
        setting = self.study.space.coded(np.array(list(values.values())))
        return replace(trial, setting=tuple(map(float, setting)), values=values)

    def store_planned(self) -> list[Trial]:
        """Store the trials of the centre, the cheap level and the plan, and return them with those that were
        stored before; nothing is run.

        Raises FolderUnusable where the stored trials are of other factors.
        """
        self.read_trials()
        return [
            each for stage in self._settings for each in self._stage(stage, partial(self._planned, stage))
        ]

    def run(self, search: bool = True) -> Generator[Outcome, None, None]:
        """Run the centre and the plan, then search and confirm, and yield the outcome of each trial.

        Outcomes of trials that were done before come at once.  Raises FolderUnusable where the stored trials
        are of other factors.
        """
        self.read_trials()
        self.stored = len(self._trials)
        stages: dict[Stage, Callable[[], Iterator[Trial]]]
        stages = {stage: partial(self._planned, stage) for stage in self._settings}
        if search:
            stages |= {"search": self._search, "confirm": self._confirm}
        for stage, new in stages.items():
            for outcome in self.evaluator.outcomes(self._stage(stage, new)):
                self.outcomes.append(outcome)
                yield outcome

    def trials_left(self, search: bool) -> int:
        """Count the trials still to come without a limit of hours; with ``search`` the search and the least
        number of confirming runs are among them."""
        left = self.planned_left
        if search and self.study.aim.goals:
            settings = 1 + len(self.study.aims) * (2 if self.study.simpler else 1)
            ended = len(self.outcomes) - self._ended_of_plan
            left += max(0, self.most_searched + REPEATS[0] * settings - ended)
        return left

    @property
    def planned_left(self) -> int:
        """The number of planned trials that have not ended."""
        begun = sum(trial.stage in self._settings for trial in self._trials)
        to_come = sum(len(self._not_made(stage)) for stage in self._settings)
        return begun - self._ended_of_plan + to_come

    @property
    def _ended_of_plan(self) -> int:
        return sum(each.trial.stage in self._settings for each in self.outcomes)

    @property
    def planned(self) -> int:
        """The number of trials of the centre, the cheap level and the plan."""
        return sum(map(len, self._settings.values()))

    def beyond_hours(self, each_s: float) -> int:
        """Count the planned trials to come that do not fit into the hours if each takes ``each_s``."""
        if self.study.file.hours is None or not each_s:
            return 0
        first, *others = (len(self._not_made(stage)) for stage in self._settings)
        room_s = 3600.0 * self.hours_before_confirming - self.spent_s() - (1 + first) * each_s
        fit = math.floor(room_s * self.evaluator.side_by_side / each_s) + 1
        return max(0, sum(others) - max(0, fit))

    @property
    def hours_before_confirming(self) -> float:
        """The hours for all runs but those that confirm, which there are only with a goal."""
        share = 1.0 - FOR_CONFIRMING if self.study.aim.goals else 1.0
        return math.inf if self.study.file.hours is None else share * self.study.file.hours

    @property
    def most_searched(self) -> int:
        """The largest number of trials of the search, apart from the hours."""
        file = self.study.file
        if file.search.runs is not None:
            return file.search.runs
        return 10**6 if file.hours else len(planned_settings(self.study))

    @cached_property
    def scales(self) -> dict[str, Scale]:
        """The scale of each response, in order."""
        return {name: SCALES[table.scale] for name, table in self.study.file.responses.items()}

    def data(self, confirmed: bool = True) -> Data:
        """Collect the data for surrogates, with or without the runs that confirm."""
        left_out = ("cheap",) if confirmed else ("cheap", "confirm")
        return Data.of([each for each in self.outcomes if each.trial.stage not in left_out], self.scales)

    def fit(self, name: str = "", confirmed: bool = True) -> Fitted:
        """Fit a surrogate, by default the study's own, to the data.

        Raises TooFewPoints where there are less data than the surrogate has terms.
        """
        name = name or self.study.file.search.surrogate
        used = sum(confirmed or outcome.trial.stage != "confirm" for outcome in self.outcomes)
        key = (name, confirmed, used)
        if key not in self._fits:
            self._fits[key] = self._fit(SURROGATES[name](), self.data(confirmed))
        return self._fits[key]

    def _fit(self, surrogate: Surrogate, data: Data) -> Fitted:
        """Fit a surrogate to data, on top of the cheap level where the study has one."""
        seed = self.study.file.seed
        if self.study.file.cheap is not None:
            below = Data.of([each for each in self.outcomes if each.trial.stage == "cheap"], self.scales)
            if not len(below.x):
                raise TooFewPoints("no run at the cheap level gave data")
            cheap = surrogate.fit(below.x, below.y, below.variance, seed)
            surrogate = TwoLevels(cheap, surrogate)
        return surrogate.fit(data.x, data.y, data.variance, seed)

    def best_so_far(self) -> str:
        """Return the best first goal among the runs that keep all limits of the first aim, with the run;
        empty where there is none."""
        aim, data = self.study.aim, self.data()
        if not aim.goals or not len(data.x):
            return ""
        goal, name = aim.goals[0], list(self.study.file.responses)[aim.goals[0].response]
        gain = np.where(aim.kept(data.y.T), goal.sign * data.y[:, goal.response], np.nan)
        if not np.isfinite(gain).any():
            return ""
        best = int(np.nanargmax(gain))
        value = float(self.scales[name].from_fit(data.y[best, goal.response]))
        return f"{name} {value:.4g} (run {data.numbers[best]:04d})"

    def mean_wall_s(self) -> float:
        """Compute the mean wall time of a run so far, without runs at the cheap level."""
        dear = [outcome for outcome in self.outcomes if outcome.trial.stage != "cheap"]
        wall_s = [outcome.wall_s for outcome in dear if outcome.wall_s > 0]
        return statistics.fmean(wall_s) if wall_s else 0.0

    def spent_s(self) -> float:
        """Compute the time that the study took so far.

        It is that of all runs, shared by those that run side by side; or, if that is more because workers
        had nothing to do, the time since the study was called plus that of the runs before.
        """
        running = len(self._trials) - len(self.outcomes)
        sum_s = sum(outcome.wall_s for outcome in self.outcomes) + max(running, 0) * self.mean_wall_s()
        before_s = sum(each.wall_s for each in self.outcomes if each.trial.number <= self.stored)
        elapsed_s = time.monotonic() - self._began_s
        return max(sum_s / self.evaluator.side_by_side, before_s / self.evaluator.side_by_side + elapsed_s)

    def _can_afford(self, hours: float | None) -> bool:
        """Tell whether one more run would end within some hours."""
        return hours is None or self.spent_s() + self.mean_wall_s() <= 3600.0 * hours

    def _stage(self, stage: Stage, new: Callable[[], Iterator[Trial]]) -> Iterator[Trial]:
        """Yield the stored trials of a stage, then new ones, each stored before it is yielded."""
        yield from [trial for trial in self._trials if trial.stage == stage]
        for trial in new():
            self._trials.append(trial)
            self.journal.write(trial)
            yield trial

    def _trial(
        self,
        stage: Stage,
        setting: Array,
        fitted: Fitted | None = None,
        seed: int | None = None,
        role: str = "",
    ) -> Trial:
        """Make the next trial, with the prediction of a surrogate for it.

        Unless it is given, the seed differs from trial to trial: equal seeds would make errors common to all
        runs, and a surrogate could not see them.
        """
        number, predicted = len(self._trials) + 1, {}
        if fitted is not None:
            mean, deviation = predict_each(fitted, setting[None])
            for i, name in enumerate(self.study.file.responses):
                predicted[name] = Prediction(float(mean[i, 0]), float(deviation[i, 0]), *self._meaning(name))
        seed = number - 1 if seed is None else seed
        values = self.study.actual(setting)
        return Trial(number, stage, tuple(map(float, setting)), seed, role, predicted, values)

    @cached_property
    def _centre(self) -> Array:
        """The middle of the space, coded, (factors,)."""
        space = self.study.space
        return np.asarray(space.ordered(np.zeros((1, space.factors)))[0])

    @cached_property
    def _settings(self) -> dict[Stage, list[Array]]:
        """The settings of each stage that is known beforehand; a plan ends with more runs of the centre."""
        cheap, plan, space = self.study.file.cheap, self.study.file.plan, self.study.space
        below = [] if cheap is None else [*space.sample(cheap.runs, self.study.file.seed + 1)]
        repeats = [self._centre] * (plan.centres - 1)
        return {"centre": [self._centre], "cheap": below, "plan": [*planned_settings(self.study), *repeats]}

    def _not_made(self, stage: Stage) -> list[Array]:
        """Return the settings of a stage that no stored trial has: the study may have had another plan."""
        made = [np.array(trial.setting) for trial in self._trials if trial.stage == stage]
        missing = []
        for setting in self._settings[stage]:
            same = [number for number, each in enumerate(made) if np.abs(each - setting).max() <= SAME]
            if same:
                del made[same[0]]
            else:
                missing.append(setting)
        return missing

    def _planned(self, stage: Stage) -> Iterator[Trial]:
        """Yield trials of the settings that are not made yet, as far as the hours go."""
        for setting in self._not_made(stage):
            if stage != "centre" and not self._can_afford(self.hours_before_confirming):
                return
            yield self._trial(stage, setting)

    def _search(self) -> Iterator[Trial]:
        """Yield one proposal of the optimiser after the other; several aims take turns."""
        stored = sum(trial.stage == "search" for trial in self._trials)
        for _ in range(stored, self.most_searched if self.study.aim.goals else 0):
            if not self._can_afford(self.hours_before_confirming):
                return
            try:
                fitted = self.fit()
            except TooFewPoints:
                return
            yield self._trial("search", self._propose(fitted), fitted)

    def _propose(self, fitted: Fitted) -> Array:
        """Ask the optimiser for a setting away from those whose runs failed.

        Where the optimiser's own choice is near one of them, expected improvement chooses among the others.
        """
        space = self._space_without_failures(self.study.space)
        done = np.array([trial.setting for trial in self._trials])
        possible = space.holds(done) & (np.abs(done) <= 1.0 + SAME).all(axis=1)
        done = done[possible] if possible.any() else done
        aims = list(self.study.aims.values())
        aim = aims[len(self._trials) % len(aims)]
        for optimiser in (OPTIMISERS[self.study.file.search.optimiser](), ExpectedImprovement()):
            rng = np.random.default_rng([self.study.file.seed, len(self._trials)])
            setting = optimiser.propose(fitted, aim, space, done, rng)
            if space.holds(setting[None])[0]:
                break
        return setting

    def _space_without_failures(self, space: Space) -> SpaceWithout:
        """Leave out the settings whose runs failed before the best one was measured: what is chosen rests on
        these runs alone."""
        before = [each for each in self.outcomes if each.trial.stage != "confirm"]
        failed = [each.trial.setting for each in before if not each.is_data]
        left_out = np.array(failed).reshape(-1, space.factors)
        return SpaceWithout(space.low, space.high, space.chains, left_out, NEAR_A_FAILURE)

    def _confirm(self) -> Iterator[Trial]:
        """Yield runs with new seeds: of the best setting for each aim, its simpler rival, and the centre."""
        settings = self.candidates()
        if not settings:
            return
        fitted = self.fit_before_confirming()
        made = {role: sum(is_of(trial, role, settings) for trial in self._trials) for role in settings}
        for repeat, role in itertools.product(range(REPEATS[1]), settings):
            if repeat < made[role]:
                continue
            if not self._can_afford(self.study.file.hours) or (
                repeat >= REPEATS[0] and self._is_narrow(settings)
            ):
                return
            yield self._trial("confirm", settings[role], fitted, FIRST_NEW_SEED + repeat, role)

    def candidates(self) -> dict[str, Array]:
        """Choose the settings that are measured again, by their roles, from the runs before.

        The roles are ``best`` and ``simpler``, with the limit where there are several aims, and ``centre``.
        There are none where the data support no optimum.
        """
        chosen: dict[str, Array] = {}
        own = OPTIMISERS[self.study.file.search.optimiser]()
        for number, (name, aim) in enumerate(self.study.aims.items()):
            if not aim.goals or self.why_no_optimum(aim):
                continue
            data, fitted = self.data(confirmed=False), self.fit_before_confirming()
            possible = self._space_without_failures(self.study.space)
            for optimiser in (own, ExpectedImprovement()):
                rng = np.random.default_rng([self.study.file.seed, CONFIRMING, number])
                setting = optimiser.recommend(fitted, aim, possible, data.x, rng)
                if possible.holds(setting[None])[0]:
                    break
            chosen[role_of(BEST, name)] = setting
            if self.study.simpler:
                rng = np.random.default_rng([self.study.file.seed, CONFIRMING, number])
                space = self.study.simpler_space()
                chosen[role_of(SIMPLER, name)] = own.recommend(fitted, aim, space, data.x, rng)
        if chosen and self._trials:
            chosen[CENTRE] = self._centre
        return chosen

    def fit_before_confirming(self) -> Fitted:
        """Fit the runs before the confirming ones, with deviations that agree with leave-one-out errors."""
        data = self.data(confirmed=False)
        return calibrated(self.fit(confirmed=False), data.y, data.variance)

    def why_no_optimum(self, aim: Aim) -> str:
        """Say why the data support no optimum, and what it would take; empty where they do.

        That is so where half of all runs failed, where the surrogate explains less than half of a goal's
        variance (Q2 < 0.5), or where no setting is expected to keep the limits.
        """
        tried = [each for each in self.outcomes if each.trial.stage not in ("cheap", "confirm")]
        failed = sum(not each.is_data for each in tried)
        if 2 * failed >= len(tried):
            return f"{failed} of {len(tried)} runs gave no data; look at the reasons in points.csv"
        try:
            fitted = self.fit(confirmed=False)
        except TooFewPoints as error:
            return f"{error}; more runs are needed"
        data, names = self.data(confirmed=False), list(self.study.file.responses)
        for goal in aim.goals:
            y, noise = data.y[:, goal.response], np.sqrt(np.nanmedian(data.variance[:, goal.response]))
            left_out = fitted.left_out()[0][:, goal.response]
            if not np.isfinite(left_out).any():
                return f"{NEEDS_ALL}; more settings are needed"
            if (q2 := explained(y, left_out)) < FEWEST_EXPLAINED:
                name, spread = names[goal.response], float(np.nanstd(y))
                if spread <= SAME * abs(float(np.nanmean(y))):
                    return f"{name} is the same in all runs: no factor changes it"
                share = (noise / spread) ** 2
                help_needed = (
                    f"about {max(2, math.ceil(share / 0.25))} times as many runs, or runs so many times as "
                    "long, are needed"
                    if share > 1.0 - FEWEST_EXPLAINED
                    else "noise is not why, so longer runs do not help; more settings, narrower ranges or "
                    "another surrogate may"
                )
                return (
                    f"the surrogate explains {100 * max(q2, 0):.0f} % of the variance of {name}, and 50 % is "
                    f"needed (noise of one run {noise:.3g}, spread of the runs {spread:.3g}): {help_needed}"
                )
        mean, _ = predict_each(fitted, np.vstack([self.study.space.sample(2000, 1), data.x]))
        if not aim.kept(mean).any():  # a run that keeps the limits by luck is no proof
            return (
                f"no setting is expected to keep all limits, and {self._nearest(aim, data)} came nearest; "
                "move the limits or widen the ranges"
            )
        return ""

    def _nearest(self, aim: Aim, data: Data) -> str:
        """Name the run that came nearest to keeping the limits, with its limited responses."""
        margin = aim.margin(data.y.T, np.sqrt(data.variance.T))
        if not np.isfinite(margin).any():
            return "no run"
        best, scales, values = int(np.nanargmax(margin)), list(self.scales.items()), []
        for number in dict.fromkeys(limit.response for limit in aim.limits):
            name, scale = scales[number]
            values.append(f"{name} {float(scale.from_fit(data.y[best, number])):.4g}")
        return f"run {data.numbers[best]:04d} with {', '.join(values)}"

    def _is_narrow(self, settings: Mapping[str, Array]) -> bool:
        """Tell whether the mean of the runs of each setting is known well enough."""
        data = self.data()
        for goal in self.study.aim.goals:
            y = data.y[:, goal.response]
            span = float(np.nanmax(y) - np.nanmin(y))
            for setting in settings.values():
                same = np.isfinite(y) & (np.abs(data.x - setting).max(axis=1) < 1e-9)
                error = np.sqrt(data.variance[same, goal.response].sum()) / max(same.sum(), 1)
                if not same.any() or NORMAL_95 * error > NARROW * span:
                    return False
        return True


def is_of(trial: Trial, role: str, settings: Mapping[str, Array]) -> bool:
    """Tell whether a trial is a confirming run of the setting that has a role now."""
    return trial.role == role and bool(np.abs(np.array(trial.setting) - settings[role]).max() <= SAME)


def role_of(kind: str, aim: str) -> str:
    """Return the role of a setting that is confirmed: its kind, and the limit of its aim where there are
    several."""
    return f"{kind}, {aim}" if aim else kind


def explained(y: Array, left_out: Array) -> float:
    """Compute the share of a response's variance, (n,), that its leave-one-out predictions explain (Q2)."""
    known = np.isfinite(y) & np.isfinite(left_out)
    varies = known.any() and np.ptp(y[known]) > 0.0  # the mean of equal numbers may differ by rounding
    total = ((y[known] - y[known].mean()) ** 2).sum() if varies else 0.0
    return float(1.0 - ((y[known] - left_out[known]) ** 2).sum() / total) if total > 0 else 0.0


def planned_settings(study: Study) -> Array:
    """List the plan's settings, coded, (runs, factors), without the centre."""
    plan, space = study.file.plan, study.space
    runs = plan.runs or 4 * space.factors
    if plan.kind == "none":
        return np.empty((0, space.factors))
    if plan.kind == "box-behnken":
        return plans.box_behnken(space.factors, centres=0)
    if plan.kind == "factorial":
        settings = plans.factorial(space, plan.levels)
        return np.asarray(settings[np.abs(settings).max(axis=1) > 0])
    if plan.kind == "latin-hypercube":
        return plans.latin_hypercube(space, runs, study.file.seed)
    return space.sample(runs, study.file.seed)
