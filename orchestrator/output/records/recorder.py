"""The records that a run writes while it goes on: time series, and snapshots for ParaView.

``history.h5`` gets rows of these groups:

- ``frames/<name>`` and ``probes/<name>`` (motion), ``forces/<panel>`` and ``bushings/<name>`` every
  ``output.series_s``;
- ``point_cycles`` and ``panel_cycles`` at the end of every cycle of the machine;
- ``energy_cycles`` at the last sync point of every cycle of the machine;
- ``loads/<frame>`` every ``output.loads_s``;
- ``shapes/<panel>`` every ``output.shapes_s``;
- ``panels/<name>`` (centre line), ``energy``, ``bed`` and the groups of deck_record.py at every output
  time;
- ``fed`` and ``removed`` for each particle that came or went.
"""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import closing
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.bed.grains import shapes
from orchestrator.case.bed.saved_bed import shape_attributes
from orchestrator.case.deck.line import deck_line
from orchestrator.case.deck.openings import half_depths_m, openings_m
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.case import Case
from orchestrator.coupling.ledger import Ledger
from orchestrator.coupling.machine import Machine
from orchestrator.coupling.mpi import is_first
from orchestrator.coupling.schemes.scheme import State
from orchestrator.output.cycles import counted_cycle_s, cycle_number, cycle_s
from orchestrator.output.records.bulk import measure_bulk
from orchestrator.output.records.cycle_record import CycleRecord
from orchestrator.output.records.deck_record import DeckRecord
from orchestrator.output.records.frame_loads import FrameLoadRecord
from orchestrator.output.records.history import COLUMNS, History, columns
from orchestrator.output.records.run_folder import HISTORY, WALLS
from orchestrator.output.records.series import PanelForces, TimeSeries
from orchestrator.output.records.snapshots import (
    Series,
    particle_mesh,
    sphere_mesh,
    surface_mesh,
    walls_mesh,
    write_mesh,
    write_state,
)
from orchestrator.output.records.surface_fields import SurfaceFields
from orchestrator.output.records.wear_record import WearRecord
from orchestrator.ports import Array, Overlaps, ParticleSnapshot, Restorable, Saved
from orchestrator.ports.clock import steps_in
from orchestrator.ports.grains import ShapeTable
from orchestrator.ports.particle_records import BedSnapshot
from orchestrator.ports.state import as_arrays, like


class DeepestOverlaps(Restorable):
    """The deepest overlaps since the last output time."""

    def __init__(self) -> None:
        self._overlaps = Overlaps()

    def add(self, overlaps: Overlaps) -> None:
        """Add the deepest overlaps of some steps."""
        self._overlaps = self._overlaps.deepest(overlaps)

    def take(self) -> Overlaps:
        """Return the deepest overlaps since the last call."""
        taken, self._overlaps = self._overlaps, Overlaps()
        return taken

    def save(self) -> Saved:
        """Return the overlaps for a checkpoint."""
        saved: Saved = as_arrays(self._overlaps)
        return saved

    def restore(self, saved: Saved) -> None:
        """Restore the overlaps that ``save`` returned."""
        self._overlaps = like(Overlaps(), saved)


class Recorder:
    """The recorder of a run, on every rank: snapshots and accounts are collective, and rank 0 writes."""

    def __init__(
        self,
        folder: Path,
        machine: Machine,
        ledger: Ledger,
        start: State,
        case: Case,
        world: Any,
        goes_on: bool = False,
    ):
        """Open the records; with ``goes_on``, continue an earlier process's records after ``restore``."""
        self._machine, self._ledger = machine, ledger
        self._writes = is_first(world)
        self._follows = any(probe.on == "particle" for probe in machine.probes)
        interval_s, shapes_s = case.coupling.sync_interval_s, case.output.shapes_s
        self._interval_s, self._cycle_s = interval_s, counted_cycle_s(case)
        self._every = steps_in(case.output.series_s or interval_s, interval_s)
        self._shapes_every = steps_in(shapes_s, interval_s) if shapes_s else 0
        self._loads_every = steps_in(case.output.loads_s, interval_s) if case.output.loads_s else 0
        if self._writes:
            self._open(folder, start, case, goes_on)

    def _open(self, folder: Path, start: State, case: Case, goes_on: bool) -> None:
        machine = self._machine
        self._history = History(folder / HISTORY, goes_on)
        rectangles = [panel.rectangle for panel in single_panels(case)]
        lines = [panel.centre_line for panel in machine.panels]
        self._forces, self._deepest = PanelForces(machine, start), DeepestOverlaps()
        self._series = TimeSeries(machine, start, self._history)
        self._cycles = CycleRecord(machine, start, rectangles, counted_cycle_s(case), self._history)
        self._loads = FrameLoadRecord(machine, self._history)
        if self._loads_every:
            self._loads.describe({name: row.frame for name, row in case.screen.exciters.items()})
        self._parts: dict[str, Restorable]
        self._parts = {"overlaps": self._deepest, "series": self._series, "cycles": self._cycles}
        self._on_panels = machine.panel_of_triangle >= 0
        self._spheres: Series | None = None
        self._walls = None if self._on_panels.all() else folder / WALLS
        if len(machine.surface.triangles):
            beside = WALLS if self._walls is not None else ""
            surface = Series(folder, "surface", beside, moves=bool(self._on_panels.any()))
            self._parts["surface"] = self._surface = surface
            start_m, triangles = start.panel.surface.position_m, machine.surface.triangles[self._on_panels]
            self._fields = SurfaceFields(start_m, triangles, self._interval_s)
        if self._walls is not None:
            write_mesh(self._walls, walls_mesh(machine.surface, {}))
        if machine.material is not None:
            self._parts["particles"] = self._particles = Series(folder, "particles")
            kinds, exits = ShapeTable.of(shapes(case)), machine.material.exits
            if (kinds.sphere_count > 1).any():
                self._parts["spheres"] = self._spheres = Series(folder, "spheres")
            for kind in ("fed", "removed"):
                for name, values in shape_attributes(kinds).items():
                    self._history.describe(kind, name, values)
            self._history.describe("removed", "names", [exit.name for exit in exits])
            self._history.describe("removed", "products", [exit.product for exit in exits])
        write_state(folder)
        if machine.wearing is not None:
            self._wear = WearRecord(machine.surface, machine.panels, rectangles)
        deck = deck_line([start.panel.surface.position_m[line] for line in lines], half_depths_m(case))
        if deck is not None and machine.material is not None:
            along_deck = [machine.panels[number].name for number, _ in deck.panels]
            self._history.describe("removed", "panels", along_deck)
        self._bulk = case.bulk
        self._deck = DeckRecord(deck, lines, cycle_s(case), openings_m(case)) if deck else None
        if self._deck is not None:
            self._parts["held"] = self._deck.retained

    def record_sync_point(self, done: int, time_s: float, state: State) -> None:
        """Record a sync point; ``done`` is the number of completed sync intervals."""
        if self._writes:
            forces_N = self._forces.at(state)
            self._series.add_forces(forces_N)
            self._cycles.add_sync_point(time_s, state, forces_N)
            if self._shapes_every and done % self._shapes_every == 0:
                for panel in self._machine.panels:
                    values = columns("shapes", state.panel.surface.part(panel.shape))
                    self._history.add(f"shapes/{panel.name}", time_s, values)
            if self._loads_every and done and done % self._loads_every == 0:
                self._loads.write_row(time_s)
        if self._ends_cycle(time_s):
            terms = self._ledger.energy_J()
            if self._writes:
                self._history.add("energy_cycles", time_s, _with_unit(terms))
        if done % self._every:
            return
        particles = self._machine.solvers.particles
        followed = particles.snapshot() if self._follows and particles is not None else None
        if self._writes:
            self._series.write_row(time_s, state, followed)

    def book(self, time_s: float) -> tuple[dict[str, float], BedSnapshot | None]:
        """Bring the books up to date: the energy ledger's terms, and the particles that came and went.

        Return the terms and the bed (None without particles), with the deepest overlaps since the last call.
        """
        terms_J = self._ledger.energy_J()
        particles, book = self._machine.solvers.particles, self._machine.material
        if particles is None or book is None:
            return terms_J, None
        present, removed, fed = particles.snapshot(), particles.removed(), book.feed.take_fed()
        overlaps = particles.overlaps()
        book.look_at_contacts(overlaps, particles.crossings())
        if self._writes:
            self._deepest.add(overlaps)
            for kind, table in (("fed", fed), ("removed", removed)):
                values = vars(table) | vars(table.grains)
                self._history.add_events(kind, {name: values[name] for name in ("time_s", *COLUMNS[kind])})
            book.add(time_s, fed, removed, present)
        return terms_J, BedSnapshot(present, overlaps)

    def record_output(
        self,
        time_s: float,
        state: State,
        before: State,
        terms_J: Mapping[str, float],
        bed: BedSnapshot | None,
    ) -> None:
        """Record an output time, with the books of ``book``: shapes, books, and files for ParaView.

        ``before`` is the state at the sync point before it, or the same state at t = 0.
        """
        machine, surface = self._machine, state.panel.surface
        worn_m3 = None if machine.wearing is None else machine.wearing.worn_m3()
        if not self._writes:
            return
        self._history.add("energy", time_s, _with_unit(terms_J))
        for panel in machine.panels:
            line_m = surface.position_m[panel.centre_line]
            self._history.add(f"panels/{panel.name}", time_s, {"centre_line_m": line_m})
        if len(machine.surface.triangles):
            triangles, panels = (
                each[self._on_panels] for each in (machine.surface.triangles, machine.panel_of_triangle)
            )
            at_points = self._fields.at_points(surface, before.panel.surface, state.load)
            if worn_m3 is not None:
                self._add_groups(time_s, self._wear.groups(worn_m3))
                at_points["worn_depth_m"] = depth_m = self._wear.vertex_depth_m(worn_m3)
                if self._walls is not None:
                    write_mesh(self._walls, walls_mesh(machine.surface, {"worn_depth_m": depth_m}))
            stretch = {"stretch_percent": self._fields.stretch_percent(surface)}
            self._surface.add(time_s, surface_mesh(surface, triangles, panels, at_points, stretch))
        if bed is not None and machine.material is not None:
            particles = bed.particles
            self._history.add("overlaps", time_s, columns("overlaps", self._deepest.take()))
            for feed in machine.material.feed.feeds:
                self._history.add(f"feeds/{feed.inlet.name}", time_s, columns("feeds", feed))
            self._history.add("bed", time_s, _describe_bed(particles))
            for name, box in self._bulk.items():
                self._history.add(f"bulk/{name}", time_s, measure_bulk(box, particles))
            if self._deck is not None:
                self._add_groups(time_s, self._deck.at(time_s, surface, particles))
            self._particles.add(time_s, particle_mesh(particles))
            if self._spheres is not None:
                self._spheres.add(time_s, sphere_mesh(particles))
        self._history.flush()

    def _ends_cycle(self, time_s: float) -> bool:
        """Return whether the next sync point belongs to another cycle, or this one is the start."""
        here, then = (cycle_number(at_s, self._cycle_s) for at_s in (time_s, time_s + self._interval_s))
        return time_s == 0.0 or here != then

    def _add_groups(self, time_s: float, groups: Mapping[str, Mapping[str, Array | float]]) -> None:
        for group, values in groups.items():
            self._history.add(group, time_s, values)

    def book_last_contacts(self) -> None:
        """Book the contacts since the last output time if a run ends between output times; collective."""
        particles, book = self._machine.solvers.particles, self._machine.material
        if particles is not None and book is not None:
            book.look_at_contacts(particles.overlaps(), particles.crossings())

    def material_balance(self) -> dict[str, Any] | None:
        """Return the material's balance at the last output time, on rank 0; None without particles."""
        book = self._machine.material
        return book.figures() if book is not None else None

    def save(self) -> Saved:
        """Write all rows to the disk, and return the memory on which later rows depend."""
        if not self._writes:
            return {}
        self._history.flush()
        return {name: part.save() for name, part in self._parts.items()}

    def restore(self, saved: Saved) -> None:
        """Restore the memory that ``save`` returned."""
        if self._writes:
            for name, part in self._parts.items():
                part.restore(saved[name])

    def close(self) -> None:
        """Write the rows that are still in memory, and close the file."""
        if self._writes:
            with closing(self._history):
                self._cycles.close()


def _with_unit(terms_J: Mapping[str, float]) -> dict[str, float]:
    return {f"{name}_J": value for name, value in terms_J.items()}


def _describe_bed(particles: ParticleSnapshot) -> dict[str, Any]:
    mass = particles.grains.mass_kg
    speed = np.linalg.norm(particles.velocity_m_per_s, axis=1)
    count = len(mass)
    return {
        "particles": float(count),
        "mass_kg": float(mass.sum()),
        "mean_speed_m_per_s": float(mass @ speed / mass.sum()) if count else 0.0,
        "mean_velocity_m_per_s": mass @ particles.velocity_m_per_s / mass.sum() if count else np.zeros(3),
        "highest_m": float(particles.position_m[:, 2].max()) if count else np.nan,
    }
