"""The data of a study: settings, responses as surrogates see them, and the noise of each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy import stats

from orchestrator.studies.design.gaussian_process import likely_noise
from orchestrator.studies.design.quadratic import model_matrix, quadratic_terms
from orchestrator.studies.design.scales import Scale
from orchestrator.studies.design.surrogates import settings_of
from orchestrator.studies.design.trials import Outcome
from orchestrator.workbench.vocabulary import Array

UNLIKELY = 0.01  # replicates that scatter more than this probability allows are believed, not the intervals
RESIDUALS_COUNT = 3  # degrees of freedom of which a surface's residuals are worth beside replicates


@dataclass(frozen=True)
class Data:
    """Settings ``x``, (n, f), coded; responses ``y``, (n, m), on the scales of the surrogates; ``variance``,
    (n, m), of their noise.

    ``widened``, (m,), is the factor by which the runs' own intervals were widened to agree with replicates;
    ``numbers``, (n,), are those of the trials.
    """

    numbers: npt.NDArray[np.int64]
    x: Array
    y: Array
    variance: Array
    widened: Array

    @classmethod
    def of(cls, outcomes: Sequence[Outcome], scales: Mapping[str, Scale]) -> Data:
        """Collect the outcomes that are data; a response that a run does not have is not a number."""
        rows = sorted((each for each in outcomes if each.is_data), key=lambda each: each.trial.number)
        factors = len(outcomes[0].trial.setting) if outcomes else 0
        x = np.array([each.trial.setting for each in rows]).reshape(len(rows), factors)
        y, variance = np.full((2, len(rows), len(scales)), np.nan)
        for i, each in enumerate(rows):
            for j, (name, scale) in enumerate(scales.items()):
                if name in each.responses:
                    measured = each.responses[name]
                    y[i, j] = scale.to_fit(measured.value)
                    if measured.deviation is not None:
                        variance[i, j] = (measured.deviation * scale.slope(measured.value)) ** 2
        widened = np.ones(len(scales))
        for j in range(len(scales)):
            variance[:, j], widened[j] = completed_variance(x, y[:, j], variance[:, j])
        return cls(np.array([each.trial.number for each in rows]), x, y, variance, widened)


def completed_variance(x: Array, y: Array, variance: Array) -> tuple[Array, float]:
    """Complete the noise of a response, (n,), and hold it against runs of one setting.

    A run without an interval gets the median noise of the others, or where no run has one the scatter of
    replicates.  Two replicates may agree by luck, so the residuals of a quadratic or a plane join them.
    Where replicates scatter more than their intervals allow (chi-square test), all are widened by the ratio.
    Where nothing tells of the noise, it is the one with which a Gaussian process is most likely.
    Return variances, (n,), and the factor on standard deviations by which they were widened.
    """
    known = np.isfinite(y)
    group = settings_of(x)
    replicates = [
        members
        for number in range(group.max(initial=-1) + 1)
        if (members := known & (group == number)).sum() > 1
    ]
    squares = float(sum(((y[members] - y[members].mean()) ** 2).sum() for members in replicates))
    freedom = int(sum(members.sum() - 1 for members in replicates))
    own = variance[known & np.isfinite(variance)]
    if len(own):
        fallback = float(np.median(own))
    elif freedom:
        residual, count = _residual_variance(x[known], y[known])
        fallback = (squares + count * residual) / (freedom + count)
    else:
        fallback = likely_noise(x[known], y[known])
    complete = np.where(np.isfinite(variance), variance, fallback)
    expected = float(sum((members.sum() - 1) * complete[members].mean() for members in replicates))
    if freedom and len(own) and expected > 0:
        ratio = squares / expected
        if stats.chi2.sf(freedom * ratio, freedom) < UNLIKELY:
            return complete * ratio, float(np.sqrt(ratio))
    return complete, 1.0


def _residual_variance(x: Array, y: Array) -> tuple[float, int]:
    """Return the residuals' variance of a quadratic, or of a plane for few points, and the weight it has.

    What the surface cannot follow counts as noise, which errs on the safe side.  The weight is 0 where there
    are too few points for a plane.
    """
    quadratic = quadratic_terms(x.shape[1])
    for terms in (quadratic, quadratic[: 1 + x.shape[1]]):
        matrix = model_matrix(x, terms)
        freedom = len(y) - int(np.linalg.matrix_rank(matrix))
        if freedom >= RESIDUALS_COUNT:
            rest = y - matrix @ np.linalg.lstsq(matrix, y, rcond=None)[0]
            return float(rest @ rest) / freedom, RESIDUALS_COUNT
    return 0.0, 0
