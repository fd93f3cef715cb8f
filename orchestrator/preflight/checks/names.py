"""Names: each that is referred to must exist, and those that share a file must differ."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.errors import CaseProblem, Key, did_you_mean
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.quantities import GROUND


def unknown_names(case: Case) -> Iterator[CaseProblem]:
    """Frames, materials, panels and particles that are referred to but not there."""
    frames = [*case.screen.frames, GROUND]
    for key, name in _frames_named(case):
        yield from _known(key, name, frames, "frame")
    for key, name in _materials_named(case):
        yield from _known(key, name, case.materials, "material")
    panels = [panel.name for panel in single_panels(case)]
    for name, probe in case.probes.items():
        if probe.panel is not None:
            yield from _known(("probes", name, "panel"), probe.panel, panels, "panel")


def shared_names(case: Case) -> Iterator[CaseProblem]:
    """Frames, panels and surfaces, and frames and probes, are told apart by name alone."""
    screen = case.screen
    taken: dict[str, Key] = {GROUND: ("screen", "frames", GROUND)}
    keys: list[tuple[str, Key]] = [(name, ("screen", "frames", name)) for name in screen.frames]
    keys += [(p.name, ("screen", "panels", p.name)) for p in single_panels(case)]
    keys += [(name, ("screen", "surfaces", name)) for name in screen.surfaces]
    for name, key in keys:
        if name in taken:
            what = "is the ground's" if name == GROUND else f"is taken by {taken[name][1]}"
            yield CaseProblem(key, f'the name "{name}" {what}', "take another name")
        taken[name] = key
    for name in case.probes:
        if name in screen.frames:
            yield CaseProblem(("probes", name), f'the name "{name}" is a frame\'s', "take another name")


def _known(key: Key, name: str, known: Iterable[str], kind: str) -> Iterator[CaseProblem]:
    if name not in known:
        yield CaseProblem(key, f'no {kind} "{name}"', did_you_mean(name, known, f"{kind}s"))


def _frames_named(case: Case) -> Iterator[tuple[Key, str]]:
    screen = case.screen
    for name, bushing in screen.bushings.items():
        for end in (0, 1):
            yield ("screen", "bushings", name, "between", end), bushing.between[end]
    for name, panel in screen.panels.items():
        for end in (0, 1):
            yield ("screen", "panels", name, "frames", end), panel.frames[end]
        for stop, row in panel.stops.items():
            if row.frame is not None:
                yield ("screen", "panels", name, "stops", stop, "frame"), row.frame
    for name, exciter in screen.exciters.items():
        yield ("screen", "exciters", name, "frame"), exciter.frame
    for name, surface in screen.surfaces.items():
        yield ("screen", "surfaces", name, "frame"), surface.frame
    for name, probe in case.probes.items():
        if probe.frame is not None:
            yield ("probes", name, "frame"), probe.frame


def _materials_named(case: Case) -> Iterator[tuple[Key, str]]:
    for number, contact in enumerate(case.contacts):
        for end in (0, 1):
            yield ("contacts", number, "between", end), contact.between[end]
    for kind, rows in (("panels", case.screen.panels), ("surfaces", case.screen.surfaces)):
        for name, row in rows.items():
            yield ("screen", kind, name, "material"), row.material
    bed = case.bed
    for kind, grains in (("particles", bed.particles), ("blocks", bed.blocks), ("feeds", bed.feeds)):
        for name, grain in grains.items():
            yield ("bed", kind, name, "material"), grain.material
