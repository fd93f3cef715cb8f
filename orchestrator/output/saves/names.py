"""Arrays by name within names: as one table, as a file of arrays holds them, and back."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchestrator.ports import Saved


def flat(saved: Saved, within: str = "") -> dict[str, Any]:
    """Names with slashes; one that ends with a slash stands for "nothing in here"."""
    table: dict[str, Any] = {} if saved else {within: np.empty(0)}
    for name, value in saved.items():
        table |= flat(value, f"{within}{name}/") if isinstance(value, dict) else {within + name: value}
    return table


def nested(table: dict[str, Any]) -> Saved:
    """What ``flat`` was made of."""
    saved: Saved = {}
    for path, value in table.items():
        *parents, name = path.split("/")
        inner = saved
        for parent in parents:
            inner = inner.setdefault(parent, {})
        if name:
            inner[name] = value
    return saved
