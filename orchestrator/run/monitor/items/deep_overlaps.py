"""Particles that overlap each other or the surface too deeply."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.run.monitor.item import MonitorItem, Observation, OutputTime


class DeepOverlaps(MonitorItem):
    """The deepest overlap, of the smaller radius."""

    name = "deep_overlaps"
    limit_key = "largest_overlap"
    message = "particles overlap by {value:.2g} of a radius: contacts too soft or steps too long"

    def observe_output(self, output: OutputTime) -> Iterator[Observation]:
        if output.bed is not None and len(output.bed[0].id):
            overlaps = output.bed[1]
            yield Observation(2 * max(overlaps.between_per_diameter, overlaps.surface_per_diameter))
