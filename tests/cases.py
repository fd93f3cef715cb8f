"""Functions by which a test writes a case: TOML text, of parts where it is long, in a folder that the test
may spoil.

``CASE`` is a small valid case; ``case_folder`` writes it or another one, ``load_case`` reads it as
a user's case is read, and ``complaints`` are what a user would be told.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

import tomli_w

from orchestrator.case.file.errors import CaseError, CaseProblem, dotted_key
from orchestrator.preflight.check import find_problems
from orchestrator.preflight.judge import JudgedCase, load_judged

CASE = """
title = "a test"
duration_s = 0.1
domain_m = [[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]

[materials.PU]
density_kg_per_m3 = 1150.0
hyperelastic = { c10_Pa = 0.7e6, c01_Pa = 2.8e6, bulk_modulus_Pa = 2e9 }

[materials.coal]
density_kg_per_m3 = 1430.0
youngs_modulus_Pa = 1e7
poisson_ratio = 0.3

[[contacts]]
between = ["coal", "PU"]
restitution = 0.34
sliding_friction = 0.47
rolling_friction = 0.0

[[contacts]]
between = ["coal", "coal"]
restitution = 0.13
sliding_friction = 0.36
rolling_friction = 0.0

[screen.frames.driving]
mass_kg = 76.0
inertia_kg_m2 = [2.0, 6.0, 6.0]
center_of_mass_m = [0.0, 0.1, 0.0]

[screen.bushings.isolation]
between = ["ground", "driving"]
positions_m = [[-0.4, 0.1, 0.0], [0.4, 0.1, 0.0]]
stiffness_N_per_m = [2e4, 3e4, 4e4]

[screen.exciters.shaft]
frame = "driving"
position_m = [0.0, 0.1, 0.0]
mass_moment_kg_m = 0.35
speed_rad_per_s = 78.5

[screen.panels.deck]
material = "PU"
frames = ["driving", "ground"]
corner_m = [0.0, 0.0, 0.0]
length_m = 0.3
width_m = 0.2
thickness_m = 0.004
clamp_m = 0.019
tension_m = 0.002

[bed.particles.ball]
position_m = [0.15, 0.1, 0.05]
sieve_size_m = 0.02
material = "coal"

[probes.middle]
panel = "deck"
at = [0.5, 0.5]
"""
LEVEL = """
about = "a test"
without = ["variation-across"]

[panel]
solver = "strip"
"""
# --set that adds a block and a feed
BLOCK = (
    'bed.blocks.coal={material="coal", box_m=[[0, 0, 0.1], [0.1, 0.1, 0.2]], count=1, '
    "sizes=[{smallest_m=0.01, largest_m=0.02, mass_fraction=1}]}"
)
FEED = (
    'bed.feeds.chute={material="coal", rate_kg_per_s=1, box_m=[[0, 0, 0.1], [0.1, 0.1, 0.2]], '
    "velocity_m_per_s=[0, 0, -1], sizes=[{smallest_m=0.01, largest_m=0.02, mass_fraction=1}]}"
)


def case_folder(folder: Path, case: str | Mapping[str, Any] = CASE, **levels: str) -> Path:
    """Write a case, a text or a table, and its levels into a folder; returns the folder."""
    (folder / "levels").mkdir(parents=True, exist_ok=True)
    (folder / "case.toml").write_text(case if isinstance(case, str) else tomli_w.dumps(case))
    for name, text in levels.items():
        (folder / "levels" / f"{name}.toml").write_text(text)
    return folder


def load_case(
    folder: Path,
    case: str | Mapping[str, Any] = CASE,
    overrides: Sequence[str] = (),
    level: str | None = None,
) -> JudgedCase:
    """Write a case and load it with some keys changed; it is judged, but not checked."""
    return load_judged(case_folder(folder, case), level, overrides)


def loaded(folder: Path, overrides: Sequence[str] = (), level: str | None = None) -> JudgedCase:
    """The test case with some keys changed."""
    return load_case(folder, CASE, overrides, level)


def problems(folder: Path, *overrides: str) -> list[CaseProblem]:
    """Return the problems that loading and checking find in the test case with some keys changed."""
    try:
        return find_problems(loaded(folder, overrides))
    except CaseError as error:
        return [*error.problems]


def keys_and_kinds(problems: Iterable[CaseProblem]) -> list[str]:
    """Return the key and the kind of each problem, such as "duration_s: out-of-range"."""
    return [f"{dotted_key(problem.key)}: {problem.kind}" for problem in problems]


def kinds(folder: Path, *overrides: str) -> list[str]:
    """Return the keys and kinds of the problems of the test case with some keys changed."""
    return keys_and_kinds(problems(folder, *overrides))


def complaints(folder: Path, *overrides: str) -> list[str]:
    """Return the problems that loading and checking find in the test case with some keys changed, as
    texts."""
    return [str(problem) for problem in problems(folder, *overrides)]


def only_complaint(folder: Path, *overrides: str) -> str:
    """The one and only complaint."""
    texts = complaints(folder, *overrides)
    assert len(texts) == 1, texts
    return texts[0]


def polyurethane(*branches: tuple[float, float]) -> str:
    """The panels' material "PU"; damped by ``branches`` of (ratio, relaxation time in s)."""
    rows = ", ".join(f"{{ ratio = {ratio}, relaxation_s = {time_s} }}" for ratio, time_s in branches)
    return f"""
[materials.PU]
density_kg_per_m3 = 1150.0
[materials.PU.hyperelastic]
c10_Pa = 0.7e6
c01_Pa = 2.8e6
bulk_modulus_Pa = 2.0e9
maxwell = [{rows}]
"""


def grains(name: str, density_kg_per_m3: float, youngs_modulus_Pa: float) -> str:
    """A material of particles, with Poisson's ratio 0.3."""
    return f"""
[materials.{name}]
density_kg_per_m3 = {density_kg_per_m3}
youngs_modulus_Pa = {youngs_modulus_Pa}
poisson_ratio = 0.3
"""


def contact(material: str, other: str, restitution: float, sliding: float, rolling: float = 0.0) -> str:
    """Return the TOML text of a contact between two materials; ``sliding`` and ``rolling`` are friction."""
    return f"""
[[contacts]]
between = ["{material}", "{other}"]
restitution = {restitution}
sliding_friction = {sliding}
rolling_friction = {rolling}
"""
