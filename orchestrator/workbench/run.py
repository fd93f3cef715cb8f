"""A run as studies know it."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import IO, Any, ClassVar

from orchestrator.coupling.ledger import share_created
from orchestrator.figures.results import entry_at, orbit_places, why_no_orbits, why_transient
from orchestrator.figures.short_names import Named, Value, named, value_at
from orchestrator.output.records import trust
from orchestrator.output.records.run_folder import is_at_work
from orchestrator.output.records.summary import worked_by_part_s
from orchestrator.output.results.frame_drives import drives
from orchestrator.output.results.machine import LARGEST_DRIFT
from orchestrator.output.results.quantities import (
    Metrics,
    Outcome,
    Question,
    half_width_of,
    measure,
    number_of,
    outcome,
    read_dataset,
)
from orchestrator.output.results.run_reader import summary_of
from orchestrator.output.results.tidy import single_numbers
from orchestrator.output.subprocesses import python
from orchestrator.ports import Array
from orchestrator.run.trials.scratch import MAIN, ONE_THREAD, run_words


@dataclass(frozen=True)
class Run:
    """A run, made or not, in its folder, as it was when it was first looked at."""

    folder: Path
    at_the_end: ClassVar[tuple[str, ...]] = trust.AT_THE_END
    """The states of runs that came to their end."""
    largest_drift: ClassVar[float] = LARGEST_DRIFT
    """The relative drift of amplitudes, in the cycles of the results, from which on nothing has settled."""

    def command(self, case: Path, level: str, sets: Sequence[str]) -> tuple[str, ...]:
        """Return the words of the command that makes the run of a case in this folder."""
        return run_words(case, level, sets, self.folder)

    @staticmethod
    def carry_out(words: Sequence[str], log: IO[str]) -> int:
        """Carry out a command of flipflow in a process of its own, and return its exit code."""
        whole = ("-c", MAIN, *words)
        return python(*whole, stdout=log, stderr=subprocess.STDOUT, env=ONE_THREAD).returncode

    @property
    def is_at_work(self) -> bool:
        """Whether a process is making it now."""
        return is_at_work(self.folder)

    @cached_property
    def summary(self) -> Mapping[str, Any]:
        """The content of its ``summary.json`` (docs/run-folder.md); {} without a readable file."""
        return summary_of(self.folder)

    @property
    def status(self) -> str:
        """Its state: done, doubtful, incomplete, interrupted or failed; "missing" where there is none."""
        return str(self.summary.get("status", "missing"))

    def came_to_its_end(self) -> bool:
        """Return whether it need not be made again; it may still be doubtful."""
        return self.status in self.at_the_end

    @property
    def is_trusted(self) -> bool:
        """Whether its figures may be used as data."""
        return trust.is_trusted(self.status)

    @property
    def outcome(self) -> Outcome:
        """What came of it, with the monitor's warnings; "stopped" where it ended by a reason in its case."""
        return outcome(self.folder)

    def is_over(self) -> bool:
        """Return whether it would end in the same way again: it was stopped, or came to its end."""
        return self.outcome != "not run"

    @staticmethod
    def named(name: str) -> Named:
        """Return what is known of a result by its short name or its path: its words, and the record of its
        figure.

        Raises KeyError, which suggests a similar name.
        """
        return named(name)

    def result(self, name: str) -> Value | None:
        """Return a result with its interval by its short name or its path; None where the run has none."""
        return value_at(self.summary, name)

    def entry(self, path: str) -> Any:
        """Return the entry of the summary at a path of keys with dots; None where there is none."""
        return entry_at(self.summary, path)

    @property
    def single_numbers(self) -> dict[str, float]:
        """Every single number of the results by its path, with the half width of its interval."""
        return dict(single_numbers(self.summary.get("results") or {}))

    @property
    def why_transient(self) -> tuple[str, str]:
        """Why a bed that is fed is not steady, and why the machine has not settled; empty if they are."""
        return why_transient(self.summary)

    @property
    def orbits(self) -> dict[str, str]:
        """The paths of the first harmonics of frames, probes on frames and pairs of frames, by name."""
        return orbit_places(self.summary)

    @property
    def why_no_orbits(self) -> str:
        """Why there are no first harmonics."""
        return why_no_orbits(self.summary)

    @property
    def share_created(self) -> float:
        """The share of the exchanged energy that the coupling created; negative where it was destroyed."""
        return share_created(self.summary)

    @property
    def worked_by_part_s(self) -> dict[str, float]:
        """The wall time in s by the part that worked: what a scheme repeats is in the parts of solvers."""
        return worked_by_part_s(self.summary)

    def number(self, question: Question) -> float:
        """Return the number that a question asks, in SI units.  Raises Unknown."""
        return number_of(question, self.folder)

    def half_width(self, question: Question) -> float | None:
        """Return half the width of the 95 % interval of that number; None without one.  Raises Unknown."""
        return half_width_of(question, self.folder)

    def dataset(self, name: str) -> Array:
        """Return a dataset of its time series.  Raises Unknown where there is none."""
        return read_dataset(self.folder, name)

    def metrics(self) -> Metrics:
        """Return the metrics by which runs are compared.  Raises KeyError for a run without shapes."""
        return measure(self.folder)

    def drives(self) -> list[str]:
        """Return the ``--set`` overlays of drives that move the frames as the run did.

        Raises CaseError for a machine that does not turn and for a run that is too short.
        """
        return drives(self.folder)
