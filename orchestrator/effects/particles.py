"""Effects between particles, and between particles and the deck."""

from __future__ import annotations

import math
from collections.abc import Iterator

from orchestrator.bed.adhesion import surface_materials
from orchestrator.bed.contact_times import smallest_diameters_m
from orchestrator.bed.sources import largest_diameter_m
from orchestrator.casefile.case import Case, Contact
from orchestrator.deck.opening_places import smaller_sides_m
from orchestrator.effects.scene import Scene, bed_kg_m2
from orchestrator.effects.verdict import TENTH, Verdict

PERCOLATION = 1 / (2 / math.sqrt(3) - 1)  # 6.46: through the throat between three touching spheres
FEWEST_LAYERS = 5.0  # of coarse particles: the project's choice


def sliding_friction(scene: Scene) -> Verdict:
    """A body slides down with g (sin - mu cos): mu / tan is what friction takes of it."""
    friction = max((row.sliding_friction for row in _on_deck(scene.case)), default=0.0)
    ratio = _of_slope(friction, scene.slope)
    return Verdict(
        effect="sliding-friction",
        present=friction > 0,
        number="mu / tan(slope)",
        value=ratio,
        threshold="0.1 (Coulomb)",
        matters=ratio > TENTH,
        why=_takes(ratio, "sliding"),
        key="contacts.sliding_friction",
        cost="hardly anything",
    )


def rolling_friction(scene: Scene) -> Verdict:
    """A sphere rolls down with 5/7 g (sin - mu_r cos)."""
    friction = max((row.rolling_friction for row in _on_deck(scene.case)), default=0.0)
    ratio = _of_slope(friction, scene.slope)
    return Verdict(
        effect="rolling-friction",
        present=friction > 0 and "rolling-friction" not in scene.left_out,
        number="mu_r / tan(slope)",
        value=ratio,
        threshold="0.1 (rolling sphere)",
        matters=ratio > TENTH,
        why=_takes(ratio, "rolling alone"),
        key="particles.rolling",
        cost="a contact history (epsd2)",
    )


def _on_deck(case: Case) -> list[Contact]:
    """Contacts of particles with panels or, without any, with other surfaces."""
    grains = set(smallest_diameters_m(case))
    panels = {panel.material for panel in case.screen.panels.values()} or surface_materials(case)
    return [
        row
        for row in case.contacts
        for grain, panel in (row.between, row.between[::-1])
        if grain in grains and panel in panels
    ]


def _of_slope(friction: float, slope: float) -> float:
    if slope < 1e-9:
        return math.inf if friction else 0.0
    return friction / slope


def _takes(ratio: float, how: str) -> str:
    if math.isinf(ratio):
        return "on the level, friction holds what lies"
    if ratio >= 1:
        return f"what is {how} stops on the flattest panel"
    return f"takes {ratio:.0%} of the acceleration of what is {how} down the flattest panel"


def adhesion(scene: Scene) -> Verdict:
    """JKR's pull-off force of the smallest particles over their weight (the Bond number), over
    what pulls them apart: their weight and the throw."""
    found = [(pull * w, w) for pull, w in _pulls(scene.case)]
    pull = max((each for each, _ in found), default=0.0)
    apart = 1 + scene.throw
    ratio = pull / apart
    sticks = f"the pull-off force is {pull:.3g} weights, shaking pulls with {apart:.3g}"
    dry = "no contact has a work of adhesion: the material is dry"
    return Verdict(
        effect="adhesion",
        present=pull > 0 and "adhesion" not in scene.left_out,
        number="Bond / (1 + throw)",
        value=ratio,
        threshold="0.1 (JKR 1971)",
        matters=ratio > TENTH,
        why=sticks if pull else f"{dry}{_would_matter(scene, apart)}",
        key="particles.adhesion",
        cost="about half as much again per step (jkr)",
    )


def _pulls(case: Case) -> Iterator[tuple[float, float]]:
    """Pull-off force over weight for a work of adhesion of 1 J/m2, and the work: of the smallest
    real particles of each pair that can meet, whatever coarse ones the case computes."""
    k = case.particles.coarse_graining
    radius_m = {name: d / 2 / k for name, d in smallest_diameters_m(case).items()}
    for row in case.contacts:
        radii = [radius_m.get(name, math.inf) for name in row.between]
        if math.isinf(min(radii)):
            continue
        name = row.between[radii.index(min(radii))]
        weight_N = 9.81 * 4 / 3 * math.pi * min(radii) ** 3 * case.materials[name].density_kg_m3
        reduced_m = 1 / (1 / radii[0] + 1 / radii[1])
        yield 1.5 * math.pi * reduced_m / weight_N, row.work_of_adhesion_J_m2 / k


def _would_matter(scene: Scene, apart: float) -> str:
    most = max((pull for pull, _ in _pulls(scene.case)), default=0.0)
    return f" (it would matter from {TENTH * apart / most:.1g} J/m2)" if most else ""


def size_distribution(scene: Scene) -> Verdict:
    """Sizes decide what passes; in a bed, small ones trickle through from a ratio of 6.46."""
    low_m = min(smallest_diameters_m(scene.case).values())
    ratio = largest_diameter_m(scene.case) / low_m
    matters, why = _sizes_matter(scene, low_m, ratio)
    return Verdict(
        effect="size-distribution",
        present=ratio > 1,
        number="largest / smallest diameter",
        value=ratio,
        threshold="6.46 (throat of three), or openings between",
        matters=matters,
        why=why,
        key="bed: sizes, curve, smallest_fed_m",
        cost="number of particles with 1/d^3, step with d of the smallest",
    )


def _sizes_matter(scene: Scene, low_m: float, ratio: float) -> tuple[bool | None, str]:
    k = scene.case.particles.coarse_graining
    for opening_m in smaller_sides_m(scene.case):
        if low_m / k < opening_m <= ratio * low_m / k:
            return True, f"openings of {opening_m * 1e3:.3g} mm divide the sizes"
    if ratio >= PERCOLATION:
        return True, "small ones trickle through the gaps between large ones"
    if ratio == 1.0:
        return None, "there is one size only; whether the material has more is not said"
    return None, "a shaken bed separates smaller ratios, too: only a run tells"


def single_particles(scene: Scene) -> Verdict | None:
    """A bed of coarse particles must be several deep; None where particles are themselves."""
    k = scene.case.particles.coarse_graining
    if k == 1.0:
        return None
    diameter_m = largest_diameter_m(scene.case)
    densest = max(
        scene.case.materials[name].density_kg_m3 for name in smallest_diameters_m(scene.case)
    )
    layers = bed_kg_m2(scene.case) / (math.pi / 6 * densest * diameter_m)
    return Verdict(
        effect="single-particles",
        present=False,
        number="layers of coarse particles",
        value=layers,
        threshold="fewer than 5 (own choice)",
        matters=layers < FEWEST_LAYERS,
        why=f"one of {diameter_m * 1e3:.3g} mm stands for {k**3:.3g}",
        key="particles.coarse_graining",
        cost=f"{k**3:.3g} times the particles, {k:.3g} times the steps",
    )
