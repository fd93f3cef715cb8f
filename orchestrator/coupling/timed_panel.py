"""A panel that is timed, and named where it fails: again a panel."""

from __future__ import annotations

from orchestrator.coupling.altered_panel import AlteredPanel
from orchestrator.coupling.stopwatch import Stopwatch
from orchestrator.ports import Known, Load, Motion, Panel, PanelState
from orchestrator.ports.ahead import ahead_of
from orchestrator.ports.clock import Interval
from orchestrator.ports.failures import solver_failure_context


def timed(panel: Panel, name: str, part: str, stopwatch: Stopwatch) -> AlteredPanel:
    """The panel says its ``name`` when it fails; its time is booked under ``part``."""
    follow = ahead_of(panel)

    def initial() -> PanelState:
        with solver_failure_context(name, None):
            return panel.initial()

    def advance(interval: Interval, clamps: Motion, load: Load) -> PanelState:
        with stopwatch(part), solver_failure_context(name, interval):
            return panel.advance(interval, clamps, load)

    def ahead(interval: Interval, clamps: Known) -> Known:
        with stopwatch(part), solver_failure_context(name, interval):
            return follow(interval, clamps)

    return AlteredPanel(panel, advance, initial, ahead=ahead)
