"""What a study of accuracy left for ``flipflow plan``."""

from __future__ import annotations

import json
import shlex
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.preflight.levels import LoadedCase
from orchestrator.studies.accuracy.model import Model, Option, Proposal
from orchestrator.studies.accuracy.points import BASE
from orchestrator.studies.accuracy.setting import Setting
from orchestrator.studies.figures import happens

NAME = "accuracy.json"


@dataclass(frozen=True)
class Candidate:
    """Settings, their error, and the processor time of a run as long as the study's, on its
    machine; ``measured`` or predicted."""

    label: str
    sets: tuple[str, ...]
    error: float
    processor_s: float
    measured: bool


@dataclass(frozen=True)
class Stored:
    """``found``: as ``tables.as_json`` wrote it."""

    file: Path
    found: dict[str, Any]

    def model(self) -> Model:
        axes = {
            axis: [
                Option(axis, Setting(one["label"], tuple(one["sets"])), one["error"], one["ratio"])
                for one in options
            ]
            for axis, options in self.found["options"].items()
        }
        parts_s = self.found["base"]["processor_by_part_s"]
        return Model(axes, parts_s, self.found["remaining"], self.found["judged_by"])

    @property
    def of_nothing(self) -> bool:
        """Whether nothing happened in it: errors of what cannot be resolved promise nothing."""
        base = [one for one in self.found["points"] if one.get("point") == BASE]
        return bool(base) and not any(happens(one) for one in base)

    @property
    def chance(self) -> float:
        """By which a prediction may be off although all adds up."""
        return float(self.found["chance"] or 0.0)

    def measured(self) -> list[Candidate]:
        """Points with their errors at the upper end of their confidence intervals."""
        return [
            Candidate(
                one["settings"],
                tuple(shlex.split(one["sets"])),
                one["error"] + (one["error_half_width"] or 0.0),
                one["processor_s"],
                True,
            )
            for one in self.found["points"]
            if one["error"] is not None
        ]

    def cheapest(self, tolerance: float) -> Candidate | None:
        """Measured, or predicted where nothing measured is so cheap."""
        within = [one for one in self.measured() if one.error <= tolerance]
        proposal = self.model().cheapest(tolerance - self.chance)
        if proposal is not None:
            within.append(_candidate(proposal, self.chance))
        return min(within, key=lambda one: one.processor_s, default=None)

    def best(self, budget_s: float) -> Candidate | None:
        """With the least error for so much processor time."""
        within = [one for one in self.measured() if one.processor_s <= budget_s]
        proposal = self.model().best(budget_s, "cheapest")
        if proposal is not None:
            within.append(_candidate(proposal, self.chance))
        return min(within, key=lambda one: one.error, default=None)


def _candidate(proposal: Proposal, chance: float) -> Candidate:
    settings = proposal.settings
    label = "; ".join(f"{axis}: {one.label}" for axis, one in settings.items())
    sets = tuple(each for one in settings.values() for each in one.sets)
    return Candidate(label or "the case as it is", sets, proposal.error + chance, proposal.processor_s, False)


def stored(loaded: LoadedCase, given: Path | None) -> Stored | None:
    """The study in the file given, or beside the case, or in its usual folder, if it is of this
    case and level; None where there is none.  Raises CaseError for a file that is none."""
    usual = (loaded.folder / NAME, Path("runs") / f"{loaded.name}-accuracy" / NAME)
    for file in (given,) if given else usual:
        if not file.is_file():
            continue
        try:
            found = json.loads(file.read_text(encoding="utf-8"))
            same = (found["case"], found["level"]) == (loaded.name, loaded.level)
        except (ValueError, KeyError, TypeError):
            raise CaseError([CaseProblem((), "is no study of accuracy", file=str(file))]) from None
        if same:
            return Stored(file, found)
        if given:
            what = f'is of case "{found["case"]}", level "{found["level"]}"'
            raise CaseError([CaseProblem((), what, file=str(file))])
    if given and not given.is_file():
        raise CaseError([CaseProblem((), "no such file", file=str(given))])
    return None
