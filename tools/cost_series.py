"""The accuracy of the predictions of ``flipflow check``: ``python -m tools.cost_series [CASE ...]``.

The tool runs shipped cases for a short time, and compares their processor time with the predicted time, part
by part.  Processor time hardly depends on other work of the machine, but it differs between processors.
Measured figures: docs/measured/cost.md.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass

from orchestrator.preflight.cost import THICK, THIN, particles_at_start, predicted_parts_s
from orchestrator.preflight.judge import load_judged
from orchestrator.studies.accuracy.combinations import parts_s
from orchestrator.studies.accuracy.plan import time_run
from tests.runs.outside import ROOT

CASES = {
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
        predicted = f"{sums[0]:.1f}" if sums[0] == sums[1] else f"{sums[0]:.1f} to {sums[1]:.1f}"
        return f"| {self.name} | {predicted} | {sums[2]:.1f} | {self.ratio:.2f} | {parts} |"


def compare(name: str) -> CostComparison:
    """Run one of ``CASES``, and return its predicted and measured times."""
    folder, level, sets = CASES[name]
    sets = [*sets, "output.pictures=false"]
    path = ROOT / "cases" / folder
    case = load_judged(path, level, sets).case
    at_start = particles_at_start(case)
    thin_s, thick_s = (predicted_parts_s(case, at_start, bed) for bed in (THIN, THICK))
    return CostComparison(name, thin_s, thick_s, parts_s(time_run(path, level, sets)))


def main(names: list[str]) -> None:
    """Print the table of the named cases, or of all cases."""
    print("| case | predicted / s | taken / s | ratio | parts: predicted/taken |")
    print("| --- | --- | --- | --- | --- |")
    for name in names or CASES:
        print(compare(name).row(), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
