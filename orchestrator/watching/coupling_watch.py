"""What is looked at after every interval: energy created by the coupling, and modes that grow."""

from __future__ import annotations

from orchestrator.coupling import State
from orchestrator.ledger import Members
from orchestrator.ports import Saved
from orchestrator.tables.numerics import HandOver
from orchestrator.watching.alternation import Alternation
from orchestrator.watching.created_energy import ClampWork, ContactWork
from orchestrator.watching.figures import Figures

PARTICLES, FRAMES = "particles and panels", "panels and frames"


class CouplingWatch:
    """Interfaces whose hand-over is turned off are not looked at: their energy does not close."""

    def __init__(self, handed: HandOver, members: Members, start: State) -> None:
        self._members = members
        self._works: dict[str, ContactWork | ClampWork] = {}
        if members.particles is not None and handed.panel_motion and handed.particle_load:
            self._works[PARTICLES] = ContactWork(start)
        if handed.frame_motion and handed.panel_reaction:
            self._works[FRAMES] = ClampWork(start)
        self._modes = Alternation(start.panel.surface.velocity_m_s)

    def add(self, length_s: float, state: State) -> None:
        """The interval of ``length_s`` that the members have just ended."""
        for work in self._works.values():
            work.add(self._members, length_s)
        self._modes.add(state.panel.surface.velocity_m_s)

    def look(self, figures: Figures, time_s: float) -> None:
        for where, work in self._works.items():
            figures.look("created_energy", work.balance.recently(), time_s, where)
            figures.look("created_in_total", work.balance.in_total(), time_s, where)
        figures.look("growing_modes", self._modes.share(), time_s)

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
