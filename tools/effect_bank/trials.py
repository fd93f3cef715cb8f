"""The runs of the bank: every scene as it is, and without each effect that can be left out of it.

The runs are points of a study, in folders of their own, and no run is made twice.
"""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from orchestrator.case.file.errors import CaseError
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports.clock import sample_s
from orchestrator.preflight.judge import JudgedCase, load_judged
from orchestrator.preflight.judgement.catalogue import EFFECTS, can_leave_out, has_effect, with_dependents
from orchestrator.studies import points as sweep
from orchestrator.studies.points import CaseStudy, seed_sets
from orchestrator.workbench import Case
from tools.effect_bank.bank import Scene

AS_IT_IS = ""
"""The name of the effect that is left out where no effect is left out."""


@dataclass(frozen=True)
class Trial:
    """A scene ``without`` an effect, or with all its effects (AS_IT_IS).

    ``runs`` has a run for each seed, or ``omitted`` says why there are none.  ``predicted_s`` is the
    predicted processor time of one run.
    """

    scene: str
    without: str
    runs: tuple[sweep.Point, ...] = ()
    predicted_s: float = 0.0
    omitted: str = ""

    @property
    def statuses(self) -> set[str]:
        """The states of all its runs; "missing" is the state of a run that has not been made."""
        return {one.status() for one in self.runs}

    @property
    def has_ended(self) -> bool:
        """Whether all its runs have come to their end, trusted or not."""
        return all(one.ended(one.run) for one in self.runs)

    @property
    def summaries(self) -> list[Mapping[str, Any]]:
        """The contents of ``summary.json`` of the runs that came to their end, trusted or not."""
        return [RunReader(one.folder).summary for one in self.runs if one.ended(one.run)]


@dataclass(frozen=True)
class SceneTrials:
    """A scene of the bank as it is loaded, with its trials; the first is the scene as it is."""

    name: str
    scene: Scene
    loaded: JudgedCase
    trials: tuple[Trial, ...]


def all_scenes(bank: Mapping[str, Scene], folder: Path, out: Path) -> list[SceneTrials]:
    """Return all scenes with their trials; nothing is run here.

    Raises CaseError with the problems of all scenes, each with the scene's name.
    """
    scenes, problems = [], []
    for name, scene in bank.items():
        try:
            scenes.append(try_scene(name, scene, folder, out))
        except CaseError as error:
            problems += [replace(one, file=f"scene {name}, {one.file}") for one in error.problems]
    if problems:
        raise CaseError(problems)
    return scenes


def try_scene(name: str, scene: Scene, folder: Path, out: Path) -> SceneTrials:
    """Check all trials of a scene, and return the scene with them; nothing is run here.

    ``folder`` is the folder of the bank's file, and ``out`` the folder of the study.  Raises CaseError if the
    scene itself has problems.  A problem that occurs only without an effect is the reason in ``omitted`` of
    the trial.
    """
    case = folder / scene.case
    sets = _sets(load_judged(case, scene.level, scene.sets), scene)
    first = _trial(name, AS_IT_IS, case, scene, sets, out)
    loaded = first.runs[0].loaded.judged
    here = [one for one in EFFECTS if has_effect(loaded.described, one)]
    trials = [first]
    for effect in here:
        if can_leave_out(loaded.described, effect) and (not scene.effects or effect in scene.effects):
            removed = with_dependents([effect], "")
            remaining = json.dumps([one for one in here if one not in removed])
            try:
                trials.append(_trial(name, effect, case, scene, [*sets, f"effects={remaining}"], out))
            except CaseError as error:
                trials.append(Trial(name, effect, omitted=str(error.problems[0])))
    return SceneTrials(name, scene, loaded, tuple(trials))


def _trial(name: str, without: str, case: Path, scene: Scene, sets: Sequence[str], out: Path) -> Trial:
    """Return the trial of a scene without an effect, checked.  Raises CaseError."""
    whole = f"{name}-without-{without}" if without else name
    bare = Case(load_judged(case, scene.level, sets))
    study = CaseStudy(case, scene.level, tuple(sets), out)
    runs = tuple(
        study.point(whole, seed_sets(bare, number), f"{whole}-seed{number}" if number else whole)
        for number in range(scene.seeds)
    )
    return Trial(name, without, runs, bare.predicted_s)


def _sets(loaded: JudgedCase, scene: Scene) -> list[str]:
    """Return the ``--set`` overlays of all runs of a scene.

    Unless the scene says otherwise, the runs write no pictures and no checkpoints, and rows as often as
    accelerations up to 500 Hz need them.
    """
    quiet = {
        "output.pictures": "false",
        "checkpoint.wall_min": "0.0",
        "output.series_s": repr(float(sample_s(loaded.case.coupling.sync_interval_s))),
    }
    if scene.duration_s is not None:
        quiet["duration_s"] = repr(scene.duration_s)
    given = {one.partition("=")[0].strip() for one in scene.sets}
    return [f"{key}={value}" for key, value in quiet.items() if key not in given] + [*scene.sets]


def every_run(scenes: Sequence[SceneTrials]) -> Iterator[tuple[sweep.Point, float]]:
    """Yield all runs of all scenes, with their predicted processor time in s."""
    for one in scenes:
        for trial in one.trials:
            for run in trial.runs:
                yield run, trial.predicted_s


def still_to_run(scenes: Sequence[SceneTrials]) -> dict[str, float]:
    """Return the predicted processor time, in s, of every run that has not ended, by the name of its folder.

    A run that failed is a result, too, and is not made again.
    """
    return {
        run.folder.name: cost_s
        for run, cost_s in every_run(scenes)
        if not run.ended(run.run) and run.status() != "failed"
    }


@dataclass
class Countdown:
    """A countdown of runs: it passes on the line of each run, with the time that the other runs will take.

    ``left_s`` is the predicted processor time, in s, of the runs that are still to be made, by the names of
    their folders.  Predictions are scaled by the time that the runs so far took.
    """

    left_s: Mapping[str, float]
    say: Callable[[str], None]
    now: Callable[[], float] = time.monotonic
    _began_s: float = field(init=False)
    _waiting: dict[str, float] = field(init=False)

    def __post_init__(self) -> None:
        """Start the clock."""
        self._began_s, self._waiting = self.now(), dict(self.left_s)

    def __call__(self, line: str) -> None:
        """Pass on a line, with the remaining time if it is the line of a run."""
        name = line.partition(":")[0]
        if name not in self._waiting:
            self.say(line)
            return
        del self._waiting[name]
        waiting_s = sum(self._waiting.values())
        done_s = sum(self.left_s.values()) - waiting_s
        wall_s = (self.now() - self._began_s) * waiting_s / done_s
        self.say(f"{line}; {len(self._waiting)} to go, about {in_time(wall_s)}")


def in_time(seconds: float) -> str:
    """Return a time in words: in seconds, or in minutes from a hundred seconds on."""
    return f"{seconds:.0f} s" if seconds < 100 else f"{seconds / 60:.0f} min"
