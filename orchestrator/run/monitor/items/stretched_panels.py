"""Panels that are stretched too far."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from orchestrator.coupling.machine import PanelPoints
from orchestrator.ports import Array
from orchestrator.run.monitor.item import MonitorItem, Observation, OutputTime


class StretchedPanels(MonitorItem):
    """The largest stretch of each panel along an edge of its triangles."""

    name = "stretched_panels"
    limit_key = "largest_stretch"
    message = "panel {where} is stretched by {value:.2g} of its length"

    def observe_output(self, output: OutputTime) -> Iterator[Observation]:
        surface_m = output.state.panel.surface.position_m
        for panel in self.subject.machine.panels:
            yield Observation(largest_stretch(panel, surface_m), panel.name)


def largest_stretch(panel: PanelPoints, surface_m: Array) -> float:
    """Returns the largest strain of an edge of the panel's triangles, over its stress-free length."""
    ends_m = surface_m[panel.edges]
    length_m = np.linalg.norm(ends_m[:, 1] - ends_m[:, 0], axis=1)
    return float((length_m / panel.edge_length_m).max()) - 1.0
