"""The summary of a run, ``summary.json``, and the table and lines on the console at its end.

docs/run-folder.md documents the keys; a test compares it with the summary.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from rich.table import Table

from orchestrator.case.file.whole import write_json
from orchestrator.coupling.ledger import share_created
from orchestrator.coupling.metered import Stopwatch
from orchestrator.output.records.run_folder import SUMMARY

SUMMARY_FORMAT = 3
"""The version of the table's format (docs/run-folder.md, "summary.json"); the oldest files have none."""
PARTS = ("particles", "panel", "frames", "mapping", "coupling", "output", "checkpoints", "monitor")


def write_summary(folder: Path, table: dict[str, Any]) -> None:
    """Write ``summary.json`` into the folder of a run, whole or not at all."""
    write_json(folder / SUMMARY, {"format_version": SUMMARY_FORMAT, **table})


def wall_by_part_s(stopwatch: Stopwatch, wall_s: float) -> dict[str, float]:
    """Return the wall time of every part; ``rest`` completes them to the whole wall time.

    Runs of a solver that repeat an interval count as ``coupling``, since the scheme asks for them.
    """
    repeated_s = stopwatch.repeated_s
    table = {part: stopwatch.wall_s.get(part, 0.0) - repeated_s.get(part, 0.0) for part in PARTS}
    table["coupling"] += sum(repeated_s.values())
    return table | {"rest": wall_s - sum(table.values())}


def worked_by_part_s(summary: Mapping[str, Any]) -> dict[str, float]:
    """Return the wall time of a run by the part that worked: repeats are in the parts of their solvers."""
    repeated_s = summary.get("repeated_by_part_s", {})  # absent from older runs
    back_s = {**repeated_s, "coupling": -sum(repeated_s.values())}
    return {part: wall_s + back_s.get(part, 0.0) for part, wall_s in summary["wall_by_part_s"].items()}


def processor_by_part_s(summary: Mapping[str, Any]) -> dict[str, float]:
    """Return the processor time of a run in s by part of the program.

    The part "start" is the time before the wall time is measured.  The rest is divided in the proportions of
    the wall time; what a scheme lets solvers repeat counts as theirs.
    """
    before_s = summary["processor_before_s"]
    rate = (summary["processor_s"] - before_s) / summary["wall_s"]
    return {"start": before_s} | {part: rate * time_s for part, time_s in worked_by_part_s(summary).items()}


def closing_table(summary: Mapping[str, Any]) -> Table:
    """Return a table of the wall time of every part, for the console."""
    table = Table(title="where the time went", title_justify="left")
    table.add_column("part")
    table.add_column("wall / s", justify="right")
    table.add_column("share", justify="right")
    for part, wall_s in summary["wall_by_part_s"].items():
        table.add_row(part, f"{wall_s:.2f}", f"{100 * wall_s / summary['wall_s']:.0f} %")
    table.add_row("all", f"{summary['wall_s']:.2f}", "100 %")
    return table


def closing_lines(summary: Mapping[str, Any]) -> list[str]:
    """Return lines about the numerical quality of a run; ``trust.py`` decides whether it is doubtful."""
    created_J = sum(J for name, J in summary["energy_ledger_J"].items() if name.startswith("created."))
    lines = [f"simulated {summary['simulated_s']:g} s in {summary['sync_intervals']} sync intervals"]
    if summary["particles"]:
        rate = f"{summary['particle_steps_per_s']:.3g} particle-steps per second"
        lines.append(f"{summary['particles']} particles, {rate}")
    lines += [
        f"momentum residual {summary['momentum_residual_relative']:.1e} (relative, worst member)",
        f"energy created by the coupling {created_J:+.3g} J "
        f"({share_created(summary):+.1e} of the energy exchanged and lost, at the worst interface)",
    ]
    if inaccurate := summary.get("stability", {}).get("inaccurate"):
        lines.append(f"the sync interval limits the accuracy: {inaccurate}")
    if iterations := summary.get("iterations"):
        lines += iteration_lines(iterations)
    if material := summary.get("material"):
        lines += material_lines(material, slice_in_words(summary))
    if monitor := summary.get("monitor"):
        lines += monitor_lines(monitor)
    return lines


def slice_in_words(summary: Mapping[str, Any]) -> str:
    """Return the slice that was run, such as "in the slice of 126 mm"; empty for the whole width.

    Results of less than a cycle lack the width; its share of the machine's stands for it.
    """
    if summary["share_of_width"] == 1.0:
        return ""
    width_m = (summary.get("results") or {}).get("slice_width_m")
    if width_m is None:
        return f"in the slice of {100 * summary['share_of_width']:.3g} % of the width"
    return f"in the slice of {1e3 * width_m:.4g} mm"


def iteration_lines(iterations: dict[str, Any]) -> list[str]:
    """Return lines about how often intervals were repeated, with a warning if that was not enough."""
    lines = [f"intervals run {iterations['mean']:.2f} times on average, {iterations['most']} at most"]
    if iterations["unsolved"]:
        lines.append(
            f"WARNING: {iterations['unsolved']} sync intervals were not solved to "
            f"coupling.tolerance; their load was off by up to {iterations['worst']:.2g} of its size"
        )
    return lines


def material_lines(material: dict[str, Any], where: str = "") -> Iterator[str]:
    """Yield lines about the whereabouts of the particles and the depth of contacts.

    ``where`` names the slice to which the masses belong; it is empty for the whole width.  A warning names
    particles that were lost, came out with the undersize although they fit through no opening, or went
    through the surface.
    """

    def part(what: str, amount: dict[str, Any]) -> str:
        return f"{what} {amount['mass_kg']:.4g} kg ({amount['number']})"

    exits = [part(f"through {name}", amount) for name, amount in material["exits"].items()]
    there = [part("on deck", material["on_deck"]), *exits, part("lost", material["lost"])]
    whose = f"particles {where}".rstrip()
    yield f"{part(f'{whose}: came', material['fed'])} = " + " + ".join(there)
    if material["lost"]["number"]:
        lost = 100 * material["lost"]["mass_kg"] / material["fed"]["mass_kg"]
        none = "" if material["exits"] else ", of which the case has none"
        yield (
            f"WARNING: {_particles(material['lost']['number'])} left the domain elsewhere than "
            f"through an exit{none}: {lost:.3g} % of the mass that came; history.h5 says where "
            "(removed, exit = -1)"
        )
    if material["escaped"]["number"]:
        yield (
            f"WARNING: {_particles(material['escaped']['number'])} too large for any opening came out with "
            "the undersize; run.log names the first"
        )
    deepest, crossings = material["deepest_overlaps"], material["crossings"]
    yield (
        "deepest overlap since the start, over the radius: "
        f"{2 * deepest['surface_per_diameter']:.2g} with the surface, "
        f"{2 * deepest['between_per_diameter']:.2g} between particles"
    )
    if crossings["number"]:
        yield (
            f"WARNING: {crossings['number']} times a particle went through the surface elsewhere "
            f"than through an opening, the first one (number {crossings['first_id']}) at t = "
            f"{crossings['first_time_s']:.6g} s"
        )


def _particles(number: int) -> str:
    return "1 particle" if number == 1 else f"{number} particles"


def monitor_lines(monitor: dict[str, Any]) -> list[str]:
    """Return a warning if the monitor had to shorten sync intervals."""
    if not monitor["shortened_intervals"]:
        return []
    return [
        f"WARNING: the monitor ran {monitor['shortened_intervals']} sync intervals "
        f"({100 * monitor['shortened_share']:.2g} %) in parts, down to "
        f"{monitor['shortest_interval_s']:g} s; run.log says when and why"
    ]
