"""Scales on which surrogates see responses, so that what they predict can exist."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy import special

from orchestrator.workbench.vocabulary import Array

ENDS = 0.05  # percent: shares nearer to 0 and 100 are moved here, since their logit is not finite
BEYOND = 10.0  # percent: a share of flows may lie so far beyond 0 and 100, by chance


@dataclass(frozen=True)
class Scale:
    """``to_fit`` gives values as surrogates see them, ``from_fit`` takes them back, ``slope`` is the
    derivative of ``to_fit``, by which standard deviations go over.  Values beyond the ``ends`` are not on
    the scale."""

    to_fit: Callable[[Array | float], Array]
    from_fit: Callable[[Array | float], Array]
    slope: Callable[[Array | float], Array]
    ends: tuple[float, float] = (-np.inf, np.inf)

    def has(self, value: float) -> bool:
        """Tell whether a value is on the scale."""
        return self.ends[0] <= value <= self.ends[1]


def _inside(percent: Array | float) -> Array:
    return np.clip(percent, ENDS, 100.0 - ENDS)


def _plain(value: Array | float) -> Array:
    return np.asarray(value, float)


def _logarithm(value: Array | float) -> Array:
    """Return the logarithm; NaN, as of a response that was not measured, for what has none."""
    return np.asarray(np.log(np.where(np.greater(value, 0.0), value, np.nan)))


SCALES = {
    "plain": Scale(_plain, _plain, lambda value: np.ones_like(_plain(value))),
    "percent": Scale(
        lambda percent: special.logit(_inside(percent) / 100.0),
        lambda logit: 100.0 * special.expit(_plain(logit)),
        lambda percent: 100.0 / (_inside(percent) * (100.0 - _inside(percent))),
        (-BEYOND, 100.0 + BEYOND),
    ),
    "logarithm": Scale(
        _logarithm,
        np.exp,
        lambda value: np.asarray(1.0 / np.where(np.greater(value, 0.0), value, np.nan)),
        (np.nextafter(0.0, 1.0), np.inf),
    ),
}
