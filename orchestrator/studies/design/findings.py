"""The findings of a study: surrogates and how far to trust them, the best settings, and their measurement."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from scipy import stats

from orchestrator.studies.design.aim import Aim
from orchestrator.studies.design.campaign import BEST, NEEDS_ALL, SIMPLER, Campaign, explained, is_of, role_of
from orchestrator.studies.design.data import Data
from orchestrator.studies.design.front import nondominated
from orchestrator.studies.design.models import SURROGATES
from orchestrator.studies.design.optimisers import predict_each
from orchestrator.studies.design.quadratic import Quadratic, Surface
from orchestrator.studies.design.scales import Scale
from orchestrator.studies.design.sensitivity import sobol_indices
from orchestrator.studies.design.surrogates import Ensemble, Fitted, TooFewPoints, calibrated
from orchestrator.studies.design.trials import Outcome
from orchestrator.workbench.vocabulary import NORMAL_95, Array

EXACT = 1e-9  # of a value: half widths, and distances beyond a limit, below it are rounding
ON_THE_FRONT = 40  # settings that are listed
DRAWN_AT_RANDOM = 1000  # settings whose predictions are compared with the optimum, as in the paper


@dataclass(frozen=True)
class Judged:
    """A surrogate and how well it predicts each response of settings that it has not seen (leave-one-out).

    ``explained`` is Q2, the share of the variance; ``coverage`` the share of runs within the 95 % interval;
    ``members``, (members, m), is what each member explains, if the surrogate has members.
    """

    name: str
    fitted: Fitted | None
    why_not: str = ""
    explained: Array = field(default_factory=lambda: np.empty(0))
    coverage: Array = field(default_factory=lambda: np.empty(0))
    members: Array | None = None


@dataclass(frozen=True)
class ConfidenceInterval:
    """A value and how far its 95 % interval reaches to its wider side, in the response's own unit."""

    value: float
    half_width: float

    @classmethod
    def of(cls, scale: Scale, mean: float, half_width: float) -> ConfidenceInterval:
        """Take an interval from a surrogate's scale to the response's unit."""
        low, value, high = (float(scale.from_fit(mean + sign * half_width)) for sign in (-1.0, 0.0, 1.0))
        return cls(value, max(value - low, high - value))

    def __str__(self) -> str:
        if not np.isfinite(self.value):
            return "unknown"
        if not self.half_width > EXACT * abs(self.value):
            return f"{self.value:.4g} ± {'0' if np.isfinite(self.half_width) else 'unknown'}"
        digits = max(0, 1 - int(np.floor(np.log10(self.half_width))))
        return f"{self.value:.{digits}f} ± {self.half_width:.{digits}f}"


@dataclass(frozen=True)
class Confirmed:
    """A setting that was measured again: predicted and measured responses, and whether they agree.

    ``why_not`` is empty where the measured intervals overlap the predicted ones and the limits hold.
    """

    role: str
    setting: Array
    runs: int
    predicted: Mapping[str, ConfidenceInterval]
    measured: Mapping[str, ConfidenceInterval]
    why_not: str = ""


@dataclass
class Findings:
    """Everything that is written about a study, computed from its outcomes alone."""

    campaign: Campaign

    @cached_property
    def data(self) -> Data:
        """All runs that are data."""
        return self.campaign.data()

    @property
    def responses(self) -> list[str]:
        """The names of the responses."""
        return list(self.campaign.study.file.responses)

    @cached_property
    def surrogates(self) -> list[Judged]:
        """All surrogates, the study's own first."""
        own = self.campaign.study.file.search.surrogate
        return [self._judge(name) for name in sorted(SURROGATES, key=lambda name: name != own)]

    def _judge(self, name: str) -> Judged:
        try:
            fitted = self.campaign.fit(name)
        except TooFewPoints as error:
            return Judged(name, None, str(error))
        mean, deviation = fitted.left_out()
        if np.isnan(mean).all(axis=0).any():
            return Judged(name, None, NEEDS_ALL)
        y, variance = self.data.y, self.data.variance
        q2 = [explained(y[:, i], mean[:, i]) for i in range(y.shape[1])]
        inside = np.abs(y - mean) <= NORMAL_95 * np.sqrt(deviation**2 + variance)
        known = np.isfinite(y) & np.isfinite(mean)
        share = (inside & known).sum(axis=0) / np.maximum(known.sum(axis=0), 1)
        members = fitted.explained_by_members() if isinstance(fitted, Ensemble) else None
        return Judged(name, fitted, "", np.array(q2), share, members)

    @cached_property
    def fitted(self) -> Fitted | None:
        """The study's own surrogate with intervals that hold for new settings; None with too few runs."""
        own = self.surrogates[0].fitted
        return None if own is None else calibrated(own, self.data.y, self.data.variance)

    @cached_property
    def quadratic(self) -> dict[str, Surface]:
        """The quadratic surface of each response; empty where there are too few runs."""
        try:
            fitted = Quadratic().fit(self.data.x, self.data.y, self.data.variance, 0)
        except TooFewPoints:
            return {}
        return dict(zip(self.responses, fitted.surfaces, strict=True))

    @cached_property
    def sobol(self) -> Array | None:
        """Sobol indices of the study's own surrogate, (m, 4, factors); None without it, or where factors are
        ordered, since they are then not independent."""
        if self.fitted is None or self.campaign.study.space.chains:
            return None
        return sobol_indices(self.fitted, self.campaign.study.space.factors)

    @cached_property
    def why_no_optimum(self) -> dict[str, str]:
        """Why the data support no optimum, by aim; only aims without one are in it."""
        aims = self.campaign.study.aims
        reasons = {name: self.campaign.why_no_optimum(aim) for name, aim in aims.items() if aim.goals}
        return {name: why for name, why in reasons.items() if why}

    @cached_property
    def candidates(self) -> dict[str, Array]:
        """The settings that are to be measured again, by their roles."""
        return self.campaign.candidates()

    @cached_property
    def best(self) -> dict[str, Array]:
        """The recommended setting of each aim that has one, by the aim's name."""
        chosen = {name: role_of(BEST, name) for name in self.campaign.study.aims}
        return {name: self.candidates[role] for name, role in chosen.items() if role in self.candidates}

    def predict(self, setting: Array) -> dict[str, ConfidenceInterval]:
        """Predict the responses at a coded setting, (factors,), by the study's own surrogate."""
        assert self.fitted is not None
        mean, deviation = predict_each(self.fitted, setting[None])
        return self._intervals(mean[:, 0], NORMAL_95 * deviation[:, 0])

    def _intervals(self, mean: Array, half_width: Array) -> dict[str, ConfidenceInterval]:
        """Take means and half widths, (m,), from the surrogates' scales to the responses' units."""
        values = zip(self.campaign.scales.items(), mean, half_width, strict=True)
        return {name: ConfidenceInterval.of(scale, middle, width) for (name, scale), middle, width in values}

    @cached_property
    def confirmed(self) -> list[Confirmed]:
        """The settings that were run again with new seeds, in the order of their first runs."""
        first = {role: self._runs_of(role)[0].trial.number for role in self.candidates if self._runs_of(role)}
        return [self._confirm(role) for role in sorted(first, key=first.__getitem__)]

    def _runs_of(self, role: str) -> list[Outcome]:
        """Return the confirming runs that are data of the setting that has a role now.

        Those of settings that had it before the study was changed, or went on, are data as any others.
        """
        return [each for each in self._tried(role) if each.is_data]

    def failures_of(self, role: str) -> list[Outcome]:
        """Return the confirming runs that are no data of the setting that has a role now."""
        return [each for each in self._tried(role) if not each.is_data]

    def _tried(self, role: str) -> list[Outcome]:
        runs = [each for each in self.campaign.outcomes if each.trial.stage == "confirm"]
        mine = [each for each in runs if is_of(each.trial, role, self.candidates)]
        return sorted(mine, key=lambda each: each.trial.number)

    def _confirm(self, role: str) -> Confirmed:
        mine = self._runs_of(role)
        setting = np.array(mine[0].trial.setting)
        rows = np.isin(self.data.numbers, [each.trial.number for each in mine])
        y, variance = self.data.y[rows], self.data.variance[rows]
        known = np.isfinite(y)
        counts = np.where(known.any(axis=0), known.sum(axis=0), np.nan)
        mean = np.where(known, y, 0.0).sum(axis=0) / counts
        error = np.sqrt(np.where(known, variance, 0.0).sum(axis=0)) / counts
        measured = self._intervals(mean, NORMAL_95 * error)
        unknown = (np.nan, np.nan)  # of a response that was added or changed later
        expected = np.array([mine[0].trial.predicted.get(name, unknown)[:2] for name in self.responses])
        predicted = self._intervals(expected[:, 0], NORMAL_95 * expected[:, 1])
        aims = self.campaign.study.aims
        aim = next(
            (a for name, a in aims.items() if role in (role_of(BEST, name), role_of(SIMPLER, name))), None
        )
        judged = sorted({i for each in ([aim] if aim else aims.values()) for i in each.responses})
        why = [
            f"{self.responses[i]} was measured as {measured[self.responses[i]]} and predicted as "
            f"{predicted[self.responses[i]]}"
            for i in judged
            if abs(mean[i] - expected[i, 0]) > NORMAL_95 * (error[i] + expected[i, 1])
        ]
        why += [f"{self.responses[i]} was not predicted" for i in judged if not np.isfinite(expected[i, 0])]
        if aim is not None:
            why += [f"{self.responses[i]} was not measured" for i in judged if not np.isfinite(mean[i])]
            for limit in aim.limits:
                if limit.sign * (mean[limit.response] - limit.value) < -EXACT * abs(limit.value):
                    name = self.responses[limit.response]
                    why.append(f"{name} was measured as {measured[name]}, beyond its limit")
        return Confirmed(role, setting, len(mine), predicted, measured, "; ".join(why))

    def is_confirmed(self) -> bool:
        """Tell whether every aim has a best setting that was measured as predicted."""
        wanted = [role_of(BEST, name) for name, aim in self.campaign.study.aims.items() if aim.goals]
        proven = {each.role for each in self.confirmed if not each.why_not}
        return bool(wanted) and set(wanted) <= proven

    def against(self, role: str, other: str, response: int) -> ConfidenceInterval | None:
        """Compute the difference of a response between two settings that were measured again, from runs with
        equal seeds; None where one of them was not."""
        pairs: dict[int, dict[str, float]] = {}
        name = self.responses[response]
        for each in (*self._runs_of(role), *self._runs_of(other)):
            if name in each.responses:
                pairs.setdefault(each.trial.seed, {})[each.trial.role] = each.responses[name].value
        differences = [pair[role] - pair[other] for pair in pairs.values() if len(pair) == 2]
        if len(differences) < 2:
            return None
        t = float(stats.t.ppf(0.975, len(differences) - 1))
        return ConfidenceInterval(
            float(np.mean(differences)), t * float(np.std(differences, ddof=1)) / len(differences) ** 0.5
        )

    @cached_property
    def trade_off(self) -> tuple[int, int, float, float] | None:
        """The two responses of the trade-off, with their signs (1: the larger the better): both goals, or the
        goal and the first limit; None where there is only one."""
        aim = self.campaign.study.aim
        parts = [(goal.response, goal.sign) for goal in aim.goals]
        parts += [(limit.response, limit.sign) for limit in aim.limits]
        if len(parts) < 2 or self.fitted is None:
            return None
        (first, first_sign), (second, second_sign) = parts[:2]
        return first, second, first_sign, second_sign

    @cached_property
    def beside(self) -> Aim:
        """The first aim without the limits that the trade-off shows: those of its second response."""
        aim, shown = self.campaign.study.aim, self.trade_off[1] if self.trade_off else None
        return replace(aim, limits=tuple(limit for limit in aim.limits if limit.response != shown))

    @cached_property
    def random_settings(self) -> Array:
        """A thousand random settings, coded, (1000, factors)."""
        return self.campaign.study.space.sample(DRAWN_AT_RANDOM, self.campaign.study.file.seed)

    @cached_property
    def front(self) -> Array:
        """Settings, coded, (n, factors), whose predicted trade-off no other one beats; ordered along it."""
        if self.trade_off is None or self.fitted is None:
            return np.empty((0, self.campaign.study.space.factors))
        first, second, *signs = self.trade_off
        rng = np.random.default_rng([self.campaign.study.file.seed, 3])
        space, x = self.campaign.study.space, self.random_settings
        for _ in range(3):
            x = np.vstack([x, space.candidates(x[-DRAWN_AT_RANDOM:], DRAWN_AT_RANDOM // 3, rng)])
            mean, _ = predict_each(self.fitted, x)
            gains = np.array(signs)[:, None] * mean[[first, second]]
            x = np.unique(x[nondominated(gains, self.beside.kept(mean))], axis=0)  # a corner is met often
        mean, _ = predict_each(self.fitted, x)
        order = np.argsort(mean[first])
        chosen = (
            order[np.unique(np.linspace(0, len(order) - 1, ON_THE_FRONT).astype(int))] if len(x) else order
        )
        return x[chosen]
