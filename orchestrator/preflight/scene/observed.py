"""The numbers that a run tells of its scene, which replace estimates."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Shape:
    """The largest height of a panel's arch in a run, the range of the height, and the largest mean strain."""

    sag_m: float
    travel_m: float
    strain: float


@dataclass(frozen=True)
class Bearing:
    """The mean load of the particles on the panels.

    ``carried`` is the normal force over the weight that would lie on the panels.  ``mobilised`` is the
    force down the deck over the normal force, None in a run without friction.
    """

    carried: float
    mobilised: float | None


@dataclass(frozen=True)
class Deepest:
    """The largest overlap in any step over a particle's diameter, and the largest with the surface in m."""

    per_diameter: float
    surface_m: float


@dataclass(frozen=True)
class Products:
    """The ratio of the coarsest product's mean diameter to the finest product's, with a text about it."""

    ratio: float
    words: str


@dataclass(frozen=True)
class ExciterLoad:
    """The mean power of the exciters on the frames, and their largest mean torque over a cycle of the run-up.

    The torque is the mean power of a cycle over the speed of the shafts in that cycle.
    """

    power_W: float
    largest_N_m: float


@dataclass(frozen=True)
class Observed:
    """The numbers of a run; each is None if the run does not tell it.

    ``frames_throw`` is the throw intensity of the frame that moves most normal to the deck; with it, the
    scene's panels have the strokes and, if they bend, the shapes of the run.  ``bed_kg_per_m2`` is the
    largest mass on the deck per area.  ``rotation`` is the displacement of a frame's outermost clamp by
    rotation over the frame's translation, with a text.  ``transport_m_per_s`` is the speed of the bed
    along the deck.  ``panels_N_per_m`` is the stiffness of all panels along themselves, pull over
    stretch; with it, the scene's springs have the stiffness of the run, and ``shaken`` is the frames'
    motion with them.  ``loss_factor`` is the largest loss factor of the panels at the frequencies of
    their pull.  ``closed`` says that the panels of the run have no openings.  ``exciter_load`` has the
    power and torque of the run's exciters.
    """

    frames_throw: float | None = None
    bed_kg_per_m2: float | None = None
    rotation: tuple[float, str] | None = None
    transport_m_per_s: float | None = None
    panels_N_per_m: float | None = None
    loss_factor: float | None = None
    bearing: Bearing | None = None
    deepest: Deepest | None = None
    products: Products | None = None
    closed: bool = False
    exciter_load: ExciterLoad | None = None
