"""Verdicts on the small test case and on one whose frame is driven."""

from __future__ import annotations

from pathlib import Path

from orchestrator.preflight.judge import JudgedCase
from orchestrator.preflight.judgement.catalogue import Judged, judge_effects
from tests.cases import CASE, load_case, loaded

APERTURES = (
    "screen.panels.deck.apertures={length_m=0.02, width_m=0.012, pitch_along_m=0.025, pitch_across_m=0.02}"
)
DEEP = APERTURES.replace("}", ", rims='deep', depth_m=0.006}")
TILTED = "screen.inclination_deg=20"
EXITS = 'screen.exits.under={product="undersize", box_m=[[-0.5, -0.5, -0.9], [0.5, 0.5, -0.3]]}'
BARE = CASE[: CASE.index("[bed.particles.ball]")] + CASE[CASE.index("[probes.middle]") :]
BEFORE_EXCITER = CASE[: CASE.index("[screen.exciters.shaft]")]
FROM_PANELS = CASE[CASE.index("[screen.panels.deck]") :]
STILL_CASE = BEFORE_EXCITER + FROM_PANELS
DRIVEN_CASE = (
    BEFORE_EXCITER
    + """
[screen.frames.driving.drive]
speed_rad_per_s = 80.0
amplitude_m = [0.003, 0.0, 0.002]
run_up_s = 0.1

"""
    + FROM_PANELS
)


def by_name(case: JudgedCase) -> dict[str, Judged]:
    return judge_effects(case.case)


def verdict(folder: Path, effect: str, *overrides: str) -> Judged:
    return by_name(loaded(folder, overrides))[effect]


def of_driven(folder: Path, effect: str, *overrides: str) -> Judged:
    return by_name(load_case(folder, DRIVEN_CASE, overrides))[effect]


def set_contact(row: str) -> str:
    """All contacts of the test case with other numbers for coal on PU."""
    other = 'between=["coal", "coal"], restitution=0.13, sliding_friction=0.36, rolling_friction=0'
    return f'contacts=[{{between=["coal", "PU"], restitution=0.34, {row}}}, {{{other}}}]'
