"""Whether the numbers of a run can be trusted, and what it warned of."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from orchestrator.coupling.ledger import share_created
from orchestrator.output.records import trust
from orchestrator.output.records.summary import closing_lines
from orchestrator.output.report.formatting import number

SHOWN = 12
UNSETTLED = 0.1  # of a frame's orbit: so much of the motion along the deck is no first harmonic


def quality_rows(summary: dict[str, Any]) -> list[tuple[str, str]]:
    """Returns rows about momentum, energy and speed; fewer for a run that failed."""
    rows = []
    if "momentum_residual_relative" in summary:
        residual = f"{summary['momentum_residual_relative']:.1e}"
        rows.append(("momentum residual, worst member (1e-12 is rounding)", residual))
    if "energy_ledger_J" in summary:
        ledger = summary["energy_ledger_J"]
        for interface in ("particles-panel", "panel-frames"):
            if f"created.{interface}" in ledger:
                created = number(ledger[f"created.{interface}"])
                rows.append((f"energy created between {interface.replace('-', ' and ')}", f"{created} J"))
        for interface, exchanged_J in summary.get("energy_exchanged_J", {}).items():
            between = interface.replace("-", " and ")
            rows.append((f"energy exchanged between {between}", f"{number(exchanged_J)} J"))
        share = f"{100 * share_created(summary):.2g} %"
        rows.append(("energy created, of what was exchanged and lost, worse of the two", share))
    rows.append(("sync intervals", f"{summary['sync_intervals']}"))
    if monitor := summary.get("monitor"):
        rows += list(_monitor_rows(monitor))
    if summary["particle_steps_per_s"]:
        rows.append(("particle steps per second", f"{summary['particle_steps_per_s']:.2e}"))
    return rows


def _monitor_rows(monitor: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """What the monitor did, and the worst that it saw."""
    if monitor["shortened_intervals"]:
        shortened = f"{monitor['shortened_intervals']}, down to {monitor['shortest_interval_s']:g} s"
        yield "of them run in parts", shortened
    for name, figure in monitor["figures"].items():
        seen = f"{number(figure['worst'])} (limit {figure['limit']:g})"
        times = f", beyond it {figure['times']} times" if figure["times"] else ""
        yield f"monitor: {name.replace('_', ' ')}, worst", seen + times


def collect_warnings(folder: Path, summary: dict[str, Any], results: dict[str, Any]) -> list[str]:
    """Says how the run ended, what is not steady, what is missing, and what the log warned of."""
    warnings = [f"Do not trust this run: {doubt}" for doubt in summary["doubts"]]
    if not trust.came_to_its_end(summary["status"]):
        warnings.append(f"The run was {summary['status']}: {summary['reason']}")
    elif summary["status"] == trust.INCOMPLETE:
        warnings.append(f"The run is incomplete: {summary['reason']}")
    state = results.get("steady")
    if state and not state["is_steady"]:
        warnings.append(f"No steady state: {state['reason']}. Bed and screening figures are transient.")
    motion = results.get("motion")
    if motion and motion["cycles"] and not motion["is_settled"]:
        warnings.append(f"The machine has not settled: {motion['reason']}.")
    for name, orbit in results.get("motion", {}).get("frames", {}).items():
        if orbit["other_m"][0] > UNSETTLED * orbit["major_m"] > 0:
            warnings.append(f"{name} has not settled to its periodic motion")
    warnings += [f"Results not made: {part}: {error}" for part, error in results["failed"].items()]
    if "energy_ledger_J" in summary:
        warnings += [line for line in closing_lines(summary) if line.startswith("WARNING")]
    if lost := results.get("screening", {}).get("lost_particles"):
        warnings.append(f"{lost} particles left elsewhere than through an exit.")
    return warnings + _logged(folder)


def _logged(folder: Path) -> list[str]:
    """Warnings and errors of the log; each once, the first few."""
    log = folder / "run.log"
    if not log.is_file():
        return []
    kinds = (" WARNING ", " ERROR ")
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    messages = [line.split(kind, 1)[1].strip() for line in lines for kind in kinds if kind in line]
    once = list(dict.fromkeys(messages))
    more = [f"and {len(once) - SHOWN} more in run.log"] if len(once) > SHOWN else []
    return once[:SHOWN] + more
