"""A case as studies know it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, ClassVar

from orchestrator.case.file.errors import CaseError, CaseProblem, did_you_mean
from orchestrator.case.file.layers import find_changes
from orchestrator.case.file.nested import leaves
from orchestrator.case.load import read_tables
from orchestrator.case.tables.case import Case as Tables
from orchestrator.case.tables.case import has_particles
from orchestrator.coupling.schemes import SCHEMES
from orchestrator.figures.short_names import part_of
from orchestrator.output.records.run_folder import changed_files, resolved_case
from orchestrator.preflight import cost, level_file, refinement
from orchestrator.preflight.check import find_problems
from orchestrator.preflight.judge import NUMERICS, JudgedCase, load_judged
from orchestrator.preflight.scene.scene import bed_kg
from orchestrator.preflight.stability.report import case_with_scheme, stability_report


@dataclass(frozen=True)
class Case:
    """A case at a level, with overlays, as it will be run."""

    judged: JudgedCase
    schemes: ClassVar[tuple[str, ...]] = tuple(SCHEMES)
    """The names of the coupling schemes."""

    @classmethod
    def load(cls, path: Path, level: str | None = None, sets: Sequence[str] = ()) -> Case:
        """Return the case in a folder at a level with ``--set`` overlays.

        Without a level it is at the case's own choice.  Raises CaseError with every problem that prevents a
        run.
        """
        judged = load_judged(path, level, sets)
        if problems := find_problems(judged):
            raise CaseError(problems)
        return cls(judged)

    @property
    def name(self) -> str:
        """The name of the case's folder."""
        return self.judged.name

    @property
    def level(self) -> str:
        """The name of its level; "" without one."""
        return self.judged.level

    @property
    def folder(self) -> Path:
        """The folder of the case."""
        return self.judged.folder

    @property
    def tables(self) -> Tables:
        """The values of its keys (docs/case-format.md), defaults included."""
        return self.judged.case

    @property
    def has_particles(self) -> bool:
        """Whether particles move in it."""
        return has_particles(self.tables)

    @property
    def bed_kg(self) -> float:
        """The mass of the particles on the deck in kg."""
        return bed_kg(self.tables)

    @property
    def predicted_s(self) -> float:
        """The predicted processor time of its run in s, good to a factor of three."""
        return cost.predicted_s(self.tables, cost.particles_at_start(self.tables))

    @property
    def safe_interval_s(self) -> float:
        """The largest sync interval in s with which the coupling is surely stable."""
        return stability_report(self.tables).safe_s

    @property
    def as_read(self) -> dict[str, Any]:
        """The tables, levels, files and overlays from which it was read, to be stored and compared later."""
        return self.judged.origin.read()

    def changes_since(self, before: Mapping[str, Any]) -> list[str]:
        """Return the dotted keys and the files that differ from an earlier ``as_read`` at the same level."""
        now = self.as_read
        parts = (
            (before["given"], now["given"]),
            (before["levels"].get(self.level), now["levels"].get(self.level)),
            (before["files"], now["files"]),
        )
        return [*dict.fromkeys(".".join(key) for one, other in parts for key in find_changes(one, other))]

    @property
    def left_out(self) -> list[str]:
        """The effects that its key ``effects`` leaves out."""
        return sorted(self.judged.choice.left_out)

    @property
    def overrides(self) -> tuple[str, ...]:
        """Its ``--set`` overlays."""
        return self.judged.origin.overrides

    @cached_property
    def values(self) -> dict[str, Any]:
        """The values of all keys as it will be run, by dotted keys."""
        return {".".join(map(str, key)): value for key, value in leaves(resolved_case(self.judged))}

    @cached_property
    def scheme(self) -> str:
        """The name of its coupling scheme, chosen by the program where the case leaves it to that."""
        return case_with_scheme(self.tables).coupling.scheme

    def with_sets(self, sets: Sequence[str]) -> Case:
        """Return the case of the same folder and level with these ``--set`` overlays in place of its own.

        It is not checked.  Raises CaseError.
        """
        return Case(load_judged(self.folder, self.level, sets))

    def changes_in(self, run: Path) -> list[str]:
        """Return the dotted keys and the files in which the case of the run in a folder differs.

        Keys that were introduced later have their defaults in the folder's case.
        """
        try:
            stored = resolved_case(load_judged(run / "case.toml"))
        except CaseError as error:
            return [".".join(map(str, problem.key)) for problem in error.problems]
        changes = [*map(".".join, find_changes(stored, resolved_case(self.judged)))]
        return [*changes, *changed_files(self.judged, run)]

    def missing_parts(self, keys: Iterable[str], given: str) -> list[CaseProblem]:
        """Return a problem for each part of dotted keys that the case does not have; ``given`` gave them."""
        tables, problems = read_tables(self.judged.layers.merged, self.folder), []
        for key in keys:
            place: Any = tables
            for number, part in enumerate(words := key.split(".")):
                if isinstance(place, Mapping) and part not in place:
                    what = f'the case has no "{part}" in {".".join(words[:number])}'
                    problems.append(
                        CaseProblem((key,), what, did_you_mean(part, place), given, kind="unknown-name")
                    )
                place = place.get(part) if isinstance(place, Mapping) else getattr(place, part, None)
        return problems

    @staticmethod
    def is_numeric(overlay: str) -> bool:
        """Return whether an overlay changes how a case is computed, and not the case that is described."""
        return overlay.partition(".")[0] in NUMERICS

    def refined(self, parameters: Sequence[str], values: int) -> refinement.Offer:
        """Return the settings of refinement parameters, with so many ``values`` each, from coarse to fine.

        Raises CaseError for a variant that the case does not have.
        """
        return refinement.offer(self.tables, parameters, values)

    def part_of(self, result: str) -> str:
        """Return the part of the machine that a result describes; "" if its name does not tell."""
        return part_of(result, self.tables)

    def level_text(self, sets: Sequence[str], about: str) -> str:
        """Return the content of a level file: the level with ``sets``, and what it leaves out named."""
        return level_file.level_text(self.judged, sets, about)
