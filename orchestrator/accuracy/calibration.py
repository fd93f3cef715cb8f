"""A short run on this machine, and what a long one takes by it.

Time of a run = start + rate x simulated time.  A study has a short and a whole run of the case as
it is, which tell start and rate on its machine; the same short run here tells how much faster or
slower this machine is, with whatever else it is busy with.
"""

from __future__ import annotations

import json
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orchestrator.accuracy.stored import Stored
from orchestrator.plans import SolverFailed
from orchestrator.studies import sweep
from orchestrator.studies.workers import Crew


@dataclass(frozen=True)
class Timing:
    """``start_s``: processor time before anything moves, where ``study_s`` were simulated in
    ``whole_s`` of processor time; each second of these takes ``wall`` and ``processor`` here."""

    start_s: float
    study_s: float
    whole_s: float
    wall: float
    processor: float

    def scaled_s(self, processor_s: float, duration_s: float) -> float:
        """Of the study's processor time, for another duration."""
        rate = max(processor_s - self.start_s, 0.0) / self.study_s
        return self.start_s + rate * duration_s

    def wall_s(self, processor_s: float, duration_s: float) -> float:
        return self.wall * self.scaled_s(processor_s, duration_s)

    def processor_s(self, processor_s: float, duration_s: float) -> float:
        return self.processor * self.scaled_s(processor_s, duration_s)

    def duration_s(self, processor_s: float, wall_s: float) -> float:
        """How long a run may last to take so much wall time; 0 if not even its start fits."""
        rate = max(processor_s - self.start_s, 0.0) / self.study_s
        return max(wall_s / self.wall - self.start_s, 0.0) / rate if rate else 0.0


def timed(case: Path, level: str | None, sets: Sequence[str]) -> dict[str, Any]:
    """The summary of a run that nobody keeps.  Raises CaseError, and SolverFailed if it does not
    end well."""
    with tempfile.TemporaryDirectory(prefix="flipflow-plan-") as scratch:
        one = sweep.point(case, level, sets, "short", Path(scratch) / "short")
        sweep.run([one], Crew(1), lambda _: None)
        if one.status() != "done":
            said = (Path(scratch) / "short.log").read_text(encoding="utf-8").strip()
            raise SolverFailed(f"the calibration run failed: {said.splitlines()[-1:]}")
        found: dict[str, Any] = json.loads((one.folder / "summary.json").read_text())
        return found


def by_study(study: Stored, case: Path, level: str | None) -> Timing:
    """From the study's whole and short run, and its short run made here."""
    base = study.found["base"]
    (short,) = study.found["short"].values()
    shared, own = study.found["shared"], study.found["sets"]
    here = timed(case, level, [*own, *shared, *short["sets"]])
    return Timing(
        _start_s(base, short),
        base["simulated_s"],
        base["processor_s"],
        here["wall_s"] / short["processor_s"],
        here["processor_s"] / short["processor_s"],
    )


def without_study(case: Path, level: str | None, sets: Sequence[str], duration_s: float) -> Timing:
    """From two short runs here, of which the longer one stands for the study."""
    short, longer = (
        timed(case, level, [*sets, f"duration_s={duration_s * part!r}", "output.pictures=false"])
        for part in (1 / 16, 1 / 8)
    )
    start_s = _start_s(longer, short)
    took_s = longer["processor_s"]
    return Timing(start_s, longer["simulated_s"], took_s, longer["wall_s"] / took_s, 1.0)


def _start_s(whole: dict[str, Any], short: dict[str, Any]) -> float:
    rate = (whole["processor_s"] - short["processor_s"]) / (
        whole["simulated_s"] - short["simulated_s"]
    )
    return float(max(short["processor_s"] - rate * short["simulated_s"], 0.0))
