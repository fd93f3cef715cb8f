"""What a page says beside the results: what was run, what it left out, and whether it can be trusted."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.case import Case
from orchestrator.coupling.ledger import share_created
from orchestrator.output.records import trust
from orchestrator.output.records.summary import closing_lines
from orchestrator.output.report.formatting import number
from orchestrator.output.results.run_reader import RunReader, cut_size_m
from orchestrator.preflight.scene.effect import describe_verdict

SHOWN = 12  # messages of the log
UNSETTLED = 0.1  # of a frame's orbit: so much of the motion along the deck is no first harmonic
Facts = Iterator[tuple[str, str]]


def machine_facts(run: RunReader) -> Facts:
    """Yields facts on the machine and how it is driven."""
    screen, panels = run.case.screen, single_panels(run.case)
    yield "deck", f"inclined by {screen.inclination_deg:g}°, {len(panels)} panels"
    if panels:
        tables = [panel.table for panel in panels]
        sizes = {
            f"{1e3 * table.length_m:g} × {1e3 * table.width_m:g} × {1e3 * table.thickness_m:g} mm"
            for table in tables
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


def bed_facts(case: Case) -> Facts:
    """Yields facts on the particles."""
    for name, feed in case.bed.feeds.items():
        sizes = ", ".join(f"{_range_mm(s)} {100 * s.mass_fraction:.3g} %" for s in feed.sizes)
        yield f"feed {name}", f"{number(feed.rate_kg_per_s)} kg/s {feed.material}: {sizes}"
    for name, block in case.bed.blocks.items():
        sizes = ", ".join(map(_range_mm, block.sizes))
        yield f"bed at t = 0, {name}", f"{block.count} particles of {block.material}, {sizes}"
    if case.bed.particles:
        yield "single particles", str(len(case.bed.particles))
    cut = cut_size_m(case)
    yield "cut size", f"{1e3 * cut:g} mm" if cut else "none"


def _range_mm(size: Any) -> str:
    return f"{1e3 * size.smallest_m:g}–{1e3 * size.largest_m:g} mm"


def solver_facts(case: Case, scheme: str) -> Facts:
    """Yields with what and how finely the run was computed; ``scheme`` is the one that it took."""
    cells = " × ".join(str(n) for n in case.panel.cells)
    yield "panels' solver", f"{case.panel.solver}, {cells} cells each"
    yield "frames' solver", case.frames.solver
    yield "particles' solver", case.particles.solver
    if cap := case.particles.largest_youngs_modulus_Pa:
        yield "particles softened to", f"{cap:.3g} Pa"
    if (k := case.particles.coarse_graining) > 1.0:
        yield "coarse graining", f"{k:g} times the diameter, one particle stands for {k**3:.3g}"
    yield "sync interval", f"{1e6 * case.coupling.sync_interval_s:.4g} µs, {scheme}"


def left_out_facts(summary: dict[str, Any]) -> Facts:
    """Yields why each effect was left out, and what was judged of it before and after the run."""
    for name, why in summary["left_out"].items():
        yield name, why
        entry = summary.get("effects", {}).get(name, {})
        for when in ("before", "after"):
            if verdict := entry.get(when):
                deciding = f"{verdict['number']} {number(verdict['value'])}, threshold {verdict['threshold']}"
                yield f"{when} the run", f"{describe_verdict(verdict['matters'])}: {deciding}"


def quality_facts(summary: dict[str, Any]) -> Facts:
    """Yields facts on momentum, energy, speed and what the monitor saw; fewer for a run that failed."""
    if "momentum_residual_relative" in summary:
        residual = f"{summary['momentum_residual_relative']:.1e}"
        yield "momentum residual, worst member (1e-12 is rounding)", residual
    if "energy_ledger_J" in summary:
        ledger = summary["energy_ledger_J"]
        for interface in ("particles-panel", "panel-frames"):
            if f"created.{interface}" in ledger:
                created_J = number(ledger[f"created.{interface}"])
                yield f"energy created between {interface.replace('-', ' and ')}", f"{created_J} J"
        for interface, exchanged_J in summary.get("energy_exchanged_J", {}).items():
            yield (f"energy exchanged between {interface.replace('-', ' and ')}", f"{number(exchanged_J)} J")
        share = f"{100 * share_created(summary):.2g} %"
        yield "energy created, of what was exchanged and lost, worse of the two", share
    yield "sync intervals", f"{summary['sync_intervals']}"
    if monitor := summary.get("monitor"):
        if monitor["shortened_intervals"]:
            shortened = f"{monitor['shortened_intervals']}, down to {monitor['shortest_interval_s']:g} s"
            yield "of them run in parts", shortened
        for name, item in monitor["figures"].items():
            worst = f"{number(item['worst'])} (limit {item['limit']:g})"
            times = f", beyond it {item['times']} times" if item["times"] else ""
            yield f"monitor: {name.replace('_', ' ')}, worst", worst + times
    if summary["particle_steps_per_s"]:
        yield "particle steps per second", f"{summary['particle_steps_per_s']:.2e}"


def collect_warnings(folder: Path, summary: dict[str, Any], results: dict[str, Any]) -> list[str]:
    """Says how the run ended, what is not steady, what is missing, and what the log warned of."""
    warnings = [f"Do not trust this run: {doubt}" for doubt in summary["doubts"]]
    if not trust.came_to_its_end(summary["status"]):
        warnings.append(f"The run was {summary['status']}: {summary['reason']}")
    elif summary["status"] == trust.INCOMPLETE:
        warnings.append(f"The run is incomplete: {summary['reason']}")
    state, motion = results.get("steady"), results.get("motion")
    if state and not state["is_steady"]:
        warnings.append(f"No steady state: {state['reason']}. Bed and screening figures are transient.")
    if motion:
        if motion["cycles"] and not motion["is_settled"]:
            warnings.append(f"The machine has not settled: {motion['reason']}.")
        for name, orbit in motion["frames"].items():
            if orbit["other_m"][0] > UNSETTLED * orbit["major_m"] > 0:
                warnings.append(f"{name} has not settled to its periodic motion")
    warnings += [f"Results not made: {part}: {error}" for part, error in results["failed"].items()]
    if "energy_ledger_J" in summary:
        warnings += [line for line in closing_lines(summary) if line.startswith("WARNING")]
    if lost := results.get("screening", {}).get("lost_particles"):
        warnings.append(f"{lost} particles left elsewhere than through an exit.")
    return warnings + _logged(folder)


def _logged(folder: Path) -> list[str]:
    """Returns the first few warnings and errors of the log, each once."""
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
