"""Whether cheap runs foretell dear ones: pairs of runs with the same seeds.

    python -m tools.paired_seeds CASE OUT --cheap SETTING [--cheap SETTING ...] [--dear SETTING]
        [--both SETTING] [--seeds 10] [--first 1] [--from SECONDS] [--to SECONDS]

A SETTING is a text of words: KEY=VALUE as of ``--set``, or the name of a level.  For each seed the tool runs
the dear setting and each cheap one with this seed in all feeds, unless the run is there, and adds a line to
OUT/pairs.csv.  The efficiency is that of what left between ``--from`` and ``--to`` (in the second half), and
the velocity is the run's own.  It prints, for each cheap setting,

- the correlation with the dear one over the seeds, with its 95 % interval by Fisher's z;
- the standard error of the mean efficiency for one processor hour, by the dear setting alone, by two levels
  (Giles, Operations Research 56(3), 2008, 607-617, doi 10.1287/opre.1070.0496) and with the cheap setting as
  a control variate of known coefficient; and the correlation from which the latter would pay.

Measured figures: docs/measured/accuracy.md, "Cheap runs beside dear ones".
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

import flipflow
from orchestrator.figures.short_names import value_at
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array
from tools.scatter import efficiencies

HOUR_S = 3600.0
NORMAL_95 = 1.96
FEWEST_PAIRS = 4  # of which Fisher's z has a variance
COLUMNS = (
    "setting",
    "seed",
    "status",
    "from_s",
    "to_s",
    "efficiency_percent",
    "velocity_m_per_s",
    "simulated_s",
    "processor_s",
    "own_start_s",
    "own_efficiency_percent",
    "own_half_width_percent",
    "own_standard_error_percent",
)


@dataclass(frozen=True)
class Levels:
    """The efficiencies of a cheap and a dear setting, and what a run of each costs.

    ``cheap`` and ``dear`` (pairs,) have the seeds in the same order, and the costs are in s of a processor.
    """

    cheap: Array
    dear: Array
    cheap_s: float
    dear_s: float

    @property
    def correlation(self) -> float:
        """The correlation coefficient over the pairs."""
        return float(np.corrcoef(self.cheap, self.dear)[0, 1])

    @property
    def interval(self) -> tuple[float, float]:
        """The 95 % interval of the correlation, by Fisher's z."""
        z, half = math.atanh(self.correlation), NORMAL_95 / math.sqrt(len(self.dear) - 3)
        return math.tanh(z - half), math.tanh(z + half)

    def dear_error(self, processor_s: float) -> float:
        """Return the standard error of the mean of dear runs alone that take this processor time."""
        return float(self.dear.std(ddof=1)) * math.sqrt(self.dear_s / processor_s)

    def two_level_error(self, processor_s: float) -> float:
        """Return the standard error of the mean of cheap runs plus the mean difference of pairs, where the
        time is divided at its best."""
        pair_s, difference = self.cheap_s + self.dear_s, float((self.dear - self.cheap).std(ddof=1))
        return _of_both(float(self.cheap.std(ddof=1)), self.cheap_s, difference, pair_s, processor_s)

    def controlled_error(self, processor_s: float, correlation: float | None = None) -> float:
        """Return the standard error with the cheap setting as a control variate, whose coefficient is the one
        that leaves least to chance, for a correlation or for the one that was measured."""
        r, deviation = self.correlation if correlation is None else correlation, float(self.dear.std(ddof=1))
        left = deviation * math.sqrt(1 - r**2)
        return _of_both(abs(r) * deviation, self.cheap_s, left, self.cheap_s + self.dear_s, processor_s)

    @property
    def pays_from(self) -> float:
        """The least correlation with which a control variate costs less than dear runs alone."""
        w = self.cheap_s / self.dear_s
        # |r| sqrt(w) + sqrt((1 - r^2) (1 + w)) < 1, with r = sin(angle)
        angle = math.atan2(math.sqrt(w), math.sqrt(1 + w)) + math.acos(1 / math.sqrt(1 + 2 * w))
        return math.sin(angle) if angle < math.pi / 2 else 1.0


def _of_both(first: float, first_s: float, second: float, second_s: float, processor_s: float) -> float:
    """Return the standard error of the sum of two independent means with these deviations and costs of a run,
    each with its best number of runs."""
    return (first * math.sqrt(first_s) + second * math.sqrt(second_s)) / math.sqrt(processor_s)


def made(given: argparse.Namespace, setting: str, seed: int, folder: Path) -> flipflow.Run | None:
    """Return the run of a setting with a seed, which is made if it is missing; None where it fails."""
    if (folder / "summary.json").exists():
        run = flipflow.open_run(folder)
        return None if run.status == "failed" else run
    words = f"{given.both} {setting}".split()
    level = next((word for word in words if "=" not in word), None)
    case = flipflow.load(given.case, level, [word for word in words if "=" in word])
    seeds = {f"bed.feeds.{name}.seed": seed for name in case.settings["bed"]["feeds"]}
    try:
        return case.change(seeds).run(folder)
    except flipflow.RunFailed as failed:
        print(f"{folder.name} fails: {failed}", flush=True)
        return None


def row(run: flipflow.Run, setting: str, seed: int, span_s: Sequence[float | None]) -> dict[str, Any]:
    """Return the line of a run for the table."""
    with RunReader(run.folder) as reader:
        from_s, to_s = (
            given or own for given, own in zip(span_s, (reader.end_s / 2, reader.end_s), strict=True)
        )
        own = value_at(run.summary, "efficiency")
        return {
            "setting": setting,
            "seed": seed,
            "status": run.status,
            "from_s": from_s,
            "to_s": to_s,
            "efficiency_percent": efficiencies(reader, from_s, to_s)[0],
            "velocity_m_per_s": getattr(value_at(run.summary, "velocity"), "value", None),
            "simulated_s": run.summary["simulated_s"],
            "processor_s": run.summary["processor_s"],
            "own_start_s": run.summary["results"]["steady"]["start_s"],
            "own_efficiency_percent": own and own.value,
            "own_half_width_percent": own and own.half_width,
            "own_standard_error_percent": run.summary["results"]["screening"]["efficiency_percent"].get(
                "standard_error"
            ),
        }


def print_pairs(name: str, column: str, levels: Levels) -> None:
    """Print what a column of the pairs says about a cheap setting."""
    low, high = levels.interval
    difference = levels.dear - levels.cheap
    off = NORMAL_95 * float(difference.std(ddof=1)) / math.sqrt(len(difference))
    print(f"{name}: {column}, {len(levels.dear)} pairs")
    for kind, values, cost_s in (
        ("cheap", levels.cheap, levels.cheap_s),
        ("dear", levels.dear, levels.dear_s),
    ):
        print(f"  {kind}: mean {values.mean():.4g}, deviation {values.std(ddof=1):.3g}, {cost_s:.1f} s each")
    print(f"  dear less cheap: {difference.mean():.3g} ± {off:.2g}, deviation {difference.std(ddof=1):.3g}")
    print(
        f"  correlation {levels.correlation:.2f} (95 %: {low:.2f} to {high:.2f}); "
        f"a control variate pays from {levels.pays_from:.2f}"
    )
    print(
        f"  standard error for a processor hour: dear alone {levels.dear_error(HOUR_S):.3g}, "
        f"two levels {levels.two_level_error(HOUR_S):.3g}, "
        f"control variate {levels.controlled_error(HOUR_S):.3g} "
        f"({levels.controlled_error(HOUR_S, low):.3g} and {levels.controlled_error(HOUR_S, high):.3g} "
        "at the ends of the interval)",
        flush=True,
    )


def main(words: Sequence[str]) -> None:
    """Make the runs that are missing, write OUT/pairs.csv, and print what the pairs say."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("case")
    parser.add_argument("out", type=Path)
    parser.add_argument("--cheap", action="append", required=True)
    parser.add_argument("--dear", default="")
    parser.add_argument("--both", default="")
    parser.add_argument("--seeds", type=int, default=10)
    parser.add_argument("--first", type=int, default=1)
    parser.add_argument("--from", dest="from_s", type=float)
    parser.add_argument("--to", dest="to_s", type=float)
    given = parser.parse_args(words)
    settings = {"dear": given.dear} | {f"cheap-{i}": text for i, text in enumerate(given.cheap, 1)}
    given.out.mkdir(parents=True, exist_ok=True)
    rows: dict[tuple[str, int], dict[str, Any]] = {}
    with (given.out / "pairs.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, COLUMNS)
        writer.writeheader()
        for seed in range(given.first, given.first + given.seeds):
            for name, setting in settings.items():
                run = made(given, setting, seed, given.out / f"{name}-{seed}")
                if run is not None:
                    rows[name, seed] = row(run, name, seed, (given.from_s, given.to_s))
                    writer.writerow(rows[name, seed])
                    file.flush()
    for name in [name for name in settings if name != "dear"]:
        print(f"{name}: {settings[name]}")
        for column in ("efficiency_percent", "velocity_m_per_s"):
            pairs = [
                (rows[name, seed], rows[kind, seed])
                for kind, seed in rows
                if kind == "dear" and (name, seed) in rows
            ]
            pairs = [each for each in pairs if None not in (each[0][column], each[1][column])]
            if len(pairs) < FEWEST_PAIRS:
                print(f"{name}: {column}, {len(pairs)} pairs, too few")
                continue
            cheap, dear, cheap_s, dear_s = (
                np.array([each[side][key] for each in pairs], dtype=float)
                for key in (column, "processor_s")
                for side in (0, 1)
            )
            print_pairs(name, column, Levels(cheap, dear, float(cheap_s.mean()), float(dear_s.mean())))


if __name__ == "__main__":
    main(sys.argv[1:])
