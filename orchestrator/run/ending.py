"""The end of a run, however it ended: its summary, its results and its pictures."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from resource import RUSAGE_SELF, getrusage
from typing import Any

from rich.console import Console

from orchestrator.case.file.slice import share
from orchestrator.figures.accuracy import Accuracy
from orchestrator.figures.figure import to_json
from orchestrator.figures.results import Results
from orchestrator.output.cycles import cycle_s
from orchestrator.output.records import summary, trust
from orchestrator.output.records.history import write_accelerations, write_results
from orchestrator.output.records.run_folder import HISTORY, LOG
from orchestrator.output.report.errors import errors_table
from orchestrator.output.results.compute import compute_results, record_error
from orchestrator.output.results.machine import acceleration_series, point_ranges
from orchestrator.output.results.observed import check_effects_by_run
from orchestrator.output.results.run_reader import RunReader
from orchestrator.output.subprocesses import python
from orchestrator.ports.acceleration import band_hz
from orchestrator.preflight.judge import JudgedCase
from orchestrator.preflight.judgement.account import Entry, lines_at_end
from orchestrator.preflight.judgement.catalogue import why_left_out
from orchestrator.preflight.stability.report import StabilityReport
from orchestrator.run.progress import Progress

KILLED = "stopped while its results were being made"  # what the summary says until they are


@dataclass(frozen=True)
class Ending:
    """The writer of a run's end; ``effects``, ``stability`` and ``accuracy`` are what was known before the
    run."""

    loaded: JudgedCase
    effects: Mapping[str, Entry]
    stability: StabilityReport
    folder: Path
    console: Console
    accuracy: Accuracy

    def write(self, progress: Progress, status: str, reason: str) -> dict[str, Any]:
        """Write ``summary.json`` and the pictures, and return the summary.

        ``status`` is "done", "interrupted" or "failed"; ``reason`` says why.  A run that is done
        may turn out to be doubtful or incomplete (``trust.py``).
        """
        case, folder, wall_s = self.loaded.case, self.folder, progress.wall_s
        stopwatch = progress.stopwatch
        particles_s = stopwatch.wall_s.get("particles", 0.0)
        figures = {
            "status": status,
            "reason": reason,
            "case": self.loaded.name,
            "level": self.loaded.level,
            "left_out": self.loaded.left_out,
            "effects": {name: entry.figures() for name, entry in self.effects.items()},
            "share_of_width": share(case.whole_machine),
            "cycle_s": cycle_s(case),
            "stability": self.stability.as_json(),
            "wall_s": wall_s,
            "processor_s": progress.processor_s,
            "processor_before_s": progress.processor_before_s,
            "peak_memory_MiB": getrusage(RUSAGE_SELF).ru_maxrss / 1024,
            "wall_by_part_s": summary.wall_by_part_s(stopwatch, wall_s),
            "repeated_by_part_s": stopwatch.repeated_s,
            "particle_steps_per_s": progress.particle_steps / particles_s if particles_s else 0.0,
            **progress.figures,
        }
        unfinished = {"status": "interrupted", "reason": KILLED} if status == trust.DONE else {}
        summary.write_summary(folder, figures | unfinished)
        if figures["sync_intervals"]:
            self._add_results(figures)
        figures["doubts"] = trust.doubts(figures) if status != "failed" else []
        figures["accuracy"] = errors_table(self.accuracy, figures)
        if status == trust.DONE:
            figures["status"] = trust.state_at_end(figures)
        summary.write_summary(folder, figures)
        if case.output.pictures and figures["sync_intervals"]:
            self._draw_pictures()
        return figures

    def _draw_pictures(self) -> None:
        """Draw the pictures in a process of their own.

        A failure is logged.  Ctrl-C ends the drawing alone, as all else of the run is written.
        """
        words = ("orchestrator.output.report.pictures", str(self.folder))
        try:
            process = python("-m", *words, alone=True, capture_output=True)
        except KeyboardInterrupt:
            LOG.warning("pictures are missing: stopped")
            self.console.print("pictures are missing: stopped")
            return
        if process.returncode:
            LOG.warning("no pictures: %s", process.stderr.strip().splitlines()[-1:])

    def _add_results(self, figures: dict[str, Any]) -> None:
        """Add the results to ``figures`` and to ``history.h5``.

        A part that fails is reported on the console and in the log; the other parts are still written.
        """
        failed: dict[str, str] = {}
        history = self.folder / HISTORY
        with _record_error(failed, "probes"), RunReader(self.folder) as reader:
            figures["probes"] = to_json(point_ranges(reader))
        with _record_error(failed, "everything"):
            results = compute_results(self.folder)
            failed |= results.failed
            with _record_error(failed, "effects"):
                self._check_effects(figures, results)
            results.failed = failed
            figures["results"] = to_json(results)
            write_results(history, figures["results"])
        with _record_error(failed, "accelerations"):
            self._write_accelerations()
        self._report_missing(figures, failed)

    def _write_accelerations(self) -> None:
        """Write the band-limited accelerations of frames and probes into ``history.h5``, after the run."""
        with RunReader(self.folder) as reader:
            time_s = reader.series_s()
            series = acceleration_series(reader)
        if series:
            write_accelerations(self.folder / HISTORY, series, band_hz(float(time_s[1] - time_s[0])))

    def _report_missing(self, figures: dict[str, Any], failed: Mapping[str, str]) -> None:
        """Report which results an internal error prevented, and make them the ``reason`` if there is none."""
        for part, error in failed.items():
            LOG.error("results not made: %s: %s", part, error)
            self.console.print(f"WARNING: results not made: {part}: {error}")
        if failed:
            what = f"results could not be made: {', '.join(failed)}"
            figures["reason"] = figures["reason"] or what

    def _check_effects(self, figures: dict[str, Any], results: Results) -> None:
        """Judge the effects again by the records of the run, and report the verdicts.

        If the run failed, the verdicts go to the log only: the last lines on the console then say why
        the run failed and how to go on.  The case of a run that goes on no longer describes what was left
        out by taking tables away, so that nothing can be judged of that.
        """
        told = {name: entry for name, entry in self.effects.items() if not self._is_gone(name, entry)}
        judged = check_effects_by_run(told, self.loaded.described, self.folder, results)
        after = {name: judged.get(name, entry) for name, entry in self.effects.items()}
        figures["effects"] = {name: entry.figures() for name, entry in after.items()}
        for line in lines_at_end(after):
            LOG.log(logging.WARNING if line.startswith("WARNING") else logging.INFO, line)
            if figures["status"] != "failed":
                self.console.print(line)

    def _is_gone(self, name: str, entry: Entry) -> bool:
        """Return whether an effect was left out by taking tables away that the case no longer has."""
        loaded = self.loaded
        return (
            bool(entry.left_out) and loaded.choice.described is None and not why_left_out(loaded.case, name)
        )


def _record_error(failed: dict[str, str], part: str) -> AbstractContextManager[None]:
    """Record in ``failed`` an error that prevents a part of the results, log its traceback, and go on."""
    return record_error(failed, part, partial(LOG.exception, "no %s", part))
