"""Wear of the panels on the report's page: a map of the deck, and a table."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchestrator.output.report.drawing import WIDE, embedded, figure
from orchestrator.output.report.formatting import interval, number
from orchestrator.output.report.tables import Sheet

MM_IN_1000_H = 1e6  # 1 m/h
NOTE = (
    "As deep as this after 1000 hours if they all went on like the averaged part of the run; "
    "the specific wear that the case gives is nearly all of its uncertainty."
)


def wear_sheet(wear: dict[str, Any]) -> Sheet:
    """Every panel."""
    columns = (
        "panel",
        "mean / (mm in 1000 h)",
        "deepest patch / (mm in 1000 h)",
        "there: share of length, of width",
        "worn through after / h",
    )
    rows = tuple(
        (
            name,
            interval(panel["mean_m_per_h"], MM_IN_1000_H),
            number(panel["largest_m_per_h"], MM_IN_1000_H),
            ", ".join(number(share, digits=2) for share in panel["largest_at"]),
            number(panel["worn_through_h"]),
        )
        for name, panel in wear["panels"].items()
    )
    return Sheet("Wear", columns, rows, NOTE)


def wear_map(wear: dict[str, Any]) -> str:
    """Depth in 1000 h of all panels' patches, one panel beside the other."""
    maps = {name: MM_IN_1000_H * _known(panel) for name, panel in wear["panels"].items()}
    drawn, ((axes,),) = figure(1, 1, WIDE, 2.6)
    deepest = max(float(np.nanmax(values)) for values in maps.values())
    for place, values in enumerate(maps.values()):
        edges = place + np.linspace(0.02, 0.98, len(values) + 1)
        across = np.linspace(0.0, 1.0, values.shape[1] + 1)
        shown = axes.pcolormesh(edges, across, values.T, vmin=0.0, vmax=deepest, cmap="magma_r")
    drawn.colorbar(shown, ax=axes, label="mm in 1000 h")
    axes.set_xticks(np.arange(len(maps)) + 0.5, list(maps))
    axes.set(ylabel="share of the width", title="wear, each panel from its first clamp")
    axes.grid(visible=False)
    return embedded(drawn)


def _known(panel: dict[str, Any]) -> Any:
    return np.array(panel["depth_m_per_h"], dtype=float)
