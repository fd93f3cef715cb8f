"""What wrappers around a panel are made of: its own calls, some of them altered."""

from __future__ import annotations

from collections.abc import Callable

from orchestrator.ports import Account, Inertia, Known, Load, Motion, Mount, Panel, PanelState, Saved
from orchestrator.ports.clock import Interval
from orchestrator.ports.panel import Ahead, surface_ahead, surface_inertia

Advance = Callable[[Interval, Motion, Load], PanelState]


class AlteredPanel:
    """``panel`` with another ``advance`` and, where given, another ``initial``, ``inertia`` and
    ``ahead``; everything else is its own.  Again a panel."""

    def __init__(
        self,
        panel: Panel,
        advance: Advance,
        initial: Callable[[], PanelState] | None = None,
        inertia: Callable[[], Inertia] | None = None,
        ahead: Ahead | None = None,
    ) -> None:
        self._panel, self._advance = panel, advance
        self._initial = initial or panel.initial
        self._inertia = inertia or (lambda: surface_inertia(panel))
        self._ahead = ahead or surface_ahead(panel)
        self.mount: Mount = panel.mount

    def initial(self) -> PanelState:
        return self._initial()

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        return self._advance(interval, clamps, load)

    def ahead(self, interval: Interval, clamps: Known) -> Known:
        return self._ahead(interval, clamps)

    def inertia(self) -> Inertia:
        return self._inertia()

    def account(self) -> Account:
        return self._panel.account()

    def save(self) -> Saved:
        return self._panel.save()

    def restore(self, saved: Saved) -> None:
        self._panel.restore(saved)

    def close(self) -> None:
        self._panel.close()
