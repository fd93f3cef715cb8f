"""The page's tables: results, what was run, and what it left out."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.case import Case
from orchestrator.output.report.formatting import interval, number, whole_number
from orchestrator.output.results.run_reader import RunReader, cut_size_m
from orchestrator.preflight.scene.effect import describe_verdict

MM_IN_1000_H = 1e6  # 1 m/h
WEAR_NOTE = (
    "As deep as this after 1000 hours if they all went on like the averaged part of the run; "
    "the specific wear that the case gives is nearly all of its uncertainty."
)


@dataclass(frozen=True)
class Sheet:
    """A table as text; ``note`` says what a reader must know to use it."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    note: str = ""


def _sheet(title: str, rows: list[dict[str, str]], note: str = "") -> Sheet:
    """A sheet from its rows, by column."""
    return Sheet(title, tuple(rows[0]), tuple(tuple(row.values()) for row in rows), note)


def screening_sheet(screening: dict[str, Any], whole: float) -> Sheet:
    """Returns flows and placements of the whole deck; masses are multiplied by ``whole``, the full width
    over that of the slice."""
    kinds = {
        "feed": ("feed_kg_per_s", "kg/s"),
        "undersize": ("undersize_kg_per_s", "kg/s"),
        "oversize": ("oversize_kg_per_s", "kg/s"),
        "hold-up in the machine": ("hold_up_kg", "kg"),
        "screening efficiency η": ("efficiency_percent", "%"),
        "fine placement (undersize recovery)": ("fine_placement_percent", "%"),
        "fines recovered, of what came in": ("recovered_percent", "%"),
        "coarse placement": ("coarse_placement_percent", "%"),
        "oversize yield": ("oversize_yield_percent", "%"),
        "fines left in the oversize": ("fines_in_oversize_percent", "%"),
        "misplaced material": ("misplaced_percent", "%"),
    }
    rows = [
        (name, interval(screening[key], whole if unit.startswith("kg") else 1.0), unit)
        for name, (key, unit) in kinds.items()
        if key in screening
    ]
    partition = screening["partition"]
    if partition:
        rows.append(("cut size reached, d50", interval(partition["d50_m"], 1e3), "mm"))
        rows.append(("probable error Ep", interval(partition["ep_m"], 1e3), "mm"))
    rows.append(("particles lost", str(screening["lost_particles"]), "particles"))
    return Sheet("Screening", ("figure", "value", "unit"), tuple(rows))


def sections_sheet(screening: dict[str, Any]) -> Sheet:
    """Returns a row for each section."""
    columns = {
        "exit": "exit",
        "yield_percent": "yield / %",
        "cumulative_efficiency_percent": "efficiency up to here / %",
        "local_efficiency_percent": "local efficiency / %",
    }
    rows = [
        {columns[key]: value if key == "exit" else interval(value) for key, value in row.items()}
        for row in screening["sections"]
    ]
    return _sheet("Sections", rows)


def bed_sheet(results: dict[str, Any], whole: float) -> Sheet:
    """Returns transport and the bed as a whole; mass and numbers are multiplied by ``whole``."""
    bed, held, transport = (results.get(name, {}) for name in ("bed", "held", "transport"))
    blinded = interval(held["blinded_openings"], whole)
    rows = [
        ("mass on the deck", interval(bed["on_deck_kg"], whole), "kg"),
        ("velocity, mass weighted", interval(bed["velocity_m_per_s"]), "m/s"),
    ]
    if transport:
        rows += [
            ("residence time of the oversize", interval(transport["residence_s"]), "s"),
            ("velocity from it", interval(transport.get("residence_velocity_m_per_s")), "m/s"),
        ]
    rows += [
        ("largest bed depth", interval(bed["largest_depth_m"], 1e3), "mm"),
        ("stickers", interval(held["stickers"], whole), "particles"),
        (f"blinded, of {number(held['openings'], whole)} openings", blinded, "openings"),
    ]
    return Sheet("Bed", ("figure", "value", "unit"), tuple(rows))


def frames_sheet(motion: dict[str, Any]) -> Sheet:
    """Returns the orbits of points on frames, and of the frames against each other."""
    orbits = motion["frames"] | {f"{name}, relative": orbit for name, orbit in motion["relative"].items()}
    note = "First harmonic at the machine's speed, in deck axes; phases of cos(ωt + φ)."
    return _sheet("Frames: orbits", [{"point": name} | _orbit(orbit) for name, orbit in orbits.items()], note)


def _orbit(orbit: dict[str, Any]) -> dict[str, str]:
    widths = orbit["half_width_m"] or [None, None, None]
    along, _, normal = (
        interval({"value": size_m, "half_width": width_m}, 1e3)
        for size_m, width_m in zip(orbit["amplitude_m"], widths, strict=True)
    )
    return {
        "along / mm": along,
        "normal / mm": normal,
        "phase along / °": whole_number(57.29578 * orbit["phase_rad"][0]),
        "phase normal / °": whole_number(57.29578 * orbit["phase_rad"][2]),
        "half axes / mm": f"{number(orbit['major_m'], 1e3)} × {number(abs(orbit['minor_m']), 1e3)}",
        "tilt / °": whole_number(orbit["tilt_deg"]),
        "other than first harmonic, along / mm": number(orbit["other_m"][0], 1e3),
    }


def accelerations_sheet(motion: dict[str, Any]) -> Sheet:
    """Returns the accelerations of points on panels."""
    rows = [
        {
            "point": name,
            "panel": point["panel"],
            "place along, across": f"{point['at'][0]:.2g}, {point['at'][1]:.2g}",
            "peak / g": number(point["peak_g"]),
            "peak of a cycle, mean / g": interval(point["cycle_peak_g"]),
            "RMS / g": interval(point["rms_g"]),
            "peak, normal / g": number(point["peak_normal_g"]),
            "RMS, normal / g": number(point["rms_normal_g"]),
        }
        for name, point in motion["panel_points"].items()
    ]
    note = "Band-limited to 500 Hz; “normal” is the part normal to the panel as built."
    return _sheet("Panels: acceleration", rows, note)


def panels_sheet(motion: dict[str, Any], whole: float) -> Sheet:
    """Returns pull, stretch and load of the panels; forces are multiplied by ``whole``."""
    rows = [
        {
            "panel": name,
            "pull, least / N": number(panel["tension_smallest_N"], whole),
            "pull, mean / N": number(panel["tension_mean_N"], whole),
            "pull, most / N": number(panel["tension_largest_N"], whole),
            "force on a clamp, most / N": number(panel["largest_clamp_force_N"], whole),
            "stretch, least / %": number(panel["stretch_smallest_percent"]),
            "stretch, most / %": number(panel["stretch_largest_percent"]),
            "mean load of the bed / N": number(-panel["load_N"][2], whole),
        }
        for name, panel in motion["panels"].items()
    ]
    return _sheet("Panels: pull, stretch and load", rows)


def wear_sheet(wear: dict[str, Any]) -> Sheet:
    """Returns the wear of every panel."""
    rows = [
        {
            "panel": name,
            "mean / (mm in 1000 h)": interval(panel["mean_m_per_h"], MM_IN_1000_H),
            "deepest patch / (mm in 1000 h)": number(panel["largest_m_per_h"], MM_IN_1000_H),
            "there: share of length, of width": ", ".join(number(x, digits=2) for x in panel["largest_at"]),
            "worn through after / h": number(panel["worn_through_h"]),
        }
        for name, panel in wear["panels"].items()
    ]
    return _sheet("Wear", rows, WEAR_NOTE)


def machine_facts(data: RunReader) -> Iterator[tuple[str, str]]:
    """Yields facts on the machine and how it is driven."""
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
    yield (
        "machine cycle",
        f"{1e3 * data.cycle_s:.4g} ms" if data.is_driven else "none: nothing drives the machine",
    )


def bed_facts(case: Case) -> Iterator[tuple[str, str]]:
    """Yields facts on the particles."""
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
    """Yields with what and how finely the run was computed; ``scheme`` is the one that it took."""
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


def left_out_rows(summary: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Yields rows (name, words): why, and what was judged before and after the run."""
    for name, why in summary["left_out"].items():
        yield name, why
        entry = summary.get("effects", {}).get(name, {})
        for when in ("before", "after"):
            if verdict := entry.get(when):
                yield f"{when} the run", _verdict(verdict)


def _verdict(verdict: dict[str, Any]) -> str:
    deciding = f"{verdict['number']} {number(verdict['value'])}, threshold {verdict['threshold']}"
    return f"{describe_verdict(verdict['matters'])}: {deciding}"
