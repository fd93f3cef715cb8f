"""Options that the commands share: the case, its level and overlays, the workers and the output folder.

A command of a study has a parameter of type ``CaseStudy`` for all of these options, or one of type ``Crew``
for the workers' options alone.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable, Generator
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, get_type_hints

import typer
from rich.table import Table

if TYPE_CHECKING:  # every command of flipflow imports this file, and quick commands need no points
    from orchestrator.studies.points import CaseStudy, Crew

StudyOutput = Generator[str | Table | Path, None, bool]
"""The output of a study's command: it yields lines, tables and the files that it wrote, and returns whether
all is well."""


def shipped_or_own(path: Path) -> Path:
    """Return a path that exists, and else that of a case which comes with the program."""
    from orchestrator.case import shipped

    return shipped.find(path)


CasePath = Annotated[
    Path,
    typer.Argument(
        metavar="CASE", callback=shipped_or_own, help="folder of a case, or name of one of the program's"
    ),
]
Level = Annotated[
    str | None, typer.Option("--level", help="level of the case, or its file [default: default_level]")
]
Overrides = Annotated[
    list[str] | None,
    typer.Option("--set", metavar="KEY=VALUE", help="value of a key, as panel.solver=rigid; may be repeated"),
]
StudyPath = Annotated[
    Path,
    typer.Argument(
        metavar="STUDY", callback=shipped_or_own, help="study.toml of a design study, or its folder"
    ),
]
Out = Annotated[Path | None, typer.Option("--out", help="folder of the study [default: runs/<case>-<study>]")]
Workers = Annotated[
    int | None,
    typer.Option("--workers", "--jobs", min=1, help="runs at a time [default: as the machine bears]"),
]
Scheduler = Annotated[str, typer.Option("--scheduler", help="address of a Dask scheduler")]

WriteJobs = Annotated[
    bool, typer.Option("--write-jobs", help="write jobs.txt and job.sh for a cluster, and run nothing")
]


def crew(workers: Workers = None, scheduler: Scheduler = "") -> Crew:
    """Return the requested crew; by default it has as many workers as the machine bears.

    Raises CaseError where no scheduler answers.
    """
    from orchestrator.case.file.errors import CaseError, CaseProblem
    from orchestrator.studies.points import Crew, workers_that_fit

    crew = Crew(workers or workers_that_fit(), scheduler)
    try:
        crew.size()
    except (OSError, ValueError) as error:
        problem = CaseProblem((), str(error), "for example tcp://host:8786", f"--scheduler {scheduler}")
        raise CaseError([problem]) from None
    return crew


def case_study(
    case: CasePath,
    level: Level = None,
    out: Out = None,
    workers: Workers = None,
    scheduler: Scheduler = "",
    overrides: Overrides = None,
) -> CaseStudy:
    """Return the study of one case that the options describe."""
    from orchestrator.studies.points import CaseStudy

    return CaseStudy(case, level, tuple(overrides or ()), out, crew(workers, scheduler))


def with_options(command: Callable[..., StudyOutput], name: str) -> Callable[..., StudyOutput]:
    """Return a study's command as a function of single options, as Typer needs it.

    ``name`` is the name of the study.
    """
    from orchestrator.studies.points import CaseStudy, Crew
    from orchestrator.workbench import StudyFolder

    # the parameters of these functions are the options that replace a parameter of the type
    records: dict[Any, Callable[..., Any]] = {CaseStudy: case_study, Crew: crew}
    hints = get_type_hints(command, include_extras=True)
    factories, options = {}, []
    for parameter in inspect.signature(command).parameters.values():
        if factory := records.get(hints[parameter.name]):
            factories[parameter.name] = factory
            types = get_type_hints(
                factory, localns={"CaseStudy": CaseStudy, "Crew": Crew}, include_extras=True
            )
            own = inspect.signature(factory).parameters.values()
            options += [each.replace(annotation=types[each.name]) for each in own]
        else:
            options.append(parameter.replace(annotation=hints[parameter.name]))

    def call(**given: Any) -> StudyOutput:
        if isinstance(out := given.get("out"), Path):
            StudyFolder(out).admit(name)
        for parameter, factory in factories.items():
            record = factory(**{key: given.pop(key) for key in inspect.signature(factory).parameters})
            if isinstance(record, CaseStudy):
                record = replace(record, name=name)
                StudyFolder(record.folder).admit()
            given[parameter] = record
        return command(**given)

    call.__doc__ = command.__doc__
    keyword = [each.replace(kind=inspect.Parameter.KEYWORD_ONLY) for each in options]
    vars(call)["__signature__"] = inspect.Signature(keyword)
    call.__annotations__ = {each.name: each.annotation for each in keyword}
    return call
