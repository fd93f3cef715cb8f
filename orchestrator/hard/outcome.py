"""How a run came out: stable, warned of itself, or stopped with a reason."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Literal

from orchestrator.records.summary import LARGEST_SHARE_CREATED, share_created

Outcome = Literal["stable", "warned", "stopped", "not run"]
MISTAKE = "a mistake in flipflow"


def outcome(folder: Path) -> Outcome:
    """``stable``: came to its end, and the coupling created less energy than a run warns of;
    ``warned``: came to its end, and says that it is not to be trusted; ``stopped``: ended early
    with a reason (exit code 4); ``not run``: interrupted, missing, or a mistake in flipflow."""
    try:
        found = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
        status, reason = str(found["status"]), str(found["reason"])
    except (OSError, ValueError, KeyError):
        return "not run"
    if status == "failed" and not reason.startswith(MISTAKE):
        return "stopped"
    if status != "done":
        return "not run"
    share = abs(share_created(found["energy_ledger_J"]))
    return "stable" if share <= LARGEST_SHARE_CREATED else "warned"
