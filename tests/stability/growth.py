"""The growth of small deviations in a sync interval: spectral radius of the real coupling loop.

The members on the line are linear where the sphere stays on the plate, so that the loop's matrix is
found exactly by running it for one interval from each deviation alone.  (Robin's share of the free
masses is kept at one: what it learns from interval to interval is not linear.)
"""

from __future__ import annotations

from collections.abc import Callable
from copy import deepcopy
from dataclasses import dataclass

import numpy as np

from orchestrator.coupling.schemes import create_scheme as named
from orchestrator.coupling.schemes.iterated import Effort
from orchestrator.coupling.schemes.robin import Robin
from orchestrator.coupling.schemes.scheme import State
from orchestrator.ports import Array, PanelState
from orchestrator.ports.clock import Interval
from tests.coupling.line import FreeFrame, HungPlate, Sphere, members, point, push

NUMBERS = 12  # sphere, plate, load and where the sphere saw the plate; frame, its acceleration,
# what the plate was told; reaction
CONTACT, FRAME, ALL = slice(0, 6), slice(6, 12), slice(0, 12)
CLOSE = Effort(1e-9, 0.0, 60)  # repeated intervals are linear when they are solved
NEUTRAL = 1e-5  # growth an interval that counts: neutral drift is found to some 1e-7


@dataclass(frozen=True)
class Line:
    """Sphere on plate on frame; the numbers that may deviate are the state's own."""

    sphere: Sphere
    plate: HungPlate
    frame: FreeFrame

    def radius(self, scheme: str, interval_s: float, numbers: slice) -> float:
        """Growth of the fastest growing deviation in an interval, where only those ``numbers``
        (CONTACT, FRAME or ALL) deviate."""
        rows = np.eye(NUMBERS)[numbers]
        matrix = np.array([self._after(scheme, interval_s, row)[numbers] for row in rows])
        return float(np.abs(np.linalg.eigvals(matrix)).max())

    def _after(self, scheme: str, interval_s: float, by: Array) -> Array:
        sphere, plate, frame = (deepcopy(part) for part in (self.sphere, self.plate, self.frame))
        sphere.x, sphere.v = sphere.x + by[0], sphere.v + by[1] / interval_s
        plate.x, plate.v = plate.x + by[2], plate.v + by[3] / interval_s
        sphere.seen += by[5]
        load, reaction = push(by[4]), push(by[11])
        frame.x, frame.v = frame.x + by[6], frame.v + by[7] / interval_s
        plate.clamp = point(by[9], by[10] / interval_s)
        surface, clamps = point(plate.x, plate.v), point(frame.x, frame.v)
        acceleration = np.array([[by[8] / interval_s**2, 0.0, 0.0]])
        state = State(clamps, acceleration, PanelState(surface, reaction), load)
        solvers = members(sphere, plate, frame)
        advancing = named(scheme, CLOSE)
        if isinstance(advancing.memory, Robin):
            seen_m = point(sphere.seen, 0.0).position_m
            advancing.memory.restore({"seen_m": seen_m, "share": np.ones(3)})
        state = advancing.advance(solvers, Interval(0, interval_s), state)
        h, a = interval_s, state.clamps_acceleration_m_per_s2[0, 0]
        clamp = plate.clamp
        return np.array(
            [
                *(sphere.x, h * sphere.v, plate.x, h * plate.v, state.load.force_N[0, 0], sphere.seen),
                *(frame.x, h * frame.v, h * h * a),
                *(clamp.position_m[0, 0], h * clamp.velocity_m_per_s[0, 0]),
                state.panel.reaction.force_N[0, 0],
            ]
        )


def limit_s(
    radius: Callable[[float], float], guess_s: float, farthest: float = 10.0, neutral: float = NEUTRAL
) -> float:
    """The shortest interval at which deviations grow, by a scan in steps of 4 % from a third of
    ``guess_s`` to ``farthest`` times it, and bisection; infinite if none does."""
    before_s = guess_s / 3
    if radius(before_s) > 1 + neutral:
        return before_s
    while before_s < farthest * guess_s:
        after_s = 1.04 * before_s
        if radius(after_s) > 1 + neutral:
            for _ in range(8):
                middle_s = (before_s + after_s) / 2
                stable = radius(middle_s) <= 1 + neutral
                before_s, after_s = (middle_s, after_s) if stable else (before_s, middle_s)
            return before_s
        before_s = after_s
    return np.inf
