"""How a run that ended early is taken up again: the words for it."""

from __future__ import annotations

import os
import shlex
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from orchestrator.output import checkpoints
from orchestrator.output.checkpoints import Save


def last_good(folder: Path, world: Any) -> Iterator[str]:
    """Where a run that failed can be taken up again."""
    last = checkpoints.newest(folder)
    if last is None:
        return
    good = checkpoints.at_sync_point(folder, last.good)
    if good is None:
        yield f"nothing was saved before; state at t = {last.simulated_s:g} s: {last.folder}"
    else:
        yield f"last good state: t = {good.simulated_s:g} s, {good.folder}"
    yield f"to go on from there: {go_on(folder, world, good or last)}"


def go_on(folder: Path, world: Any, save: Save | None = None) -> str:
    """The command that takes the run up again, from ``save`` or the last one."""
    with_ranks = [] if world is None else ["mpirun", *_as_root(), "-n", str(world.size)]
    point = [] if save is None else ["--save", str(save.sync_points)]
    return shlex.join([*with_ranks, "flipflow", "resume", str(folder), *point])


def _as_root() -> list[str]:
    """Open MPI's mpirun wants this of root, unless the environment says so, as in Docker."""
    allowed = os.geteuid() != 0 or "OMPI_ALLOW_RUN_AS_ROOT" in os.environ
    return [] if allowed else ["--allow-run-as-root"]
