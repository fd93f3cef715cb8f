"""How the time of a run falls with the number of MPI ranks of one computer, and where more no longer pay.

LIGGGHTS's particles are divided among the ranks, and each panel belongs to one rank.  Frames, mapping,
coupling, monitor and output are not divided: Amdahl's law (G. M. Amdahl, AFIPS Conf. Proc. 30 (1967) 483-485,
doi 10.1145/1465482.1465560) with the borders between the ranks' parts.  Messages within a computer take no
time in it.  Equations and measurements: docs/how-large-how-long.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from orchestrator.case.bed.grains import largest_length_m
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.ports.decomposition import BORDER_COST, bordering_share, grids
from orchestrator.preflight.cost import RankShare, in_words, likely_transport_m_per_s, predicted_parts_s
from orchestrator.preflight.stability.report import case_with_scheme

UNEVENNESS = 1.15
"""Particles of the fullest rank over the mean, between 1 and the ratio above which the box is cut again."""
LISTED_DIAMETERS = 1.3
"""The distance up to which particles are listed as neighbours, over the largest diameter."""
WORTH = 0.75
"""Time on twice as many ranks over the time before, above which more ranks do not pay."""


@dataclass(frozen=True)
class RankTime:
    """The predicted wall time of a run on a number of ranks, divided into parts (s)."""

    ranks: int
    particles_s: float
    panels_s: float
    undivided_s: float

    @property
    def run_s(self) -> float:
        """The wall time of the whole run."""
        return self.particles_s + self.panels_s + self.undivided_s


def rank_time(case: Case, at_start: int, ranks: int) -> RankTime:
    """Return the predicted wall time of a case with ``at_start`` particles at t = 0 on so many ranks."""
    case = case_with_scheme(case)
    transport_m_per_s = likely_transport_m_per_s(case, at_start)
    panels = len(single_panels(case))
    bordering = _bordering(case, ranks) if ranks > 1 and has_particles(case) else 0.0
    share = RankShare(
        panels=math.ceil(panels / ranks) / max(panels, 1),
        particles=1.0 if ranks == 1 else min(1.0, UNEVENNESS * (1.0 + BORDER_COST * bordering) / ranks),
    )
    parts_s = predicted_parts_s(case, at_start, transport_m_per_s, share)
    particles_s, panels_s = parts_s.pop("particles"), parts_s.pop("panel")
    return RankTime(ranks, particles_s, panels_s, sum(parts_s.values()))


def rank_times(case: Case, at_start: int, most: int) -> list[RankTime]:
    """Return the predicted times on 1, 2, 4, ... ranks and on ``most``."""
    case = case_with_scheme(case)  # which takes a while to choose
    doubled = [2**k for k in range(most.bit_length()) if 2**k < most]
    return [rank_time(case, at_start, ranks) for ranks in [*doubled, most]]


def last_worth(times: list[RankTime]) -> RankTime:
    """Return the last of times on ever more ranks that is worth its ranks.

    Twice as many ranks are worth it where they take at most ``WORTH`` of the time.
    """
    best = times[0]
    for time in times[1:]:
        wanted = WORTH ** math.log2(time.ranks / best.ranks)
        if time.run_s > wanted * best.run_s:
            break
        best = time
    return best


def scaling_lines(case: Case, at_start: int, most: int) -> Iterator[str]:
    """Yield lines with the predicted wall times on up to ``most`` ranks, and where more no longer pay."""
    intervals = case.duration_s / case.coupling.sync_interval_s
    times = rank_times(case, at_start, most)
    yield (
        f"on up to {most} ranks of one computer, each with a core of its own (docs/how-large-how-long.md):"
    )
    yield "   ranks        run   per interval  speed-up   particles  panels  undivided"
    for time in times:
        parts_s = (time.particles_s, time.panels_s, time.undivided_s)
        particles, panels, undivided = (f"{100 * part_s / time.run_s:.0f} %" for part_s in parts_s)
        yield (
            f"  {time.ranks:6d} {in_words(time.run_s):>10} {1e3 * time.run_s / intervals:11.3g} ms "
            f"{times[0].run_s / time.run_s:9.1f}   {particles:>9}  {panels:>6}  {undivided:>9}"
        )
    worth = last_worth(times)
    if worth is times[-1]:
        yield f"  all {most} ranks pay: each doubling saves a quarter of the time or more"
    else:
        yield (
            f"  more than {worth.ranks} ranks do not pay: twice as many save less than a quarter of the "
            f"time; {_hindrance(case, at_start, times[times.index(worth) + 1])}"
        )


def _hindrance(case: Case, at_start: int, time: RankTime) -> str:
    """Return what takes the most of the time besides the particles' own work, in words."""
    transport_m_per_s = likely_transport_m_per_s(case, at_start)
    on_every_rank_s = predicted_parts_s(case, at_start, transport_m_per_s, RankShare(particles=0.0))
    causes = {
        "every rank makes all of LIGGGHTS's steps and moves the whole surface": on_every_rank_s["particles"],
        "frames, mapping, coupling and output are not divided among ranks": time.undivided_s,
        "there are no more panels than ranks": time.panels_s,
    }
    return max(causes, key=lambda cause: causes[cause])


def _bordering(case: Case, ranks: int) -> float:
    """Return the particles at the borders of a rank's part over those in it, for the best grid of parts."""
    length_m, width_m = _bed_sides_m(case)
    reach_m = LISTED_DIAMETERS * largest_length_m(case)
    return min(
        bordering_share((length_m / grid[0], width_m / grid[1], 1.0), grid, reach_m)
        for grid in grids(ranks)
        if grid[2] == 1
    )


def _bed_sides_m(case: Case) -> tuple[float, float]:
    """Return length and width of the deck on which particles lie; without panels, those of the domain."""
    rectangles = [panel.rectangle for panel in single_panels(case)]
    if not rectangles:
        (low_x_m, low_y_m, _), (high_x_m, high_y_m, _) = case.domain_m
        return high_x_m - low_x_m, high_y_m - low_y_m
    width_m = max(rectangle.corner_m[1] + rectangle.width_m for rectangle in rectangles) - min(
        rectangle.corner_m[1] for rectangle in rectangles
    )
    return sum(rectangle.span_m * rectangle.width_m for rectangle in rectangles) / width_m, width_m
