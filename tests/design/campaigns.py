"""Studies whose runs are a noisy function, so that their whole course takes seconds."""

from __future__ import annotations

import zlib
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from orchestrator.studies.design.campaign import Campaign
from orchestrator.studies.design.study_file import Study, read_study
from orchestrator.studies.design.trials import Journal, Measured, Outcome, Trial

BELT: dict[str, Any] = {
    "title": "A belt",
    "case": ".",
    "goals": ["maximise speed"],
    "limits": ["share >= 60"],
    "factors": {"slope": {"range": [10.0, 30.0], "unit": "deg"}, "stroke": {"range": [2.0, 6.0]}},
    "set": {"screen.inclination_deg": "slope", "screen.stroke_m": "stroke / 1000"},
    "responses": {
        "speed": {"result": "results.speed", "unit": "m/s"},
        "share": {"result": "results.share", "unit": "%"},
    },
    "plan": {"runs": 7, "centres": 2},
    "search": {"runs": 3, "surrogate": "quadratic"},
}


def changed(table: Mapping[str, Any], changes: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table with other values; keys have dots, and None takes a key away."""
    new = {key: changed(value, {}) if isinstance(value, Mapping) else value for key, value in table.items()}
    for key, value in changes.items():
        first, _, rest = key.partition("/")
        if rest:
            new[first] = changed(new.get(first, {}), {rest: value})
        elif value is None:
            del new[first]
        else:
            new[first] = value
    return new


def write_study(folder: Path, **changes: Any) -> Path:
    """Write the study of a belt with changes, keys of tables separated by ``/``."""
    file = folder / "study.toml"
    file.write_text(tomli_w.dumps(changed(BELT, changes)), encoding="utf-8")
    return file


def belt(folder: Path, **changes: Any) -> Study:
    """Read the study of a belt with changes."""
    return read_study(write_study(folder, **changes))


def belt_truth(x: Mapping[str, float]) -> dict[str, float]:
    """Speed and share of a belt: steep and strong is fast, and separates badly."""
    slope, stroke = (x["slope"] - 20.0) / 10.0, (x["stroke"] - 4.0) / 2.0
    return {
        "speed": 1.3 + 0.7 * slope + 0.2 * stroke + 0.05 * slope * stroke,
        "share": 70.0 - 18.0 * slope - 9.0 * stroke - 3.0 * slope**2,
    }


@dataclass
class NoisyFunction:
    """An evaluator whose runs are a function with noise.

    ``store`` keeps what was run, as folders of runs do; ``made`` lists it in order.  ``deviations`` has
    what runs say of their noise where that is not so.  ``failing`` says of a setting why its run is no data.
    The run with the number ``killed_in`` is never ended.
    """

    study: Study
    truth: Callable[[Mapping[str, float]], dict[str, float]] = belt_truth
    noise: Mapping[str, float] = field(default_factory=lambda: {"speed": 0.01, "share": 0.5})
    deviations: Mapping[str, float | None] = field(default_factory=dict)
    failing: Callable[[Mapping[str, float]], str] = lambda x: ""
    wall_s: Callable[[Trial], float] = lambda trial: 60.0
    store: dict[str, Outcome] = field(default_factory=dict)
    killed_in: int = 0
    made: list[Trial] = field(default_factory=list)
    side_by_side: int = 1

    def outcomes(self, wanted: Iterable[Trial]) -> Iterator[Outcome]:
        """Yield the outcome of each trial when it has ended."""
        for trial in wanted:
            if trial.name not in self.store:
                if trial.number == self.killed_in:
                    raise Killed
                self.made.append(trial)
                self.store[trial.name] = self._run(trial)
            yield replace(self.store[trial.name], trial=trial)

    def _run(self, trial: Trial) -> Outcome:
        actual = self.study.actual(np.array(trial.setting))
        if why := self.failing(actual):
            return Outcome(trial, "failed", why, wall_s=self.wall_s(trial))
        measured = {}
        for name, value in self.truth(actual).items():
            rng = np.random.default_rng([trial.seed, zlib.crc32(name.encode())])
            deviation = self.noise.get(name, 0.0)
            noisy = value + deviation * float(rng.standard_normal())
            measured[name] = Measured(noisy, self.deviations.get(name, deviation or None))
        return Outcome(trial, "done", "", measured, wall_s=self.wall_s(trial), particle_steps=1000)


class Killed(BaseException):
    """The end of a study in the middle of a run."""


def campaign(study: Study, folder: Path, **evaluator: Any) -> Campaign:
    """Return a study under way whose runs are a function; its trials are written down in the folder."""
    return Campaign(study, NoisyFunction(study, **evaluator), Journal(folder / "runs"))


def run_all(study: Study, folder: Path, **evaluator: Any) -> Campaign:
    """Run a whole study."""
    whole = campaign(study, folder, **evaluator)
    list(whole.run())
    return whole
