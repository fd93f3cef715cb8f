"""A set of panels that the coupling loop treats as a single panel with concatenated points.

Under MPI, each rank has some neighbouring panels.  It advances them, and then all ranks exchange the results,
so that every rank knows the whole surface and all reactions.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from scipy.sparse import block_diag, csr_array

from orchestrator.ports import Account, Inertia, Known, Load, Motion, Mount, Panel, PanelState, Saved
from orchestrator.ports.clock import Interval
from orchestrator.ports.panel import Joinable, JointAdvance, surface_ahead, surface_inertia


@dataclass(frozen=True)
class Group:
    """Panels that one call advances: their numbers, in order, and their points in the set."""

    panels: Sequence[int]
    clamps: slice
    surface: slice
    advance: JointAdvance


class PanelSet:
    """``count`` panels as one panel, on every rank of ``communicator`` (None: one process).

    ``open_panel(i)`` opens panel i; it is called only on the rank that owns it.  Panel i has the
    points ``surface[i]`` and ``clamps[i]`` (slices) of the concatenated arrays.
    """

    def __init__(self, count: int, open_panel: Callable[[int], Panel], communicator: Any = None) -> None:
        self._communicator = communicator
        rank, size = (communicator.rank, communicator.size) if communicator else (0, 1)
        starts = [count * number // size for number in range(size + 1)]
        self._own: dict[int, Panel] = {}
        try:
            for i in range(starts[rank], starts[rank + 1]):
                self._own[i] = open_panel(i)
        except BaseException:
            self.close()
            raise
        self._follow = {i: surface_ahead(panel) for i, panel in self._own.items()}
        states = self.exchange({i: panel.initial() for i, panel in self._own.items()})
        mounts = self.exchange({i: panel.mount for i, panel in self._own.items()})
        self.surface = consecutive_slices([len(state.surface) for state in states])
        self.clamps = consecutive_slices([len(mount.frame) for mount in mounts])
        self._initial = concatenate_states(states)
        vectors = [
            (len(s.surface), len(s.surface), len(m.frame)) for s, m in zip(states, mounts, strict=True)
        ]
        self._rows = np.diff(np.cumsum([(0, 0, 0), *vectors], axis=0)[starts], axis=0)  # sent by each rank
        self._groups = [self._group(run) for run in _runs(self._own)]
        self.mount = Mount(
            np.concatenate([mount.position_m for mount in mounts]),
            tuple(frame for mount in mounts for frame in mount.frame),
        )

    def initial(self) -> PanelState:
        return self._initial

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        own = [
            group.advance(interval, clamps.part(group.clamps), load.part(group.surface))
            for group in self._groups
        ]
        return self._exchange_states(own)

    def _group(self, numbers: Sequence[int]) -> Group:
        """Return panels of this rank that can be joined, or a single one, as a group."""
        panels = [self._own[i] for i in numbers]
        advance = _together(panels) if len(panels) > 1 else panels[0].advance
        assert advance is not None, "only panels that can be joined make a run"
        clamps, surface = (
            slice(of[numbers[0]].start, of[numbers[-1]].stop) for of in (self.clamps, self.surface)
        )
        return Group(numbers, clamps, surface, advance)

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        own = {i: ahead(interval, clamps.part(self.clamps[i])) for i, ahead in self._follow.items()}
        parts = self.exchange(own)
        motion = concatenate_motions([part.motion for part in parts])
        return Known(motion, np.concatenate([part.which for part in parts]))

    def inertia(self) -> Inertia:
        parts = self.exchange({i: surface_inertia(panel) for i, panel in self._own.items()})
        return Inertia(
            csr_array(block_diag([part.shapes for part in parts])),
            np.concatenate([part.mass_kg for part in parts]),
            np.concatenate([part.held for part in parts]),
        )

    def account(self) -> Account:
        return sum_accounts(self.exchange({i: panel.account() for i, panel in self._own.items()}))

    def save(self) -> Saved:
        """Return the states of the panels on this rank."""
        return {str(i): panel.save() for i, panel in self._own.items()}

    def restore(self, saved: Saved) -> None:
        for i, panel in self._own.items():
            panel.restore(saved[str(i)])

    def close(self) -> None:
        for panel in self._own.values():
            panel.close()

    def exchange(self, own: Mapping[int, Any]) -> list[Any]:
        """Return the values of all panels, in order, from the ranks that own the panels."""
        parts = self._communicator.allgather(own) if self._communicator else [own]
        return [value for part in parts for value in part.values()]  # ranks have consecutive panels

    def _exchange_states(self, own: Sequence[PanelState]) -> PanelState:
        """Return the state of all panels from those of this rank's groups.

        They go between ranks as plain numbers, since they do in every interval.
        """
        if not self._communicator:
            return concatenate_states(own)
        sent = [np.empty((0, 3)), *(state.surface.position_m for state in own)]
        sent += [state.surface.velocity_m_per_s for state in own]
        sent += [state.reaction.force_N for state in own]
        received = np.empty((self._rows.sum(), 3))
        self._communicator.Allgatherv(np.concatenate(sent), (received, 3 * self._rows.sum(axis=1)))
        parts = np.split(received, np.cumsum(self._rows)[:-1])
        position_m, velocity_m_per_s, force_N = (np.concatenate(parts[kind::3]) for kind in range(3))
        return PanelState(Motion.unchecked(position_m, velocity_m_per_s), Load.unchecked(force_N))


def _runs(panels: Mapping[int, Panel]) -> list[list[int]]:
    """Return the numbers of the panels in runs of such that can be joined; others stand alone."""
    runs: list[list[int]] = []
    for number in panels:
        if runs and _together([panels[i] for i in (*runs[-1], number)]):
            runs[-1].append(number)
        else:
            runs.append([number])
    return runs


def _together(panels: Sequence[Panel]) -> JointAdvance | None:
    """Return the call that advances panels together, or None where they cannot be joined."""
    return panels[0].join(panels) if isinstance(panels[0], Joinable) else None


def consecutive_slices(lengths: Sequence[int]) -> tuple[slice, ...]:
    """Return consecutive slices of the given lengths."""
    ends = np.cumsum([0, *lengths]).tolist()
    return tuple(slice(a, b) for a, b in itertools.pairwise(ends))


def concatenate_states(states: Sequence[PanelState]) -> PanelState:
    """Return one state with the points of all panels, one panel after the other."""
    return PanelState(
        concatenate_motions([s.surface for s in states]),
        Load.unchecked(np.concatenate([s.reaction.force_N for s in states])),
    )


def concatenate_motions(motions: Sequence[Motion]) -> Motion:
    """Return the points of all motions, one after the other."""
    return Motion.unchecked(
        np.concatenate([motion.position_m for motion in motions]),
        np.concatenate([motion.velocity_m_per_s for motion in motions]),
    )


def sum_accounts(accounts: Sequence[Account]) -> Account:
    """Return the sum of accounts, entry by entry, without angular momentum, which no panel reports."""

    def add_entries(name: str) -> Any:
        values = [getattr(account, name) for account in accounts]
        if not isinstance(values[0], Mapping):
            return np.sum(values, axis=0)
        keys = dict.fromkeys(key for value in values for key in value)
        return {key: sum(value.get(key, 0.0) for value in values) for key in keys}

    return Account(**{f.name: add_entries(f.name) for f in fields(Account) if f.name != "angular"})
