"""Panels around a compiled body, which one call advances together with others of their kind."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Sequence
from typing import Any

import numpy as np

from adapters.panel.common.compiled_body import CompiledBody, kernel
from adapters.panel.common.panel import BodyPanel
from orchestrator.ports import Account, Load, Motion, Panel, PanelState, check_point_count
from orchestrator.ports.clock import Interval
from orchestrator.ports.panel import JointAdvance


class CompiledPanel(BodyPanel):
    """A panel whose body is compiled, and advances surface, reaction and works in one call for all panels.

    The body itself has the motion of surface and clamps, and their work; ``_surface`` and ``_clamps`` are
    those of t = 0.  ``_move`` of a subclass has the same equations in Python, with which the tests compare
    the compiled ones.
    """

    STATE = ("_elapsed_s",)
    _body: CompiledBody

    def advance(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        return CompiledPanels([self])(interval, clamps, load)

    def join(self, panels: Sequence[Panel]) -> JointAdvance | None:
        """Return the call that advances ``panels`` together, or None where one of them is of another kind."""
        alike = [panel for panel in panels if isinstance(panel, type(self))]
        return CompiledPanels(alike) if len(alike) == len(panels) else None

    def account(self) -> Account:
        self._received_J = dict(
            zip(("load", "clamps"), self._body.memory["received_J"].tolist(), strict=True)
        )
        return super().account()

    @abstractmethod
    def _check(self, interval: Interval, found: Any) -> None:
        """Raise SolverFailed if ``found``, what the compiled code says of the body, shows a blow-up."""


class CompiledPanels:
    """Panels of one kind that one compiled call advances."""

    def __init__(self, panels: Sequence[CompiledPanel]) -> None:
        self._panels = panels
        self._bodies = [panel._body.kernel for panel in panels]
        self._clamp_points = sum([len(panel._clamps.position_m) for panel in panels])
        self._surface_points = sum([len(panel._surface.position_m) for panel in panels])
        self._length_s, self._steps = 0.0, [0]  # of the interval before

    def __len__(self) -> int:
        return len(self._panels)

    def __call__(self, interval: Interval, clamps: Motion, load: Load) -> PanelState:
        """Advance the panels over an interval.

        Clamps, load and the state returned have one panel after the other.  Raises SolverFailed.
        """
        check_point_count("panels: clamps", clamps, self._clamp_points)
        check_point_count("panels: load", load, self._surface_points)
        if interval.length_s != self._length_s:
            self._length_s = interval.length_s
            self._steps = [interval.steps(panel._body.step_s) for panel in self._panels]
        surface_m, surface_m_per_s = np.empty((2, *load.force_N.shape))
        reaction_N = np.empty_like(clamps.position_m)
        found = kernel.advance_together(
            self._bodies,
            clamps_m=np.ascontiguousarray(clamps.position_m),
            clamps_m_per_s=np.ascontiguousarray(clamps.velocity_m_per_s),
            load_N=np.ascontiguousarray(load.force_N),
            length_s=interval.length_s,
            steps=self._steps,
            surface_m=surface_m,
            surface_m_per_s=surface_m_per_s,
            reaction_N=reaction_N,
        )
        for panel, of_panel in zip(self._panels, found, strict=True):
            panel._check(interval, of_panel)
            panel._elapsed_s += interval.length_s
        return PanelState(Motion(surface_m, surface_m_per_s), Load(reaction_N))
