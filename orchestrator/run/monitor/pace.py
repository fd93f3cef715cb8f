"""The pace of a run: a sync interval is run whole, or in equal parts.

Parts come from repeated halving, so that their lengths are again exact decimal numbers.  Every solver
takes whole steps in each part.  Its steps have their usual length, or the length of the part where the
part is shorter.  Only this module knows of parts: records, checkpoints and counts go by whole sync
intervals.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from orchestrator.coupling.schemes.scheme import Scheme, Solvers, State
from orchestrator.ports import Load
from orchestrator.ports.clock import Interval
from orchestrator.ports.state import SavedAttributes

Look = Callable[[Interval], None]


class Pace(SavedAttributes):
    """The pace of a run, which halves intervals after trouble and doubles them when all is calm again.

    ``parts`` is the number of parts of the next interval, and ``last_s`` the length of the last part.
    ``trusted`` is True if nothing has been amiss for a while.  ``divided`` counts the intervals that were
    run in parts, and ``finest`` is the largest number of parts.  All values are the same on all ranks.
    """

    STATE = ("parts", "last_s", "trusted", "divided", "finest", "_quiet", "_patience", "_eased")

    def __init__(self, length_s: float, most: int, calm: int) -> None:
        """Run intervals of ``length_s`` in up to ``most`` parts.

        After ``calm`` intervals without trouble, parts become twice as long.  If trouble then comes back,
        the next time takes twice as many calm intervals.
        """
        self.parts, self.last_s, self.trusted = 1, length_s, True
        self.divided, self.finest = 0, 1
        self._most, self._patience = most, max(1, calm)
        self._quiet, self._eased = 0, False

    def advance(
        self, scheme: Scheme, solvers: Solvers, interval: Interval, state: State, look: Look
    ) -> tuple[State, State]:
        """Return the state after a sync interval, and the same state with the mean loads of the interval.

        The run goes on from the first state and records the second one.  ``look`` is called with each
        part after it has ended.
        """
        ends = []
        for part in interval.divided(self.parts):
            state = scheme.advance(solvers, part, self._with_late_loads(scheme, state, part))
            self.last_s = part.length_s
            look(part)
            ends.append(state)
        self.divided += self.parts > 1
        self.finest = max(self.finest, self.parts)
        return state, mean_state(ends)

    def shorten(self) -> bool:
        """Run the next intervals in twice as many parts, and return whether shorter parts are allowed."""
        self._quiet, self.trusted = 0, False
        if 2 * self.parts > self._most:
            return False
        if self._eased:
            self._patience, self._eased = 2 * self._patience, False
        self.parts *= 2
        return True

    def ease(self, intervals: int = 1) -> bool:
        """Count intervals without trouble, and return whether parts become longer."""
        if self.trusted:
            return False
        self._quiet += intervals
        if self._quiet < self._patience:
            return False
        self._quiet = 0
        self.trusted = self.parts == 1
        self._eased = not self.trusted
        self.parts = max(1, self.parts // 2)
        return self._eased

    def _with_late_loads(self, scheme: Scheme, state: State, part: Interval) -> State:
        """Return the state with late loads scaled to the impulse of the part in which they arose."""
        if not scheme.late or part.length_s == self.last_s:
            return state
        share = self.last_s / part.length_s
        reaction = Load(share * state.panel.reaction.force_N)
        panel = replace(state.panel, reaction=reaction)
        return replace(state, load=Load(share * state.load.force_N), panel=panel)


def mean_state(ends: list[State]) -> State:
    """Return the last of the states at the ends of equal parts, with the mean loads of the parts."""
    if len(ends) == 1:
        return ends[0]
    load_N = np.mean([end.load.force_N for end in ends], axis=0)
    reaction_N = np.mean([end.panel.reaction.force_N for end in ends], axis=0)
    panel = replace(ends[-1].panel, reaction=Load(reaction_N))
    return replace(ends[-1], load=Load(load_N), panel=panel)
