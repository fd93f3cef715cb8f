"""The accuracy of the predictions of ``flipflow check``: ``python -m tools.cost_series [NAME ...]``.

The tool runs shipped cases for a short time, three of them with every model of panels, frames and particles,
and compares their processor time with the predicted time, part by part.  Processor time hardly depends on
other work of the machine up to its number of cores, but it differs between processors.  Measured figures:
docs/measured/cost.csv, which the test suite compares with the predictions.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Annotated

import typer

from orchestrator.case.tables.case import Case, has_particles
from orchestrator.cli.planning import time_run
from orchestrator.output.records.summary import processor_by_part_s
from orchestrator.preflight.cost import THICK, THIN, particles_at_start, predicted_parts_s
from orchestrator.preflight.judge import load_judged
from tests.runs.outside import ROOT

SHORT_RUNS: dict[str, tuple[str, str, list[str]]] = {
    "quickstart draft": ("quickstart", "draft", ["duration_s=0.2"]),
    "quickstart default": ("quickstart", "default", ["duration_s=0.2"]),
    "ball-on-panel draft": ("ball-on-panel", "draft", []),
    "empty-machine default": ("empty-machine", "default", ["duration_s=0.2"]),
    "panel-cycle default": ("panel-cycle", "default", ["duration_s=0.2"]),
    "motor-start draft": ("motor-start", "draft", ["duration_s=0.1"]),
    "ffs0827-empty draft": ("ffs0827-empty", "draft", ["duration_s=0.4"]),
    "ffs0827-panelpair draft": ("ffs0827-panelpair", "draft", ["duration_s=0.5"]),
    "ffs0827-slice dry": ("ffs0827-slice", "dry", ["duration_s=0.5"]),
    "banana draft": ("banana", "draft", ["duration_s=0.5"]),
    "quickstart draft, aitken": ("quickstart", "draft", ["duration_s=0.1", "coupling.scheme=aitken"]),
    "quickstart draft, quasi-newton": (
        "quickstart",
        "draft",
        ["duration_s=0.1", "coupling.scheme=quasi-newton"],
    ),
    "quickstart draft, robin": ("quickstart", "draft", ["duration_s=0.1", "coupling.scheme=robin"]),
}

DURATIONS_S = {"empty-machine": 0.6, "panel-cycle": 0.4, "quickstart": 0.5}
"""The cases that are run with every model, and the simulated time of each."""

WITHOUT_PICTURES = ("output.pictures=false",)

IN_THE_SUITE = ("quickstart draft", "ball-on-panel draft", "panel-cycle default")
"""Three cases whose runs take seconds, for the test suite."""


@dataclass(frozen=True)
class CostComparison:
    """The processor time of a case by part, in s: predicted for a thin and for a thick bed, and measured."""

    name: str
    thin_s: dict[str, float]
    thick_s: dict[str, float]
    measured_s: dict[str, float]

    @property
    def ratio(self) -> float:
        """The predicted over the measured time: 1 inside the predicted range, else by its nearest end."""
        low, high, measured = (sum(x.values()) for x in (self.thin_s, self.thick_s, self.measured_s))
        return min(max(low / measured, min(1.0, high / measured)), max(high / measured, 1.0))

    def row(self) -> str:
        """Return the row of the Markdown table."""
        sums = [sum(x.values()) for x in (self.thin_s, self.thick_s, self.measured_s)]
        parts = ", ".join(
            f"{name} {self.thick_s.get(name, 0.0):.2f}/{measured_s:.2f}"
            for name, measured_s in self.measured_s.items()
        )
        predicted = " to ".join(dict.fromkeys(f"{time_s:.1f}" for time_s in sums[:2]))
        return f"| {self.name} | {predicted} | {sums[2]:.1f} | {self.ratio:.2f} | {parts} |"


def models(case: Case) -> dict[str, tuple[str, ...]]:
    """Return the ``--set`` overlays by which a case gets each model of its parts, by the model's name."""
    along, across = case.panel.cells
    fine = math.ceil(1.5 * along), math.ceil(1.5 * across)

    def panel(solver: str, along: int, across: int, integrator: str = "explicit") -> tuple[str, ...]:
        keys = {"solver": solver, "integrator": integrator, "step_s": 0.0, "cells": [along, across]}
        return tuple(f"panel.{key}={value}" for key, value in keys.items())

    found = {
        "panel rigid": panel("rigid", along, across),
        "panel strip": panel("strip", along, 1),
        "panel sheet coarse": panel("sheet", along // 2, across // 2),
        "panel sheet": panel("sheet", along, across),
        "panel sheet fine": panel("sheet", *fine),
        "frames exudyn": ("frames.solver=exudyn",),
    }
    if not any(frame.drive for frame in case.screen.frames.values()):  # two-mass frames cannot be driven
        found["frames two-mass"] = ("frames.solver=two-mass",)
    if has_particles(case):
        used_Pa = max(m.youngs_modulus_Pa or 0.0 for m in case.materials.values())
        modulus_Pa = min(used_Pa, case.particles.largest_youngs_modulus_Pa or used_Pa)
        found["particles none"] = ("particles.solver=none",)
        found["particles coarser"] = ("particles.coarse_graining=1.5",)
        found["particles softer"] = (f"particles.largest_youngs_modulus_Pa={modulus_Pa / 10:g}",)
        found["particles stiffer"] = (f"particles.largest_youngs_modulus_Pa={modulus_Pa * 10:g}",)
    else:  # the solid of the loaded case would take an hour
        found["panel solid coarse"] = panel("solid", math.ceil(along / 1.5), across // 3, "implicit")
    return found


def runs_by_name() -> dict[str, tuple[str, str, list[str]]]:
    """Return case, level and ``--set`` overlays of every run: the short runs, and those with every model."""
    runs = dict(SHORT_RUNS)
    for folder, duration_s in DURATIONS_S.items():
        case = load_judged(ROOT / "cases" / folder, "default", []).case
        for name, overlays in models(case).items():
            runs[f"{folder}, {name}"] = folder, "default", [f"duration_s={duration_s}", *overlays]
    return runs


def predict(name: str) -> tuple[dict[str, float], dict[str, float]]:
    """Return the predicted processor time of a run of ``runs_by_name`` in s by part: for a thin bed, and for
    a thick one."""
    folder, level, sets = runs_by_name()[name]
    case = load_judged(ROOT / "cases" / folder, level, [*sets, *WITHOUT_PICTURES]).case
    at_start = particles_at_start(case)
    return predicted_parts_s(case, at_start, THIN), predicted_parts_s(case, at_start, THICK)


def compare(name: str) -> CostComparison:
    """Make one of the runs of ``runs_by_name``, and return its predicted and measured times."""
    folder, level, sets = runs_by_name()[name]
    summary = time_run(ROOT / "cases" / folder, level, [*sets, *WITHOUT_PICTURES])
    return CostComparison(name, *predict(name), processor_by_part_s(summary))


def main(names: Annotated[list[str] | None, typer.Argument()] = None) -> None:
    """Print predicted and measured processor times of the named runs, or of all runs."""
    print("| run | predicted / s | measured / s | ratio | parts: predicted/measured |")
    print("| --- | --- | --- | --- | --- |")
    for name in names or runs_by_name():
        print(compare(name).row(), flush=True)


if __name__ == "__main__":
    typer.run(main)
