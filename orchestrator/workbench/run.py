"""A run as studies know it."""

from __future__ import annotations

import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import IO, Any, ClassVar

from orchestrator.coupling.ledger import share_created
from orchestrator.figures import results, short_names
from orchestrator.output.records import run_folder, summary, trust
from orchestrator.output.results import frame_drives, machine, quantities, run_reader, tidy
from orchestrator.output.subprocesses import python
from orchestrator.ports import Array
from orchestrator.run.trials.scratch import MAIN, ONE_THREAD, run_words


@dataclass(frozen=True)
class Run:
    """A run, made or not, in its folder, as it was when it was first looked at."""

    folder: Path
    at_the_end: ClassVar[tuple[str, ...]] = trust.AT_THE_END
    """The states of runs that came to their end."""
    largest_drift: ClassVar[float] = machine.LARGEST_DRIFT
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
        return run_folder.is_at_work(self.folder)

    @cached_property
    def summary(self) -> Mapping[str, Any]:
        """The content of its ``summary.json`` (docs/run-folder.md); {} without a readable file."""
        return run_reader.summary_of(self.folder)

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
    def outcome(self) -> quantities.Outcome:
        """What came of it, with the monitor's warnings; "stopped" where it ended by a reason in its case."""
        return quantities.outcome(self.folder)

    def is_over(self) -> bool:
        """Return whether it would end in the same way again: it was stopped, or came to its end."""
        return self.outcome != "not run"

    @staticmethod
    def named(name: str) -> short_names.Named:
        """Return what is known of a result by its short name or its path: its words, and the record of its
        figure.

        Raises KeyError, which suggests a similar name.
        """
        return short_names.named(name)

    def result(self, name: str) -> short_names.Value | None:
        """Return a result with its interval by its short name or its path; None where the run has none."""
        return short_names.value_at(self.summary, name)

    def entry(self, path: str) -> Any:
        """Return the entry of the summary at a path of keys with dots; None where there is none."""
        return results.entry_at(self.summary, path)

    @property
    def single_numbers(self) -> dict[str, float]:
        """Every single number of the results by its path, with the half width of its interval."""
        return dict(tidy.single_numbers(self.summary.get("results") or {}))

    @property
    def why_transient(self) -> tuple[str, str]:
        """Why a bed that is fed is not steady, and why the machine has not settled; empty if they are."""
        return results.why_transient(self.summary)

    @property
    def orbits(self) -> dict[str, str]:
        """The paths of the first harmonics of frames, probes on frames and pairs of frames, by name."""
        return results.orbit_places(self.summary)

    @property
    def why_no_orbits(self) -> str:
        """Why there are no first harmonics."""
        return results.why_no_orbits(self.summary)

    @property
    def share_created(self) -> float:
        """The share of the exchanged energy that the coupling created; negative where it was destroyed."""
        return share_created(self.summary)

    @property
    def worked_by_part_s(self) -> dict[str, float]:
        """The wall time in s by the part that worked: what a scheme repeats is in the parts of solvers."""
        return summary.worked_by_part_s(self.summary)

    @property
    def processor_by_part_s(self) -> dict[str, float]:
        """The processor time in s by part of the program."""
        return summary.processor_by_part_s(self.summary)

    def number(self, question: quantities.Question) -> float:
        """Return the number that a question asks, in SI units.  Raises Unknown."""
        return quantities.number_of(question, self.folder)

    def half_width(self, question: quantities.Question) -> float | None:
        """Return half the width of the 95 % interval of that number; None without one.  Raises Unknown."""
        return quantities.half_width_of(question, self.folder)

    def dataset(self, name: str) -> Array:
        """Return a dataset of its time series.  Raises Unknown where there is none."""
        return quantities.read_dataset(self.folder, name)

    def metrics(self) -> quantities.Metrics:
        """Return the metrics by which runs are compared.  Raises KeyError for a run without shapes."""
        return quantities.measure(self.folder)

    def drives(self) -> list[str]:
        """Return the ``--set`` overlays of drives that move the frames as the run did.

        Raises CaseError for a machine that does not turn and for a run that is too short.
        """
        return frame_drives.drives(self.folder)
