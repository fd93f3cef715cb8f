"""What was run, in words: rows (name, value) for the page's first table."""

from __future__ import annotations

import math
from collections.abc import Iterator

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.case import Case
from orchestrator.output.report.words import number
from orchestrator.output.results.run_data import RunData, cut_size_m

NO_CYCLE = "none: nothing drives the machine"


def machine_facts(data: RunData) -> Iterator[tuple[str, str]]:
    """The machine and how it is driven."""
    case = data.case
    panels = single_panels(case)
    yield "deck", f"inclined by {case.screen.inclination_deg:g}°, {len(panels)} panels"
    sizes = {
        f"{1e3 * p.table.length_m:g} × {1e3 * p.table.width_m:g} × {1e3 * p.table.thickness_m:g} mm"
        for p in panels
    }
    if panels:
        yield "panels, free length × width × thickness", "; ".join(sorted(sizes))
    for pattern in dict.fromkeys(p.apertures for p in panels if p.apertures is not None):
        yield (
            f"openings ({pattern.shape}), length × width",
            f"{1e3 * pattern.length_m:g} × {1e3 * pattern.width_m:g} mm, every "
            f"{1e3 * pattern.pitch_along_m:g} × {1e3 * pattern.pitch_across_m:g} mm",
        )
    tensions = sorted({1e3 * (p.rectangle.span_m - p.rectangle.length_m) for p in panels})
    if panels:
        yield "tension amount δ", ", ".join(f"{t:.3g} mm" for t in tensions)
    materials = dict.fromkeys(p.table.material for p in panels)
    yield "panel material", ", ".join(materials) or "none"
    frames = ", ".join(
        f"{name} {frame.mass_kg:g} kg" if frame.mass_kg else f"{name} (moved as prescribed)"
        for name, frame in case.screen.frames.items()
    )
    yield "frames", frames or "none"
    for name, exciter in case.screen.exciters.items():
        speed = exciter.speed_rad_per_s
        yield (
            f"exciter {name}",
            f"{speed:g} rad/s = {speed / 2 / math.pi * 60:.0f} rpm, "
            f"{exciter.mass_moment_kg_m:g} kg m on {exciter.frame}",
        )
    yield "machine cycle", f"{1e3 * data.cycle_s:.4g} ms" if data.is_driven else NO_CYCLE


def bed_facts(case: Case) -> Iterator[tuple[str, str]]:
    """The particles."""
    for name, feed in case.bed.feeds.items():
        sizes = ", ".join(
            f"{1e3 * s.smallest_m:g}–{1e3 * s.largest_m:g} mm {100 * s.mass_fraction:.3g} %"
            for s in feed.sizes
        )
        yield f"feed {name}", f"{number(feed.rate_kg_per_s)} kg/s {feed.material}: {sizes}"
    for name, block in case.bed.blocks.items():
        sizes = ", ".join(f"{1e3 * s.smallest_m:g}–{1e3 * s.largest_m:g} mm" for s in block.sizes)
        yield f"bed at t = 0, {name}", f"{block.count} particles of {block.material}, {sizes}"
    if case.bed.particles:
        yield "single particles", str(len(case.bed.particles))
    cut = cut_size_m(case)
    yield "cut size", f"{1e3 * cut:g} mm" if cut else "none"


def solver_facts(case: Case, scheme: str) -> Iterator[tuple[str, str]]:
    """With what and how finely; ``scheme``: the one that the run took."""
    cells = " × ".join(str(n) for n in case.panel.cells)
    yield "panels' solver", f"{case.panel.solver}, {cells} cells each"
    yield "frames' solver", case.frames.solver
    yield "particles' solver", case.particles.solver
    cap = case.particles.largest_youngs_modulus_Pa
    if cap:
        yield "particles softened to", f"{cap:.3g} Pa"
    k = case.particles.coarse_graining
    if k > 1.0:
        yield "coarse graining", f"{k:g} times the diameter, one particle stands for {k**3:.3g}"
    yield "sync interval", f"{1e6 * case.coupling.sync_interval_s:.4g} µs, {scheme}"
