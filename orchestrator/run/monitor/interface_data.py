"""What crossed both interfaces in an interval, as the members' meters have it: of any scheme."""

from __future__ import annotations

from typing import NamedTuple

from orchestrator.coupling.ledger import Members
from orchestrator.ports import Load, Motion, PanelState
from orchestrator.ports.hermite import Path


class Crossed(NamedTuple):
    """Of an interval of ``length_s``: the frames' load and motion; where the panels' clamps were
    told to go, under which load, and what came of it; the particles' path and load, None without
    any."""

    length_s: float
    frames: tuple[Load, Motion]
    panel: tuple[Motion, Load, PanelState]
    particles: tuple[Path, Load] | None


def crossed(members: Members, length_s: float) -> Crossed:
    """In the interval that the members have just ended."""
    particles = members.particles.last if members.particles is not None else None
    return Crossed(length_s, members.frames.last, members.panel.last, particles)
