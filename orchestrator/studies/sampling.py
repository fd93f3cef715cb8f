"""How often a run that is to be measured writes what it is measured by."""

from __future__ import annotations

from fractions import Fraction

from orchestrator.ports.clock import exact

SAMPLES_PER_S = 2500  # of shapes and series: enough for accelerations to 500 Hz


def sample_s(interval_s: float) -> Fraction:
    """The time between two samples: whole sync intervals of this length."""
    return max(1, round(1 / SAMPLES_PER_S / interval_s)) * exact(interval_s)


def sampled_at(interval_s: float) -> tuple[str, ...]:
    """``--set`` overlays: rows often enough, at whole sync intervals; no pictures."""
    every_s = float(sample_s(interval_s))
    return (f"output.series_s={every_s!r}", f"output.shapes_s={every_s!r}", "output.pictures=false")
