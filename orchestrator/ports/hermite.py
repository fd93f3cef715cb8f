"""The smooth path between two motions: cubic Hermite in position and velocity."""

from __future__ import annotations

from dataclasses import dataclass

from orchestrator.ports.crossing import Array, Motion


@dataclass(frozen=True)
class Path:
    """Points moving from ``start`` to ``end`` in ``length_s`` with continuous velocity."""

    start: Motion
    end: Motion
    length_s: float

    def position_m(self, fraction: float) -> Array:
        """(points, 3) at ``fraction`` (0 ... 1) of the interval."""
        t, h = fraction, self.length_s
        value: Array = (
            (1 + 2 * t) * (1 - t) ** 2 * self.start.position_m
            + t * (1 - t) ** 2 * h * self.start.velocity_m_per_s
            + t * t * (3 - 2 * t) * self.end.position_m
            + t * t * (t - 1) * h * self.end.velocity_m_per_s
        )
        return value

    def velocity_m_per_s(self, fraction: float) -> Array:
        t, h = fraction, self.length_s
        value: Array = (
            6 * t * (t - 1) / h * (self.start.position_m - self.end.position_m)
            + (1 - t) * (1 - 3 * t) * self.start.velocity_m_per_s
            + t * (3 * t - 2) * self.end.velocity_m_per_s
        )
        return value

    def acceleration_m_per_s2(self, fraction: float) -> Array:
        t, h = fraction, self.length_s
        value: Array = (
            (12 * t - 6) / h**2 * (self.start.position_m - self.end.position_m)
            + (6 * t - 4) / h * self.start.velocity_m_per_s
            + (6 * t - 2) / h * self.end.velocity_m_per_s
        )
        return value

    def at(self, fraction: float) -> Motion:
        return Motion(self.position_m(fraction), self.velocity_m_per_s(fraction))
