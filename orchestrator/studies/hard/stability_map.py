"""The map of what stays stable: coupling scheme, sync interval, mass of the bed over the panel's.

``map.toml`` beside a case says which key changes the mass of the bed and how.  Sync intervals are
multiples of the largest safe one of the plain scheme (particles-first) at that mass, as the card
gives it, for every scheme alike: what a scheme gains is read off along a row.
"""

from __future__ import annotations

import csv
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

from annotated_types import Len
from pydantic import ValidationError

from orchestrator.case.file.errors import CaseError, from_validation
from orchestrator.case.file.toml_file import read_toml
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.quantities import OneLine, Positive, Table
from orchestrator.coupling.schemes import SCHEMES
from orchestrator.preflight.levels import load
from orchestrator.preflight.scene.scene import bed_kg
from orchestrator.studies.hard.cases import QUIET, interval_of, point
from orchestrator.studies.hard.outcome import REMARKS, outcome, remarks
from orchestrator.studies.sweep import Point

FILE = "map.toml"
PLAIN = "particles-first"
HEAD = ("scheme", "bed / panel", "interval / safe", "sync_interval_s", "outcome", *REMARKS)


class Axes(Table):
    """``map.toml``."""

    key: OneLine
    """The key that changes the mass of the bed."""
    values: Annotated[tuple[Positive, ...], Len(1)]
    """Its values."""
    multiples: Annotated[tuple[Positive, ...], Len(1)]
    """Sync intervals over the plain scheme's largest safe one."""
    sets: tuple[OneLine, ...] = ()
    """As ``--set``, for every run."""


@dataclass(frozen=True)
class Spot:
    """One run of the map; ``mass_ratio``: bed over panels, ``multiple``: sync interval over the
    plain scheme's largest safe one."""

    scheme: str
    mass_ratio: float
    multiple: float
    run: Point

    @property
    def outcome(self) -> str:
        return outcome(self.run.folder)

    def words(self) -> tuple[str, ...]:
        interval_s = self.run.loaded.case.coupling.sync_interval_s
        numbers = (f"{x:.3g}" for x in (self.mass_ratio, self.multiple, interval_s))
        return (self.scheme, *numbers, self.outcome, *remarks(self.run.folder))


def axes(case: Path) -> Axes:
    """Raises CaseError."""
    given = read_toml(case / FILE, case)
    try:
        return Axes.model_validate(given)
    except ValidationError as error:
        raise CaseError([*from_validation(error, Axes)]) from None


def spots(case: Path, out: Path) -> list[Spot]:
    """Every run of the map; none is run here.  Raises CaseError."""
    wanted = axes(case)
    found = []
    for value in wanted.values:
        sets = [*QUIET, *wanted.sets, f"{wanted.key}={value!r}"]
        ratio = mass_ratio(load(case, None, sets).case)
        plain = [*sets, f"coupling.scheme={PLAIN}"]
        for multiple in wanted.multiples:
            interval = interval_of(case, plain, multiple)
            for scheme in SCHEMES:
                name = f"{scheme}-{ratio:.3g}-{multiple:g}"
                own = [*sets, f"coupling.scheme={scheme}", *interval]
                found.append(Spot(scheme, ratio, multiple, point(case, name, own, out / name)))
    return found


def mass_ratio(case: Case) -> float:
    """Mass of the particles over that of the panels between their clamps."""
    panels_kg = sum(
        (panel.count * panel.length_m * panel.width_m * panel.thickness_m)
        * case.materials[panel.material].density_kg_per_m3
        for panel in case.screen.panels.values()
    )
    return bed_kg(case) / panels_kg


def write(found: Sequence[Spot], folder: Path) -> Path:
    """``map.csv``"""
    file = folder / "map.csv"
    with file.open("w", newline="", encoding="utf-8") as text:
        writer = csv.writer(text)
        writer.writerow(HEAD)
        writer.writerows(spot.words() for spot in found)
    return file
