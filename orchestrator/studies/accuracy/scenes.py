"""Scenes: cases whose ``accuracy.toml`` says how their accuracy is studied, for one picture of them all."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from pydantic import ValidationError

from orchestrator.studies.points import CaseStudy
from orchestrator.workbench import CaseError, CaseProblem
from orchestrator.workbench.vocabulary import Few, OneLine, Positive, Table, from_validation, read_toml

FILE = "accuracy.toml"


class Size(Table):
    """The size of a scene's study.  What is not given is that of the command line."""

    sets: tuple[OneLine, ...] = ()
    """Overlays of all points, as ``--set`` takes them."""
    points: Few | None = None
    """The number of values of each parameter."""
    seeds: Few | None = None
    """The number of runs of each point with other random numbers."""
    budget_s: Positive | None = None
    """The processor time in s from which on a run is left out."""


class Scene(Size):
    """The content of ``accuracy.toml``: the study of a case."""

    title: OneLine
    """The name of the scene in pictures."""
    level: OneLine = ""
    """The level of the case; by default its default level."""
    parameters: tuple[OneLine, ...]
    """The parameters that are varied, as ``--parameters`` takes them."""
    quantities: tuple[OneLine, ...]
    """The quantities whose errors decide, as ``--quantities`` takes them."""
    quick: Size = Size()
    """What differs in a quick study."""

    def sized(self, is_quick: bool) -> Scene:
        """Return the scene in its full or its quick size."""
        given = {name: value for name in Size.model_fields if (value := getattr(self.quick, name))}
        return self.model_copy(update=given) if is_quick else self


def is_case(path: Path) -> bool:
    """Return whether a path is a case, rather than a folder of cases."""
    return path.is_file() or (path / "case.toml").is_file()


def find_scenes(study: CaseStudy) -> Iterator[tuple[Scene, CaseStudy]]:
    """Yield the scenes below a folder, each with the study of its case.

    Raises CaseError with the problems of all files, or where there is none.
    """
    scenes: list[tuple[Scene, CaseStudy]] = []
    problems = []
    for file in sorted(study.case.rglob(FILE)):
        try:
            scene = Scene.model_validate(read_toml(file, file.parent))
        except ValidationError as error:
            problems += [replace(each, file=str(file)) for each in from_validation(error, Scene)]
            continue
        except CaseError as error:
            problems += error.problems
            continue
        case, level = file.parent, study.level or scene.level or None
        scenes.append((scene, replace(study, case=case, level=level, out=study.folder / case.name)))
    if problems:
        raise CaseError(problems)
    if not scenes:
        what = f"is not a case, and has no case with {FILE}"
        raise CaseError([CaseProblem((), what, "docs/commands.md", str(study.case), kind="file")])
    yield from scenes
