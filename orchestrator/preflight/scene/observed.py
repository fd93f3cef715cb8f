"""What a run tells of its scene, in the place of what was estimated."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Shape:
    """A panel in a run: largest height of its arch, range of that height, largest mean strain."""

    sag_m: float
    travel_m: float
    strain: float


@dataclass(frozen=True)
class Bearing:
    """How particles bear on the panels in the mean: force normal to them over the weight that
    would lie on them (``carried``), and force down the deck over the normal one (``mobilised``,
    None in a run without friction)."""

    carried: float
    mobilised: float | None


@dataclass(frozen=True)
class Deepest:
    """The largest overlap in any step of the particles, over a particle's diameter, and the largest
    of those with the surface in m."""

    per_diameter: float
    surface_m: float


@dataclass(frozen=True)
class Products:
    """The mean diameter of the coarsest product over that of the finest, and words about it."""

    ratio: float
    words: str


@dataclass(frozen=True)
class Turned:
    """The mean power of the exciters on the frames, and the largest of a cycle during the run-up over
    the speed that the shafts had then: the torque."""

    power_W: float
    largest_N_m: float


@dataclass(frozen=True)
class Observed:
    """The numbers of a run; each is None where the run does not tell.

    ``frames_throw`` is the throw intensity of the frame that moves most normal to the deck; with it,
    the scene's panels have the strokes and, where they bend, the shapes of the run.
    ``bed_kg_per_m2`` is the largest mass on the deck per area.  ``rotation`` and ``sideways`` are the
    displacement of a frame's outermost clamp by rotation, and out of the vertical plane, over its
    translation, with words about it.  ``transport_m_per_s`` is the speed of the bed along the deck.
    ``panels_N_per_m`` is the stiffness of all panels along themselves, pull over stretch; with it
    the scene's springs have the run's, and ``shaken`` is the frames' motion with them.
    ``loss_factor`` is the largest of the panels', at the frequencies of their pull.  ``closed`` says
    that the panels of the run have no openings.  ``turned`` is what the run's exciters took.
    """

    frames_throw: float | None = None
    bed_kg_per_m2: float | None = None
    rotation: tuple[float, str] | None = None
    sideways: tuple[float, str] | None = None
    transport_m_per_s: float | None = None
    panels_N_per_m: float | None = None
    loss_factor: float | None = None
    bearing: Bearing | None = None
    deepest: Deepest | None = None
    products: Products | None = None
    closed: bool = False
    turned: Turned | None = None
