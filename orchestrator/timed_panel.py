"""A panel that is timed, and named where it fails: again a panel."""

from __future__ import annotations

from orchestrator.clock import Interval
from orchestrator.inertia import inertia_of
from orchestrator.naming import named
from orchestrator.ports import Account, Inertia, Load, Motion, Mount, Panel, PanelState, Saved
from orchestrator.state import restorable
from orchestrator.stopwatch import Stopwatch


class TimedPanel:
    """A panel that says its name when it fails; its time is booked under ``part``."""

    def __init__(self, panel: Panel, name: str, part: str, stopwatch: Stopwatch) -> None:
        self._panel, self._name, self._part, self._stopwatch = panel, name, part, stopwatch
        self.mount: Mount = panel.mount

    def initial(self) -> PanelState:
        with named(self._name, None):
            return self._panel.initial()

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        with self._stopwatch(self._part), named(self._name, interval):
            return self._panel.advance(interval, clamps, load)

    def inertia(self) -> Inertia:
        return inertia_of(self._panel)

    def account(self) -> Account:
        return self._panel.account()

    def save(self) -> Saved:
        return restorable(self._panel).save()

    def restore(self, saved: Saved) -> None:
        restorable(self._panel).restore(saved)

    def close(self) -> None:
        self._panel.close()
