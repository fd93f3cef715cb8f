"""The case of a slice of the machine's width, from the case of the whole machine.

Everything extensive is multiplied by  share = slice width / full width: masses and inertia,
stiffness and damping of the bushings, exciters, feed rates and numbers of particles.  Panels are
cut to the slice and so have their share by themselves.  The frames' equations of motion are linear
in all of these: the frames of a slice move exactly as the whole machine's wherever the load is the
same at every place across.  Theory: docs/theory/feed.md.
"""

from __future__ import annotations

from typing import TypeVar

from orchestrator.case import solvers
from orchestrator.case.file import slice_surfaces, slice_tables
from orchestrator.case.file.errors import CaseError, CaseProblem, Key
from orchestrator.case.tables.bed import Block, Feed
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.screen import PanelTable
from orchestrator.ports import Array, Indices

Filled = TypeVar("Filled", Block, Feed)
ENOUGH_DIAMETERS = 5.0  # of the largest particles in a slice, so that none bridges: own choice


def share(case: Case) -> float:
    """Of the full width that the slice of a whole machine has; 1 without one."""
    if case.slice is None:
        return 1.0
    low, high = full_width_m(case)
    return case.slice.width_m / (high - low)


def full_width_m(case: Case) -> tuple[float, float]:
    """Where all panels begin and end along y.  Raises CaseError if they do not agree."""
    sides = {name: _sides_m(panel) for name, panel in case.screen.panels.items()}
    if not sides:
        raise CaseError([CaseProblem(("slice",), "there are no panels to slice")])
    (first, one), *others = sides.items()
    for name, (low, high) in others:
        if abs(low - one[0]) + abs(high - one[1]) > 1e-6:
            there = f"panel {first} from {one[0]:g} to {one[1]:g}"
            what = f"goes from y = {low:g} to {high:g} m, {there}"
            hint = "a slice wants panels of the same width side by side"
            raise CaseError([CaseProblem(("screen", "panels", name, "width_m"), what, hint)])
    return one


def bounds_m(case: Case) -> tuple[float, float]:
    """Where the slice begins and ends along y, for the case of the whole machine."""
    assert case.slice is not None
    middle_m = sum(full_width_m(case)) / 2.0
    return middle_m - case.slice.width_m / 2.0, middle_m + case.slice.width_m / 2.0


def cut_surface(case: Case, position_m: Array, triangles: Indices) -> tuple[Array, Indices]:
    """The part of a rigid surface, points (n, 3) and triangles (m, 3), that a case has: all of it,
    or what lies in its slice with the walls moved in."""
    if case.slice is None or case.whole is case:
        return position_m, triangles
    low, high = full_width_m(case.whole)
    move_in_m = (high - low - case.slice.width_m) / 2.0 if case.slice.sides == "walls" else None
    return slice_surfaces.cut(position_m, triangles, bounds_m(case.whole), move_in_m)


def sliced(case: Case) -> Case:
    """The case of the slice, or the case itself where it has none.  Raises CaseError where a slice
    makes no sense."""
    if case.slice is None:
        return case
    if found := _problems(case):
        raise CaseError(found)
    y_m, part = bounds_m(case), share(case)
    domain_m = case.domain_m
    if case.slice.sides == "periodic":
        domain_m = slice_tables.between(domain_m, y_m)
    update: dict[str, object] = {
        "screen": slice_tables.screen(case.screen, part, y_m),
        "bed": slice_tables.bed(case.bed, part, y_m),
        "domain_m": domain_m,
    }
    return case.cut_to(update)


def _problems(case: Case) -> list[CaseProblem]:
    assert case.slice is not None
    found = []
    for name, panel in case.screen.panels.items():
        if abs(panel.across[0]) + abs(panel.across[2]) > 1e-9:
            key: Key = ("screen", "panels", name, "across")
            found.append(CaseProblem(key, "a slice wants panels that run across along y"))
    if found:
        return found
    low, high = full_width_m(case)
    if case.slice.width_m > (high - low) * (1 + 1e-9):
        what = f"{case.slice.width_m:g} m is wider than the machine's {high - low:g} m"
        found.append(CaseProblem(("slice", "width_m"), what))
        return found
    y_m = bounds_m(case)
    for kind, rows in (("blocks", case.bed.blocks), ("feeds", case.bed.feeds)):
        for name, row in rows.items():
            if row.box_m[1][1] <= y_m[0] or y_m[1] <= row.box_m[0][1]:
                what = f"does not reach into the slice from y = {y_m[0]:g} to {y_m[1]:g} m"
                found.append(CaseProblem(("bed", kind, name, "box_m"), what))
    for name, particle in case.bed.particles.items():
        if not y_m[0] <= particle.position_m[1] < y_m[1]:
            key = ("bed", "particles", name, "position_m")
            found.append(CaseProblem(key, f"is not in the slice from y = {y_m[0]:g} to {y_m[1]:g} m"))
    return found + _through_openings(case) + _in_periodic(case)


def _through_openings(case: Case) -> list[CaseProblem]:
    """A slice that would cut openings, or lie partly in the strips without any."""
    assert case.slice is not None
    width_m = case.slice.width_m
    for name, panel in case.screen.panels.items():
        openings = panel.apertures
        if openings is None:
            continue
        pitch_m = openings.pitch_across_m
        most = int((panel.width_m - 2 * openings.margin_across_m) / pitch_m + 1e-6)
        pitches = width_m / pitch_m
        if abs(pitches - round(pitches)) > 1e-6 or pitches > most + 1e-6:
            what = f"{width_m:g} m is {pitches:.6g} pitches of the openings of panel {name}"
            fitting = max(min(round(pitches), most), 1)
            hint = f"take a whole number of at most {most}: {fitting * pitch_m:g} m is {fitting}"
            return [CaseProblem(("slice", "width_m"), what, hint)]
    return []


def _in_periodic(case: Case) -> list[CaseProblem]:
    """What cannot go on across periodic sides."""
    assert case.slice is not None
    if case.slice.sides == "walls":
        return []
    found = []
    particles = solvers.particles(case)
    if particles is not None and not particles.periodic and (case.bed.particles or case.bed.sources):
        others = solvers.those("particles", lambda able: able.periodic)
        what = f"particles.solver {case.particles.solver} has no periodic sides"
        hint = f'take "walls", or particles.solver = {others}'
        found.append(CaseProblem(("slice", "sides"), what, hint))
    if case.gravity_m_per_s2[1] != 0:
        found.append(CaseProblem(("gravity_m_per_s2",), "pulls along y, across periodic sides"))
    return found


def _sides_m(panel: PanelTable) -> tuple[float, float]:
    one = panel.corner_m[1]
    other = one + (panel.width_m if panel.across[1] > 0 else -panel.width_m)
    return min(one, other), max(one, other)
