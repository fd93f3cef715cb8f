"""Predictions against what models have taken: the tables of docs/measured/model_hierarchy.md."""

from __future__ import annotations

import math
import re
from collections.abc import Iterator

import pytest

from orchestrator.case.tables.case import Case
from orchestrator.preflight.cost import particles_at_start, predicted_parts_s, predicted_s
from orchestrator.preflight.judge import load_judged
from tests.runs.outside import ROOT

GOOD_TO = 3.0  # a factor, as cost.py says; busy machines differ by as much
TEXT = (ROOT / "docs/measured/model_hierarchy.md").read_text(encoding="utf-8")


def tables() -> Iterator[tuple[str, str, dict[tuple[str, str], float]]]:
    """Case, duration, and processor time in s by part and model."""
    for part in TEXT.split("`flipflow ladder cases/")[1:]:
        command = re.match(r"(\S+) --duration ([\d.]+)", part)
        assert command is not None
        rows = [re.split(r" ?\| ?", line.strip("| ")) for line in part.splitlines() if "|" in line]
        header, _, *body = rows
        column = header.index("processor s")
        taken = {(row[0], row[1]): float(row[column]) for row in body if len(row) == len(header)}
        yield command[1], command[2], taken


TABLES = list(tables())


def model(solver: str, along: int, across: int, integrator: str = "explicit") -> tuple[str, ...]:
    keys = {"solver": solver, "integrator": integrator, "step_s": 0.0, "cells": [along, across]}
    return tuple(f"panel.{key}={value}" for key, value in keys.items())


def models(case: Case) -> dict[tuple[str, str], tuple[str, ...]]:
    """``--set`` overlays of the tables' rows that need no other run."""
    along, across = case.panel.cells if case.panel.solver == "sheet" else (22, 8)
    fine = math.ceil(1.5 * along), math.ceil(1.5 * across)
    discrete, cap = "particles.solver=liggghts", "particles.largest_youngs_modulus_Pa"
    used_Pa = max(m.youngs_modulus_Pa or 0.0 for m in case.materials.values())
    now_Pa = min(used_Pa, case.particles.largest_youngs_modulus_Pa or used_Pa)
    return {
        ("panel", "rigid"): model("rigid", along, across),
        ("panel", "strip"): model("strip", along, 1),
        ("panel", "sheet coarse"): model("sheet", along // 2, across // 2),
        ("panel", "sheet"): model("sheet", along, across),
        ("panel", "sheet fine"): model("sheet", *fine),
        ("panel", "solid"): model("solid", fine[0], across // 2, "implicit"),
        **{("frames", name): (f"frames.solver={name}",) for name in ("two-mass", "planar", "exudyn")},
        ("particles", "none"): ("particles.solver=none",),
        ("particles", "coarser"): (discrete, "particles.coarse_graining=1.5"),
        ("particles", "softer"): (discrete, f"{cap}={now_Pa / 10:g}"),
        ("particles", "as it is"): (discrete,),
        ("particles", "stiffer"): (discrete, f"{cap}={now_Pa * 10:g}"),
    }


@pytest.mark.parametrize(("case", "duration", "taken"), TABLES, ids=[row[0] for row in TABLES])
def test_predictions_are_good_to_a_factor_of_three(
    case: str, duration: str, taken: dict[tuple[str, str], float]
) -> None:
    base = load_judged(ROOT / "cases" / case, "default", [f"duration_s={duration}"]).case
    compared = 0
    for row, overlays in models(base).items():
        if row in taken:
            sets = [f"duration_s={duration}", *overlays]
            found = load_judged(ROOT / "cases" / case, "default", sets).case
            said_s = predicted_s(found, particles_at_start(found))
            assert taken[row] / GOOD_TO < said_s < taken[row] * GOOD_TO, row
            compared += 1
    assert compared >= 5


def test_what_makes_a_run_dear() -> None:
    """Twice the time costs twice as much but for the start; particles and panels add to it, and the
    steps of a sheet go with the third power of its cells (their number, and the step)."""

    def of(*sets: str, at_start: int = 0) -> float:
        return predicted_s(load_judged(ROOT / "cases/quickstart", "default", sets).case, at_start)

    def of_panels(*sets: str) -> float:
        case = load_judged(ROOT / "cases/quickstart", "default", [*sets, "particles.solver=none"]).case
        return predicted_parts_s(case, 0)["panel"]

    half, whole = of("duration_s=0.25"), of("duration_s=0.5")
    nothing_s = 2 * half - whole
    assert 0.0 < nothing_s < half
    assert of(at_start=10_000) - whole == pytest.approx(2 * (of(at_start=5_000) - whole))
    cells = [of_panels(f"panel.cells=[{22 * n}, {4 * n}]") for n in (1, 2, 3)]
    assert cells[0] == pytest.approx(of_panels())
    assert (cells[2] - cells[0]) / (cells[1] - cells[0]) == pytest.approx(26 / 7)
