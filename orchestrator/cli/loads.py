"""The command ``flipflow loads``: the forces on a frame as files for another program."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from orchestrator.case.file.folder import FolderUnusable, admit
from orchestrator.output.loads import Format
from orchestrator.output.loads.files import write_loads
from orchestrator.output.loads.forces import read_forces


def export(run: Path, frame: str, how: Format, out: Path, from_s: float, to_s: float) -> Iterator[str]:
    """Write the loads on a frame, and yield what is said.

    Raises CaseError, FolderUnusable and OSError for what is wrong.
    """
    if out.exists() and (not out.is_dir() or any(out.iterdir())):
        raise FolderUnusable(f"{out}: is there already; give a new folder with --out")
    try:
        forces = read_forces(admit(run), frame, from_s, to_s)
    except ValueError as error:  # a folder that is no run, or of another version
        raise FolderUnusable(str(error)) from None
    yield from (f"written: {file}" for file in write_loads(forces, how, out, run.name, frame))
    force, moment = forces.out_of_balance()
    yield (
        f"{len(forces.names)} loads at {len(forces.time_s)} moments: forces balance to {force:.1e} of the "
        f"largest, moments about the centre of mass to {moment:.1e}"
    )
