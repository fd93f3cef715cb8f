"""Trials of a study and what came of them, kept beside their runs.

A trial is a setting with a choice of random numbers; it is written down before its run begins, so that a
study that was ended at any moment goes on with the same trials.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any, Literal, NamedTuple, Protocol

from orchestrator.workbench import FolderUnusable, StudyFolder

Stage = Literal["centre", "cheap", "plan", "search", "confirm"]
DONE = "done"


class Prediction(NamedTuple):
    """What a surrogate said of a response: value and standard deviation on a scale, and of which result."""

    mean: float
    deviation: float
    scale: str = ""
    result: str = ""


@dataclass(frozen=True)
class Trial:
    """One run that is asked for: a coded setting, and the number that is added to the case's seeds.

    ``values`` has the setting in the factors' units; it is what was run, and stays where the ranges of the
    study are changed, on which the coded setting rests.  ``role`` says what a confirming run is of;
    ``predicted`` is what the surrogate said of each response when the trial was proposed.
    """

    number: int
    stage: Stage
    setting: tuple[float, ...]
    seed: int
    role: str = ""
    predicted: Mapping[str, Prediction] = field(default_factory=dict)
    values: Mapping[str, float] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The name of its run's folder."""
        return f"{self.number:04d}"


@dataclass(frozen=True)
class Measured:
    """A response of one run; ``deviation`` is the standard deviation of its noise, None where unknown."""

    value: float
    deviation: float | None = None


@dataclass(frozen=True)
class Outcome:
    """The result of a trial.

    ``status`` is the run's own; ``why`` says why the run is no data, and is empty where it is.
    ``not_steady`` says why the bed or the machine did not become steady, where a response depends on it.
    """

    trial: Trial
    status: str
    why: str = ""
    responses: Mapping[str, Measured] = field(default_factory=dict)
    wall_s: float = 0.0
    processor_s: float = 0.0
    particle_steps: int = 0
    not_steady: str = ""

    @property
    def is_data(self) -> bool:
        """Whether the surrogates may see it."""
        return not self.why


class Evaluator(Protocol):
    """What makes trials: runs of a case, or, in tests, a function with noise."""

    @property
    def side_by_side(self) -> int:
        """The number of trials that are made at a time."""
        ...

    def outcomes(self, wanted: Iterable[Trial]) -> Iterator[Outcome]:
        """Make trials, and yield what came of each in the order in which they end.

        The next trial is taken only when there is room for it, so that it may depend on what ended before.
        """
        ...


class Journal:
    """The trials of a study, each in a file beside its run's folder."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder

    def read(self) -> list[Trial]:
        """Read all trials, in order."""
        folder = StudyFolder(self.folder)
        return [
            _trial(file, folder.read_json(file.name))
            for file in sorted(self.folder.glob("[0-9]*.trial.json"))
        ]

    def write(self, trial: Trial) -> None:
        """Write a trial down."""
        self.folder.mkdir(parents=True, exist_ok=True)
        StudyFolder(self.folder).write_json(f"{trial.name}.trial.json", asdict(trial))


def _trial(file: Path, table: Any) -> Trial:
    """Return the trial that a file holds.  Raises FolderUnusable."""
    try:
        predicted = {name: Prediction(*told) for name, told in table.pop("predicted").items()}
        return Trial(**table | {"setting": tuple(table["setting"]), "predicted": predicted})
    except (KeyError, TypeError, AttributeError) as error:
        raise FolderUnusable(f"{file}: is not a trial of a study ({error})") from None
