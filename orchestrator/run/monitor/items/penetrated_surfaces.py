"""Panels that have gone through a rigid surface or another panel."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.run.monitor.item import MonitorItem, Observation, OutputTime


class PenetratedSurfaces(MonitorItem):
    """The deepest penetration, in thicknesses of the panel."""

    name = "penetrated_surfaces"
    limit_key = "largest_penetration"
    message = (
        "panel {where} by {value:.3g} of its thickness, and nothing holds it there: tighten it, "
        "move one of them, or give the panel a stop"
    )

    def observe_output(self, output: OutputTime) -> Iterator[Observation]:
        through = self.subject.machine.penetrations.deepest(output.state.panel.surface.position_m)
        if through is not None:
            yield Observation(through.thicknesses, f"{through.panel} has gone through {through.surface}")
