"""What a run tells of its scene, in the place of what was estimated."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal


@dataclass(frozen=True)
class Shape:
    """A panel in a run: largest height of its arch, range of that height, largest mean strain."""

    sag_m: float
    travel_m: float
    strain: float


@dataclass(frozen=True)
class Seen:
    """None where the run does not tell.

    ``frames_throw``: throw intensity of the frame that moves most normal to the deck; with it,
    the scene's panels have the strokes and, where they bend, the shapes of the run.
    ``bed_kg_m2``: largest mass on the deck per area.  ``rotation`` and
    ``sideways``: displacement of a frame's outermost clamp by rotation, and out of the vertical
    plane, over its translation, and words about it.  ``transport_m_s``: speed of the bed along the
    deck.
    """

    frames_throw: float | None = None
    bed_kg_m2: float | None = None
    rotation: tuple[float, str] | None = None
    sideways: tuple[float, str] | None = None
    transport_m_s: float | None = None


What = Literal["frames_throw", "bed_kg_m2", "rotation", "sideways", "transport_m_s"]
