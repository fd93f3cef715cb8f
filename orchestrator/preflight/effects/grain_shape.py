"""The shape of grains, where they are computed as spheres and not as clumps of several spheres.

A rolling friction stands for what shape does to rolling: a grain with edges is held back by the couple of
its weight and of the distance between its contact and the plumb line of its centre.  Where that couple is
smaller than that of the slope, a lone sphere runs ever faster, and a grain with edges does not.  How shape
scatters rebounds, and how grains turn to pass an opening, spheres leave out altogether.
Wensrich, C. M. and Katterfeld, A., Powder Technology 217, 2012, 409-417, doi 10.1016/j.powtec.2011.10.057.
"""

from __future__ import annotations

from orchestrator.case.bed.grains import grains_by_material
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.preflight.scene.contacts import FEWEST_LAYERS, LEVEL, rolling_on_deck
from orchestrator.preflight.scene.effect import Effect, Verdict
from orchestrator.preflight.scene.scene import Scene

OPEN = "what edges change of rebounds and of passing, spheres do not tell"


def judge(scene: Scene) -> Verdict:
    """Judge by whether a lone sphere stops rolling on the flattest panel of a deck.

    It matters where nothing stops it: the results then depend on the length of the deck.
    """
    number, threshold = (
        "mu_r / tan(slope)",
        f"1 (a lone sphere stops), or {FEWEST_LAYERS:g} layers (own choice)",
    )
    rolling = rolling_on_deck(scene)
    if rolling is None or not rolling.is_endless:
        slopes = rolling is not None and rolling.slope >= LEVEL
        return Verdict(
            number, rolling.friction / rolling.slope if rolling and slopes else None, threshold, None, OPEN
        )
    why = f"a sphere that rolls runs ever faster: {rolling.in_words}"
    return Verdict(number, rolling.friction / rolling.slope, threshold, True, why)


def left_out(case: Case) -> str:
    """Return which grains are computed as spheres; empty without any."""
    if not has_particles(case) or not _some_are_spheres(case):
        return ""
    which = "some particles" if _some_are_clumps(case) else "particles"
    return f"{which} are spheres; rolling friction stands for their shape"


def _some_are_spheres(case: Case) -> bool:
    return any(one.sphere_count == 1 for grains in grains_by_material(case).values() for one in grains)


def _some_are_clumps(case: Case) -> bool:
    return any(one.sphere_count > 1 for grains in grains_by_material(case).values() for one in grains)


EFFECT = Effect(
    part="particles",
    judge=judge,
    described=lambda case: not _some_are_spheres(case),
    left_out=left_out,
    key="bed: shape; materials: shape; contacts: rolling_friction",
    checked_by="bed_kg_per_m2",
    about=("particles",),
)
