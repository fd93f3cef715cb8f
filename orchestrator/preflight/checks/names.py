"""The checks of names: each name that is referred to must exist, and names in one file must differ."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.errors import CaseProblem, Key, did_you_mean
from orchestrator.case.materials.library import suggest
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.quantities import GROUND

REFERENCES = {
    "frame": (
        "screen.bushings.between",
        "screen.panels.frames",
        "screen.panels.stops.frame",
        "screen.exciters.frame",
        "screen.surfaces.frame",
        "probes.frame",
    ),
    "material": (
        "contacts.between",
        "screen.panels.material",
        "screen.surfaces.material",
        "bed.particles.material",
        "bed.blocks.material",
        "bed.feeds.material",
    ),
    "panel": ("probes.panel",),
}
"""Dotted paths of the keys that refer to frames, materials and panels by their names."""


def rows(case: Case, path: str) -> Iterator[tuple[Key, Any]]:
    """Yield each row or value at a dotted path of a case with its key.

    The path ``screen.panels.stops``, for example, leads to all stops of all panels.  Values that the
    case does not give are left out.
    """
    reached: list[tuple[Key, Any]] = [((), case)]
    for part in path.split("."):
        inner = [((*key, part), getattr(table, part)) for key, table in reached]
        reached = [row for key, value in inner for row in _members(key, value) if row[1] is not None]
    yield from reached


def _members(key: Key, value: Any) -> Iterator[tuple[Key, Any]]:
    match value:
        case dict():
            yield from (((*key, name), inner) for name, inner in value.items())
        case tuple():
            yield from (((*key, number), inner) for number, inner in enumerate(value))
        case _:
            yield key, value


def unknown_names(case: Case) -> Iterator[CaseProblem]:
    """Check that all frames, materials and panels that the case refers to exist."""
    known = {
        "frame": [*case.screen.frames, GROUND],
        "material": [*case.materials],
        "panel": [panel.name for panel in single_panels(case)],
    }
    for kind, paths in REFERENCES.items():
        for key, name in (row for path in paths for row in rows(case, path)):
            if name not in known[kind]:
                of_names = did_you_mean(name, known[kind], f"{kind}s")
                hint = suggest(name, known[kind]) if kind == "material" else of_names
                yield CaseProblem(key, f'no {kind} "{name}"', hint, kind="unknown-name")


def shared_names(case: Case) -> Iterator[CaseProblem]:
    """Check that frames, panels and surfaces have different names, and that no probe has a frame's name."""
    screen = case.screen
    owners: dict[str, Key] = {GROUND: ("screen", "frames", GROUND)}
    keys: list[tuple[str, Key]] = [(name, ("screen", "frames", name)) for name in screen.frames]
    keys += [(p.name, ("screen", "panels", p.name)) for p in single_panels(case)]
    keys += [(name, ("screen", "surfaces", name)) for name in screen.surfaces]
    for name, key in keys:
        if name in owners:
            what = "is reserved" if name == GROUND else f"is taken by {owners[name][1]}"
            yield CaseProblem(key, f'the name "{name}" {what}', "take another name")
        owners[name] = key
    for name in case.probes:
        if name in screen.frames:
            yield CaseProblem(("probes", name), f'the name "{name}" is taken by frames', "take another name")
