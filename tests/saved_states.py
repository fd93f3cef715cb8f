"""Comparison of saved states, to the last bit."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchestrator.ports import Saved


def differences(first: Saved, second: Saved, within: str = "") -> list[str]:
    """Names of the arrays that differ in shape, type or any bit; minus zero is not zero."""
    if first.keys() != second.keys():
        return [f"{within}: {sorted(first)} and {sorted(second)}"]
    differing = []
    for name in first:
        where = f"{within}/{name}"
        if isinstance(first[name], dict):
            differing += differences(first[name], second[name], where)
        elif _bits(first[name]) != _bits(second[name]):
            differing.append(where)
    return differing


def _bits(value: Any) -> tuple[Any, ...]:
    array = np.asarray(value)
    return array.shape, array.dtype, array.tobytes()
