"""The mounting of the proposed mats: thickness, clamps' angle and slack with which they hang in every turn.

Trials of one mat (``preflight/mats``) decide.  A mounting is wanted with which the empty mat hangs down in
every turn, with a mean peak of 30 to 50 g (the intensity of such mats in C. Yu, R. Geng and X. Wang, Minerals
11, 2021, 631, doi:10.3390/min11060631), also at strokes and speeds somewhat above and below, and if it is as
soft as a strip with free sides, which the edges of a mat are, and with half and twice the loss factor, the
range of polyurethane in the material library.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

from orchestrator.case.file.errors import CaseProblem
from orchestrator.cli.proposal.layout import Mounting
from orchestrator.cli.proposal.wishes import Wishes, down, problem
from orchestrator.preflight.mats.mats import remembered_regimes, trials_of
from orchestrator.preflight.mats.regime import Regime
from orchestrator.preflight.mats.trial import Trial
from orchestrator.preflight.scene.scene import Scene

THICKNESSES_M, ANGLES_DEG = (0.004, 0.0045, 0.005, 0.0055, 0.006), (15.0, 20.0, 25.0)
SLACKS = (0.0, 0.005, 0.01, 0.015, 0.02)
"""What is tried; slacks over the distance of the clamps."""
MOST_SLACK = (
    0.26  # of the stroke: the scene's mats pull nothing while slack, and real ones pull by their inertia
)
LEAST_G, MOST_G = 30.0, 50.0
SHORT_LIST = 4
FIRST_CELLS, FIRST_TURNS, CELLS, TURNS = 16, 8, 24, 12
SMALLER_STROKES = (0.85, 0.7, 0.55, 0.4)


class Shares(NamedTuple):
    """Stroke, speed, loss factor and hindered share of a trial, over those that are wanted."""

    stroke: float = 1.0
    speed: float = 1.0
    loss: float = 1.0
    hindered: float = 1.0


WANTED, SOFT = Shares(), Shares(hindered=0.0)
NEIGHBOURS = (
    SOFT,
    Shares(stroke=0.9),
    Shares(stroke=1.1),
    Shares(speed=0.95),
    Shares(speed=1.05),
    Shares(loss=0.5),
    Shares(loss=2.0),
)
"""What is beside the wanted stroke, speed and mat, at which the mats are to hang, too."""


@dataclass(frozen=True)
class Choice:
    """A mounting and the regimes of its mats, empty: one for each way in which mats are moved.

    ``has_room`` says whether they hang at ``NEIGHBOURS``, too.
    """

    mounting: Mounting
    regimes: tuple[Regime, ...]
    has_room: bool


def choose_mounting(moved: Scene) -> Choice | None:
    """Return the best mounting for the machine of a scene, or None if no mat hangs down in every turn."""
    trials = [trial for _, trial in trials_of(moved)]
    tried = _mountings(trials)
    first = _try(trials, tried, [WANTED], FIRST_CELLS, FIRST_TURNS)
    hanging = [number for number, (regimes,) in enumerate(first) if _all_hang(regimes)]
    hanging.sort(key=lambda number: _off_g(first[number][0]))
    short: list[Mounting] = []
    while hanging and len(short) < SHORT_LIST:
        next_few = [tried[number] for number in hanging[:SHORT_LIST]]
        soft = _try(trials, next_few, [SOFT], FIRST_CELLS, FIRST_TURNS)
        short += [mounting for mounting, (regimes,) in zip(next_few, soft, strict=True) if _all_hang(regimes)]
        del hanging[:SHORT_LIST]
    del short[SHORT_LIST:]
    around = [WANTED, *NEIGHBOURS]
    found = _try(trials, short, around, CELLS, TURNS) if short else []
    choices = [
        (not _all_hang(itertools.chain(*beside)), _off_g(beside[0]), number)
        for number, beside in enumerate(found)
        if _all_hang(beside[0])
    ]
    if not choices:
        return None
    lacks_room, _, number = min(choices)
    return Choice(short[number], found[number][0], not lacks_room)


def _try(
    trials: Sequence[Trial], mountings: Sequence[Mounting], around: Sequence[Shares], cells: int, turns: int
) -> list[list[tuple[Regime, ...]]]:
    """Return the regimes of all trials for each mounting, at and beside what is wanted."""
    cases = list(itertools.product(mountings, around, trials))
    tried = [_beside(_with(trial, mounting), shares) for mounting, shares, trial in cases]
    found = iter(remembered_regimes(tried, cells, turns))
    return [[tuple(next(found) for _ in trials) for _ in around] for _ in mountings]


def _all_hang(regimes: Iterable[Regime]) -> bool:
    """Return whether no mat arches up in any turn."""
    return not any(regime.turns_up for regime in regimes)


def no_hanging_mats(wishes: Wishes, moved: Scene) -> Iterator[CaseProblem]:
    """Yield the problem of a stroke and a speed at which no mat hangs, with a stroke at which one does."""
    at = f"{1e3 * wishes.stroke_m:.3g} mm and {30 / math.pi * wishes.speed_rad_per_s:.0f} rpm"
    what = f"at {at}, none of the mats that were tried hangs down in every turn"
    trials = [trial for _, trial in trials_of(moved)]
    for share in SMALLER_STROKES:
        both = [Shares(stroke=share), SOFT._replace(stroke=share)]
        found = _try(trials, _mountings(trials), both, FIRST_CELLS, FIRST_TURNS)
        if any(_all_hang(itertools.chain(*beside)) for beside in found):
            hint = f"give at most {down(1e3 * share * wishes.stroke_m):g} mm, or a lower --speed"
            yield problem("stroke", what, hint)
            return
    yield problem("stroke", what, "give a smaller --stroke or a lower --speed")


def _off_g(regimes: Sequence[Regime]) -> float:
    """Return how far the peaks of regimes are from the wanted range, first, and from its middle."""
    middle_g, half_g = (LEAST_G + MOST_G) / 2, (MOST_G - LEAST_G) / 2
    off_g = [abs(regime.mean_peak_g - middle_g) for regime in regimes]
    return sum(max(0.0, off - half_g) + 0.1 * off for off in off_g)


def _mountings(trials: Sequence[Trial]) -> Sequence[Mounting]:
    """Return the mountings that are tried, with round slacks with which the stroke stretches the mat."""
    longest = max(trials, key=lambda trial: trial.stroke_m)
    slacks_m = [round(slack * longest.plan.rectangle.span_m, 4) for slack in SLACKS]
    slacks_m = [slack_m for slack_m in slacks_m if slack_m <= MOST_SLACK * longest.stroke_m]
    return [Mounting(*row) for row in itertools.product(THICKNESSES_M, ANGLES_DEG, slacks_m)]


def _with(trial: Trial, mounting: Mounting) -> Trial:
    """Return a trial of the same mat, mounted otherwise between the same places."""
    at = trial.plan.rectangle
    mounted = replace(at, length_m=at.span_m + mounting.slack_m, clamp_angle_deg=mounting.clamp_angle_deg)
    return replace(trial, plan=replace(trial.plan, rectangle=mounted, thickness_m=mounting.thickness_m))


def _beside(trial: Trial, shares: Shares) -> Trial:
    """Return a trial at shares of its stroke, speed, loss factor and hindered share."""
    span_m, material = trial.plan.rectangle.span_m, trial.plan.material
    beside = trial.at(shares.stroke * trial.stroke_m, shares.speed * trial.speed_rad_per_s, span_m)
    branches = tuple((shares.loss * ratio, time_s) for ratio, time_s in material.branches)
    hindered_share = shares.hindered * trial.plan.hindered_share
    material = replace(material, branches=branches)
    return replace(beside, plan=replace(beside.plan, material=material, hindered_share=hindered_share))
