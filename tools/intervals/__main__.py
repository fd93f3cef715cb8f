"""How often the intervals of single runs hold: ``python -m tools.intervals RUNS [--seeds 30]``.

The tool runs three small cases with other random numbers each time, into the folder RUNS, unless they were
run before.  For each headline figure of each case it compares the intervals with the scatter between the
runs.  Measured figures: docs/measured/screening.md, "Intervals of single runs".
"""

from __future__ import annotations

import sys
from argparse import ArgumentParser
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from subprocess import run
from typing import Any

import numpy as np

from orchestrator.figures.short_names import value_at
from orchestrator.output.records.run_folder import SUMMARY
from orchestrator.output.results.compute import compute_results

CASES = {"gap": ("chute", "middle"), "linear": ("chute", "middle"), "strips": ("coal", "middle-1")}
"""The cases beside this file, with the names of their feed and of the probe on a panel."""
FIGURES = {
    "efficiency": "results.screening.efficiency_percent",
    "fines recovered": "results.screening.recovered_percent",
    "oversize yield": "results.screening.oversize_yield_percent",
    "feed": "results.screening.feed_kg_per_s",
    "material velocity": "results.bed.velocity_m_per_s",
    "mass on the deck": "results.bed.on_deck_kg",
    "height of the bed": "results.bed.mean_depth_m",
    "relative amplitude": "results.motion.relative.driven-driving.along_m",
    "force on the ground, horizontal": "results.motion.ground.amplitude_N.x",
    "force on the ground, vertical": "results.motion.ground.amplitude_N.z",
    "peak acceleration of a panel": "results.motion.panel_points.{probe}.cycle_peak_g",
    "RMS acceleration of a panel": "results.motion.panel_points.{probe}.rms_g",
    "power of the drives": "results.power.drives_W",
}
NORMAL_95 = 1.96
FEWEST_RUNS = 5
EXACT = 1e-6  # a figure that scatters by less does not depend on chance


@dataclass(frozen=True)
class Compared:
    """The intervals of a figure beside its scatter between runs.

    ``ratio`` (runs,) is half the width over 1.96 standard deviations between the runs, and ``held`` (runs,)
    whether the interval has the mean of the other runs.  ``cycles`` is the mean number of cycles.
    """

    figure: str
    value: float
    deviation: float
    cycles: float
    ratio: Any
    held: Any

    @property
    def row(self) -> str:
        """The row of the table."""
        right = np.mean((self.ratio >= 0.5) & (self.ratio <= 2.0))
        return (
            f"{self.figure} | {len(self.held)} | {self.cycles:.0f} | {self.value:.4g} | "
            f"{self.deviation:.2g} | {np.median(self.ratio):.2f} | {100 * right:.0f} % | "
            f"{100 * self.held.mean():.0f} %"
        )


def main(words: list[str]) -> None:
    """Make the runs that are missing, and print the table."""
    parser = ArgumentParser(description=__doc__)
    parser.add_argument("runs", type=Path)
    parser.add_argument("--seeds", type=int, default=30)
    given = parser.parse_args(words)
    print("| case | figure | runs | cycles | mean | deviation | ratio, median | ratio 0.5 to 2 | held |")
    print("| --- | --- | --- | --- | --- | --- | --- | --- | --- |")
    every: list[Compared] = []
    for case, (feed, probe) in CASES.items():
        folders = [made(given.runs, case, feed, seed) for seed in range(given.seeds)]
        for one in compare([{"results": compute_results(folder)} for folder in folders], probe):
            print(f"| {case} | {one.row} |", flush=True)
            every.append(one)
    held, ratio = (np.concatenate([getattr(one, name) for one in every]) for name in ("held", "ratio"))
    right = np.mean((ratio >= 0.5) & (ratio <= 2.0))
    print(f"all: {len(held)} intervals, ratio 0.5 to 2: {100 * right:.1f} %, held: {100 * held.mean():.1f} %")


def made(runs: Path, case: str, feed: str, seed: int) -> Path:
    """Return the folder of a run, which is made if it is missing."""
    folder = runs / f"{case}-{seed}"
    if not (folder / SUMMARY).exists():
        words = ["run", str(Path(__file__).with_name(case)), "--out", str(folder)]
        words += ["--set", f"bed.feeds.{feed}.seed={seed}"]
        run([Path(sys.executable).with_name("flipflow"), *words], check=False, capture_output=True)
    return folder


def compare(tables: list[dict[str, Any]], probe: str) -> Iterator[Compared]:
    """Yield the comparison of each figure that enough runs have with an interval."""
    for figure, path in FIGURES.items():
        entries = [value_at(table, path.format(probe=probe)) for table in tables]
        known = [
            (entry, table) for entry, table in zip(entries, tables, strict=True) if entry and entry.half_width
        ]
        if len(known) < FEWEST_RUNS:
            continue
        value, width = (
            np.array([getattr(entry, name) for entry, _ in known]) for name in ("value", "half_width")
        )
        deviation, count = float(value.std(ddof=1)), len(known)
        if deviation < EXACT * abs(value.mean()):
            continue
        others = (value.sum() - value) / (count - 1)
        part = "motion" if ".motion." in path else "steady"
        cycles = float(np.mean([table["results"][part]["cycles"] for _, table in known]))
        held = np.abs(value - others) <= width * np.sqrt(1 + 1 / (count - 1))
        yield Compared(figure, float(value.mean()), deviation, cycles, width / (NORMAL_95 * deviation), held)


if __name__ == "__main__":
    main(sys.argv[1:])
