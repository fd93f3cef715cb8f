"""The items of the monitor, and the search for them.

Each item class here is a quantity that a run observes.  Installed packages add items by an entry
point of the group ``flipflow.monitor``.  A case gives the limit of an item in
``[monitor.items.<name>]``; items that every case has (with a ``limit_key``) are keys of ``[monitor]``
itself.
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import entry_points
from inspect import isclass
from math import sqrt
from typing import NamedTuple

import numpy as np

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.errors import CaseProblem, did_you_mean
from orchestrator.case.solver_plans import particle_step_s
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.numerics import MonitorSettings, Then
from orchestrator.coupling._kernel import sizes_and_changes
from orchestrator.coupling.ledger import created_shares
from orchestrator.coupling.schemes.scheme import State
from orchestrator.output.records.panel_lines import FOLD_LENGTHS, find_fold_m
from orchestrator.ports import Array, Indices, InterfaceData, Saved
from orchestrator.ports.state import SavedAttributes
from orchestrator.run.monitor.interface_work import SLOW_M_PER_S, exchanged_J
from orchestrator.run.monitor.item import Books, MonitorItem, Observation, Subject


class CreatedEnergy(MonitorItem):
    """The energy created at each interface over the energy that went through in some twenty intervals."""

    name = "created_energy"
    limit_key = "largest_created_share"
    message = (
        "the coupling creates or destroys energy between {where}: {value:.2g} of what went through "
        "in the last intervals"
    )

    def observe(self) -> Iterator[Observation]:
        for where, work in self.subject.works.items():
            yield Observation(work.balance.recent_share(), where)


class CreatedInTotal(MonitorItem):
    """The energy created at each interface over the energy exchanged or lost there since t = 0."""

    name = "created_in_total"
    limit_key = "largest_created_in_total"
    message = (
        "the coupling has created or destroyed energy ({where}): {value:.2g} of all that went "
        "through or was lost there"
    )

    def observe_books(self, books: Books) -> Iterator[Observation]:
        shares = created_shares(books.terms_J, exchanged_J(self.subject.works))
        for interface, share in shares.items():
            yield Observation(abs(share), interface)


class CrossedSurface(MonitorItem):
    """The number of times that a particle went through the surface other than through an opening."""

    name = "crossed_surface"
    limit_key = "most_crossings"
    message = (
        "{value:.0f} times a particle went through the surface, its centre to the other side, the "
        "first time {where}: contacts too soft (particles.largest_youngs_modulus_Pa) or steps too "
        "long"
    )

    def observe(self) -> Iterator[Observation]:
        particles = self.subject.machine.solvers.particles
        if particles is not None and (crossings := particles.crossings()).number:
            yield Observation(crossings.number, crossings.first_in_words())


class DeepOverlaps(MonitorItem):
    """The deepest overlap of a contact, over the smaller radius."""

    name = "deep_overlaps"
    limit_key = "largest_overlap"
    message = "particles overlap by {value:.2g} of a radius: contacts too soft or steps too long"

    def observe_books(self, books: Books) -> Iterator[Observation]:
        if books.bed is not None and len(books.bed.particles.id):
            overlaps = books.bed.overlaps
            yield Observation(2 * max(overlaps.between_per_diameter, overlaps.surface_per_diameter))


TURNS = 8  # reversals in succession that make a mode
ROUND = 0.8  # least cosine between a change and the reversed change before it
GROWTH = 2.0  # least growth of the changes over the reversals


class Alternation(SavedAttributes):
    """A detector of surface points whose velocity (points, 3) alternates between sync points and grows.

    A coupling that is unstable on a light point leaves the unit circle at -1
    (docs/theory/stability.md): the velocity of the point changes its sign with every interval, and grows.
    The second difference of three velocities is four times as large as an alternating velocity.  Of a
    smooth motion it is only the share (w H)^2.  A point belongs to a growing mode if its second difference
    reverses again and again and is larger each time.  A ringing decays between two blows instead.
    The points are examined one by one only if a point alternates with the share ``least`` of the
    surface's speed.
    """

    STATE = (
        "_now_m_per_s",
        "_before_m_per_s",
        "_twice_before_m_per_s",
        "_first",
        "_turns",
        "_quick_m_per_s",
        "_growing_m_per_s",
    )

    def __init__(self, velocity_m_per_s: Array, least: float) -> None:
        self._least = least
        self._quick_m_per_s, self._growing_m_per_s = SLOW_M_PER_S, 0.0
        self._begin(velocity_m_per_s)

    def _begin(self, velocity_m_per_s: Array) -> None:
        self._now_m_per_s = self._before_m_per_s = self._twice_before_m_per_s = velocity_m_per_s
        self._first: Array = np.zeros(len(velocity_m_per_s))
        self._turns: Indices = np.zeros(len(velocity_m_per_s), dtype=np.int64)

    def add(self, velocities_m_per_s: list[Array]) -> None:
        """Add the velocities (points, 3) at successive sync points."""
        last = [self._twice_before_m_per_s, self._before_m_per_s, self._now_m_per_s, *velocities_m_per_s]
        points = max(1, len(self._now_m_per_s))
        for number, (squares, change_m_per_s) in enumerate(sizes_and_changes(last[1:])):
            self._quick_m_per_s = max(self._quick_m_per_s, sqrt(squares / points))
            if change_m_per_s > 4 * self._least * self._quick_m_per_s:
                self._count(np.diff(last[number : number + 4], n=2, axis=0))
            else:
                self._growing_m_per_s = 0.0
                self._turns.fill(0)
        self._twice_before_m_per_s, self._before_m_per_s, self._now_m_per_s = last[-3:]

    def _count(self, changes_m_per_s: Array) -> None:
        """Count the successive reversals of each point, and find the fastest growing point.

        ``changes_m_per_s`` (2, points, 3) are the last two second differences.
        """
        before, square = np.einsum("nij,nij->ni", changes_m_per_s, changes_m_per_s)
        along = np.einsum("ij,ij->i", *changes_m_per_s)
        turned = (along < -ROUND * np.sqrt(square * before)) & (square > before)
        self._turns = (self._turns + 1) * turned
        self._first = np.where(self._turns > 1, self._first, square)
        grows = (self._turns >= TURNS) & (square > GROWTH**2 * self._first)
        self._growing_m_per_s = float(np.sqrt(square[grows].max(initial=0.0))) / 4

    def share(self) -> float:
        """Return the speed of the fastest point that alternates and grows, over the surface's largest speed.

        The speed of the surface is the root mean square over its points, and the largest so far counts.
        """
        return self._growing_m_per_s / self._quick_m_per_s

    def begin_anew(self) -> None:
        """Forget recent intervals: the next ones have another length."""
        self._growing_m_per_s = 0.0
        self._begin(self._now_m_per_s)


def square_sum(values: Array) -> float:
    """Return the sum of the squares of values (any shape)."""
    flat = values.ravel()
    return float(flat.dot(flat))


def lengths(vectors: Array) -> Array:
    """Return the lengths (n,) of vectors (n, 3), equal to NumPy's ``norm`` to the bit and in less time."""
    x, y, z = vectors.T
    return np.asarray(np.sqrt(x * x + y * y + z * z))


class GrowingModes(MonitorItem):
    """The largest speed of a point that alternates and grows, over the panels' largest speed so far."""

    name = "growing_modes"
    limit_key = "largest_growing_share"
    message = (
        "a mode of the interface grows: a point alternates from interval to interval with "
        "{value:.2g} of the surface's largest speed so far"
    )

    def __init__(self, subject: Subject) -> None:
        super().__init__(subject)
        self._panels = slice(0, max((panel.surface.stop for panel in subject.machine.panels), default=None))
        velocity_m_per_s = subject.start.panel.surface.velocity_m_per_s[self._panels]
        self._modes = Alternation(velocity_m_per_s, subject.case.monitor.largest_growing_share)

    def add_intervals(self, intervals: list[InterfaceData]) -> None:
        self._modes.add([data.panel[2].surface.velocity_m_per_s[self._panels] for data in intervals])

    def observe(self) -> Iterator[Observation]:
        yield Observation(self._modes.share())

    def begin_anew(self) -> None:
        self._modes.begin_anew()

    def save(self) -> Saved:
        return self._modes.save()

    def restore(self, saved: Saved) -> None:
        self._modes.restore(saved)


class LongSteps(MonitorItem):
    """The longest motion in a particle step: of a particle over its own radius, and of the surface over the
    smallest radius."""

    name = "long_steps"
    limit_key = "largest_step_share"
    message = "{where} moves in a particle step by {value:.2g} of a radius"

    def __init__(self, subject: Subject) -> None:
        super().__init__(subject)
        self._step_s = particle_step_s(subject.case)

    def observe_books(self, books: Books) -> Iterator[Observation]:
        if books.bed is None or not len(books.bed.particles.id):
            return
        particles, surface = books.bed.particles, books.state.panel.surface
        radius_m = particles.grains.contact_radius_m
        share = self._step_s * lengths(particles.velocity_m_per_s) / radius_m
        farthest = int(np.argmax(share))
        yield Observation(float(share[farthest]), f"particle {particles.id[farthest]}")
        fastest_m_per_s = lengths(surface.velocity_m_per_s).max(initial=0.0)
        yield Observation(float(self._step_s * fastest_m_per_s / radius_m.min()), "the surface")


class PenetratedSurfaces(MonitorItem):
    """The deepest penetration of a panel into a surface, in thicknesses of the panel."""

    name = "penetrated_surfaces"
    limit_key = "largest_penetration"
    message = (
        "panel {where} by {value:.3g} of its thickness, and nothing holds it there: tighten it, "
        "move one of them, or give the panel a stop"
    )

    def observe_surface(self, state: State) -> Iterator[Observation]:
        through = self.subject.machine.penetrations.deepest(state.panel.surface.position_m)
        if through is not None:
            yield Observation(through.thicknesses, f"{through.panel} has gone through {through.surface}")


class FoldedPanels(MonitorItem):
    """Panels whose middle line comes nearer to itself than their thickness: 1 for each."""

    name = "folded_panels"
    fixed_limit = 0.0
    message = "{where}, and no solver here knows that it touches itself"

    def __init__(self, subject: Subject) -> None:
        super().__init__(subject)
        self._thickness_m = {panel.name: panel.table.thickness_m for panel in single_panels(subject.case)}
        lines = [panel.centre_line for panel in subject.machine.panels]
        self._ends = np.concatenate([np.empty((0, 2), int), *(np.c_[line[:-1], line[1:]] for line in lines)])
        self._chords = np.array([line[[0, -1]] for line in lines], int).reshape(-1, 2)
        self._pieces = [len(line) - 1 for line in lines]

    def observe_surface(self, state: State) -> Iterator[Observation]:
        position_m = state.panel.surface.position_m
        piece_m, chord_m = (
            position_m[ends[:, 1]] - position_m[ends[:, 0]] for ends in (self._ends, self._chords)
        )
        along = np.einsum("ij,ij->i", piece_m, np.repeat(chord_m, self._pieces, axis=0))
        if (FOLD_LENGTHS * along > lengths(piece_m) * np.repeat(lengths(chord_m), self._pieces)).all():
            return  # no line turns back so far that it could touch itself
        for panel in self.subject.machine.panels:
            thickness_m = self._thickness_m[panel.name]
            at_m = find_fold_m(position_m[panel.centre_line], thickness_m)
            if at_m is not None:
                where = (
                    f"panel {panel.name} has folded into itself: its line {at_m[0]:.3g} m and {at_m[1]:.3g}"
                    f" m from its first clamp is nearer than its thickness of {thickness_m:.3g} m"
                )
                yield Observation(1.0, where)


class StretchedPanels(MonitorItem):
    """The largest stretch of an edge of the panels' triangles."""

    name = "stretched_panels"
    limit_key = "largest_stretch"
    message = "panel {where} is stretched by {value:.2g} of its length"

    def __init__(self, subject: Subject) -> None:
        super().__init__(subject)
        panels = subject.machine.panels
        self._edges = np.concatenate([np.empty((0, 2), int), *(panel.edges for panel in panels)])
        self._length_m = np.concatenate([np.empty(0), *(panel.edge_length_m for panel in panels)])
        self._panel = np.repeat([panel.name for panel in panels], [len(panel.edges) for panel in panels])

    def observe_surface(self, state: State) -> Iterator[Observation]:
        if len(self._edges):
            worst, stretch = largest_stretch(self._edges, self._length_m, state.panel.surface.position_m)
            yield Observation(stretch, str(self._panel[worst]))


def largest_stretch(edges: Indices, length_m: Array, position_m: Array) -> tuple[int, float]:
    """Return the number and the strain of the most stretched edge.

    ``edges`` (n, 2) are pairs of the points at ``position_m``, and ``length_m`` (n,) are the stress-free
    lengths.
    """
    ratio = lengths(position_m[edges[:, 1]] - position_m[edges[:, 0]]) / length_m
    worst = int(ratio.argmax())
    return worst, float(ratio[worst]) - 1.0


class ItemLimit(NamedTuple):
    """The limit of an item in a case, with the reaction beyond it; ``given`` is the case's key for it."""

    then: Then
    limit: float
    given: str


def all_items() -> dict[str, type[MonitorItem]]:
    """Return every item class by its name: first from this file, then from installed packages."""
    classes = [kind for kind in globals().values() if isclass(kind) and issubclass(kind, MonitorItem)]
    classes += [point.load() for point in entry_points(group="flipflow.monitor")]
    return {kind.name: kind for kind in classes if kind is not MonitorItem}


def item_limit(settings: MonitorSettings, kind: type[MonitorItem]) -> ItemLimit | None:
    """Return the limit of an item in ``[monitor]``, or None if the case does not name the item."""
    if kind.fixed_limit is not None:
        return ItemLimit(getattr(settings, kind.name), kind.fixed_limit, f"monitor.{kind.name}")
    if kind.limit_key:
        limit = getattr(settings, kind.limit_key)
        return ItemLimit(getattr(settings, kind.name), limit, f"monitor.{kind.limit_key} = {limit:g}")
    table = settings.items.get(kind.name)
    if table is None:
        return None
    return ItemLimit(table.then, table.limit, f"monitor.items.{kind.name}.limit = {table.limit:g}")


def unknown_items(case: Case) -> list[CaseProblem]:
    """Return a problem for each table ``[monitor.items.<name>]`` whose item does not exist."""
    if not case.monitor.items:
        return []
    names = [
        name for name, kind in all_items().items() if not (kind.limit_key or kind.fixed_limit is not None)
    ]
    return [
        CaseProblem(
            ("monitor", "items", name),
            f'there is no item "{name}" of the monitor',
            did_you_mean(name, names) if names else "docs/how-to/add-a-monitor-item.md adds one",
            kind="unknown-name",
        )
        for name in case.monitor.items
        if name not in names
    ]
