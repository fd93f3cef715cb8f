"""The lines of the designer's sheet of a case: what handbooks would say about the whole machine.

They are rules, not results: none of them is computed from a run, and no run knows of them.
docs/designers-sheet.md has the rules, their sources and what is not among them.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field

import numpy as np

from orchestrator.case.bed.size_distribution import given_classes
from orchestrator.case.deck.openings import open_share
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.bed import SizeClass
from orchestrator.case.tables.case import Case
from orchestrator.preflight.scene.frame_modes import frame_modes
from orchestrator.preflight.scene.frame_motion import frame_motions
from orchestrator.preflight.scene.scene import Scene, deck_m2
from orchestrator.preflight.scene.shaking import free_frames
from orchestrator.preflight.sheet.area import Openings, required_m2
from orchestrator.preflight.sheet.bearings import rating_life_h
from orchestrator.preflight.sheet.feed_shares import FeedShares, shares_at
from orchestrator.preflight.sheet.karra import karra_screen
from orchestrator.preflight.sheet.supports import power_W, support_forces

EFFICIENCY = 0.85
"""Share of the undersize for which the area is sized: some 0.7 to 0.95 is asked of screens."""
PACKED = 0.6  # share of a bed's volume that loosely packed particles fill
DEEPEST = 4.0
"""Openings: a bed that is deeper at the discharge keeps fines from the deck (VSMA)."""
RULE = "rule, not result"
T_PER_H = 3.6  # per kg/s
LINEAR = "linear model of frames, bushings and panels"


@dataclass(frozen=True)
class SheetLine:
    """A line of the sheet: its name, its text and its source, and its numbers by their names with units."""

    name: str
    text: str
    source: str
    values: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Duty:
    """What a deck with equal openings has to do: the whole feed, its size classes and its bulk density."""

    fed_kg_per_s: float
    rows: tuple[SizeClass, ...]
    bulk_kg_per_m3: float
    openings: Openings
    area_m2: float
    width_m: float
    thickness_m: float
    slope_rad: float

    @property
    def shares(self) -> FeedShares:
        """The feed's shares at the smaller side of the openings."""
        return shares_at(self.rows, self.openings.smaller_m)

    def required_m2(self, efficiency: float = EFFICIENCY) -> float | None:
        """Return the area by the factors of VSMA; None for openings beyond their table."""
        return required_m2(self.fed_kg_per_s, self.openings, self.shares, self.bulk_kg_per_m3, efficiency)


def duty_of(case: Case, rates_kg_per_s: Mapping[str, float] | None = None) -> Duty | None:
    """Return the duty of a whole machine's deck; None without a feed or openings, and where these differ.

    ``rates_kg_per_s`` replaces the rates of feeds, by their names.
    """
    panels = [panel for panel in single_panels(case) if panel.apertures is not None]
    patterns = {panel.apertures for panel in panels}
    rates = {
        name: (rates_kg_per_s or {}).get(name, row.rate_kg_per_s) for name, row in case.bed.feeds.items()
    }
    fed_kg_per_s = sum(rates.values())
    if len(patterns) != 1 or fed_kg_per_s <= 0.0:
        return None
    (pattern,) = patterns
    assert pattern is not None, "panels without openings were left out"
    rows, bulk_m3_per_s = [], 0.0
    for name, feed in case.bed.feeds.items():
        share = rates[name] / fed_kg_per_s
        rows += [row.times(share, "mass_fraction") for row in given_classes(feed)]
        bulk_m3_per_s += rates[name] / (PACKED * case.materials[feed.material].density_kg_per_m3)
    areas_m2 = [panel.rectangle.span_m * panel.rectangle.width_m for panel in panels]
    slopes_rad = [math.asin(min(1.0, abs(panel.rectangle.along[2]))) for panel in panels]
    return Duty(
        fed_kg_per_s=fed_kg_per_s,
        rows=tuple(rows),
        bulk_kg_per_m3=fed_kg_per_s / bulk_m3_per_s,
        openings=Openings(pattern.width_m, pattern.length_m, 1.0 - pattern.solid_share),
        area_m2=deck_m2(case),
        width_m=max(panel.rectangle.width_m for panel in panels),
        thickness_m=max(panel.table.thickness_m for panel in panels),
        slope_rad=float(np.average(slopes_rad, weights=areas_m2)),
    )


def sheet(whole: Scene, rates_kg_per_s: Mapping[str, float] | None = None) -> tuple[SheetLine, ...]:
    """Return the lines for the scene of a whole machine; ``rates_kg_per_s`` as of ``duty_of``."""
    duty = duty_of(whole.case, rates_kg_per_s)
    of_duty = [] if duty is None else [*_screening(whole.case, duty), *_bed(duty, whole.transport_m_per_s)]
    return (*of_duty, *_machine(whole))


def too_small_decks(duty: Duty | None) -> Iterator[str]:
    """Yield a warning about a deck that is too small by the factors of VSMA."""
    needed_m2 = duty.required_m2() if duty is not None else None
    if duty is None or needed_m2 is None or needed_m2 <= duty.area_m2:
        return
    yield (
        f"the deck is too small: {T_PER_H * duty.fed_kg_per_s:.4g} t/h need {needed_m2:.3g} m2 for "
        f"{EFFICIENCY:.0%} of the fines by the factors of VSMA, and it has {duty.area_m2:.3g} m2 ({RULE})"
    )


def _screening(case: Case, duty: Duty) -> Iterator[SheetLine]:
    shares, fed_t_per_h = duty.shares, T_PER_H * duty.fed_kg_per_s
    mm = 1e3 * duty.openings.smaller_m
    needed_m2, at_95_m2 = duty.required_m2(), duty.required_m2(0.95)
    if needed_m2 is not None and at_95_m2 is not None:
        yield SheetLine(
            "required area",
            f"{needed_m2:.3g} m2 for {EFFICIENCY:.0%} of the fines ({at_95_m2:.3g} m2 for 95%); there are "
            f"{duty.area_m2:.3g} m2 between the clamps",
            "VSMA factors",
            {"required_m2": needed_m2, "efficiency": EFFICIENCY, "area_m2": duty.area_m2},
        )
    per_m2 = duty.fed_kg_per_s / duty.area_m2
    found = karra_screen(
        per_m2, duty.openings, duty.thickness_m, duty.slope_rad, duty.rows, duty.bulk_kg_per_m3
    )
    if found is not None:
        yield SheetLine(
            "Karra's model",
            f"d50 {1e3 * found.d50_m:.3g} mm, {found.passing:.0%} of what is finer than the openings passes; "
            f"{T_PER_H * found.load_kg_per_m2_s:.3g} t/h of fines per m2, capacity "
            f"{T_PER_H * found.capacity_kg_per_m2_s:.3g}; openings of {mm:.3g} mm let through "
            f"{1e3 * found.throughfall_m:.3g} mm on the slope",
            "Karra 1979",
            {
                "d50_m": found.d50_m,
                "passing": found.passing,
                "load_kg_per_m2_s": found.load_kg_per_m2_s,
                "capacity_kg_per_m2_s": found.capacity_kg_per_m2_s,
                "throughfall_m": found.throughfall_m,
            },
        )
    yield SheetLine(
        "load",
        f"{fed_t_per_h:.4g} t/h, {T_PER_H * per_m2:.3g} t/h per m2, {fed_t_per_h / duty.width_m:.3g} t/h per "
        f"metre of width; bulk density {duty.bulk_kg_per_m3:.3g} kg/m3",
        f"solids fill {PACKED:g} of a bed",
        {"fed_kg_per_s": duty.fed_kg_per_s, "kg_per_m2_s": per_m2, "bulk_kg_per_m3": duty.bulk_kg_per_m3},
    )
    yield SheetLine(
        "feed",
        f"{shares.oversize:.0%} oversize, {shares.near_mesh:.0%} near-mesh (0.75 to 1.25), "
        f"{shares.half_size:.0%} half-size at {mm:.3g} mm",
        "the feed's curve",
        {"oversize": shares.oversize, "near_mesh": shares.near_mesh, "half_size": shares.half_size},
    )
    yield SheetLine(
        "open area",
        f"{duty.openings.open_share:.1%} of the field with openings, {open_share(case):.1%} of the panels",
        "geometry",
        {"of_field": duty.openings.open_share, "of_panels": open_share(case)},
    )


def _bed(duty: Duty, transport_m_per_s: float) -> Iterator[SheetLine]:
    """Yield the line about the bed's depth by the balance of mass."""
    feed_m = bed_depth_m(duty.fed_kg_per_s, duty.width_m, transport_m_per_s, duty.bulk_kg_per_m3)
    discharge_m = feed_m * (1.0 - EFFICIENCY * duty.shares.undersize)
    of_feed, of_discharge = (depth_m / duty.openings.smaller_m for depth_m in (feed_m, discharge_m))
    yield SheetLine(
        "bed depth",
        f"{1e3 * feed_m:.3g} mm = {of_feed:.3g} openings at the feed, {1e3 * discharge_m:.3g} mm = "
        f"{of_discharge:.3g} at the discharge, at {transport_m_per_s:.3g} m/s; at most {DEEPEST:g} there",
        "VSMA, mass balance",
        {"feed_m": feed_m, "discharge_m": discharge_m, "discharge_over_opening": of_discharge},
    )


def bed_depth_m(rate_kg_per_s: float, width_m: float, speed_m_per_s: float, bulk_kg_per_m3: float) -> float:
    """Return the depth of a bed that moves at a speed."""
    return rate_kg_per_s / (width_m * speed_m_per_s * bulk_kg_per_m3)


def _machine(whole: Scene) -> Iterator[SheetLine]:
    for motion in frame_motions(whole):
        values = {"acceleration_g": motion.acceleration_g, "throw_g": motion.throw_g}
        values |= {} if motion.angle_deg is None else {"angle_deg": motion.angle_deg}
        yield SheetLine(f"frame {motion.frame}", motion.numbers_in_words, LINEAR, values)
    modes = [mode for mode in frame_modes(whole) if mode.frequency_Hz > 0]
    for speed_rad_per_s in sorted({shaking.speed_rad_per_s for shaking in whole.shaken}):
        excited_Hz = speed_rad_per_s / (2 * math.pi)
        if modes:
            near = min(modes, key=lambda mode: abs(mode.frequency_Hz - excited_Hz))
            margin = near.frequency_Hz / excited_Hz - 1
            text = f"{margin:+.0%} from {excited_Hz:.3g} Hz to the nearest, {near.in_words}"
            yield SheetLine("margin to modes", text, LINEAR, {"margin": margin})
    yield from _supports(whole)
    yield from _bearings(whole)
    if whole.plan.exciters and free_frames(whole.plan):
        watt = power_W(whole)
        yield SheetLine(
            "power",
            f"{watt / 1e3:.3g} kW lost in the bushings, without bearings, belt, motor, mats and bed",
            LINEAR,
            {"power_W": watt},
        )


def _supports(whole: Scene) -> Iterator[SheetLine]:
    forces = support_forces(whole)
    for name, bushing in whole.case.screen.bushings.items():
        count = len(bushing.positions_m)
        own = [row for row in forces if row.name == name or row.name in _numbered(name, count)]
        if own:
            most = max(own, key=lambda row: row.static_N + row.dynamic_N)
            yield SheetLine(
                f"supports {name}",
                f"each of {len(own)} carries up to {most.static_N / 1e3:.3g} kN static and "
                f"{most.dynamic_N / 1e3:.3g} kN dynamic ({most.name}), without the bed",
                LINEAR,
                {f"{row.name}.static_N": row.static_N for row in own}
                | {f"{row.name}.dynamic_N": row.dynamic_N for row in own},
            )


def _numbered(name: str, count: int) -> set[str]:
    return {f"{name}-{number + 1}" for number in range(count)} if count > 1 else set()


def _bearings(whole: Scene) -> Iterator[SheetLine]:
    for name, exciter in whole.case.screen.exciters.items():
        force_N = exciter.mass_moment_kg_m * exciter.speed_rad_per_s**2
        key = f"screen.exciters.{name}.bearings"
        if (bearings := exciter.bearings) is None:
            text = f"unbalance of {force_N / 1e3:.4g} kN; give {key}.dynamic_rating_N for their life"
            yield SheetLine(f"bearings {name}", text, "ISO 281", {"force_N": force_N})
            continue
        load_N = force_N / bearings.count
        life_h = rating_life_h(bearings.dynamic_rating_N, load_N, exciter.speed_rad_per_s)
        yield SheetLine(
            f"bearings {name}",
            f"L10h {life_h:.3g} h: {bearings.count} roller bearings with C = "
            f"{bearings.dynamic_rating_N / 1e3:.4g} kN under {load_N / 1e3:.4g} kN each",
            "ISO 281 (SKF, NSK)",
            {"L10_h": life_h, "load_N": load_N},
        )
