"""The sentences that say what is proposed, how far it is from resonance, and what a designer should doubt."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from orchestrator.case.deck.panels import TRANSPORT_M_PER_S, axes
from orchestrator.case.materials.library import shapes
from orchestrator.case.materials.typical_feed import finer_share
from orchestrator.cli.proposal.deck_size import deck_m2_of, needed_m2_of
from orchestrator.cli.proposal.layout import Layout
from orchestrator.cli.proposal.levels import DRAFT_S
from orchestrator.cli.proposal.machine import round_to
from orchestrator.cli.proposal.mounting import LEAST_G, MOST_G, Choice
from orchestrator.cli.proposal.proposal import Proposal, panels_N_per_m
from orchestrator.cli.proposal.wishes import Wishes
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.preflight.cost import in_words
from orchestrator.preflight.scene.frame_modes import NEAR, frame_modes
from orchestrator.preflight.sheet.sheet import DEEPEST, EFFICIENCY, PACKED, RULE, bed_depth_m

USUAL_STRAINS, USUAL_SHAKE_G = (0.005, 0.03), 6.0
USUAL_SLOPES_DEG = (5.0, 35.0)
LONGEST_PANEL_M = 0.8


def remarks(proposal: Proposal, warnings: Sequence[str]) -> list[str]:
    """Return sentences about a proposal, the doubtful ones last.

    Each of the ``warnings``, which are those of ``flipflow check``, is a doubtful one.
    """
    sentences = [*_remarks(proposal), *(f"doubtful: {warning}" for warning in warnings)]
    return sorted(sentences, key=lambda sentence: sentence.startswith("doubtful"))


def _remarks(proposal: Proposal) -> Iterator[str]:
    """Yield sentences about a proposal, part by part."""
    wishes, layout = proposal.wishes, proposal.layout
    panels = "panels" if wishes.panels > 1 else "one panel"
    yield (
        f"deck: {layout.length_m:.3g} m long, {panels} of {1e3 * layout.free_m:.4g} mm free length, "
        f"openings of {1e3 * wishes.opening_m:.4g} x {1e3 * wishes.opening_length_m:.4g} mm"
    )
    if (needed_m2 := needed_m2_of(wishes)) is not None:
        yield (
            f"area: {deck_m2_of(wishes):.3g} m2 between the clamps; the factors of VSMA require "
            f"{needed_m2:.3g} m2 for {EFFICIENCY:.0%} of the fines ({RULE})"
        )
    if layout.slopes_deg:
        parts = zip(layout.slopes_deg, layout.panels_per_slope, strict=True)
        yield "slopes: " + ", ".join(f"{slope_deg:g} degrees on {count} panels" for slope_deg, count in parts)
    yield (
        f"stroke: {1e3 * wishes.stroke_m:.3g} mm (half of the whole travel), which stretches the panels by "
        f"{layout.stretch:.1%}"
    )
    if proposal.mounting is not None:
        yield from _mats(proposal.mounting)
    if proposal.machine is not None:
        yield from _machine(proposal)
    if wishes.has_material:
        yield from _material(proposal)
    yield from _doubts_about_the_deck(wishes, layout)


def _mats(chosen: Choice) -> Iterator[str]:
    """Yield sentences about the mats' mounting and how they flip."""
    mounting = chosen.mounting
    ways = "; the next one ".join(regime.in_words for regime in chosen.regimes)
    yield (
        f"mats: {1e3 * mounting.thickness_m:.3g} mm thick, clamps that point down by "
        f"{mounting.clamp_angle_deg:g} degrees, {1e3 * mounting.slack_m:.3g} mm of slack; an empty mat "
        f"{ways}"
    )
    if not chosen.has_room:
        yield (
            "doubtful: the mats arch up in some turns if the stroke is 10 % or the speed 5 % off, the "
            "mats are softer, or their loss factor differs"
        )
    peaks_g = [regime.mean_peak_g for regime in chosen.regimes]
    if min(peaks_g) < 0.8 * LEAST_G or max(peaks_g) > 1.2 * MOST_G:
        usual = f"{LEAST_G:g} to {MOST_G:g} g are usual"
        flip = " and ".join(f"{peak_g:.3g}" for peak_g in peaks_g)
        yield f"doubtful: the mats flip with {flip} g, and {usual}; try another --stroke"


def _doubts_about_the_deck(wishes: Wishes, layout: Layout) -> Iterator[str]:
    """Yield doubts about the panels' stretch and length and about the slopes."""
    least, most = USUAL_STRAINS
    if layout.stretch > most:
        yield f"doubtful: panels are seldom stretched by more than {most:.0%}; take longer ones (--length)"
    if wishes.stroke_m < least * layout.panel_m:
        yield f"doubtful: panels stretched by less than {least:.1%} hardly throw; take a larger --stroke"
    if wishes.length_m is not None and layout.panel_m > LONGEST_PANEL_M:
        yield f"doubtful: panels are seldom longer than {1e3 * LONGEST_PANEL_M:g} mm; take more --panels"
    if wishes.template == "test-rig":
        return
    flattest_deg, steepest_deg = USUAL_SLOPES_DEG
    if not all(flattest_deg <= slope_deg <= steepest_deg for slope_deg in wishes.slopes_deg):
        usual = f"{flattest_deg:g} to {steepest_deg:g} degrees are usual"
        yield f"doubtful: {usual}; on a flatter deck little moves along, on a steeper one little passes"
    if any(lower > upper for upper, lower in pairwise(wishes.slopes_deg)):
        yield "doubtful: the deck becomes steeper towards its lower end; slopes usually fall"


def _machine(proposal: Proposal) -> Iterator[str]:
    """Yield sentences about masses, springs and distances from resonance."""
    machine = proposal.machine
    assert machine is not None, "only free frames have a machine"
    (shaking,) = proposal.scene.shaken
    along, _, normal = axes(proposal.scene.case).T
    sizes_m = {
        name: [abs(shaking.amplitude_m[name] @ axis) for axis in (along, normal)]
        for name in ("driving", "driven")
    }
    amplitudes_m = {name: along_m for name, (along_m, _) in sizes_m.items()}
    moved = ", ".join(
        f"{name} {1e3 * along_m:.2g} and {1e3 * normal_m:.2g} mm"
        for name, (along_m, normal_m) in sizes_m.items()
    )
    yield (
        f"frames: {machine.driving.mass_kg:g} kg (driving) and {machine.driven.mass_kg:g} kg (driven), "
        f"unbalance {machine.mass_moment_kg_m:g} kg m; amplitudes along the deck and normal to it: {moved}"
    )
    if machine.is_heavy:
        yield (
            f"doubtful: frames heavier than usual, {machine.driven.mass_kg:g} instead of "
            f"{round_to(machine.usual_driven_kg, 3):g} kg (driven): the panels are so stiff for this speed "
            "that lighter frames would need no bushings; take longer or thinner panels, or a higher --speed"
        )
    held_N_per_m = panels_N_per_m(proposal.scene)
    total_N_per_m = machine.shear.total_N_per_m[0] + held_N_per_m
    yield (
        f"springs: {len(machine.shear.positions_m)} shear bushings of "
        f"{round_to(machine.shear.stiffness_N_per_m[0] / 1e3, 3):g} kN/m along the deck; the panels add "
        f"{held_N_per_m / total_N_per_m:.0%} of the total stiffness"
    )
    yield from resonances(proposal)
    shake_g = amplitudes_m["driven"] * shaking.speed_rad_per_s**2 / STANDARD_GRAVITY_M_PER_S2
    if shake_g > USUAL_SHAKE_G:
        yield (
            f"doubtful: the driven frame reaches {shake_g:.2g} g along the deck, and most machines stay "
            f"below {USUAL_SHAKE_G:g} g; --stroke is half of the whole travel"
        )


def resonances(proposal: Proposal) -> Iterator[str]:
    """Yield a sentence about the modes nearest to the working speed, and a line for each mode."""
    (shaking,) = proposal.scene.shaken
    working_Hz = shaking.speed_rad_per_s / (2 * math.pi)
    modes = frame_modes(proposal.scene)
    nearest = min(abs(mode.frequency_Hz / working_Hz - 1) for mode in modes)
    yield (
        f"resonance: the nearest mode of the frames is {nearest:.0%} away from the working speed of "
        f"{working_Hz:.3g} Hz (less than {NEAR:.0%} is doubtful):"
    )
    for mode in modes:
        yield f"  {mode.frequency_Hz / working_Hz - 1:+5.0%}  {mode.in_words}"


def _material(proposal: Proposal) -> Iterator[str]:
    """Yield sentences about the bed and the draft."""
    wishes, layout = proposal.wishes, proposal.layout
    cut_m, finest_m = wishes.separation_m, wishes.feed_m[0][0]
    fine, half = (finer_share(wishes.feed_m, size_m) for size_m in (cut_m, cut_m / 2))
    sizes = (
        f"up to {1e3 * layout.largest_m:.3g} mm"
        if wishes.feed_m[0][0] < cut_m / 10
        else (f"{1e3 * finest_m:.3g} to {1e3 * layout.largest_m:.3g} mm")
    )
    kind = "by its sieve analysis" if wishes.feed_file else "with a typical curve; give your own with --feed"
    yield (
        f"feed: {3.6 * wishes.throughput_kg_per_s:.4g} t/h of {wishes.material}, {sizes} {kind}; "
        f"{fine:.0%} is finer than the cut of {1e3 * cut_m:.4g} mm, "
        f"and {half:.0%} finer than half of it"
    )
    shape = shapes()[wishes.shape]
    friction = shape.rolling_friction
    yield (
        f"grains: {shape.name} ({shape.about}), computed as spheres; a rolling friction of "
        f"{friction.value:g} ({friction.low:g} to {friction.high:g}) stands for their edges"
    )
    if proposal.air:
        yield f"air: drag is computed, because {proposal.air}"
    draft_s = proposal.run_s["draft"]
    yield f"draft: about {in_words(draft_s)} of processor time: {proposal.draft.about}"
    if draft_s > DRAFT_S:
        yield f"doubtful: even the coarsest draft is predicted to take more than {in_words(DRAFT_S)}"
    bulk_kg_per_m3 = PACKED * wishes.density_kg_per_m3
    depth_m = bed_depth_m(wishes.throughput_kg_per_s, wishes.width_m, TRANSPORT_M_PER_S, bulk_kg_per_m3)
    if depth_m > DEEPEST * wishes.smaller_m:
        yield (
            f"doubtful: at {TRANSPORT_M_PER_S:g} m/s the bed is {1e3 * depth_m:.3g} mm deep, more than "
            f"{DEEPEST:g} openings; a wider deck lets more of the fines reach it"
        )
