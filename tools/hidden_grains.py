"""Whether a calibration finds the grains of synthetic measurements: hidden settings, run and found again.

    python -m tools.hidden_grains OUT STUDY... [--hidden 10] [--known FACTOR ...]

Each STUDY is the folder of a design study whose runs are made.  The tool draws settings within its ranges
(seed 1), runs each study's case at each of them with other random numbers, takes the responses for
measurements with the noise of one run, and calibrates with every single study and with all together,
and with all where a factor is known.
OUT/hidden.csv has each factor with its hidden value and interval.

Measured figures: docs/measured/design.md, "Hidden grains".
"""

from __future__ import annotations

import argparse
import csv
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from orchestrator.studies.design.calibration import calibrate
from orchestrator.studies.design.campaign import Campaign
from orchestrator.studies.design.space import Space
from orchestrator.studies.design.study import DesignStudy
from orchestrator.studies.design.study_file import read_study
from orchestrator.studies.design.trials import Outcome, Trial
from orchestrator.studies.points import Crew

INSIDE = 0.9  # of the ranges: what is hidden does not lie at their ends
FIRST = 9001  # number of the first hidden run in a study's folder, beyond those of its plan


def hidden_settings(space: Space, count: int) -> list[Trial]:
    """Return the trials of hidden settings, with seeds that no run of a plan has."""
    coded = INSIDE * np.random.default_rng(1).uniform(-1, 1, (count, space.factors))
    return [Trial(FIRST + i, "plan", tuple(map(float, x)), FIRST + i) for i, x in enumerate(coded)]


def measured(campaign: Campaign, outcome: Outcome) -> Campaign:
    """Return a campaign whose targets are the responses of a run, with the noise of one run."""
    data, responses = campaign.data(), {}
    for number, (name, table) in enumerate(campaign.study.file.responses.items()):
        value = outcome.responses[name].value
        noise = float(np.sqrt(np.median(data.variance[:, number])) / campaign.scales[name].slope(value))
        responses[name] = table.model_copy(update={"target": value, "target_deviation": noise})
    file = campaign.study.file.model_copy(update={"responses": responses})
    return Campaign(
        replace(campaign.study, file=file), campaign.evaluator, campaign.journal, campaign.outcomes
    )


def rows(designs: Sequence[DesignStudy], count: int, given: Sequence[str]) -> Iterator[dict[str, object]]:
    """Yield a row for each hidden setting, each study and all together, and each factor.

    All together are calibrated again with each of the factors ``given`` as known.
    """
    trials = [
        replace(trial, values=designs[0].study.actual(np.array(trial.setting)))
        for trial in hidden_settings(designs[0].study.space, count)
    ]
    each = [list(design.runs.outcomes(trials)) for design in designs]
    for place, trial in enumerate(trials):
        campaigns = {
            design.study.path(design.study.file.case).name: measured(design.campaign, outcomes[place])
            for design, outcomes in zip(designs, each, strict=True)
        }
        together = list(campaigns.values())
        sets: dict[str, tuple[list[Campaign], Mapping[str, float]]] = {"all": (together, {})}
        sets |= {name: ([campaign], {}) for name, campaign in campaigns.items()}
        for known in given:
            sets[f"all, {known} known"] = together, {known: trial.values[known]}
        for name, (chosen, values) in sets.items():
            for factor in calibrate(chosen, values).factors():
                yield {
                    "hidden": place + 1,
                    "measured": name,
                    "factor": factor.name,
                    "value": round(trial.values[factor.name], 4),
                    "likeliest": round(factor.likeliest, 4),
                    "low": round(factor.low, 4),
                    "high": round(factor.high, 4),
                    "is_found": factor.is_found,
                }


def main() -> None:
    """Run and calibrate, and print how many factors were found, and how many intervals hold the truth."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("out", type=Path)
    parser.add_argument("studies", type=Path, nargs="+")
    parser.add_argument("--hidden", type=int, default=10)
    parser.add_argument("--known", action="append", default=[])
    given = parser.parse_args()
    designs = [DesignStudy(read_study(study), Crew(1), study) for study in given.studies]
    for design in designs:
        design.load_finished()
    table = list(rows(designs, given.hidden, given.known))
    given.out.mkdir(parents=True, exist_ok=True)
    with (given.out / "hidden.csv").open("w", newline="") as file:
        writer = csv.DictWriter(file, table[0])
        writer.writeheader()
        writer.writerows(table)
    for name, factor in dict.fromkeys((str(row["measured"]), str(row["factor"])) for row in table):
        mine = [row for row in table if (row["measured"], row["factor"]) == (name, factor)]
        held = sum(float(str(r["low"])) <= float(str(r["value"])) <= float(str(r["high"])) for r in mine)
        found = sum(bool(row["is_found"]) for row in mine)
        print(f"{name}, {factor}: {held} of {len(mine)} intervals hold the value, {found} are narrow")


if __name__ == "__main__":
    main()
