"""The origin of a checkpoint: which run it belongs to, and whether a run may go on from it.

Tables that only observe the run (``FREE``) may change, and the run may end later; but means over output
times and accelerations need rows at one distance from the start to the end (``EVEN``).  Any other change
would make it another run.  Other versions of programs or another computer may change the last bits of the
results, which a warning says.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from orchestrator.case.bed.saved_bed import BED
from orchestrator.case.file.errors import show_value
from orchestrator.case.file.folder import FolderUnusable
from orchestrator.case.file.nested import leaves
from orchestrator.case.provenance import provenance
from orchestrator.output.checkpoints import ORIGIN_KEYS, Checkpoint
from orchestrator.output.records.run_folder import named_files, resolved_case
from orchestrator.preflight.judge import JudgedCase

FREE = {"title", "description", "default_level", "output", "checkpoint", "monitor"}
EVEN = {"output.interval_s", "output.series_s", "output.shapes_s"}
SAME_BITS = tuple(name for name in ORIGIN_KEYS if name != "ranks")


def origin(loaded: JudgedCase, run: Path, world: Any) -> dict[str, Any]:
    """Return where a checkpoint comes from, for ``checkpoint.json``; ``run`` is the folder of the run."""
    copies = [run / named.copy for named in named_files(loaded.case.whole_machine)]
    named = [copy for copy in copies if copy.is_file()] + [*run.glob(BED)]
    return {
        "name": loaded.name,
        "level": loaded.level,
        "case": resolved_case(loaded),
        "files": {file.name: hashlib.sha256(file.read_bytes()).hexdigest() for file in named},
        "provenance": provenance(1 if world is None else world.size),
    }


def refuse_another_run(checkpoint: Checkpoint, now: Mapping[str, Any]) -> None:
    """Raise FolderUnusable with a list of the differences if ``now`` (from ``origin``) is another run."""
    about = checkpoint.about
    ranks, then = now["provenance"]["ranks"], about["provenance"]["ranks"]
    differing = [
        f"  {key}: {show_value(before)} was saved, now it is {show_value(after)}"
        for key, before, after in differences(about["case"], now["case"])
        if not _may_change(key, before, after, checkpoint.simulated_s)
    ]
    for name, digest in about["files"].items():
        if now["files"].get(name) != digest:
            differing.append(f"  {name} is another file")
    if ranks != then:
        differing.append(f"  {then} processes saved it, now there are {ranks}")
    if differing:
        free = ", ".join(sorted(FREE))
        raise FolderUnusable(
            f"{checkpoint.folder.parent.parent}: this is not the run that was saved:\n"
            + "\n".join(differing)
            + f"\nIt may end later (duration_s) and change in: {free}, but for the intervals of output; "
            "all else needs a new run."
        )


def warnings(checkpoint: Checkpoint, now: Mapping[str, Any]) -> list[str]:
    """Return a line for each difference that may change the last bits."""
    then = checkpoint.about["provenance"]
    return [
        f"saved with {key} {before}, now it is {after}: the last bits may differ"
        for name in SAME_BITS
        for key, before, after in differences({name: then[name]}, {name: now["provenance"][name]})
    ]


def differences(before: Mapping[str, Any], after: Mapping[str, Any]) -> list[tuple[str, Any, Any]]:
    """Return the dotted keys that differ with both values; a value that is missing is None."""
    flat = _flatten(before), _flatten(after)
    keys = sorted(flat[0].keys() | flat[1].keys())
    values = ((key, flat[0].get(key), flat[1].get(key)) for key in keys)
    return [(key, old, new) for key, old, new in values if old != new]


def _may_change(key: str, before: Any, after: Any, simulated_s: float) -> bool:
    if key == "duration_s":
        return isinstance(after, float | int) and after >= simulated_s
    return key.split(".")[0] in FREE and key not in EVEN


def _flatten(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of a table by dotted keys; elements of lists are counted from 1."""
    return {
        ".".join(str(word + 1 if isinstance(word, int) else word) for word in key): value
        for key, value in leaves(table)
    }
