"""Combinations of settings, and the runs that measure them."""

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
from orchestrator.preflight.cost import particles_at_start, predicted_s
from orchestrator.studies.accuracy.refinement import Setting, joint_label, joint_sets
from orchestrator.studies.points import Point, is_random, point, sample_s, sampled_at, seeded
from orchestrator.studies.workers import Crew

BASE, ALONE, TOGETHER, REFERENCE, CALIBRATION = "base", "knob", "diagonal", "reference", "short"


@dataclass(frozen=True)
class Asked:
    """What a user asked for.  ``budget_s``: processor time that one run may take; ``seeds``: runs
    of each point with other random numbers."""

    case: Path
    level: str | None
    sets: tuple[str, ...]
    parameters: tuple[str, ...]
    values: int
    seeds: int
    budget_s: float
    out: Path
    crew: Crew
    judged_by: tuple[str, ...]


@dataclass(frozen=True)
class Combination:
    """The case with ``settings`` by axis; ``runs`` one for each seed, or ``omitted`` says why there
    are none."""

    kind: str
    name: str
    settings: dict[str, Setting] = field(default_factory=dict)
    runs: tuple[Point, ...] = ()
    predicted_s: float = 0.0
    omitted: str = ""

    @property
    def sets(self) -> tuple[str, ...]:
        return joint_sets(self.settings)

    @property
    def label(self) -> str:
        as_it_is = self.kind in (BASE, CALIBRATION)
        return "the case as it is" if as_it_is else joint_label(self.settings)

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
    if kind == ALONE:
        ((axis, setting),) = settings.items()
        return re.sub(r"[^\w.+-]+", "-", f"{axis}-{setting.label}").strip("-")
    if kind in (TOGETHER, REFERENCE):
        return f"together-{zlib.crc32(chr(10).join(joint_sets(settings)).encode()):08x}"
    return kind


def combination(
    asked: Asked, case: Case, shared: Sequence[str], kind: str, settings: dict[str, Setting]
) -> Combination:
    """Checked, and within the budget; ``case`` is the one as it is."""
    name = named(kind, settings)
    sets = [*asked.sets, *shared, *joint_sets(settings)]
    runs = []
    try:
        for number in range(asked.seeds if is_random(case) else 1):
            folder = asked.out / (f"{name}-seed{number}" if number else name)
            more = seeded(case, number)
            runs.append(point(asked.case, asked.level, [*sets, *more], name, folder))
    except CaseError as error:
        return Combination(kind, name, settings, omitted=str(error.problems[0]))
    there = runs[0].loaded.case
    return Combination(kind, name, settings, tuple(runs), predicted_s(there, particles_at_start(there)))


def scale(combinations: Sequence[Combination], measured_s: dict[str, float]) -> float:
    """What this machine takes, over what was predicted: median over points that were run."""
    ratios = [measured_s[one.name] / one.predicted_s for one in combinations if one.name in measured_s]
    return median(ratios) if ratios else 1.0


def part_s(case: Case, parts: int) -> float:
    """Returns how long a short run lasts: one of ``parts`` of the time in which all feeds run.  A
    case in which a feed does not begin is refused."""
    begun_s = max((feed.start_s for feed in case.bed.feeds.values()), default=0.0)
    return begun_s + (case.duration_s - begun_s) / parts
