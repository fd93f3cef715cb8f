"""The output of ``flipflow plan``: the cheapest settings for a tolerance and a time."""

from __future__ import annotations

import shlex
from pathlib import Path

from orchestrator.cli.console import CONSOLE, refuse, reported_errors
from orchestrator.cli.planning import Plan, predict_wall_s, time_by_study
from orchestrator.preflight.cost import in_words
from orchestrator.preflight.judge import JudgedCase
from orchestrator.studies.accuracy.stored import find_study
from orchestrator.workbench import Case

OTHER_CASE = "the study is of the case before changes in {}: its errors hold for that"
UNITS_S = {"s": 1.0, "min": 60.0, "h": 3600.0, "d": 86400.0}


def choose_settings(
    loaded: JudgedCase,
    case: Path,
    level: str | None,
    given: Path | None,
    tolerance: float,
    budget_s: float,
    overrides: list[str],
) -> Plan:
    """Return the plan that follows from a stored study and a short run on this machine."""
    at_level = f" --level {loaded.level}" if loaded.level else ""
    with reported_errors():
        measured = find_study(Case(loaded), given)
        if measured is None:
            longest_s = predict_wall_s(case, level, overrides, Case(loaded))
            refuse(
                f"no study of {loaded.name}, level {loaded.level or 'none'}: its error is not "
                f"known; as it is it would take about {in_words(longest_s)} here. First: flipflow "
                f"study accuracy {case}{at_level}"
            )
        if measured.is_empty:
            refuse(
                f"{measured.file}: nothing happened in that study that could be resolved: its errors "
                "of 0 % promise nothing. Study the case for as long as it takes until something "
                f"does: flipflow study accuracy {case} --set duration_s=..."
            )
        CONSOLE.print(f"by {measured.file}; a short run of the case on this machine ...")
        timing = time_by_study(measured, case, level)
    return Plan(loaded.case, measured, timing, tolerance, budget_s)


def print_choice(plan: Plan, case: Path, overrides: list[str], loaded: JudgedCase) -> bool:
    """Print the cheapest settings, and return whether they fit into the budget."""
    if changes := plan.study.changes(Case(loaded)):
        CONSOLE.print(f"warning: {OTHER_CASE.format(', '.join(changes))}")
    chosen = plan.choice
    if chosen is None:
        least = min((each.error.at_most for each in plan.study.measured_candidates), default=None)
        best = "" if least is None else f"; the best has {100 * least:.3g} %"
        CONSOLE.print(f"no settings of the study are within {100 * plan.tolerance:g} %{best}")
    else:
        how = "measured" if chosen.measured else "predicted, not measured"
        error, width = chosen.error, chosen.error.half_width
        size = f"{100 * error.value:.3g}" + (f" ± {100 * width:.2g}" if width else "")
        CONSOLE.print(f"{chosen.label}: error {size} % ({how}), {in_words(plan.wall_s)}")
        for line in plan.study.table["warnings"]:
            CONSOLE.print(f"warning: {line}")
        if plan.study.table["chance"] is None:
            CONSOLE.print("warning: the study has one seed, so that chance may add to the error: --seeds 3")
        sets = [word for setting in (*overrides, *chosen.sets) for word in ("--set", setting)]
        at_level = ["--level", loaded.level] if loaded.level else []
        CONSOLE.print(shlex.join(["flipflow", "run", str(case), *at_level, *sets]))
    if not plan.fits:
        CONSOLE.print(f"that does not fit into {in_words(plan.budget_s)}; what would:")
        for line in plan.remedies():
            CONSOLE.print(f"  {line}")
    return plan.fits


def parse_share(text: str) -> float:
    """Return the number that ``text`` (5% or 0.05) stands for."""
    try:
        share = float(text.rstrip("%")) * (0.01 if text.endswith("%") else 1.0)
    except ValueError:
        share = 0.0
    if not 0 < share < 1:
        refuse(f"--tolerance {text}: is not a share; for example 5% or 0.05")
    return share


def parse_time_s(text: str) -> float:
    """Return the time in s that ``text`` (90s, 30min, 1h, 2d) stands for."""
    number = text.rstrip("abcdefghijklmnopqrstuvwxyz ")
    unit = text[len(number) :].strip() or "s"
    try:
        time_s = float(number) * UNITS_S[unit]
    except (ValueError, KeyError):
        time_s = 0.0
    if not 0 < time_s < float("inf"):
        refuse(f"--budget {text}: is not a time; for example 90s, 30min, 1h or 2d")
    return time_s
