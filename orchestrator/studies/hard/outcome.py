"""How a run came out: stable, warned of itself, or stopped with a reason."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

from orchestrator.coupling.ledger import share_created
from orchestrator.output.records import trust
from orchestrator.output.results.run_reader import RunReader

Outcome = Literal["stable", "warned", "stopped", "not run"]
INTERNAL_ERROR = "internal error"


OF_THE_COUPLING = ("created_energy", "created_in_total", "growing_modes")  # of the watch
REMARKS = ("share created", "intervals not solved", "why it was stopped")


def outcome(folder: Path) -> Outcome:
    """``stable``: came to its end, neither the watch on the coupling had anything to say of its
    energy and modes, nor is it doubtful; ``warned``: came to its end, and one of them; ``stopped``:
    ended early with a reason (exit code 4); ``not run``: interrupted, missing, or a mistake in
    flipflow."""
    found = _summary(folder)
    status, reason = found.get("status"), str(found.get("reason"))
    if status == "failed" and not reason.startswith(INTERNAL_ERROR):
        return "stopped"
    if not trust.came_to_its_end(str(status)):
        return "not run"
    figures = found.get("monitor", {}).get("figures", {})
    amiss = any(figures[key]["times"] for key in OF_THE_COUPLING if key in figures)
    return "warned" if amiss or status == trust.DOUBTFUL else "stable"


def remarks(folder: Path) -> tuple[str, str, str]:
    """``REMARKS``, as far as they are known: energy created over all exchanged and lost; intervals
    that an iterated scheme did not solve to its tolerance; the reason of an early end."""
    found = _summary(folder)
    share = f"{share_created(found):+.1e}" if "energy_ledger_J" in found else ""
    iterations = found.get("iterations") or {}
    return share, str(iterations.get("unsolved", "")), str(found.get("reason", ""))


def _summary(folder: Path) -> dict[str, Any]:
    """Empty where there is none."""
    try:
        return RunReader(folder).summary
    except (OSError, ValueError):
        return {}
