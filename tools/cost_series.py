"""How well ``flipflow check`` predicts: ``python -m tools.cost_series [CASE ...]``.

Shipped cases are run for a short time, and the processor time that they took is compared with what
was predicted, part by part.  Processor time hardly depends on what else the machine does; another
processor's is another one.  Measured figures: docs/measured/cost.md.
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
"""Three cases that take seconds."""


@dataclass(frozen=True)
class Compared:
    """Processor time by part, of a thin and of a thick bed as predicted, and as taken."""

    name: str
    thin_s: dict[str, float]
    thick_s: dict[str, float]
    taken_s: dict[str, float]

    @property
    def ratio(self) -> float:
        """Predicted over taken; of a range its nearest end, 1 inside."""
        low, high, taken = (sum(x.values()) for x in (self.thin_s, self.thick_s, self.taken_s))
        return min(max(low / taken, min(1.0, high / taken)), max(high / taken, 1.0))

    def row(self) -> str:
        sums = [sum(x.values()) for x in (self.thin_s, self.thick_s, self.taken_s)]
        parts = ", ".join(
            f"{name} {self.thick_s.get(name, 0.0):.2f}/{taken_s:.2f}"
            for name, taken_s in self.taken_s.items()
        )
        said = f"{sums[0]:.1f}" if sums[0] == sums[1] else f"{sums[0]:.1f} to {sums[1]:.1f}"
        return f"| {self.name} | {said} | {sums[2]:.1f} | {self.ratio:.2f} | {parts} |"


def compared(name: str) -> Compared:
    """Run one of ``CASES``."""
    folder, level, sets = CASES[name]
    sets = [*sets, "output.pictures=false"]
    path = ROOT / "cases" / folder
    case = load_judged(path, level, sets).case
    at_start = particles_at_start(case)
    thin_s, thick_s = (predicted_parts_s(case, at_start, bed) for bed in (THIN, THICK))
    return Compared(name, thin_s, thick_s, parts_s(time_run(path, level, sets)))


def main(names: list[str]) -> None:
    print("| case | predicted / s | taken / s | ratio | parts: predicted/taken |")
    print("| --- | --- | --- | --- | --- |")
    for name in names or CASES:
        print(compared(name).row(), flush=True)


if __name__ == "__main__":
    main(sys.argv[1:])
