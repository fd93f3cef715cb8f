"""The facts on a page beside the results: the machine, the effects left out, and the warnings."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from orchestrator.case.bed.adhesion import pull_offs
from orchestrator.case.bed.size_distribution import given_classes, median_size_m, sample_of
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.bed import Filling
from orchestrator.figures.results import Results
from orchestrator.output.records import trust
from orchestrator.output.records.summary import closing_lines
from orchestrator.output.report.formatting import number
from orchestrator.output.report.headline import reasons_not_steady
from orchestrator.output.results.run_reader import RunReader
from orchestrator.preflight.scene.effect import describe_verdict
from orchestrator.preflight.scene.scene import scene
from orchestrator.preflight.sheet.sheet import SheetLine, sheet

SHOWN = 12  # messages of the log on the page
UNSETTLED = 0.1  # of a frame's orbit: largest motion along the deck beside the first harmonic
Facts = Iterator[tuple[str, str]]


def machine_facts(run: RunReader) -> Facts:
    """Yield facts about the machine and its drive."""
    screen, panels = run.case.screen, single_panels(run.case)
    yield "deck", f"inclined by {screen.inclination_deg:g}°, {len(panels)} panels"
    if panels:
        sizes = {
            f"{1e3 * p.table.length_m:g} × {1e3 * p.table.width_m:g} × {1e3 * p.table.thickness_m:g} mm"
            for p in panels
        }
        yield "panels, free length × width × thickness", "; ".join(sorted(sizes))
    for pattern in dict.fromkeys(p.apertures for p in panels if p.apertures is not None):
        yield (
            f"openings ({pattern.shape}), length × width",
            f"{1e3 * pattern.length_m:g} × {1e3 * pattern.width_m:g} mm, every "
            f"{1e3 * pattern.pitch_along_m:g} × {1e3 * pattern.pitch_across_m:g} mm",
        )
    if panels:
        tensions = sorted({1e3 * (p.rectangle.span_m - p.rectangle.length_m) for p in panels})
        yield "tension amount δ", ", ".join(f"{t:.3g} mm" for t in tensions)
    for pair in pull_offs(run.case):
        yield "adhesion", pair.in_words
    yield "panel material", ", ".join(dict.fromkeys(p.table.material for p in panels)) or "none"
    frames = [
        f"{name} {frame.mass_kg:g} kg" if frame.mass_kg else f"{name} (moved as prescribed)"
        for name, frame in screen.frames.items()
    ]
    yield "frames", ", ".join(frames) or "none"
    for name, exciter in screen.exciters.items():
        speed = exciter.speed_rad_per_s
        yield (
            f"exciter {name}",
            f"{speed:g} rad/s = {speed / 2 / math.pi * 60:.0f} rpm, "
            f"{exciter.mass_moment_kg_m:g} kg m on {exciter.frame}",
        )
    driven = f"{1e3 * run.cycle_s:.4g} ms" if run.is_driven else "none: nothing drives the machine"
    yield "machine cycle", driven


def sheet_lines(run: RunReader) -> tuple[SheetLine, ...]:
    """Return the designer's sheet of the whole machine with the feed that was run."""
    return sheet(scene(run.case.original))


def describe_sizes(source: Filling) -> str:
    """Return the sizes of a block or feed as the case gives them: its classes, or what its curve covers."""
    if not source.curve:
        return ", ".join(
            f"{1e3 * row.smallest_m:g}–{1e3 * row.largest_m:g} mm {100 * row.mass_fraction:.3g} %"
            for row in source.sizes
        )
    finest_mm, coarsest_mm = (1e3 * source.curve[end].sieve_size_m for end in (0, -1))
    middle_mm = 1e3 * median_size_m(given_classes(source))
    sample = sample_of(source)
    sampled = "" if sample is None else f"; {sample.in_words}"
    return f"curve {finest_mm:g} to {coarsest_mm:g} mm, half of the mass below {middle_mm:.3g} mm{sampled}"


def left_out_facts(summary: Mapping[str, Any]) -> Facts:
    """Yield the reason why each effect was left out, and its verdicts before and after the run."""
    for name, why in summary["left_out"].items():
        yield name, why
        entry = summary.get("effects", {}).get(name, {})
        for when in ("before", "after"):
            if verdict := entry.get(when):
                deciding = f"{verdict['number']} {number(verdict['value'])}, threshold {verdict['threshold']}"
                yield f"{when} the run", f"{describe_verdict(verdict['matters'])}: {deciding}"


def collect_warnings(folder: Path, summary: Mapping[str, Any], results: Results) -> list[str]:
    """Return warnings about doubts, the run's end, unsteady states, missing results, and from the log."""
    warnings = [f"Do not trust this run: {doubt}" for doubt in summary["doubts"]]
    if not trust.came_to_its_end(summary["status"]):
        warnings.append(f"The run was {summary['status']}: {summary['reason']}")
    elif summary["status"] == trust.INCOMPLETE:
        warnings.append(f"The run is incomplete: {summary['reason']}")
    warnings += reasons_not_steady(results)
    for name, orbit in results.motion.frames.items() if results.motion else ():
        if orbit.other_m[0] > UNSETTLED * orbit.major_m > 0:
            warnings.append(f"{name} has not settled to its periodic motion")
    warnings += [f"Results not made: {part}: {error}" for part, error in results.failed.items()]
    if "energy_ledger_J" in summary:
        warnings += [line for line in closing_lines(summary) if line.startswith("WARNING")]
    if results.screening and (lost := results.screening.lost_particles):
        warnings.append(f"{lost} particles left elsewhere than through an exit.")
    return warnings + _log_warnings(folder)


def _log_warnings(folder: Path) -> list[str]:
    """Return the first ``SHOWN`` different warnings and errors of the log."""
    log = folder / "run.log"
    if not log.is_file():
        return []
    lines = log.read_text(encoding="utf-8", errors="replace").splitlines()
    messages = [
        line.split(kind, 1)[1].strip() for line in lines for kind in (" WARNING ", " ERROR ") if kind in line
    ]
    once = list(dict.fromkeys(messages))
    more = [f"and {len(once) - SHOWN} more in run.log"] if len(once) > SHOWN else []
    return once[:SHOWN] + more
