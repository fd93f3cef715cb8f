"""A run that the command line starts or resumes: its output, its errors and its exit code.

The exit code is 0 if the run is done, 1 after an internal error, 2 if the case or the output folder is
wrong, 3 if a solver is missing, 4 if a solver failed, the run became unstable or its results could not
be written, 5 if the run is done but not to be trusted, 6 if it is done but its results could not be
made, and 129 (SIGHUP), 130 (SIGINT), 138 (SIGUSR1) or 143 (SIGTERM) if it was interrupted.
"""

from __future__ import annotations

import io
import json
import os
import shlex
import signal
import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import IO, Any, cast

from rich.console import Console

from orchestrator.case import provenance
from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.folder import FolderUnusable, UnreadableFile, admit, open_hdf5
from orchestrator.case.file.whole import write_json
from orchestrator.cli import accuracy
from orchestrator.cli.console import FAILED, MISSING, TOO_LARGE, WRONG, TextConsole, find_all_problems
from orchestrator.cli.overview import adhesion_lines
from orchestrator.coupling import mpi
from orchestrator.figures.results import parse_results
from orchestrator.output import checkpoints
from orchestrator.output.checkpoints import Checkpoint, OtherCheckpoint
from orchestrator.output.records import run_folder, summary, trust
from orchestrator.output.records.run_folder import (
    HISTORY,
    LOG,
    PAGE,
    PICTURES,
    RUN_LOCK,
    SUMMARY,
    is_at_work,
    lock,
    write_case,
)
from orchestrator.output.report.corners import range_lines
from orchestrator.output.report.errors import closing_line
from orchestrator.output.report.headline import headline_lines
from orchestrator.ports.plans import SolverFailed, SolverMissing
from orchestrator.preflight.check import warnings
from orchestrator.preflight.judge import JudgedCase, load_judged
from orchestrator.preflight.judgement.account import Entry, account, lines_at_start, recall
from orchestrator.preflight.judgement.catalogue import EFFECTS
from orchestrator.preflight.judgement.pair import key_of, share_pairs
from orchestrator.preflight.scene.frame_motion import motion_lines
from orchestrator.preflight.scene.scene import scene
from orchestrator.preflight.stability.report import stability_report
from orchestrator.run.interruption import ImmediateStop, Interrupted, find_immediate_stop
from orchestrator.run.origin import origin, refuse_another_run
from orchestrator.run.origin import warnings as origin_warnings
from orchestrator.run.run import Run
from orchestrator.run.trials.half_interval import try_half
from orchestrator.run.trials.pairs import try_before_run

KILLED = "the run had been killed, or the machine stopped: nothing says how it ended"
DONE, BROKEN = 0, 1
OUT = "out of memory"
AT_ONCE = 128 + signal.SIGINT
RANK_0_FIRST_S = 3.0  # rank 0 closes its files within that time
SUMMARY_WRITTEN_S = 3600.0  # the results of a long run take minutes


def run(
    path: Path, level: str | None, out: Path | None, overrides: Sequence[str], trial_s: float = 0.0
) -> int:
    """Run a case on every rank, and return the exit code.

    ``trial_s`` is the wall time that a single process may spend on half the interval after a run that advises
    a shorter one.
    """
    world = mpi.communicator()
    with ExitStack() as held:
        try:
            loaded = load_judged(path, level, overrides)
            _require_runnable(loaded)
            loaded = _decide_effects(loaded, path, level, overrides, world)
            entries = account(loaded.described, loaded.left_out, loaded.choice.pairs, loaded.choice.asked)
            _require_same_case(loaded, world)  # and no folder is made if another rank refuses the case
            folder = mpi.first_rank_does(world, lambda: run_folder.create_run_folder(loaded, out, world))
            _hold(folder, held, world)
            code = _execute(loaded, entries, folder, world)
            for line in try_half(folder, trial_s) if world is None and trial_s > 0 else ():
                _console().print(line)
            return code
        except Exception as error:
            return _report_refusal(world, error)


def resume(folder: Path, overrides: Sequence[str], sync_point: int | None = None) -> int:
    """Resume a run on every rank, and return the exit code.

    The run continues from its last checkpoint or from the checkpoint of a ``sync_point``.
    """
    world = mpi.communicator()
    with ExitStack() as held:
        try:
            mpi.first_rank_does(world, lambda: _require_ended_run(folder))
            _hold(folder, held, world)
            checkpoint = mpi.first_rank_does(world, lambda: _find_checkpoint(folder, sync_point))
            as_saved = load_judged(folder, None, overrides)
            about = checkpoint.about
            left_out = {name: figures["left_out"] for name, figures in about["left_out"].items()}
            loaded = replace(as_saved, name=about["name"], level=about["level"], left_out=left_out)
            _require_runnable(loaded)
            _require_same_case(loaded, world)
            entries = recall(account(loaded.described, loaded.left_out), about["left_out"])
            warned = mpi.first_rank_does(world, lambda: _prepare_folder(folder, checkpoint, loaded, world))
            return _execute(loaded, entries, folder, world, checkpoint, warned)
        except Exception as error:
            return _report_refusal(world, error)


def _hold(folder: Path, held: ExitStack, world: Any) -> None:
    """Lock the folder of a run until ``held`` ends.  Raises FolderUnusable if another process works there."""
    mpi.first_rank_does(world, lambda: held.enter_context(lock(folder / RUN_LOCK)))


def _decide_effects(
    loaded: JudgedCase, path: Path, level: str | None, overrides: Sequence[str], world: Any
) -> JudgedCase:
    """Return the case after short runs with and without the effects about which "auto" cannot decide.

    The first rank makes the runs or finds them in the memory, and all ranks make the same choice.
    """
    if not loaded.choice.asked:
        return loaded
    say = _console().print
    tried = mpi.first_rank_does(world, lambda: try_before_run(loaded, say))
    if not tried and world is None:
        return loaded
    known = mpi.first_rank_does(world, lambda: {**loaded.choice.pairs, **tried})
    read = loaded.origin.read()
    share_pairs({key_of(read, name): known.get(name) for name in EFFECTS})
    loaded = load_judged(path, level, overrides)
    _require_runnable(loaded)
    return loaded


def _require_ended_run(folder: Path) -> None:
    """Raise FolderUnusable if a folder has no run, a foreign one, or one that is still going on."""
    if not (folder / "case.toml").is_file() or not (folder / "provenance.json").is_file():
        raise FolderUnusable(f"{folder}: is not the folder of a run")
    if is_at_work(admit(folder)):
        raise FolderUnusable(f"{folder}: the run is still going on")
    provenance.read_provenance(folder)


def _find_checkpoint(folder: Path, sync_point: int | None) -> Checkpoint:
    """Return the last undamaged checkpoint, or the checkpoint of a sync point.

    Raises FolderUnusable if there is none, and OtherCheckpoint if another version of flipflow wrote it.
    """
    checkpoint = (
        checkpoints.find_newest(folder)
        if sync_point is None
        else checkpoints.find_at_sync_point(folder, sync_point)
    )
    if checkpoint is None and (torn := checkpoints.find_damage(folder)):
        raise FolderUnusable(f"{folder}: no checkpoint that is whole:\n" + "\n".join(torn))
    if checkpoint is None and sync_point is not None:
        raise FolderUnusable(
            f"{folder}: has no whole checkpoint of sync point {sync_point}; they are in "
            f"{folder / checkpoints.FOLDER}"
        )
    if checkpoint is None:
        raise FolderUnusable(
            f"{folder}: nothing was saved; [checkpoint] in a case says when that is done, and what ends "
            "a run with Ctrl-C does it, too"
        )
    return checkpoint


def _prepare_folder(folder: Path, checkpoint: Checkpoint, loaded: JudgedCase, world: Any) -> list[str]:
    """Restore the folder as it was at the checkpoint, and return warnings about that.

    Raises FolderUnusable if the case is that of another run, and UnreadableFile if the series are foreign.
    """
    now = origin(loaded, folder, world)
    refuse_another_run(checkpoint, now)
    killed = [] if (folder / SUMMARY).exists() else [KILLED]
    checkpoints.remove_later(folder, checkpoint)
    checkpoint.put_back(folder)
    open_hdf5(folder / HISTORY).close()
    for written_at_end in ("failure.txt", SUMMARY, PAGE, *PICTURES):
        (folder / written_at_end).unlink(missing_ok=True)
    write_case(folder, loaded)
    begun = provenance.read_provenance(folder)
    resumed = [*begun.get("resumed", []), {"at_s": checkpoint.simulated_s, **now["provenance"]}]
    write_json(folder / "provenance.json", begun | {"resumed": resumed})
    return [*killed, *checkpoint.torn, *origin_warnings(checkpoint, now)]


def _require_runnable(loaded: JudgedCase) -> None:
    """Raise CaseError for a case with problems, and SolverMissing if this rank lacks the panels' solver.

    PETSc starts on all ranks together, so none may go on without it.
    """
    if problems := find_all_problems(loaded):
        raise CaseError(problems)
    if loaded.case.screen.panels:
        loaded.case.panel.adapter.load()


def _require_same_case(loaded: JudgedCase, world: Any) -> None:
    """Wait until all ranks have read the case, and raise FolderUnusable if they have not read the same.

    The order of tables counts, too: it numbers the materials.
    """
    if world is not None and len(set(world.allgather(json.dumps(run_folder.resolved_case(loaded))))) > 1:
        raise FolderUnusable(
            f"{loaded.folder}: the ranks have read different cases there; give all of them the same files "
            "and options"
        )


def _report_refusal(world: Any, error: Exception) -> int:
    """Print once why nothing will run, and return the exit code."""
    match error:
        case SolverMissing():
            message, code = str(error), MISSING
        case OtherCheckpoint():
            message, code = str(error), FAILED
        case CaseError() | FolderUnusable() | UnreadableFile() | OSError():
            message, code = str(error), WRONG
        case MemoryError():
            message, code = TOO_LARGE, WRONG
        case _:
            message, code = _describe_internal(error), BROKEN
    return mpi.in_turn(world, lambda: _console().print(message), code)


def _execute(
    loaded: JudgedCase,
    entries: Mapping[str, Entry],
    folder: Path,
    world: Any,
    checkpoint: Checkpoint | None = None,
    warned: Sequence[str] = (),
) -> int:
    """Run the case in its folder, or continue from ``checkpoint``, and return the exit code.

    ``entries`` is the account of its effects, and ``warned`` has further warnings.
    """
    first = mpi.is_first(world)
    console = _console(quiet=not first)
    with run_folder.logging_to(folder, first):
        LOG.info("case %s, level %s", loaded.folder, loaded.level or "none")
        _print_and_log(loaded.case.title, console)
        doing = "running" if checkpoint is None else f"going on from t = {checkpoint.simulated_s:g} s with"
        _print_and_log(f"{doing} {loaded.name} {loaded.level} into {folder}", console)
        for line in motion_lines(scene(loaded.case)):
            _print_and_log(line, console)
        try:
            stability = stability_report(loaded.case)
            lines = [
                *warned,
                *provenance.warnings(),
                *warnings(loaded),
                *stability.warnings(),
                *lines_at_start(entries),
            ]
        except MemoryError as error:  # the panels' meshes are too large; nothing has been computed
            if first and checkpoint is None:
                run_folder.remove_folder(folder)
            return _report_refusal(world, error)
        for line in (*adhesion_lines(loaded.case), *stability.detail_lines()):
            LOG.info(line)
        for line in lines:
            LOG.warning(line)
            console.print(f"warning: {line}")
        found = mpi.first_rank_does(world, lambda: accuracy.found(loaded, folder, checkpoint is not None))
        coupled_run = Run(loaded, entries, stability, folder, world, console, found, checkpoint)
        return _run_to_the_end(coupled_run, loaded, folder, world, console)


class _StandardError(io.TextIOBase):
    """Standard error that survives the loss of its reader during a run.

    A terminal may hang up, or a pipe may lose its reader; run.log has all lines anyway.  The stream then
    leads to the null device, because otherwise Python would end with exit code 120.
    """

    def __init__(self) -> None:
        # while Rich shows a bar, it replaces standard error by a proxy, which would print to this console
        self._stream = getattr(sys.stderr, "rich_proxied_file", sys.stderr)

    def write(self, text: str) -> int:
        try:
            self._stream.write(text)
        except OSError:
            self._discard_from_now()
        return len(text)

    def flush(self) -> None:
        try:
            self._stream.flush()
        except OSError:
            self._discard_from_now()

    def _discard_from_now(self) -> None:
        nowhere = os.open(os.devnull, os.O_WRONLY)
        os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)

    def isatty(self) -> bool:
        return bool(self._stream.isatty())

    def fileno(self) -> int:
        return int(self._stream.fileno())


def _console(quiet: bool = False) -> Console:
    file = cast(IO[str], _StandardError())
    return TextConsole(file=file, quiet=quiet, highlight=False, markup=False, soft_wrap=True)


def _run_to_the_end(run: Run, loaded: JudgedCase, folder: Path, world: Any, console: Console) -> int:
    """Run to the end or to an error, finish the folder, print a message and return the exit code."""
    try:
        run.go()
    except Interrupted as stopped:
        code, status, reason = 128 + stopped.signal, "interrupted", str(stopped)
        _print_and_log(f"{reason} at t = {run.simulated_s:g} s", console)
        console.print(f"to go on: {resume_hint(folder, world)}")
    except BaseException as error:
        return _end_after_error(run, *_classify(error), folder, world)
    else:
        code, status, reason = DONE, trust.DONE, ""
    try:
        return mpi.first_rank_does(world, lambda: _finish(run, loaded, code, status, reason, folder, console))
    except KeyboardInterrupt:
        _print_and_log(f"stopped at once: {folder} lacks what a run writes at its end", console)
        return mpi.end_all(world, AT_ONCE)


def _classify(error: BaseException) -> tuple[int, str, str]:
    """Return the exit code, the status and the reason of a run that ``error`` ended.

    Raise ``error`` itself if it is no exception of a kind that ends runs.
    """
    if stop := find_immediate_stop(error):
        code = 128 + stop.signal if isinstance(stop, ImmediateStop) else AT_ONCE
        return code, "interrupted", str(stop) or "stopped at once"
    notes = getattr(error, "__notes__", ())  # the member and the moment, if they are known
    match error:
        case CaseError():
            return WRONG, "refused", str(error)
        case SolverMissing():
            return MISSING, "refused", str(error)
        case SolverFailed() if not isinstance(error.__cause__, MemoryError | OSError):
            return FAILED, "failed", "; ".join([str(error), *notes])
        case SolverFailed() | OSError() | MemoryError():
            return FAILED, "failed", "; ".join([f"{trust.REFUSED}: {str(error) or OUT}", *notes])
        case Exception():
            LOG.error("internal error", exc_info=error)
            return BROKEN, "failed", "; ".join([_describe_internal(error), *notes])
    raise error


def _describe_internal(error: Exception) -> str:
    return f"{trust.INTERNAL_ERROR}: {type(error).__name__}: {error}"


def _finish(
    run: Run, loaded: JudgedCase, code: int, status: str, reason: str, folder: Path, console: Console
) -> int:
    """Finish the run's folder, print the closing table and the folder, and return the exit code.

    The exit code differs from ``code`` if the summary calls the run doubtful or incomplete, or cannot be
    written.
    """
    try:
        figures = run.finish(status, reason)
        if trust.came_to_its_end(figures["status"]):
            console.print(summary.closing_table(figures))
            results = parse_results(figures)
            ranges = range_lines(folder, loaded, results)
            for line in (*summary.closing_lines(figures), *headline_lines(results), *ranges):
                _print_and_log(line, console)
            _print_and_log(closing_line(figures), console)
            for doubt in figures["doubts"]:
                LOG.warning("do not trust this run: %s", doubt)
                console.print(f"WARNING: do not trust this run: {doubt}")
        console.print(f"results in {folder}")
    except OSError as error:
        LOG.error("the results are not complete: %s", error)
        console.print(f"the results are not complete: {error}\nall else is in {folder}")
        return FAILED
    return trust.EXIT_CODES.get(figures["status"], code)


def _end_after_error(run: Run, code: int, status: str, reason: str, folder: Path, world: Any) -> int:
    """End all ranks, wherever they wait; the first rank that fails prints the reason.

    Where all ranks fail alike that is rank 0, which alone has the figures of the summary.  A run that is
    refused before it has computed anything leaves no folder.
    """
    rank = world.rank if world else 0
    if rank > 0:
        time.sleep(RANK_0_FIRST_S)
    if not run_folder.claim(folder / "failure.txt", reason, rank):
        time.sleep(SUMMARY_WRITTEN_S)  # the rank that failed first then ends this one
        return mpi.end_all(world, code)
    LOG.error(reason)
    console = _console()
    console.print(reason)
    if status != "refused":
        logs = ", ".join(sorted(str(log) for log in folder.rglob("*log*") if log.is_file()))
        console.print(f"logs: {logs}" if logs else f"{folder} has gone")
        try:
            run.finish(status, reason)
        except Exception as error:  # whatever it is, the other ranks wait for this one
            LOG.error("no summary", exc_info=error)
            console.print(f"no summary: {error or OUT}")
        for line in resume_lines(folder, world):
            LOG.error(line)
            console.print(line)
    elif run.resumes is None:
        run_folder.remove_folder(folder)
    return mpi.end_all(world, code)


def _print_and_log(line: str, console: Console) -> None:
    LOG.info(line)
    console.print(line)


def resume_lines(folder: Path, world: Any) -> Iterator[str]:
    """Yield lines about the last good state of a failed run, with the command that resumes it there."""
    last = checkpoints.find_newest(folder)
    if last is None:
        return
    good = checkpoints.find_at_sync_point(folder, last.good)
    if good is None:
        yield f"nothing was saved before; state at t = {last.simulated_s:g} s: {last.folder}"
    else:
        yield f"last good state: t = {good.simulated_s:g} s, {good.folder}"
    yield f"to go on from there: {resume_hint(folder, world, good or last)}"


def resume_hint(folder: Path, world: Any, checkpoint: Checkpoint | None = None) -> str:
    """Return the command that resumes the run from ``checkpoint``, or from the last checkpoint."""
    # Open MPI's mpirun refuses to run as root unless the environment or this option allows it
    allowed = os.geteuid() != 0 or "OMPI_ALLOW_RUN_AS_ROOT" in os.environ
    as_root = [] if allowed else ["--allow-run-as-root"]
    with_ranks = [] if world is None else ["mpirun", *as_root, "-n", str(world.size)]
    point = [] if checkpoint is None else ["--checkpoint", str(checkpoint.sync_points)]
    return shlex.join([*with_ranks, "flipflow", "resume", str(folder), *point])
