"""The warnings about a deck that can hardly be meant: panels out of line, or openings of the wrong size."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from orchestrator.case.bed.grains import sieve_sizes_m
from orchestrator.case.deck.panels import perforated_panels, single_panels
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.preflight.scene.panel_rows import Joint, panel_rows

LARGEST_KINK_DEG = 20.0  # Neighbouring segments of a banana deck differ by some 15 degrees.
LARGEST_SIDE_STEP_M = 1e-3
ACROSS = 0.2  # sine of the angle to the x axis beyond which a panel counts as lying across it
LARGEST_STEP = 0.5  # of the thinner panel's thickness


def panels_out_of_line(case: Case) -> Iterator[str]:
    """Yield a warning for each way in which panels one behind the other do not continue each other."""
    faults: dict[str, list[str]] = {}
    for joint in panel_rows(case).joints:
        for kind, text in _faults(joint):
            faults.setdefault(kind, []).append(text)
    for first, *others in faults.values():
        yield first + (f" (and {len(others)} more such joints)" if others else "")


def panels_across(case: Case) -> Iterator[str]:
    """Yield a warning for panels that run across the deck's x axis, along which strokes are given."""
    turned = [panel.name for panel in single_panels(case) if abs(panel.rectangle.along[1]) > ACROSS]
    if turned:
        more = f" and {len(turned) - 1} more" if len(turned) > 1 else ""
        yield (
            f"not along x: panel {turned[0]}{more}; strokes along the deck and ellipses of frames are those "
            "in the plane of x and z, so turn the machine until its deck runs along x or -x"
        )


def openings_and_particles(case: Case) -> Iterator[str]:
    """Yield a warning for openings that all particles pass, and for openings that none can pass."""
    if not has_particles(case) or not case.bed.has_material:
        return
    smallest_m, largest_m = sieve_sizes_m(case)
    for panel, *others in perforated_panels(case):
        assert panel.apertures is not None, "only panels with apertures are perforated"
        narrowest = panel.apertures.narrowest_section
        least_m, most_m = narrowest.spheres_m
        who = f"panel {panel.name}" + (f" and {len(others)} more" if others else "")
        if largest_m < least_m:
            yield (
                f"the openings of {who} are larger than all particles: {1e3 * least_m:.3g} mm against "
                f"at most {1e3 * largest_m:.3g} mm, so that nothing stays on the deck"
            )
        elif smallest_m >= most_m:
            yield (
                f"the openings of {who} are smaller than all particles: {1e3 * most_m:.3g} mm against "
                f"at least {1e3 * smallest_m:.3g} mm, so that nothing passes"
            )


def _faults(joint: Joint) -> Iterator[tuple[str, str]]:
    upper, lower = joint.upper, joint.lower
    along = upper.along + lower.along
    normal = np.cross(along, upper.across) / np.linalg.norm(np.cross(along, upper.across))
    step_m = float(joint.gap_m @ (normal if normal[2] > 0 else -normal))
    limit_m = LARGEST_STEP * min(upper.panel.table.thickness_m, lower.panel.table.thickness_m)
    if abs(step_m) > limit_m:
        way = "above" if step_m > 0 else "below"
        yield (
            "step",
            f"panels {joint.name} are out of line: the second begins {_mm(step_m)} {way} the first's end",
        )
    aside_m = float(joint.gap_m @ upper.across)
    if abs(aside_m) > LARGEST_SIDE_STEP_M:
        yield "aside", f"panels {joint.name} are out of line: the second is {_mm(aside_m)} aside of the first"
    kink_deg = math.degrees(math.acos(min(1.0, float(upper.along @ lower.along))))
    if kink_deg > LARGEST_KINK_DEG:
        yield "kink", f"panels {joint.name} are out of line: they make an angle of {kink_deg:.3g} deg"
    if upper.frames[1] != lower.frames[0]:
        yield (
            "frames",
            f"panels {joint.name} meet, but {upper.frames[1]} holds the first's end and {lower.frames[0]} "
            "the second's: the joint opens and closes by the stroke; neighbours share a cross beam",
        )


def _mm(length_m: float) -> str:
    return f"{1e3 * abs(length_m):.3g} mm"
