"""Comparison of saved states, to the last bit."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchestrator.ports import Saved


def differences(one: Saved, other: Saved, within: str = "") -> list[str]:
    """Names of the arrays that differ in shape, type or any bit; minus zero is not zero."""
    if one.keys() != other.keys():
        return [f"{within}: {sorted(one)} and {sorted(other)}"]
    found = []
    for name in one:
        where = f"{within}/{name}"
        if isinstance(one[name], dict):
            found += differences(one[name], other[name], where)
        elif _bits(one[name]) != _bits(other[name]):
            found.append(where)
    return found


def _bits(value: Any) -> tuple[Any, ...]:
    array = np.asarray(value)
    return array.shape, array.dtype, array.tobytes()
