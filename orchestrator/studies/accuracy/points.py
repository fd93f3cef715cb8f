"""The points of a study: settings taken together, and the runs that measure them."""

from __future__ import annotations

import re
import zlib
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from pathlib import Path
from statistics import median

from orchestrator.case.file.errors import CaseError
from orchestrator.case.tables.case import Case
from orchestrator.output.records import trust
from orchestrator.ports.clock import exact
from orchestrator.preflight.check import mistakes
from orchestrator.preflight.cost import particles_at_start, predicted_s
from orchestrator.preflight.levels import LoadedCase, load
from orchestrator.studies import points as sweep
from orchestrator.studies.accuracy.setting import Setting
from orchestrator.studies.points import is_random, sample_s, sampled_at, seeded
from orchestrator.studies.workers import Crew

BASE, KNOB, TOGETHER, REFERENCE, CALIBRATION = "base", "knob", "diagonal", "reference", "short"


@dataclass(frozen=True)
class Asked:
    """What a user asked for.  ``budget_s``: processor time that one run may take; ``seeds``: runs
    of each point with other random numbers."""

    case: Path
    level: str | None
    sets: tuple[str, ...]
    knobs: tuple[str, ...]
    values: int
    seeds: int
    budget_s: float
    out: Path
    crew: Crew
    judged_by: tuple[str, ...]


@dataclass(frozen=True)
class Point:
    """The case with ``settings`` by axis; ``runs`` one for each seed, or ``omitted`` says why there
    are none."""

    kind: str
    name: str
    settings: dict[str, Setting] = field(default_factory=dict)
    runs: tuple[sweep.Point, ...] = ()
    predicted_s: float = 0.0
    omitted: str = ""

    @property
    def sets(self) -> tuple[str, ...]:
        """In the order of the axes."""
        return tuple(one for setting in self.settings.values() for one in setting.sets)

    @property
    def label(self) -> str:
        """In words."""
        if self.kind in (BASE, CALIBRATION):
            return "the case as it is"
        return "; ".join(f"{axis}: {one.label}" for axis, one in self.settings.items())

    @property
    def ended(self) -> bool:
        """Whether all its runs have come to an end, well or not."""
        ends = (*trust.AT_THE_END, "failed")
        return bool(self.runs) and all(one.status() in ends for one in self.runs)

    @property
    def done(self) -> bool:
        return bool(self.runs) and all(one.status() == "done" for one in self.runs)


def common(case: Case, coarsest_s: float) -> tuple[str, ...]:
    """``--set`` overlays of all points alike: written at the same times by all sync intervals down
    from ``coarsest_s``, and lasting for whole samples.  A watch that shortens intervals only warns:
    an interval is what its label says."""
    every = sample_s(coarsest_s)
    shortens = [name for name, then in case.monitor.model_dump().items() if then == "shorten"]
    return (
        *(f"monitor.{name}=warn" for name in shortens),
        *sampled_at(coarsest_s),
        f"output.interval_s={_whole(exact(case.output.interval_s), every)!r}",
        f"duration_s={_whole(exact(case.duration_s), every)!r}",
        "checkpoint.wall_min=0.0",
    )


def _whole(time_s: Fraction, every: Fraction) -> float:
    return float(max(1, round(time_s / every)) * every)


def named(kind: str, settings: dict[str, Setting]) -> str:
    """A folder's name; what is taken together goes by a checksum of what it is."""
    if kind == KNOB:
        ((axis, setting),) = settings.items()
        return re.sub(r"[^\w.+-]+", "-", f"{axis}-{setting.label}").strip("-")
    if kind in (TOGETHER, REFERENCE):
        sets = "\n".join(one for setting in settings.values() for one in setting.sets)
        return f"together-{zlib.crc32(sets.encode()):08x}"
    return kind


def point(asked: Asked, case: Case, shared: Sequence[str], kind: str, settings: dict[str, Setting]) -> Point:
    """Checked, and within the budget; ``case`` is the one as it is."""
    name = named(kind, settings)
    sets = [*asked.sets, *shared, *(one for setting in settings.values() for one in setting.sets)]
    runs = []
    try:
        for number in range(asked.seeds if is_random(case) else 1):
            folder = asked.out / (f"{name}-seed{number}" if number else name)
            more = seeded(case, number)
            runs.append(sweep.point(asked.case, asked.level, [*sets, *more], name, folder))
    except CaseError as error:
        return Point(kind, name, settings, omitted=str(error.mistakes[0]))
    there = runs[0].loaded.case
    return Point(kind, name, settings, tuple(runs), predicted_s(there, particles_at_start(there)))


def scale(points: Sequence[Point], measured_s: dict[str, float]) -> float:
    """What this machine takes, over what was predicted: median over points that were run."""
    ratios = [measured_s[one.name] / one.predicted_s for one in points if one.name in measured_s]
    return median(ratios) if ratios else 1.0


def checked(asked: Asked) -> LoadedCase:
    """The case as it is.  Raises CaseError."""
    loaded = load(asked.case, asked.level, asked.sets)
    if wrong := mistakes(loaded):
        raise CaseError(wrong)
    return loaded
