"""The command line's commands that look at a case."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.cli.console import CONSOLE, ERRORS, checked, refuse, reported_errors
from orchestrator.cli.options import CasePath, Level, Overrides

if TYPE_CHECKING:
    from orchestrator.preflight.judge import JudgedCase
    from orchestrator.studies.accuracy.plan import Stored
    from orchestrator.studies.pairs import TriedEffects


def check(
    case: CasePath,
    level: Level = None,
    detail: Annotated[
        bool, typer.Option("--detail", help="all that limits the sync interval, with its numbers")
    ] = False,
    overrides: Overrides = None,
) -> None:
    """Check a case without running it, and say what is in it.

    Exit code 0: it can be run; 2: it cannot, with every problem in one message.
    """
    from orchestrator.cli.overview import overview

    loaded = checked(case, level, overrides)
    with reported_errors():
        for line in overview(loaded, detail):
            CONSOLE.print(line)


def explain(
    case: CasePath,
    level: Level = None,
    study: Annotated[
        Path | None,
        typer.Option(help="accuracy.json of flipflow study accuracy [default: the one beside case.toml]"),
    ] = None,
    results: Annotated[
        str | None,
        typer.Option(
            "--for",
            metavar="NAMES",
            help="results, by short names (efficiency,stroke,...), whose change decides",
        ),
    ] = None,
    budget: Annotated[float, typer.Option(min=0, help="with --for: processor time for all runs / s")] = 300.0,
    overrides: Overrides = None,
) -> None:
    """Say which effects a case calls for, by estimates before any run.

    For each effect: whether the case has it at this level, the dimensionless number that decides,
    the threshold, what follows, and which key changes it.  At the end: what matters and is
    lacking, and what could be left out.  No solver is started or needed.  Where flipflow study accuracy
    has measured what an effect amounts to, its figures take the estimate's place.

    With --for, a verdict is the change of these results in short runs with and without the effect
    at a cheap level, except where an estimate surely says that it may be left out.  The runs are
    remembered.

    Exit code 0: done, whatever the verdicts; 2: the case has problems.
    """
    from orchestrator.cli.explain import print_explanation
    from orchestrator.preflight.check import find_table_problems

    loaded = checked(case, level, overrides, find_table_problems)
    with reported_errors():
        measured = _stored(loaded, study)
        asked = tuple(word.strip() for word in (results or "").split(",") if word.strip())
        print_explanation(loaded, measured, _tried(loaded, asked, budget), asked)


def _stored(loaded: JudgedCase, given: Path | None) -> Stored | None:
    """The study of accuracy that is given, or lies beside the case; None where there is none."""
    if given is None and not (loaded.folder / "accuracy.json").is_file():
        return None
    from orchestrator.studies.accuracy.plan import stored

    return stored(loaded, given)


def _tried(loaded: JudgedCase, asked: tuple[str, ...], budget_s: float) -> TriedEffects | None:
    """Makes runs with and without effects for results that are ``asked`` for; None where none are."""
    from orchestrator.case.scalars import scalar
    from orchestrator.studies.pairs import LIMIT_S, RUNS_IN_BUDGET, Pairs, try_all_effects

    try:
        for name in asked:
            scalar(name)
    except KeyError as error:
        refuse(f"--for: {error.args[0]}")
    if not asked:
        return None
    limit_s = max(LIMIT_S, budget_s / RUNS_IN_BUDGET)
    return try_all_effects(loaded, Pairs(limit_s, ERRORS.print), budget_s)


def list_cases(
    folder: Annotated[Path, typer.Argument(help="folder that holds cases")] = Path("cases"),
) -> None:
    """List cases with their titles and levels."""
    if not folder.is_dir():
        refuse(f"{folder}: no such folder; name the one that holds your cases: flipflow list FOLDER")
    for line in _case_lines(folder):
        CONSOLE.print(line)


def _case_lines(folder: Path) -> Iterator[str]:
    """Yields a line for each case in a folder, and one for its levels."""
    from orchestrator.case.file.errors import CaseError, visible
    from orchestrator.case.file.layers import read_toml
    from orchestrator.case.load import level_names
    from orchestrator.preflight.judge import load_judged

    for file in sorted(folder.glob("*/case.toml")):
        try:
            title = str(read_toml(file).get("title", "(no title)"))
            default = load_judged(file).level
        except CaseError:
            title, default = f"(has problems: flipflow check {file.parent})", ""
        names = [f"{n} (default)" if n == default else n for n in level_names(file.parent)]
        yield visible(f"{file.parent}  {title}")
        yield visible(f"    levels: {', '.join(names) or 'none'}")
