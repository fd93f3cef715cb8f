"""What buys accuracy: every knob by name, and those that a case has."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from orchestrator.case.file.errors import did_you_mean
from orchestrator.case.tables.case import Case
from orchestrator.studies.accuracy import coupling_knobs, panel_knobs, particle_knobs
from orchestrator.studies.accuracy.setting import Family, NotOffered, Setting


@dataclass(frozen=True)
class Knob:
    """``families``: of a case, with so many values each; raises NotOffered."""

    title: str
    families: Callable[[Case, int], list[Family]]


KNOBS = {
    "sync": Knob("sync interval", coupling_knobs.sync),
    "scheme": Knob("coupling scheme", coupling_knobs.scheme),
    "panel-mesh": Knob("panel mesh", panel_knobs.mesh),
    "panel-model": Knob("panel model", panel_knobs.model),
    "panel-step": Knob("panel's time step", panel_knobs.step),
    "particle-step": Knob("particles' time step", particle_knobs.step),
    "stiffness": Knob("stiffness of contacts", particle_knobs.stiffness),
    "slice": Knob("slice of the width", particle_knobs.width),
    "number": Knob("number of particles", particle_knobs.number),
    "cut-off": Knob("finest size fed", particle_knobs.cut_off),
}


@dataclass(frozen=True)
class Offer:
    """What a case can turn, and why it cannot turn the rest: knob -> reason."""

    families: tuple[Family, ...]
    missing: dict[str, str]

    def own(self, axis: str) -> Setting:
        """The case's own setting on an axis."""
        settings = (s for family in self.of(axis) for s in family.settings)
        return next((s for s in settings if not s.sets), Setting("as it is"))

    def of(self, axis: str) -> list[Family]:
        """Families on an axis."""
        return [family for family in self.families if family.axis == axis]

    @property
    def titles(self) -> dict[str, str]:
        """Of each axis: its knobs, in words."""
        return {
            axis: " or ".join(dict.fromkeys(KNOBS[one.knob].title for one in self.of(axis)))
            for axis in self.axes
        }

    @property
    def axes(self) -> list[str]:
        return list(dict.fromkeys(family.axis for family in self.families))


def offer(case: Case, names: Sequence[str], points: int) -> Offer:
    """Of the knobs named, ``points`` values each; "scheme=aitken+robin" has these variants only."""
    families: list[Family] = []
    missing = {}
    for each in names:
        name, _, only = each.partition("=")
        try:
            found = KNOBS[name].families(case, points)
            families += _chosen(found, only.split("+")) if only else found
        except NotOffered as why:
            missing[name] = str(why)
    return Offer(tuple(families), missing)


def _chosen(found: Sequence[Family], variants: Sequence[str]) -> list[Family]:
    """Raises NotOffered for one that there is not."""
    known = [one.variant for one in found]
    for name in variants:
        if name not in known:
            raise NotOffered(f'no variant "{name}"; {did_you_mean(name, known)}')
    return [one for one in found if one.variant in variants]
