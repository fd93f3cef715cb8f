"""The limits of what a proposed machine can do: wishes beyond them are refused, all in one message."""

from __future__ import annotations

import math
from collections.abc import Iterator

from orchestrator.case.deck.panels import TRANSPORT_M_PER_S
from orchestrator.case.file.errors import CaseProblem
from orchestrator.cli.proposal import machine, two_mass
from orchestrator.cli.proposal.deck_size import too_small_deck
from orchestrator.cli.proposal.layout import AROUND_M, Layout, openings_of, panel_length_m
from orchestrator.cli.proposal.wishes import Wishes, down, problem, up
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.preflight.sheet.sheet import PACKED

LARGEST_STRAIN = 0.06  # of a panel at full stroke
LARGEST_SHAKE_G = 15.0  # of the driven frame
DEEPEST_BED_M = 0.25  # at the speed of a thick bed
SHORTEST_PANEL_M = 0.1
FEWEST_OPENINGS = 3  # in a row along and across a panel


def find_impossible(wishes: Wishes) -> Iterator[CaseProblem]:
    """Yield each reason why no machine can fulfil the wishes."""
    panel_m = panel_length_m(wishes)
    if panel_m < SHORTEST_PANEL_M - 1e-9:
        need_m = up(wishes.panels * (SHORTEST_PANEL_M + AROUND_M))
        panels = "1 panel" if wishes.panels == 1 else f"{wishes.panels} panels"
        their = "its clamps do" if wishes.panels == 1 else "their clamps do"
        what = f"{panels} and {their} not fit in {wishes.length_m:g} m"
        fewer = ", or fewer --panels" if wishes.panels > 1 else ""
        yield problem("length", what, f"give at least {need_m:g} m{fewer}")
    else:
        yield from _openings(wishes, panel_m)
        if wishes.has_material:
            yield from too_small_deck(wishes)
        strain = wishes.stroke_m / panel_m
        if strain > LARGEST_STRAIN:
            what = f"stretches panels of {1e3 * panel_m:.3g} mm by {strain:.1%}"
            largest_mm = down(1e3 * LARGEST_STRAIN * panel_m)
            yield problem("stroke", what, f"give at most {largest_mm:g} mm, or longer panels (--length)")
    yield from _shaking(wishes)
    if wishes.has_material:
        yield from _separation(wishes)
        largest_kg_per_s = (
            PACKED * wishes.density_kg_per_m3 * wishes.width_m * TRANSPORT_M_PER_S * DEEPEST_BED_M
        )
        if wishes.throughput_kg_per_s > largest_kg_per_s:
            depth_m = wishes.throughput_kg_per_s / largest_kg_per_s * DEEPEST_BED_M
            what = (
                f"at {3.6 * wishes.throughput_kg_per_s:.4g} t/h the bed is {depth_m:.2g} m deep on a deck "
                f"{wishes.width_m:g} m wide"
            )
            hint = f"give at most {down(3.6 * largest_kg_per_s):g} t/h, or a larger --width"
            yield problem("throughput", what, hint)


def _separation(wishes: Wishes) -> Iterator[CaseProblem]:
    """Yield a problem for a cut that no grain is above or below, and for one above the openings."""
    finest_m, largest_m = wishes.feed_m[0][0], wishes.feed_m[-1][0]
    cut_mm = 1e3 * wishes.separation_m
    where = "cut" if wishes.cut_m else "feed"
    if not finest_m < wishes.separation_m < largest_m:
        side = "above the coarsest" if wishes.separation_m >= largest_m else "below the finest"
        sizes = f"{1e3 * finest_m:.3g} to {1e3 * largest_m:.4g} mm"
        what = f"the cut of {cut_mm:.4g} mm is {side} grain, of sizes {sizes}"
        yield problem(where, what, "take another --cut, --opening or --feed")
    elif wishes.separation_m > wishes.smaller_m * (1 + 1e-9):
        what = f"no grain between {1e3 * wishes.smaller_m:.4g} and {cut_mm:.4g} mm passes the openings"
        yield problem(where, what, "take a smaller --cut or a larger --opening")


def _openings(wishes: Wishes, panel_m: float) -> Iterator[CaseProblem]:
    """Yield a problem for each direction in which a panel of this free length has too few openings."""
    row = openings_of(wishes)
    along = "opening-length" if "opening-length" in wishes.answers else "opening"
    directions = (
        ("opening", "across", wishes.width_m - 2 * row.margin_across_m, row.width_m, row.pitch_across_m),
        (along, "along", panel_m - 2 * row.margin_along_m, row.length_m, row.pitch_along_m),
    )
    for option, where, room_m, size_m, pitch_m in directions:
        fitting = int(room_m / pitch_m + 1e-6)
        if fitting < FEWEST_OPENINGS:
            found = ("no opening fits", "only 1 opening fits", "only 2 openings fit")[max(0, fitting)]
            room = f"{where} a panel, in the {1e3 * max(0.0, room_m):.4g} mm between its margins"
            what = f"{1e3 * size_m:.4g} mm: {found} {room}"
            yield problem(option, what, f"at least {FEWEST_OPENINGS} in a row are needed")


def _shaking(wishes: Wishes) -> Iterator[CaseProblem]:
    """Yield a problem for a stroke at which the driven frame would break; a crank gives it half of that."""
    if wishes.template == "test-rig":
        return
    share = two_mass.amplitudes_m(1.0, machine.RATIO)[1] if wishes.is_free else 0.5
    largest_m = LARGEST_SHAKE_G * STANDARD_GRAVITY_M_PER_S2 / wishes.speed_rad_per_s**2 / share
    if wishes.stroke_m > largest_m:
        shake_g = LARGEST_SHAKE_G * wishes.stroke_m / largest_m
        what = f"{1e3 * wishes.stroke_m:.3g} mm at this speed accelerates the driven frame to {shake_g:.2g} g"
        yield problem("stroke", what, f"give at most {down(1e3 * largest_m):g} mm, or a lower --speed")


def too_stiff_panels(layout: Layout, panels_N_per_m: float) -> Iterator[CaseProblem]:
    """Yield a problem if the panels alone are so stiff that no usual driven frame comes near resonance."""
    wishes = layout.wishes
    usual_kg = machine.usual_driven_kg(layout)
    needed_kg = machine.least_driven_kg(layout, panels_N_per_m)
    if needed_kg > machine.HEAVIEST * usual_kg:
        factor = math.sqrt(needed_kg / (machine.HEAVIEST * usual_kg))
        rpm = up(30 / math.pi * wishes.speed_rad_per_s * factor)
        what = (
            f"the panels alone hold the frames with {panels_N_per_m / 1e6:.2g} MN/m: at this speed only a "
            f"driven frame of {up(needed_kg):g} kg (usual: {up(usual_kg):g} kg) would reach the stroke"
        )
        yield problem("speed", what, f"take {rpm:g} rpm or more, or fewer and longer panels")
