"""The layout of decks: the panels and surfaces that a deck's parameters describe, in deck axes.

``lay_out_decks`` replaces every deck of a case, so that no later step needs to know about decks.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from itertools import pairwise
from typing import Any

import numpy as np

from orchestrator.case.file.errors import CaseError, CaseProblem, Key
from orchestrator.case.file.plausible import wrong_sizes
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.deck import Deck, PanelSheet
from orchestrator.case.tables.screen import PanelTable, Surface
from orchestrator.ports import Array

LARGEST_STRAIN = 0.1  # This limits tension_m / length_m; panels at work are stretched by some 0.025.
BETWEEN_CLAMPS_M = 0.002  # of neighbours, where no pitch is given
ACROSS, UP = np.eye(3)[1:]


def lay_out_decks(case: Case) -> Case:
    """Return the case with panels and surfaces in place of its decks.

    Raises CaseError with every problem of the decks.  If the case has sizes that must be mistakes, it
    raises CaseError with these alone, because such sizes would overflow here.
    """
    screen = case.screen
    if not screen.decks:
        return case
    faults = [*wrong_sizes(case)]
    if not faults:
        faults = [problem for name, deck in screen.decks.items() for problem in problems(name, deck)]
    panels, surfaces = dict(screen.panels), dict(screen.surfaces)
    if not faults:
        for name, deck in screen.decks.items():
            beams_m = beams(deck, screen.inclination_deg)
            new_panels = dict(panels_of(name, deck, beams_m))
            new_surfaces = dict(surfaces_of(name, deck, beams_m, screen.inclination_deg))
            for twice in (panels.keys() & new_panels) | (surfaces.keys() & new_surfaces):
                faults.append(CaseProblem(("screen", "decks", name), f'"{twice}" is there already'))
            panels, surfaces = panels | new_panels, surfaces | new_surfaces
    if faults:
        raise CaseError(faults)
    update = {"panels": panels, "surfaces": surfaces, "decks": {}}
    return case.model_copy(update={"screen": screen.model_copy(update=update)})


def problems(name: str, deck: Deck) -> Iterator[CaseProblem]:
    """Yield the problems of a deck: wrong counts, excessive tension and overlapping panels."""
    key: Key = ("screen", "decks", name)
    segments, counts = len(deck.slopes_deg), deck.panels_per_slope
    if counts and (len(counts) != segments or sum(counts) != deck.panels):
        numbers = f"{len(counts)} numbers that add up to {sum(counts)}"
        what = f"{numbers}, for {segments} slopes and {deck.panels} panels"
        hint = "give one number for each slope, which add up to the panels"
        yield CaseProblem((*key, "panels_per_slope"), what, hint, kind="wrong-type")
    elif not counts and segments and deck.panels % segments:
        what = f"{deck.panels} panels cannot be shared equally among {segments} slopes"
        whole = [
            count * segments for count in (deck.panels // segments, deck.panels // segments + 1) if count
        ]
        hint = "give panels_per_slope, or take " + " or ".join(map(str, whole))
        yield CaseProblem((*key, "panels"), what, f"{hint} panels, with a pitch that keeps the length")
    if len(deck.tension_m) not in (1, deck.panels):
        what = f"{len(deck.tension_m)} values for {deck.panels} panels"
        yield CaseProblem((*key, "tension_m"), what, "give one for all, or one for each", kind="wrong-type")
        return
    for tension_m in sorted(set(tensions(deck))):
        strain = tension_m / deck.length_m
        if abs(strain) > LARGEST_STRAIN:
            what = f"{tension_m:g} m on {deck.length_m:g} m is a strain of {strain:.3g}"
            limit_m = LARGEST_STRAIN * deck.length_m
            hint = f"at most {LARGEST_STRAIN:g} ({limit_m:.3g} m) is possible, taut or slack"
            yield CaseProblem((*key, "tension_m"), what, hint, kind="out-of-range")
    needed_m = mounted_m(deck)
    if pitch_m(deck) < needed_m - 1e-12:
        what = f"with {pitch_m(deck):g} m neighbouring panels overlap"
        hint = f"give at least {needed_m:g} m, which length, tension and two clamps take"
        yield CaseProblem((*key, "pitch_m"), what, hint, kind="misplaced")


def move_to_deck(problem: CaseProblem, decks: Mapping[str, Any]) -> CaseProblem:
    """Return a problem in a deck's panel or surface at the deck's key, and any other problem unchanged."""
    match problem.key:
        case ("screen", "panels" | "surfaces", str(part), *inner):
            name = next((name for name in decks if part.startswith(f"{name}-")), None)
            if name is not None:
                field = inner[:1] if inner and inner[0] in Deck.model_fields else []
                if field in (["apertures"], ["stops"]):  # A deck and its panels have these tables in common.
                    field = inner
                key = ("screen", "decks", name, *field)
                what = problem.what if part in problem.what else f"{part}: {problem.what}"
                return replace(problem, key=key, what=what)
    return problem


def tensions(deck: Deck) -> tuple[float, ...]:
    """Return the tension of each panel, as a length in m."""
    return deck.tension_m if len(deck.tension_m) == deck.panels else deck.tension_m * deck.panels


def clamp_reach_m(deck: Deck) -> tuple[float, float]:
    """Return how far a clamp reaches along the deck, and how high its outer edge stands over the inner."""
    angle_rad = math.radians(deck.clamp_angle_deg)
    return deck.clamp_m * math.cos(angle_rad), deck.clamp_m * math.sin(angle_rad)


def mounted_m(deck: Deck) -> float:
    """Return the length that the longest panel takes with its clamps."""
    return deck.length_m + max(tensions(deck)) + 2 * clamp_reach_m(deck)[0]


def pitch_m(deck: Deck) -> float:
    """Return the distance between cross beams, as given or as the longest panel needs it."""
    return mounted_m(deck) + BETWEEN_CLAMPS_M if deck.pitch_m is None else deck.pitch_m


def panels_per_slope(deck: Deck) -> tuple[int, ...]:
    """Return the number of panels of each segment; a deck without slopes is one segment."""
    segments = max(len(deck.slopes_deg), 1)
    return deck.panels_per_slope or (deck.panels // segments,) * segments


def directions(deck: Deck, inclination_deg: float) -> Array:
    """Return a unit vector along each panel, pointing downhill, (panels, 3)."""
    slopes_deg = deck.slopes_deg or (inclination_deg,)
    each = np.repeat(slopes_deg, panels_per_slope(deck))
    down = np.radians(each - inclination_deg)
    return np.column_stack([np.cos(down), np.zeros_like(down), -np.sin(down)])


def beams(deck: Deck, inclination_deg: float) -> Array:
    """Return the middle of each cross beam's top, at the side of ``corner_m``, (panels + 1, 3)."""
    steps_m = pitch_m(deck) * directions(deck, inclination_deg)
    return np.vstack([np.zeros(3), np.cumsum(steps_m, axis=0)]) + deck.corner_m


def panels_of(name: str, deck: Deck, beams_m: Array) -> Iterator[tuple[str, PanelTable]]:
    """Yield the name and the table of each panel; a panel lies in the middle between its cross beams."""
    sheet = {key: getattr(deck, key) for key in PanelSheet.model_fields}
    for number, (start_m, end_m) in enumerate(pairwise(beams_m)):
        tension_m = tensions(deck)[number]
        along = (end_m - start_m) / pitch_m(deck)
        corner_m = start_m + (pitch_m(deck) - deck.length_m - tension_m) / 2 * along
        yield (
            f"{name}-{number + 1}",
            PanelTable(
                frames=deck.frames if number % 2 == 0 else deck.frames[::-1],
                corner_m=corner_m.tolist(),
                along=along.tolist(),
                tension_m=tension_m,
                **sheet,
            ),
        )


def surfaces_of(
    name: str, deck: Deck, beams_m: Array, inclination_deg: float
) -> Iterator[tuple[str, Surface]]:
    """Yield the name and the table of each side plate and cross beam, and of the feed chute."""
    if deck.side_plates is not None:
        yield from _side_plates(name, deck, beams_m)
    if deck.cross_beams is not None:
        yield from _cross_beams(name, deck, beams_m)
    if deck.feed_chute is not None:
        yield f"{name}-chute", _chute(deck, beams_m[0], inclination_deg)


def _side_plates(name: str, deck: Deck, beams_m: Array) -> Iterator[tuple[str, Surface]]:
    """Yield a parallelogram for each side and segment.

    Neighbours share an edge along the deck's normal, so that no gap opens where the slope changes.
    """
    plates = deck.side_plates
    assert plates is not None
    corners_m = beams_m[[0, *np.cumsum(panels_per_slope(deck))]]
    high_m = (plates.height_m + plates.depth_m) * UP
    sides = {"left": -plates.gap_m, "right": deck.width_m + plates.gap_m}
    for side, y_m in sides.items():
        for number, (start_m, end_m) in enumerate(pairwise(corners_m)):
            corner_m = start_m + y_m * ACROSS - plates.depth_m * UP
            edges_m = (end_m - start_m, high_m)
            plate = _plate(corner_m, edges_m, plates.frame, plates.material)
            yield f"{name}-{side}-{number + 1}", plate


def _cross_beams(name: str, deck: Deck, beams_m: Array) -> Iterator[tuple[str, Surface]]:
    """Yield the visible top of each cross beam, from the clamp above to the clamp below.

    It joins the clamps' outer edges, which are higher than the panels where clamps are turned.  At the deck's
    two ends the top begins or ends in the beam's middle.  Beams that the clamps cover completely are left
    out.
    """
    assert deck.cross_beams is not None
    along = np.diff(beams_m, axis=0)
    reach_m, lift_m = clamp_reach_m(deck)
    whole_m = np.array(tensions(deck)) + deck.length_m + 2 * reach_m
    gaps_m = (pitch_m(deck) - whole_m)[:, None] / 2 * along / pitch_m(deck)
    none = np.zeros((1, 3))
    along_1 = along / pitch_m(deck)
    lifts_m = lift_m * np.column_stack([-along_1[:, 2], along_1[:, 1], along_1[:, 0]])
    from_m = beams_m - np.vstack([none, gaps_m]) + np.vstack([lifts_m[:1], lifts_m])
    to_m = beams_m + np.vstack([gaps_m, none]) + np.vstack([lifts_m, lifts_m[-1:]])
    for number, (start_m, end_m) in enumerate(zip(from_m, to_m, strict=True)):
        if np.linalg.norm(end_m - start_m) > 1e-9 * pitch_m(deck):
            edges_m = (end_m - start_m, deck.width_m * ACROSS)
            frame = deck.frames[number % 2]
            top = _plate(start_m, edges_m, frame, deck.cross_beams.material)
            yield f"{name}-beam-{number + 1}", top


def _chute(deck: Deck, beam_m: Array, inclination_deg: float) -> Surface:
    """Return the feed chute, which ends above the first cross beam, whose panels meet at ``beam_m`` (3,)."""
    chute = deck.feed_chute
    assert chute is not None
    down = math.radians(chute.slope_deg - inclination_deg)
    uphill_m = chute.length_m * np.array([-math.cos(down), 0.0, math.sin(down)])
    _, lift_m = clamp_reach_m(deck)
    corner_m = beam_m + (chute.drop_m + lift_m) * UP + uphill_m
    return _plate(corner_m, (-uphill_m, deck.width_m * ACROSS), chute.frame, chute.material)


def _plate(corner_m: Array, edges_m: tuple[Array, Array], frame: str, material: str) -> Surface:
    """Return a plate with a corner (3,) and the two edges (3,) that start there."""
    first_m, second_m = (edge_m.tolist() for edge_m in edges_m)
    return Surface(corner_m=corner_m.tolist(), edges_m=(first_m, second_m), frame=frame, material=material)
