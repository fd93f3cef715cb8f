"""The elements of bushings that are no linear springs and dampers, together: ``hysteresis`` and
``gap_springs`` have their laws."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from adapters.frames.common.gap_springs import GapSprings
from adapters.frames.common.hysteresis import Hysteresis
from orchestrator.ports import Array
from orchestrator.ports.plans import FramesPlan
from orchestrator.ports.state import Saved


class BushingElements:
    """The friction and Maxwell elements and the gap springs of all bushings of a plan.

    ``sag_m`` (bushings, 3) are the stretches at which the linear springs hold the preload.  Raises ValueError
    for a characteristic that cannot hold it.
    """

    def __init__(self, plan: FramesPlan, sag_m: Array) -> None:
        self.hysteresis, self.gap_springs = Hysteresis(plan), GapSprings(plan, sag_m)

    def __bool__(self) -> bool:
        """Return whether there are elements at all."""
        return bool(self.hysteresis) or bool(self.gap_springs)

    @property
    def stiffness_N_per_m(self) -> Array:
        """What the elements add at most to the stiffness along the axes of each bushing, (bushings, 3)."""
        return self.hysteresis.stiffness_N_per_m + self.gap_springs.stiffness_N_per_m

    @property
    def force_N(self) -> Array:
        """The elements' force along the axes of each bushing, (bushings, 3)."""
        return self.hysteresis.force_N + self.gap_springs.force_N

    def mean_N(self, moved_m: Array, step_s: float) -> Array:
        """Return the mean force (bushings, 3) over a step in which the bushings' ends move apart by
        ``moved_m`` (bushings, 3) along their axes.  The call changes nothing."""
        return self.hysteresis.mean_N(moved_m, step_s) + self.gap_springs.mean_N(moved_m)

    def end_N(self, moved_m: Array, step_s: float) -> Array:
        """Return the force (bushings, 3) at the end of a step that has, with the force at its start, the mean
        of ``mean_N``.  The call changes nothing."""
        return 2 * self.mean_N(moved_m, step_s) - self.force_N

    def end_of_one_N(self, bushing: int, moved_m: Sequence[float], step_s: float) -> list[float]:
        """Return the force (3,) of one bushing, as ``end_N``.  For a few elements, plain numbers are faster
        than arrays."""
        rubber_N = self.hysteresis.force_of_one_after_N(bushing, moved_m, step_s)
        start_N = self.gap_springs.mean_of_one_N(bushing, (0.0, 0.0, 0.0))
        mean_N = self.gap_springs.mean_of_one_N(bushing, moved_m)
        return [r + 2 * m - s for r, m, s in zip(rubber_N, mean_N, start_N, strict=True)]

    def accept(self, moved_m: Array, step_s: float) -> float:
        """Go to the end of a step as in ``mean_N``, and return the energy lost in it in J."""
        self.gap_springs.accept(moved_m)
        return self.hysteresis.accept(moved_m, step_s)

    def save(self) -> Saved:
        """Return the states of the elements that there are, by their names."""
        return {name: part.save() for name, part in self._parts()}

    def restore(self, saved: Saved) -> None:
        """Take the elements back to a saved state."""
        for name, part in self._parts():
            part.restore(saved[name])

    def stored_J(self) -> float:
        """Return the energy in the elements, but for a constant, in J."""
        return self.hysteresis.stored_J() + self.gap_springs.stored_J()

    def _parts(self) -> Iterator[tuple[str, Hysteresis | GapSprings]]:
        if self.hysteresis:
            yield "hysteresis", self.hysteresis
        if self.gap_springs:
            yield "gap_springs", self.gap_springs
