"""From the command line to a run and its exit code: who says what went wrong, and once.

0 done, 1 a mistake in flipflow itself, 2 the case or the output folder is wrong, 3 a solver is
missing, 4 a solver failed or the run became unstable or its results could not be written,
130 or 143 interrupted.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.console import Console

from orchestrator import ranks, run_folder, summary
from orchestrator.case_errors import CaseError
from orchestrator.checks import mistakes, warnings
from orchestrator.levels import load
from orchestrator.plans import SolverFailed, SolverMissing
from orchestrator.run import Run
from orchestrator.run_folder import LOG, FolderUnusable
from orchestrator.watch import Interrupted

DONE, BROKEN, WRONG, MISSING, FAILED = 0, 1, 2, 3, 4


def run(path: Path, level: str | None, out: Path | None, overrides: Sequence[str]) -> int:
    """Runs a case on every rank; returns the exit code."""
    world = ranks.communicator()
    console = Console(stderr=True, quiet=not ranks.is_first(world), highlight=False)
    try:
        loaded = load(path, level, overrides)
        if found := mistakes(loaded):
            raise CaseError(found)
        folder = ranks.first_rank_does(world, lambda: run_folder.opened(loaded, out, world))
    except (CaseError, FolderUnusable) as error:
        console.print(str(error), markup=False, soft_wrap=True)
        return WRONG
    console.print(f"running {loaded.name} {loaded.level} into {folder}", markup=False)
    for line in [*warnings(loaded), *(f"left out: {why}" for why in loaded.left_out.values())]:
        LOG.warning(line)
        console.print(f"warning: {line}", markup=False, soft_wrap=True)
    return _guarded(Run(loaded, folder, world, console), folder, world, console)


def _guarded(run: Run, folder: Path, world: Any, console: Console) -> int:
    """Runs, and turns whatever happens into a message, a finished folder and an exit code."""
    try:
        run.go()
    except Interrupted as stopped:
        code, status, reason = 128 + stopped.signal, "interrupted", str(stopped)
    except SolverMissing as error:
        return _failed(run, MISSING, str(error), folder, world)
    except (SolverFailed, OSError, MemoryError) as error:
        return _failed(run, FAILED, str(error), folder, world)
    except Exception as error:
        LOG.exception("a mistake in flipflow")
        reason = f"a mistake in flipflow: {type(error).__name__}: {error}"
        return _failed(run, BROKEN, reason, folder, world)
    else:
        code, status, reason = DONE, "done", ""
    if ranks.is_first(world):
        _close(run.finish(status, reason), folder, console)
    return code


def _failed(run: Run, code: int, reason: str, folder: Path, world: Any) -> int:
    """The first rank to fail speaks and ends all of them, wherever they wait."""
    if not run_folder.claimed(folder / "failure.txt", reason):
        time.sleep(10)  # the rank that speaks is about to end this one, too
    else:
        LOG.error(reason)
        console = Console(stderr=True, highlight=False)
        logs = ", ".join(sorted(str(log) for log in folder.rglob("*log*") if log.is_file()))
        console.print(f"{reason}\nlogs: {logs}", markup=False, soft_wrap=True)
        run.finish("failed", reason)
    if world is not None:
        world.Abort(code)
    return code


def _close(figures: dict[str, Any], folder: Path, console: Console) -> None:
    """The closing table, and where everything is."""
    if figures["status"] == "done":
        console.print(summary.closing_table(figures))
        for line in summary.closing_lines(figures):
            LOG.info(line)
            console.print(line, markup=False)
    else:
        console.print(figures["reason"], markup=False)
    console.print(f"results in {folder}", markup=False)
