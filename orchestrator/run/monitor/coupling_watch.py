"""What is looked at after every interval: energy created by the coupling, and modes that grow."""

from __future__ import annotations

from orchestrator.case.tables.case import Case
from orchestrator.coupling.machine import Machine
from orchestrator.coupling.schemes.exchange import State
from orchestrator.ports import Saved
from orchestrator.run.monitor.created_energy import ClampWork, ContactWork
from orchestrator.run.monitor.growing_modes import Alternation
from orchestrator.run.monitor.interface_data import Crossed
from orchestrator.run.monitor.limits import Figures

PARTICLES, FRAMES = "particles and panels", "panels and frames"
INTERFACES = {PARTICLES: "particles-panel", FRAMES: "panel-frames"}  # by their names in the ledger


class CouplingWatch:
    """Of the panels, which come before all else of the surface.  Interfaces whose hand-over is
    turned off are not looked at: their energy does not close."""

    def __init__(self, case: Case, machine: Machine, start: State) -> None:
        self._surface = slice(0, max((one.surface.stop for one in machine.panels), default=None))
        clamps = slice(0, max((one.clamps.stop for one in machine.panels), default=None))
        handed = case.exchange
        self._works: dict[str, ContactWork | ClampWork] = {}
        if machine.members.particles is not None and handed.panel_motion and handed.particle_load:
            self._works[PARTICLES] = ContactWork(start, self._surface)
        if handed.frame_motion and handed.panel_reaction:
            self._works[FRAMES] = ClampWork(start, clamps)
        least = case.monitor.largest_growing_share
        self._modes = Alternation(start.panel.surface.velocity_m_per_s[self._surface], least)

    def add(self, crossed: Crossed) -> None:
        """An interval's."""
        for work in self._works.values():
            work.add(crossed)
        self._modes.add(crossed.panel[2].surface.velocity_m_per_s[self._surface])

    def look(self, figures: Figures, time_s: float) -> None:
        for where, work in self._works.items():
            figures.look("created_energy", work.balance.recently(), time_s, where)
        figures.look("growing_modes", self._modes.share(), time_s)

    def exchanged_J(self) -> dict[str, float]:
        """By interface, as the ledger names it: the scale for energy created there."""
        return {INTERFACES[where]: work.exchange.scale_J for where, work in self._works.items()}

    def begin_anew(self) -> None:
        """Intervals are of another length from now on."""
        for work in self._works.values():
            work.begin_anew()
        self._modes.begin_anew()

    def save(self) -> Saved:
        works = {where: work.save() for where, work in self._works.items()}
        return {"works": works, "modes": self._modes.save()}

    def restore(self, saved: Saved) -> None:
        for where, work in self._works.items():
            work.restore(saved["works"][where])
        self._modes.restore(saved["modes"])
