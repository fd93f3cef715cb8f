"""From the command line to a run and its exit code: who says what went wrong, and once.

0 done, 1 a mistake in flipflow itself, 2 the case or the output folder is wrong, 3 a solver is
missing, 4 a solver failed or the run became unstable or its results could not be written, 5 done
but not to be trusted, 6 done but its results could not be made, 129 (SIGHUP), 130 (SIGINT), 138
(SIGUSR1) or 143 (SIGTERM) interrupted.
"""

from __future__ import annotations

import io
import os
import signal
import sys
import time
from collections.abc import Mapping, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import IO, Any, cast

from rich.console import Console

from orchestrator.case import adapter, distributions
from orchestrator.case.file.errors import CaseError
from orchestrator.cli.console import TOO_LARGE, find_problems
from orchestrator.cli.going_on import go_on, last_good
from orchestrator.coupling import ranks
from orchestrator.output.checkpoints import Save
from orchestrator.output.records import run_folder, summary, trust
from orchestrator.output.records.run_folder import LOG, OF_A_RUN, FolderUnusable, lock
from orchestrator.output.report.headline import headline
from orchestrator.ports.plans import SolverFailed, SolverMissing
from orchestrator.preflight.check import warnings
from orchestrator.preflight.judgement.account import Entry, account, at_start
from orchestrator.preflight.judgement.catalogue import EFFECTS
from orchestrator.preflight.judgement.pair import agree, key_of
from orchestrator.preflight.levels import LoadedCase, load
from orchestrator.preflight.stability import plain, words
from orchestrator.preflight.stability.choice import settled_card
from orchestrator.run.interruption import ImmediateStop, Interrupted, immediate_stop
from orchestrator.run.run import Run
from orchestrator.studies.trials import before

DONE, BROKEN, WRONG, MISSING, FAILED = 0, 1, 2, 3, 4
OUT = "out of memory"
AT_ONCE = 128 + signal.SIGINT


def run(path: Path, level: str | None, out: Path | None, overrides: Sequence[str]) -> int:
    """Runs a case on every rank; returns the exit code."""
    world = ranks.communicator()
    try:
        loaded = load(path, level, overrides)
        ready(loaded)
        loaded = _tried_out(loaded, path, level, overrides, world)
        entries = account(loaded.described, loaded.left_out, loaded.choice.pairs, loaded.choice.asked)
        if world is not None:  # no folder where another rank refuses
            world.Barrier()
        folder = ranks.first_rank_does(world, lambda: run_folder.create_run_folder(loaded, out, world))
    except Exception as error:
        return refused(world, error)
    return carried_out(loaded, entries, folder, world)


def _tried_out(
    loaded: LoadedCase, path: Path, level: str | None, overrides: Sequence[str], world: Any
) -> LoadedCase:
    """The case with what short runs with and without effects say of those that "auto" cannot
    decide about; the first rank makes or remembers them, and all ranks choose alike."""
    if not loaded.choice.asked:
        return loaded
    say = _console().print
    made = ranks.first_rank_does(world, lambda: before(loaded, say))
    if not made and world is None:
        return loaded
    known = ranks.first_rank_does(world, lambda: {**loaded.choice.pairs, **made})
    read = loaded.origin.read()
    agree({key_of(read, name): known.get(name) for name in EFFECTS})
    loaded = load(path, level, overrides)
    ready(loaded)
    return loaded


def ready(loaded: LoadedCase) -> None:
    """Raises CaseError for a case with mistakes, and SolverMissing where this rank lacks what
    solves the panels: PETSc starts up on all ranks together, so that none may go on without."""
    if problems := find_problems(loaded):
        raise CaseError(problems)
    adapter.imported("panel", loaded.case.panel.solver)


def refused(world: Any, error: Exception) -> int:
    """Says, once, why nothing is run; returns the exit code."""
    match error:
        case SolverMissing():
            said, code = str(error), MISSING
        case CaseError() | FolderUnusable() | OSError():
            said, code = str(error), WRONG
        case MemoryError():
            said, code = TOO_LARGE, WRONG
        case _:
            said, code = f"a mistake in flipflow: {type(error).__name__}: {error}", BROKEN
    return ranks.in_turn(world, lambda: _console().print(run_folder.printable(said)), code)


def carried_out(
    loaded: LoadedCase,
    entries: Mapping[str, Entry],
    folder: Path,
    world: Any,
    save: Save | None = None,
    said: Sequence[str] = (),
) -> int:
    """Runs the case in its folder, or goes on from ``save``; returns the exit code.

    ``entries``: the account of its effects; ``said``: what else is to be said before.  Raises
    FolderUnusable where another process is at work.
    """
    first = ranks.is_first(world)
    console = _console(quiet=not first)
    alone = lock(folder / OF_A_RUN) if first else nullcontext()
    with run_folder.logging_to(folder, first), alone:
        LOG.info("case %s, level %s", loaded.folder, loaded.level or "none")
        doing = "running" if save is None else f"going on from t = {save.simulated_s:g} s with"
        _say(f"{doing} {loaded.name} {loaded.level} into {folder}", console)
        said = [*said, *distributions.warnings()]
        try:
            stability = settled_card(loaded.case)
            before = [*said, *warnings(loaded), *plain.warnings(stability), *at_start(entries)]
        except MemoryError as error:  # of panels' meshes; nothing has been computed
            if first and save is None:
                run_folder.remove_folder(folder)
            return refused(world, error)
        for line in words.lines(stability):
            LOG.info(line)
        for line in before:
            LOG.warning(line)
            console.print(f"warning: {line}")
        opened = Run(loaded, entries, stability, folder, world, console, save)
        return _run_guarded(opened, folder, world, console)


class _StandardError(io.TextIOBase):
    """Standard error, which may go away during a run: a terminal that hangs up, a pipe that nobody
    reads any more.  What can be said to nobody is in run.log.  From then on the stream leads
    nowhere, or Python would end with exit code 120 over what it could not write."""

    def __init__(self) -> None:
        # while it shows a bar, Rich puts something in the place of standard error that prints here
        self._stream = getattr(sys.stderr, "rich_proxied_file", sys.stderr)

    def write(self, text: str) -> int:
        try:
            self._stream.write(text)
        except OSError:
            self._leads_nowhere()
        return len(text)

    def flush(self) -> None:
        try:
            self._stream.flush()
        except OSError:
            self._leads_nowhere()

    def _leads_nowhere(self) -> None:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)

    def isatty(self) -> bool:
        return bool(self._stream.isatty())

    def fileno(self) -> int:
        return int(self._stream.fileno())


def _console(quiet: bool = False) -> Console:
    file = cast(IO[str], _StandardError())
    return Console(file=file, quiet=quiet, highlight=False, markup=False, soft_wrap=True)


def _run_guarded(run: Run, folder: Path, world: Any, console: Console) -> int:
    """Runs, and turns whatever happens into a message, a finished folder and an exit code."""
    try:
        run.go()
    except Interrupted as stopped:
        code, status, reason = 128 + stopped.signal, "interrupted", str(stopped)
        _say(f"{reason} at t = {run.simulated_s:g} s", console)
        console.print(run_folder.printable(f"to go on: {go_on(folder, world)}"))
    except BaseException as error:
        return _ended(run, *_ending(error), folder, world)
    else:
        code, status, reason = DONE, trust.DONE, ""
    try:
        return ranks.first_rank_does(world, lambda: _finished(run, code, status, reason, folder, console))
    except KeyboardInterrupt:
        _say(f"stopped at once: what the run leaves at its end is not in {folder}", console)
        return ranks.end_all(world, AT_ONCE)


def _ending(error: BaseException) -> tuple[int, str, str]:
    """Exit code, status and reason of a run that ``error`` ended."""
    if stop := immediate_stop(error):
        code = 128 + stop.signal if isinstance(stop, ImmediateStop) else AT_ONCE
        return code, "interrupted", str(stop) or "stopped at once"
    match error:
        case CaseError():
            return WRONG, "refused", str(error)
        case SolverMissing():
            return MISSING, "refused", str(error)
        case SolverFailed() | OSError() | MemoryError():
            return FAILED, "failed", _noted(str(error) or OUT, error)
        case Exception():
            LOG.error("a mistake in flipflow", exc_info=error)
            said = f"a mistake in flipflow: {type(error).__name__}: {error}"
            return BROKEN, "failed", _noted(said, error)
    raise error


def _finished(run: Run, code: int, status: str, reason: str, folder: Path, console: Console) -> int:
    """Writes what a run leaves at its end; returns its exit code, which is another one than
    ``code`` where the summary says that the run is doubtful or incomplete, or cannot be written."""
    try:
        figures = run.finish(status, reason)
        _close(figures, folder, console)
    except OSError as error:
        LOG.error("no summary: %s", error)
        console.print(f"no summary: {error}\nall else is in {folder}")
        return FAILED
    return trust.EXIT_CODES.get(figures["status"], code)


def _noted(reason: str, error: BaseException) -> str:
    """With the member and the moment, where they are known."""
    return "; ".join([reason, *getattr(error, "__notes__", ())])


def _ended(run: Run, code: int, status: str, reason: str, folder: Path, world: Any) -> int:
    """The first rank to fail speaks and ends all of them, wherever they wait.  What was refused
    before anything was computed leaves no folder."""
    if not run_folder.claim(folder / "failure.txt", reason, world.rank if world else 0):
        time.sleep(60)  # the rank that speaks ends this one, too, when it has written its summary
    else:
        LOG.error(reason)
        console = _console()
        console.print(reason)
        if status != "refused":
            _leave_usable(run, status, reason, folder, console)
            for line in last_good(folder, world):
                LOG.error(line)
                console.print(line)
        elif run.resumes is None:
            run_folder.remove_folder(folder)
    return ranks.end_all(world, code)


def _leave_usable(run: Run, status: str, reason: str, folder: Path, console: Console) -> None:
    logs = ", ".join(sorted(str(log) for log in folder.rglob("*log*") if log.is_file()))
    console.print(f"logs: {logs}" if logs else f"{folder} has gone")
    try:
        run.finish(status, reason)
    except (OSError, MemoryError) as error:
        console.print(f"no summary: {error or OUT}")


def _close(figures: dict[str, Any], folder: Path, console: Console) -> None:
    """The closing table, and where everything is."""
    if trust.came_to_its_end(figures["status"]):
        console.print(summary.closing_table(figures))
        for line in summary.closing_lines(figures):
            _say(line, console)
        for tile in headline(figures.get("results") or {}):
            _say(tile.line, console)
        for doubt in figures["doubts"]:
            LOG.warning("do not trust this run: %s", doubt)
            console.print(f"WARNING: do not trust this run: {doubt}")
    console.print(run_folder.printable(f"results in {folder}"))


def _say(line: str, console: Console) -> None:
    """On the console and in the log."""
    LOG.info(line)
    console.print(run_folder.printable(line))
