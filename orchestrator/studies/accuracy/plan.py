"""Which settings to take for a tolerance and a time, and what to give up where both do not fit."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from orchestrator.case.bed.sources import largest_diameter_m
from orchestrator.case.file.contents import has_particles
from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.slice import ENOUGH_DIAMETERS, full_width_m
from orchestrator.case.tables.case import Case
from orchestrator.output.cycles import cycle_s
from orchestrator.preflight.cost import in_words
from orchestrator.studies.accuracy.calibration import Timing
from orchestrator.studies.accuracy.stored import Candidate, Stored

SHARED = ("particles", "panel")  # parts that ranks divide among them
MOST_RANKS = 1024


@dataclass(frozen=True)
class Plan:
    """``chosen``: the cheapest within the tolerance, or None; it takes ``wall_s`` here."""

    case: Case
    study: Stored
    timing: Timing
    tolerance: float
    budget_s: float
    chosen: Candidate | None

    @property
    def wall_s(self) -> float:
        return math.inf if self.chosen is None else self._wall_s(self.chosen)

    @property
    def fits(self) -> bool:
        return self.wall_s <= self.budget_s

    def _wall_s(self, one: Candidate) -> float:
        return self.timing.wall_s(one.processor_s, self.case.duration_s)

    def coarser(self) -> Candidate | None:
        """The least error within the time."""
        return self.study.best(self.timing.affordable_s(self.budget_s, self.case.duration_s))

    def remedies(self) -> Iterator[str]:
        """What would make it fit, in words."""
        if self.chosen is not None:
            yield from self._shorter(self.chosen)
        coarser = self.coarser()
        if coarser is not None:
            yield (
                f"coarser: {_sets(coarser)} is off by {100 * coarser.error:.2g} % and takes "
                f"{in_words(self._wall_s(coarser))}"
            )
        if self.chosen is not None:
            yield from self._more_ranks()
            yield from self._narrower()

    def _shorter(self, one: Candidate) -> Iterator[str]:
        longest_s = self.case.duration_s
        duration_s = self.timing.duration_s(one.processor_s, self.budget_s, longest_s)
        cycle = cycle_s(self.case)
        if cycle < self.case.duration_s:
            cycles, every = math.floor(duration_s / cycle), round(self.case.duration_s / cycle)
            if cycles:
                seconds = f"duration_s={cycles * cycle:.4g}"
                yield f"fewer cycles: {cycles} of {every} ({seconds})"
        elif duration_s > 0:
            yield f"a shorter run: duration_s={duration_s:.3g}"

    def _more_ranks(self) -> Iterator[str]:
        shared_s, alone_s = self._parts_s()
        if alone_s < self.budget_s:
            ranks = math.ceil(shared_s / (self.budget_s - alone_s))
            if ranks <= MOST_RANKS:
                yield f"more ranks: mpirun -n {max(2, ranks)}, if they share their work perfectly"
                return
        yield "more ranks would not do: what they do not share takes too long"

    def _narrower(self) -> Iterator[str]:
        """A slice, where particles and panels are what takes the time."""
        shared_s, alone_s = self._parts_s()
        if not has_particles(self.case) or self.case.bed.particles or alone_s >= self.budget_s:
            return
        try:
            low, high = full_width_m(self.case.whole)
        except CaseError:
            return
        now_m = self.case.slice.width_m if self.case.slice else high - low
        width_m = now_m * (self.budget_s - alone_s) / shared_s
        if width_m >= ENOUGH_DIAMETERS * largest_diameter_m(self.case):
            yield f"a slice: slice.width_m={width_m:.3g} instead of {now_m:.3g} m"

    def _parts_s(self) -> tuple[float, float]:
        """Wall time of what ranks share, and of the rest."""
        parts_s = self.study.found["base"]["processor_by_part_s"]
        share = sum(parts_s.get(name, 0.0) for name in SHARED) / sum(parts_s.values())
        return share * self.wall_s, (1 - share) * self.wall_s


def planned(case: Case, study: Stored, timing: Timing, tolerance: float, budget_s: float) -> Plan:
    """The cheapest settings within the tolerance, whether or not they fit the budget."""
    return Plan(case, study, timing, tolerance, budget_s, study.cheapest(tolerance))


def _sets(one: Candidate) -> str:
    return " ".join(f"--set {each}" for each in one.sets) or "the case as it is"
