"""The rows of panels in deck axes: which panel follows which, and where rows begin and end."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from orchestrator.case.deck.panels import SinglePanel, axes, single_panels
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array


@dataclass(frozen=True)
class PlacedPanel:
    """A panel in deck axes, seen in the direction of flow.

    ``upper_m`` and ``lower_m`` (3,) are the middles of its outer edges under the clamps, ``along`` (3,)
    leads from one to the other, and ``frames`` names the frames of the upper and of the lower clamp.
    """

    panel: SinglePanel
    upper_m: Array
    lower_m: Array
    along: Array
    across: Array
    frames: tuple[str, str]

    @property
    def name(self) -> str:
        """The panel's name."""
        return self.panel.name

    @property
    def width_m(self) -> float:
        """The panel's width."""
        return self.panel.rectangle.width_m

    @property
    def normal(self) -> Array:
        """The unit normal (3,) on the side of the particles."""
        normal = np.cross(self.along, self.across)
        return np.asarray(-normal if normal[2] < 0 else normal)

    def point_m(self, along: float, across: float) -> Array:
        """Return a point (3,) by its shares of the whole length and of the width."""
        middle_m = self.upper_m + along * (self.lower_m - self.upper_m)
        return np.asarray(middle_m + (across - 0.5) * self.width_m * self.across)


@dataclass(frozen=True)
class Joint:
    """Two panels one behind the other."""

    upper: PlacedPanel
    lower: PlacedPanel

    @property
    def gap_m(self) -> Array:
        """The vector (3,) from the lower edge of the upper panel to the upper edge of the lower panel."""
        return np.asarray(self.lower.upper_m - self.upper.lower_m)

    @property
    def name(self) -> str:
        """The names of both panels."""
        return f"{self.upper.name} and {self.lower.name}"


@dataclass(frozen=True)
class PanelRows:
    """All panels of a case, the joints between them, and the panels at which rows begin and end."""

    panels: tuple[PlacedPanel, ...]
    joints: tuple[Joint, ...]

    @property
    def first(self) -> tuple[PlacedPanel, ...]:
        """The panels that follow no other."""
        followers = {joint.lower.name for joint in self.joints}
        return tuple(panel for panel in self.panels if panel.name not in followers)

    @property
    def last(self) -> tuple[PlacedPanel, ...]:
        """The panels that no other follows."""
        followed = {joint.upper.name for joint in self.joints}
        return tuple(panel for panel in self.panels if panel.name not in followed)


def panel_rows(case: Case) -> PanelRows:
    """Return the rows of a case.

    A panel follows another if its upper edge is the nearest one, nearer to the other's lower edge than a
    panel's length, and the two overlap across.
    """
    panels = tuple(_place(case, panel) for panel in single_panels(case))
    joints = []
    for panel in panels:
        reach_m = float(np.linalg.norm(panel.lower_m - panel.upper_m))
        near = [
            (float(np.linalg.norm(other.upper_m - panel.lower_m)), number)
            for number, other in enumerate(panels)
            if other is not panel
            and abs((other.upper_m - panel.lower_m) @ panel.across) < (panel.width_m + other.width_m) / 2
        ]
        distance_m, number = min(near, default=(np.inf, -1))
        if distance_m < reach_m:
            joints.append(Joint(panel, panels[number]))
    return PanelRows(panels, tuple(joints))


def _place(case: Case, panel: SinglePanel) -> PlacedPanel:
    r = panel.rectangle
    ends = np.array([[-r.clamp_m, r.width_m / 2], [r.length_m + r.clamp_m, r.width_m / 2]])
    first_m, last_m = r.mounted(ends) @ axes(case)
    along, across = r.along @ axes(case), r.across @ axes(case)
    if along[0] < 0:
        return PlacedPanel(panel, last_m, first_m, -along, across, panel.frames[::-1])
    return PlacedPanel(panel, first_m, last_m, along, across, panel.frames)
