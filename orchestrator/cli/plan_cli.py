"""The command line's ``flipflow plan``."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.cli.console import CONSOLE, FAILED, checked, refuse, reported_errors
from orchestrator.cli.options import CasePath, Level, Overrides

if TYPE_CHECKING:
    from orchestrator.preflight.judge import JudgedCase
    from orchestrator.studies.accuracy.plan import Plan

UNITS_S = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}


def plan(
    case: CasePath,
    tolerance: Annotated[str, typer.Option(metavar="SHARE", help="error, as 5% or 0.05")],
    budget: Annotated[str, typer.Option(metavar="TIME", help="wall time, as 90s, 30min, 1h or 2d")],
    level: Level = None,
    study: Annotated[
        Path | None,
        typer.Option(
            "--study", help="accuracy.json of a study [default: beside case.toml, or in runs/<case>-accuracy]"
        ),
    ] = None,
    write: Annotated[
        str | None, typer.Option(metavar="LEVEL", help="writes this level into the case's folder")
    ] = None,
    overrides: Overrides = None,
) -> None:
    """Choose settings for a tolerance and a time.

    From a stored study of accuracy and a short run on this machine: the cheapest settings within
    the tolerance, the wall time that they will take here and their error; where that does not fit
    the budget, what would make it fit.

    Exit code 0: it fits; 4: it does not; 2: the case, the study or the command is wrong.
    """
    wanted, budget_s = _share(tolerance), _seconds(budget)
    loaded = checked(case, level, overrides)
    made = _planned(loaded, case, level, study, wanted, budget_s, overrides or [])
    if not _said(made, case, overrides or [], loaded):
        raise typer.Exit(FAILED)
    if write is not None and made.chosen is not None:
        from orchestrator.preflight.level_file import write_level

        about = f"planned: {100 * made.chosen.error:.2g} % in {_time(made.wall_s)}"
        with reported_errors():
            file = write_level(loaded, write, [*(overrides or []), *made.chosen.sets], about)
        CONSOLE.print(f"written: {file}")


def _planned(
    loaded: JudgedCase,
    case: Path,
    level: str | None,
    given: Path | None,
    tolerance: float,
    budget_s: float,
    overrides: list[str],
) -> Plan:
    from orchestrator.studies.accuracy.plan import Plan, as_it_is_s, by_study, stored

    with reported_errors():
        found = stored(loaded, given)
        if found is None:
            longest_s = as_it_is_s(case, level, overrides, loaded.case)
            refuse(
                f"no study of {loaded.name}, level {loaded.level or 'none'}: its error is not "
                f"known; as it is it would take about {_time(longest_s)} here. First: flipflow "
                f"study accuracy {case} --level {loaded.level}"
            )
        if found.of_nothing:
            refuse(
                f"{found.file}: nothing happened in that study that could be resolved: its errors "
                "of 0 % promise nothing. Study the case for as long as it takes until something "
                f"does: flipflow study accuracy {case} --set duration_s=..."
            )
        CONSOLE.print(f"by {found.file}; a short run of the case on this machine ...")
        timing = by_study(found, case, level)
    return Plan(loaded.case, found, timing, tolerance, budget_s)


def _said(made: Plan, case: Path, overrides: list[str], loaded: JudgedCase) -> bool:
    """Whether it fits."""
    other = [one for one in made.study.found["sets"] if one not in overrides]
    if other := [one for one in other if not one.startswith("duration_s=")]:
        CONSOLE.print(f"warning: the study was made with {' '.join(other)}")
    one = made.chosen
    if one is None:
        least = min((each.error for each in made.study.measured()), default=None)
        said_least = "" if least is None else f"; the best has {100 * least:.2g} %"
        CONSOLE.print(f"no settings of the study are within {100 * made.tolerance:g} %{said_least}")
    else:
        how = "measured" if one.measured else "predicted, not measured"
        CONSOLE.print(f"{one.label}: error {100 * one.error:.2g} % ({how}), {_time(made.wall_s)}")
        sets = [word for each in (*overrides, *one.sets) for word in ("--set", each)]
        at_level = ["--level", loaded.level] if loaded.level else []
        CONSOLE.print(shlex.join(["flipflow", "run", str(case), *at_level, *sets]))
    if made.fits:
        return True
    CONSOLE.print(f"that does not fit into {_time(made.budget_s)}; what would:")
    for line in made.remedies():
        CONSOLE.print(f"  {line}")
    return False


def _time(time_s: float) -> str:
    from orchestrator.preflight.cost import in_words

    return in_words(time_s)


def _share(text: str) -> float:
    try:
        found = float(text.rstrip("%")) * (0.01 if text.endswith("%") else 1.0)
    except ValueError:
        found = 0.0
    if not 0 < found < 1:
        refuse(f"--tolerance {text}: is no share; for example 5% or 0.05")
    return found


def _seconds(text: str) -> float:
    number = text.rstrip("abcdefghijklmnopqrstuvwxyz ")
    unit = text[len(number) :].strip() or "s"
    try:
        found = float(number) * UNITS_S[unit]
    except (ValueError, KeyError):
        found = 0.0
    if not 0 < found < float("inf"):
        refuse(f"--budget {text}: is no time; for example 90s, 30min, 1h or 2d")
    return found
