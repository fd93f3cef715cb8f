"""The front of two goals: what cannot be improved in one without loss in the other."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from orchestrator.workbench.vocabulary import Array


def nondominated(gains: Array, kept: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
    """Tell which points, (n,), of ``gains``, (goals, n), keep the limits and are bettered by none."""
    better = (gains[:, None, :] >= gains[:, :, None]).all(axis=0) & (
        gains[:, None, :] > gains[:, :, None]
    ).any(axis=0)
    best: npt.NDArray[np.bool_] = kept & ~(better & kept[None, :]).any(axis=1)
    return best


def improvements(gains: Array, reference: Array, new: Array) -> Array:
    """Compute the area, (k,), that each new point, (2, k), adds to that of points, (2, n)."""
    above = gains[:, (gains > reference[:, None]).all(axis=0)]
    front = above[:, nondominated(above, np.ones(above.shape[1], bool))]
    front = front[:, np.argsort(front[0])]
    left = np.concatenate([reference[:1], front[0]])  # strips along the first goal ...
    right = np.concatenate([front[0], [np.inf]])
    height = np.concatenate([front[1], reference[1:]])  # ... and how high they are filled
    width = np.maximum(np.minimum(new[0][:, None], right) - left, 0.0)
    areas: Array = (width * np.maximum(new[1][:, None] - height, 0.0)).sum(axis=1)
    return areas
