"""Effects of what comes, goes, and lies around the deck."""

from __future__ import annotations

import math

from orchestrator.bed.sources import largest_diameter_m
from orchestrator.bed.transport import TRANSPORT_M_S, deck_length_m
from orchestrator.casefile.left_out import has_particles
from orchestrator.checks.slices import ENOUGH_DIAMETERS
from orchestrator.effects.scene import Scene
from orchestrator.effects.shaking import free_frames
from orchestrator.effects.verdict import TENTH, Verdict


def feed(scene: Scene) -> Verdict | None:
    """Share of the bed that is replaced in the run; None without particles."""
    return _passage(
        scene,
        effect="feed",
        present=bool(scene.case.bed.feeds),
        key="bed.feeds.<name>",
        cost="a deck that fills for as long as material stays on it",
    )


def removal(scene: Scene) -> Verdict | None:
    """The same share leaves; None without particles."""
    return _passage(
        scene,
        effect="removal",
        present=bool(scene.case.screen.exits),
        key="screen.exits.<name>",
        cost="nothing",
    )


def _passage(scene: Scene, effect: str, present: bool, key: str, cost: str) -> Verdict | None:
    if not has_particles(scene.case):
        return None
    share = scene.case.duration_s * TRANSPORT_M_S / max(deck_length_m(scene.case), 1e-9)
    level = scene.slope < 1e-9
    why = f"in the run {share:.0%} of the bed goes over the deck, at {TRANSPORT_M_S:g} m/s"
    if level:
        why = "the deck is level: whether it carries the bed along, only a run tells"
    return Verdict(
        effect=effect,
        present=present,
        number="run / time on the deck",
        value=None if level else share,
        threshold="0.1 (mass balance)",
        matters=None if level else share > TENTH,
        why=why,
        key=key,
        cost=cost,
    )


def gravity(scene: Scene) -> Verdict:
    """Always, but for frames that are driven and nothing else; the number says how it compares."""
    there = any(scene.case.gravity_m_s2)
    needed = has_particles(scene.case) or bool(scene.panels) or bool(free_frames(scene.plan))
    throw = scene.throw
    return Verdict(
        effect="gravity",
        present=there,
        number="1 / throw",
        value=1 / throw if throw else math.inf,
        threshold="always",
        matters=needed,
        why="particles fall, panels and frames hang" if needed else "nothing here can fall",
        key="gravity_m_s2",
        cost="nothing",
    )


def full_width(scene: Scene) -> Verdict | None:
    """Width of the slice over the largest particle; None without a slice."""
    part = scene.case.slice
    if part is None or not has_particles(scene.case):
        return None
    ratio = part.width_m / largest_diameter_m(scene.case)
    narrow = ratio < ENOUGH_DIAMETERS
    return Verdict(
        effect="full-width",
        present=False,
        number="slice / largest diameter",
        value=ratio,
        threshold=f"{ENOUGH_DIAMETERS:g} (own choice)",
        matters=True if narrow else None,
        why="large particles may bridge" if narrow else "side plates and uneven feed: a run tells",
        key="slice.width_m",
        cost="particles go with the width",
    )
