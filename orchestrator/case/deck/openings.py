"""The openings of a case: their places, and the particles that can pass them."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from orchestrator.case.bed.grains import sieve_sizes_m
from orchestrator.case.deck.panels import perforated_panels, single_panels
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.case.tables.deck import DrawnApertures
from orchestrator.ports import Array
from orchestrator.ports.drawn_openings import DrawnOpenings
from orchestrator.ports.geometry import AperturePattern, Rectangle

ALIKE = 1e-6  # relative difference of sizes of openings that are one size


def openings_m(case: Case) -> Array:
    """Return the centres of all openings (n, 3), on the straight line between the clamps."""
    rows = [(panel.rectangle, panel.apertures) for panel in single_panels(case)]
    centres_m = [at.mounted(pattern.centres_m(at)) for at, pattern in rows if pattern is not None]
    return np.vstack([np.empty((0, 3)), *centres_m])


def smaller_sides_m(case: Case) -> Iterator[float]:
    """Yield the smaller side of the openings of each panel that has openings.

    Of drawn ones, these are the diameters of the largest spheres that pass the widest opening and, where it
    differs, the narrowest.
    """
    for panel in single_panels(case):
        if panel.apertures is not None:
            least_m, most_m = panel.apertures.narrowest_section.spheres_m
            yield most_m
            if least_m < most_m * (1 - ALIKE):
                yield least_m


def half_depths_m(case: Case) -> list[float]:
    """Return half the depth of the openings of each panel, 0 without a depth, in the order of the case."""
    patterns = [panel.apertures for panel in single_panels(case)]
    return [pattern.depth_m / 2 if pattern is not None else 0.0 for pattern in patterns]


def open_share(case: Case) -> float:
    """Return the area of all openings over the free area of the panels that have openings (at least one)."""
    open_m2 = free_m2 = 0.0
    for panel in single_panels(case):
        if panel.apertures is not None:
            at = panel.rectangle
            open_m2 += len(panel.apertures.centres_m(at)) * panel.apertures.opening_m2
            free_m2 += at.length_m * at.width_m
    return open_m2 / free_m2


def straight_passing(apertures: AperturePattern, size_m: float) -> float:
    """Return the probability that a sphere which falls straight onto the pattern touches nothing.

    For rectangles a x b it is  (a - d)(b - d) / (pitch_along pitch_across),  the single-attempt
    probability of Gaudin (Principles of Mineral Dressing, 1939) and Taggart (Handbook of Mineral
    Dressing, 1945).  A slot counts with its area, shrunk by half a diameter all around, and an opening with a
    depth by its narrowest section.  Drawn openings count as exactly, but for 1e-4 of their area.
    """
    narrowest = apertures.narrowest_section
    if narrowest.drawn:
        return narrowest.drawn.passed_share(size_m)
    a, b = narrowest.length_m - size_m, narrowest.width_m - size_m
    if min(a, b) <= 0.0:
        return 0.0
    free = AperturePattern(apertures.shape, a, b, apertures.pitch_along_m, apertures.pitch_across_m)
    return 1.0 - free.solid_share


def openings(case: Case) -> Iterator[str]:
    """Yield lines that describe the openings and the particles that pass them; equal panels share lines."""
    limits_m = sieve_sizes_m(case) if has_particles(case) else None
    for panel, *others in perforated_panels(case):
        pattern = panel.apertures
        assert pattern is not None, "only panels with apertures are perforated"
        who = f"{panel.name} and {len(others)} more" if others else panel.name
        where = "free panel" if case.slice is None else "free panel in the slice, which has no margins"
        yield f"  openings   {who}: {_pattern(pattern, panel.rectangle)} of the {where}"
        if isinstance(table := panel.table.apertures, DrawnApertures) and (
            ignored := _ignored(table, pattern)
        ):
            yield f"             {table.file}: without {ignored}"
        if pattern.depth_m:
            yield f"             {_depth(pattern)}"
        if limits_m:
            yield f"             {_passing(pattern, *limits_m)}"


def _pattern(pattern: AperturePattern, rectangle: Rectangle) -> str:
    """Return a description of the openings of a panel, which ends with their share of it."""
    count = len(pattern.centres_m(rectangle))
    free_m2 = rectangle.length_m * rectangle.width_m
    whole = count * pattern.opening_m2 / free_m2
    open_share = f"{1 - pattern.solid_share:.1%} open within the pattern, {whole:.1%}"
    if pattern.drawn:
        return f"{_drawn(pattern.drawn)}, {open_share}"
    lands = (pattern.pitch_along_m - pattern.length_m, pattern.pitch_across_m - pattern.width_m)
    return (
        f"{count} {pattern.shape}s of {pattern.length_m * 1e3:g} x {pattern.width_m * 1e3:g} mm in "
        f"{pattern.counts(rectangle)[0]} rows, lands {lands[0] * 1e3:.3g} and "
        f"{lands[1] * 1e3:.3g} mm, {open_share}"
    )


def _drawn(drawn: DrawnOpenings) -> str:
    """Return a description of the openings of a drawing."""
    least_m, most_m = drawn.spheres_m
    least = "" if least_m > most_m * (1 - ALIKE) else f"{1e3 * least_m:.3g} to "
    land = f", lands of at least {1e3 * drawn.land_m:.3g} mm" if len(drawn) > 1 else ""
    ways = zip(drawn.repeats_m, ("along", "across"), strict=True)
    repeats = " and ".join(f"{1e3 * period_m:.4g} mm {way}" for period_m, way in ways if period_m)
    again = f"repeat every {repeats}" if repeats else "do not repeat"
    sizes = f"{least}{1e3 * most_m:.3g} mm"
    return f"{len(drawn)} openings of a drawing for spheres below {sizes}{land}; they {again}"


def _ignored(table: DrawnApertures, pattern: AperturePattern) -> str:
    """Return what of a drawing is no opening of the free panel, in words; "" for nothing."""
    under = len(table.drawing.outlines_m) - len(pattern.drawn or ())
    return ", ".join(filter(None, (f"{under} under the clamps" if under else "", table.drawing.ignored)))


def _depth(pattern: AperturePattern) -> str:
    """Return a description of openings with a depth."""
    lower, below = pattern.section(pattern.depth_m), ""
    if pattern.relief_deg and not pattern.drawn:
        below = f", {lower.length_m * 1e3:.3g} x {lower.width_m * 1e3:.3g} mm below"
    return f"openings are {pattern.depth_m * 1e3:g} mm deep, relief {pattern.relief_deg:g} degrees{below}"


def _passing(pattern: AperturePattern, smallest_m: float, largest_m: float) -> str:
    """Return a description of the particles that can pass the openings."""
    narrowest = pattern.narrowest_section
    limit_m = narrowest.spheres_m[1]
    span = f"particles of {smallest_m * 1e3:.3g} to {largest_m * 1e3:.3g} mm"
    if smallest_m >= limit_m:
        return f"none of the {span} can pass"
    who = "all" if largest_m < narrowest.spheres_m[0] else f"those below {limit_m * 1e3:g} mm"
    return (
        f"of the {span} {who} can pass; the smallest, falling straight onto the pattern, does so "
        f"without contact with probability {straight_passing(pattern, smallest_m):.2g}"
    )
