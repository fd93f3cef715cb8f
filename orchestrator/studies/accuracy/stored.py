"""A study of accuracy as it was stored, with what it recommends, for ``flipflow plan`` and ``explain``."""

from __future__ import annotations

import shlex
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from orchestrator.studies.accuracy.combinations import ALONE, BASE, Error, happens, joint_label, joint_sets
from orchestrator.studies.accuracy.convergence import Model, Option, Proposal
from orchestrator.studies.accuracy.recommendation import recommend
from orchestrator.workbench import Accuracy, Case, CaseError, CaseProblem, Setting, StudyFolder

NAME = Accuracy.stored_in
FORMAT = 4
"""Version of this file, which holds for its keys and for what its numbers mean."""


@dataclass(frozen=True)
class Candidate:
    """A candidate for a plan: joint settings with their errors and their processor time.

    ``errors`` are those that decide.  ``processor_s`` is the time of a run as long as the study's, on the
    study's machine.  ``measured`` says whether errors and time were measured or predicted.
    """

    label: str
    sets: tuple[str, ...]
    errors: tuple[Error, ...]
    processor_s: float
    measured: bool

    @property
    def error(self) -> Error:
        """The error whose confidence interval reaches highest."""
        return max(self.errors, key=lambda error: error.at_most)


@dataclass(frozen=True)
class StoredStudy:
    """A study of accuracy, as ``report.as_json`` wrote it into a file."""

    file: Path
    table: dict[str, Any]

    @cached_property
    def model(self) -> Model:
        """The model that predicts error and cost of joint settings."""
        table, axes = self.table, {}
        for axis, every in table["options"].items():
            settings = (Setting(one["label"], tuple(one["sets"])) for one in every)
            pairs = zip(every, settings, strict=True)
            axes[axis] = [Option(axis, setting, one["error"], one["ratio"]) for one, setting in pairs]
        return Model(axes, table["base"]["processor_by_part_s"], table["judged_by"])

    @property
    def is_empty(self) -> bool:
        """Whether nothing happened in the study, so that its errors promise nothing."""
        base = [one for one in self.table["points"] if one.get("point") == BASE]
        return bool(base) and not any(happens(one) for one in base)

    def changes(self, case: Case) -> list[str]:
        """Return the dotted keys and the files of the case, and the overrides, that differ from the study's.

        A run may be longer or shorter than the study.
        """
        overrides = set(self.table["sets"]) ^ set(case.as_read["overrides"])
        return [
            *case.changes_since(self.table["read"]),
            *(word for word in sorted(overrides) if not word.startswith("duration_s=")),
        ]

    @property
    def measured_candidates(self) -> list[Candidate]:
        """The measured points with their errors against the study's reference.

        Settings that are no choice, such as a machine without its particles, are no candidates.
        """
        choices = {shlex.join(one["sets"]) for every in self.table["options"].values() for one in every}
        return [
            Candidate(
                one["settings"],
                tuple(shlex.split(one["sets"])),
                tuple(
                    Error(one[f"{name}_error"], one[f"{name}_error_half_width"])
                    for name in self.table["judged_by"]
                    if one.get(f"{name}_error") is not None
                ),
                one["processor_s"],
                True,
            )
            for one in self.table["points"]
            if one["error"] is not None and (one["kind"] != ALONE or one["sets"] in choices)
        ]

    def recommend(self, tolerance: float) -> Candidate | None:
        """Return the candidate that the study recommends for a tolerance, or else the cheapest settings that
        were not measured and are predicted to be within it; None where there are none."""
        own_error = self.table["reference_error"]
        best = next(one for one in self.table["points"] if one["point"] == self.table["reference"])
        reference = Candidate(
            best["settings"],
            tuple(shlex.split(best["sets"])),
            (Error(own_error or 0.0),),
            best["processor_s"],
            False,
        )
        candidates = ((one, one.errors, one.processor_s) for one in self.measured_candidates)
        measured, _ = recommend(candidates, (reference, own_error, reference.processor_s), tolerance)
        return measured or self._predicted(self.model.cheapest(tolerance - self._unseen))

    def best(self, budget_s: float) -> Candidate | None:
        """Return the candidate with the least error within a processor time; None where there is none."""
        within = [each for each in self.measured_candidates if each.processor_s <= budget_s]
        if predicted := self._predicted(self.model.best(budget_s, "cheapest")):
            within.append(predicted)
        return min(within, key=lambda each: each.error.at_most, default=None)

    @property
    def _unseen(self) -> float:
        """The error that is added to predicted ones: the largest half width of a deciding error in the study,
        and the largest error that remains in the finest settings."""
        remaining = max(
            (self.table["remaining"].get(name, 0.0) for name in self.table["judged_by"]), default=0.0
        )
        return float(self.table["chance"] or 0.0) + float(remaining)

    def _predicted(self, proposal: Proposal | None) -> Candidate | None:
        """Return the candidate of a proposal; None where there is none, or where it was measured."""
        if proposal is None or shlex.join(joint_sets(proposal.settings)) in self._measured_sets:
            return None
        label, error = joint_label(proposal.settings) or "the case as it is", proposal.error + self._unseen
        return Candidate(label, joint_sets(proposal.settings), (Error(error),), proposal.processor_s, False)

    @property
    def _measured_sets(self) -> set[str]:
        return {one["sets"] for one in self.table["points"] if one["status"] == "done"}


def find_study(case: Case, given: Path | None) -> StoredStudy | None:
    """Return the study of a case at its level from the given file, or None where there is no study.

    Without a file, the study is searched beside the case and in the usual folder of the study.  Raises
    CaseError for a file without a study, and for a given file that is missing or belongs to another case.
    """

    def problem(file: Path, what: str) -> CaseError:
        return CaseError([CaseProblem((), what, file=str(file), kind="file")])

    if given and not given.is_file():
        raise problem(given, "no such file")
    usual = (case.folder / NAME, Path("runs") / f"{case.name}-accuracy" / NAME)
    for file in (given,) if given else filter(Path.is_file, usual):
        try:
            table = StudyFolder(file.parent).read_json(file.name)
            name, level, version = table["case"], table["level"], table.get("format_version")
        except (ValueError, KeyError, TypeError):
            raise problem(file, "is not a study of accuracy") from None
        if version != FORMAT:
            raise problem(file, "another version of flipflow wrote it; make the study again")
        if (name, level) == (case.name, case.level):
            return StoredStudy(file, table)
        if given:
            raise problem(file, f'is of case "{name}", level "{level}"')
    return None
