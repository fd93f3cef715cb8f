"""A run that goes on from a checkpoint, in its own folder."""

from __future__ import annotations

import json
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from orchestrator.cli.launch import execute, report_refusal, require_runnable
from orchestrator.coupling import mpi
from orchestrator.output import checkpoints
from orchestrator.output.checkpoints import Checkpoint
from orchestrator.output.records.run_folder import SUMMARY, FolderUnusable, is_at_work, write_case, write_json
from orchestrator.preflight.judge import JudgedCase, load_judged
from orchestrator.preflight.judgement.account import account
from orchestrator.run.origin import origin, refuse_another_run, warnings

KILLED = "the run had been killed, or the machine stopped: nothing says how it ended"


def resume(folder: Path, overrides: Sequence[str], sync_point: int | None = None) -> int:
    """Goes on with a run on every rank, from its last checkpoint or from that of a ``sync_point``.
    Returns the exit code."""
    world = mpi.communicator()
    try:
        checkpoint = mpi.first_rank_does(world, lambda: _find_checkpoint(folder, sync_point))
        as_saved = load_judged(folder, None, overrides)
        loaded = replace(as_saved, name=checkpoint.about["name"], level=checkpoint.about["level"])
        require_runnable(loaded)
        entries = account(loaded.described, loaded.left_out)
        warned = mpi.first_rank_does(world, lambda: _prepare_folder(folder, checkpoint, loaded, world))
        return execute(loaded, entries, folder, world, checkpoint, warned)
    except Exception as error:
        return report_refusal(world, error)


def _find_checkpoint(folder: Path, sync_point: int | None) -> Checkpoint:
    """Returns the last checkpoint that is whole, or the one of a sync point.  Raises FolderUnusable."""
    if not (folder / "case.toml").is_file() or not (folder / "provenance.json").is_file():
        raise FolderUnusable(f"{folder}: is not the folder of a run")
    if is_at_work(folder):
        raise FolderUnusable(f"{folder}: the run is still going on")
    checkpoint = (
        checkpoints.newest(folder) if sync_point is None else checkpoints.at_sync_point(folder, sync_point)
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
    """Makes the folder as it was at the checkpoint, and returns warnings about that.  Raises
    FolderUnusable for what is another run."""
    now = origin(loaded, folder, world)
    refuse_another_run(checkpoint, now)
    killed = [] if (folder / SUMMARY).exists() else [KILLED]
    checkpoints.remove_later(folder, checkpoint)
    checkpoint.put_back(folder)
    for of_the_end in ("failure.txt", SUMMARY):
        (folder / of_the_end).unlink(missing_ok=True)
    write_case(folder, loaded)
    provenance = json.loads((folder / "provenance.json").read_text(encoding="utf-8"))
    resumed = [*provenance.get("resumed", []), {"at_s": checkpoint.simulated_s, **now["provenance"]}]
    write_json(folder / "provenance.json", provenance | {"resumed": resumed})
    return [*killed, *checkpoint.torn, *warnings(checkpoint, now)]
