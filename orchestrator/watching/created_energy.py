"""Energy that the coupling creates, interval by interval, from what crosses at sync points.

Between two sync points each side of an interface moves from a known place to a known place under a
known mean load, so that no solver needs to be asked, and no rank to wait.

Particles and panels: particles on a path from p to q give the mean load F, panels move from x to y
under P (F itself, or an earlier one), and the particles' next path starts at y.  The particles
receive -F.(q - p), and of the jump from the last path's end to p the mean of the loads before and
after; the panels receive P.(y - x).  The sum is what was created.  Left out: on a curved path the
load's deviation from its mean times the velocity's, and what the load at the sync point differs
from the mean of both, each of second order in what changes within one interval.

Panels and frames: panels whose clamps are told to move from c to d give the mean reaction R, frames
move from x to y under Q (R, or an earlier one), and receive Q.(y - x); the panels receive
-R.(d - c).  Left out: likewise.

docs/theory/stability.md, "The watch"; tests/watching compares both with the ledger.
"""

from __future__ import annotations

import numpy as np

from orchestrator.coupling import State
from orchestrator.ledger import Members
from orchestrator.ports import Array, Load, Saved
from orchestrator.state import put_back, taken

SLOW_M_S = 1e-3  # nothing on a screen that moves slower counts
FADE = 1 - 1 / 20  # an interval's share in what is recent falls so much with each one after it

_SUMS = ("created_J", "through_J", "_recent_created_J", "_recent_through_J", "_newest_J")


class Balance:
    """Energy created at an interface, against what went through it.

    ``through_J``: sum of the sizes of each point's work; a load on what moves slower than
    ``SLOW_M_S`` counts as if it moved so fast.  ``created_J``: since t = 0; negative: destroyed.
    """

    def __init__(self) -> None:
        self.created_J = self.through_J = 0.0
        self._recent_created_J = self._recent_through_J = self._newest_J = 0.0

    def add(self, created_J: float, through_J: float) -> None:
        """An interval's."""
        self.created_J += created_J
        self.through_J += through_J
        self._recent_created_J = FADE * self._recent_created_J + created_J
        self._recent_through_J = FADE * self._recent_through_J + through_J
        self._newest_J = through_J

    def recently(self) -> float:
        """Share created of what went through in the last twenty intervals or so.  What went through
        in the newest does not count as created: it may come back in the next."""
        return self._share(self._recent_created_J, self._recent_through_J)

    def in_total(self) -> float:
        """The same since t = 0."""
        return self._share(self.created_J, self.through_J)

    def begin_anew(self, in_transit_J: float = 0.0) -> None:
        """Forgets what is recent but what the next interval takes back."""
        self._recent_created_J = in_transit_J / FADE  # whole in the next interval
        self._recent_through_J = self._newest_J = 0.0

    def save(self) -> Saved:
        return taken(self, *_SUMS)

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, *_SUMS)

    def _share(self, created_J: float, through_J: float) -> float:
        beyond_J = abs(created_J) - self._newest_J
        return beyond_J / through_J if beyond_J > 0 else 0.0


_OF_CONTACTS = ("_surface_m", "_path_end_m", "_load_N", "_load_before_N")


class ContactWork:
    """Between particles and panels."""

    def __init__(self, start: State) -> None:
        self.balance = Balance()
        self._surface_m = self._path_end_m = start.panel.surface.position_m
        self._load_N = self._load_before_N = start.load.force_N

    def add(self, members: Members, length_s: float) -> None:
        """Of the interval of ``length_s`` that the members have just ended."""
        assert members.particles is not None
        path, load = members.particles.last
        _, given, state = members.panel.last
        moved_m = state.surface.position_m - self._surface_m
        jump_m = path.start.position_m - self._path_end_m
        at_jump_N = (2 * load.force_N + 5 * self._load_N - self._load_before_N) / 6
        particles_J = np.vdot(load.force_N, path.end.position_m - path.start.position_m)
        particles_J += np.vdot(at_jump_N, jump_m)
        created_J = np.vdot(given.force_N, moved_m) - particles_J
        self.balance.add(float(created_J), through_J(load, moved_m, length_s))
        self._surface_m, self._path_end_m = state.surface.position_m, path.end.position_m
        self._load_before_N, self._load_N = self._load_N, load.force_N

    def begin_anew(self) -> None:
        """Intervals are of another length from now on."""
        jump_m = self._surface_m - self._path_end_m
        self.balance.begin_anew(float(np.vdot(self._load_N, jump_m)))

    def save(self) -> Saved:
        return taken(self, *_OF_CONTACTS) | {"balance": self.balance.save()}

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, *_OF_CONTACTS)
        self.balance.restore(saved["balance"])


_OF_CLAMPS = ("_clamps_m", "_told_m", "_reaction_N")


class ClampWork:
    """Between panels and frames."""

    def __init__(self, start: State) -> None:
        self.balance = Balance()
        self._clamps_m = self._told_m = start.clamps.position_m
        self._reaction_N = start.panel.reaction.force_N

    def add(self, members: Members, length_s: float) -> None:
        reaction, clamps = members.frames.last
        told, _, state = members.panel.last
        moved_m = clamps.position_m - self._clamps_m
        panels_J = np.vdot(state.reaction.force_N, told.position_m - self._told_m)
        created_J = np.vdot(reaction.force_N, moved_m) - panels_J
        self.balance.add(float(created_J), through_J(reaction, moved_m, length_s))
        self._clamps_m, self._told_m = clamps.position_m, told.position_m
        self._reaction_N = state.reaction.force_N

    def begin_anew(self) -> None:
        """Intervals are of another length from now on."""
        jump_m = self._clamps_m - self._told_m
        self.balance.begin_anew(float(np.vdot(self._reaction_N, jump_m)))

    def save(self) -> Saved:
        return taken(self, *_OF_CLAMPS) | {"balance": self.balance.save()}

    def restore(self, saved: Saved) -> None:
        put_back(self, saved, *_OF_CLAMPS)
        self.balance.restore(saved["balance"])


def through_J(load: Load, moved_m: Array, length_s: float) -> float:
    """Sum of the sizes of each point's work, (points, 3) moved under ``load`` in ``length_s``."""
    by_point_J = np.einsum("ij,ij->i", load.force_N, moved_m)
    slow_J = SLOW_M_S * length_s * np.abs(load.force_N).sum()
    return float(np.abs(by_point_J).sum() + slow_J)
