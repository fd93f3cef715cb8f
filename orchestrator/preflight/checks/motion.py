"""The warnings about the machine's motion: resonances, damping, its start and its direction."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

import numpy as np

from orchestrator.case.deck.panels import axes
from orchestrator.case.solver_plans import bushing_axes
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.preflight.scene.clamp_motion import has_moved_by_forces
from orchestrator.preflight.scene.frame_modes import NEAR, SHAPES, frame_modes, modes_near, name_frame
from orchestrator.preflight.scene.moved_panel import MovedPanel
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import free_frames

UNDAMPED = 0.002  # Share of the critical damping below which a mode rings for more than 80 cycles.
NORMAL = SHAPES.index("motion normal to the deck")
LOOSE_HZ = 1e-3  # Rounding of a mode that nothing holds.
SOFT_HZ = 0.8  # A frame that hangs 0.4 m deep in its springs; screens have 2 Hz and more.
CYCLES = 4  # of a usual run-up
BEYOND = 2.0  # factor by which a bushing may work beyond its measured amplitudes and frequencies
SHEARED = 1.5  # Motion normal to a panel over that along it; a circular motion has 1.
SHARES = np.linspace(0.0, 1.0, 17)  # of a panel's length, width and swing, where it is looked for in exits
LEVEL = 0.09  # Sine of 5 degrees.
BEATING = 1.5  # Speeds that differ by less than this factor beat; a second exciter may turn twice as fast.
UPRIGHT = 0.27  # Tangent of 15 degrees: a stroke that leans less against the normal carries nothing.


def resonances(scene: Scene) -> Iterator[str]:
    """Yield a warning for each speed of excitation, with all the frames' modes that are near it."""
    for shaking in scene.shaken:
        excited_Hz = shaking.speed_rad_per_s / (2 * math.pi)
        if near := modes_near(scene, shaking.speed_rad_per_s):
            which = "; ".join(mode.in_words for mode in near)
            modes = "a mode" if len(near) == 1 else f"{len(near)} modes"
            yield (
                f"the excitation at {excited_Hz:.3g} Hz is within {NEAR:.0%} of {modes} of the "
                f"frames: {which}; near resonance, small changes of stiffness, mass or load change the "
                "motion strongly; change bushings, masses or the speed"
            )


def slips_of_magnitude(scene: Scene) -> Iterator[str]:
    """Yield warnings about frames that would hang deep in their bushings, or weigh less than their panels.

    Stiffnesses in kN/m and masses in tonnes, typed as numbers in N/m and kg, are a thousand times too small.
    """
    upwards = (mode for mode in frame_modes(scene) if np.argmax(mode.energy.sum(axis=0)) == NORMAL)
    softest = next((mode for mode in upwards if LOOSE_HZ < mode.frequency_Hz < SOFT_HZ), None)
    if softest is not None:
        sag_m = STANDARD_GRAVITY_M_PER_S2 / (2 * math.pi * softest.frequency_Hz) ** 2
        yield (
            f"soft bushings: {softest.in_words}, which is a static deflection of {sag_m:.2g} m under "
            f"gravity; {_softest_bushing(scene.case)}rubber springs of screens have 1e4 to 1e7 N/m"
        )
    free = free_frames(scene.plan)
    for body in (body for body in scene.plan.bodies if body.name in free):
        panels_kg = sum(s.mass_kg * s.frames.count(body.name) / 2 for s in scene.springs)
        if body.mass_kg < panels_kg:
            yield (
                f"{name_frame(body.name)} of {body.mass_kg:.3g} kg is lighter than the panels that it "
                f"carries, {panels_kg:.3g} kg; mass_kg is in kg"
            )


def _softest_bushing(case: Case) -> str:
    """Return a text about the softest stiffness of all bushings, as if in N/mm; "" without bushings."""
    sizes = [
        (size, name)
        for name, row in case.screen.bushings.items()
        for size in row.stiffness_N_per_m
        if size > 0
    ]
    if not sizes:
        return ""
    size, name = min(sizes)
    key = f"screen.bushings.{name}.stiffness_N_per_m"
    return f"{key} has {size:g}, and {size:g} N/mm would be {1e3 * size:g} N/m; "


def missing_damping(case: Case, scene: Scene) -> Iterator[str]:
    """Yield warnings about frames and panels whose vibrations nothing damps."""
    undamped = [
        mode for mode in frame_modes(scene) if mode.frequency_Hz > 0 and mode.damping_ratio < UNDAMPED
    ]
    if undamped:
        more = f"{_more(len(undamped))} modes" if len(undamped) > 1 else ""
        yield (
            f"no damping of {undamped[0].in_words}{more}: less than {UNDAMPED:.1%} of critical, so that the "
            "start-up motion hardly dies out; give the bushings damping_N_s_per_m (loss factor times "
            "stiffness over speed; the loss factor of rubber is about 0.1)"
        )
    if not case.panel.adapter.deforms:
        return
    for name in dict.fromkeys(panel.material for panel in case.screen.panels.values()):
        law = case.materials[name].hyperelastic
        if law is not None and not law.maxwell and not law.loss_curve:
            yield (
                f"no damping in panels of {name}: their vibrations do not die out; give the material maxwell "
                "branches or a loss_curve (the loss factor of polyurethane is about 0.1)"
            )


def bushings_beyond_points(case: Case, scene: Scene) -> Iterator[str]:
    """Yield a warning for each bushing that moves much farther, or faster, than its curves were measured."""
    shaken = scene.shaken
    speeds_Hz = [shaking.speed_rad_per_s / (2 * math.pi) for shaking in shaken]
    for name, bushing in case.screen.bushings.items():
        own_axes = bushing_axes(case, bushing)
        moved = [s.relative_m(bushing.between) for s in shaken if set(bushing.between) <= set(s.amplitude_m)]
        for curve in bushing.curves:
            along = ["xyz".index(axis) for axis in curve.axes]
            sizes_mm = [1e3 * float(np.linalg.norm((own_axes @ vector)[along])) for vector in moved]
            measured_mm = [1e3 * point.amplitude_m for point in curve.points]
            measured_Hz = [point.frequency_Hz for point in curve.points]
            for what in (
                *_beyond("an amplitude", "mm", sizes_mm, measured_mm),
                *_beyond("a frequency", "Hz", speeds_Hz, measured_Hz),
            ):
                yield f"bushing {name} along {curve.axes} works at {what}: its force is extrapolated"


def loss_curves_beyond_points(case: Case, scene: Scene) -> Iterator[str]:
    """Yield a warning for each material of panels whose loss curve is far from the machine's speed."""
    speeds_Hz = [shaking.speed_rad_per_s / (2 * math.pi) for shaking in scene.shaken]
    if not case.panel.adapter.deforms:
        return
    for name in dict.fromkeys(panel.material for panel in case.screen.panels.values()):
        law = case.materials[name].hyperelastic
        measured_Hz = [point.frequency_Hz for point in law.loss_curve] if law is not None else []
        for what in _beyond("a frequency", "Hz", speeds_Hz, measured_Hz):
            yield f"material {name} of panels works at {what}: its loss is extrapolated"


def _beyond(what: str, unit: str, works: Sequence[float], measured: Sequence[float]) -> Iterator[str]:
    """Yield a text if the largest of these numbers is far outside of the measured ones."""
    if works and measured and not min(measured) / BEYOND <= max(works) <= BEYOND * max(measured):
        span = f"{min(measured):.3g} to {max(measured):.3g} {unit}"
        yield f"{what} of {max(works):.3g} {unit}, and its curve was measured from {span}"


def sudden_exciters(case: Case) -> Iterator[str]:
    """Yield a warning for each exciter without run-up, whose force would begin with a blow."""
    if not has_moved_by_forces(case) or not case.frames.adapter.moved_by_forces:
        return
    for name, exciter in case.screen.exciters.items():
        if exciter.run_up_s == 0:
            force_N = exciter.mass_moment_kg_m * exciter.speed_rad_per_s**2
            cycles_s = CYCLES * 2 * math.pi / exciter.speed_rad_per_s
            yield (
                f'exciter "{name}" has no run-up: its full force of {force_N:.3g} N acts at once, and the '
                f"frames swing long before they settle; set run_up_s, {CYCLES} cycles are {cycles_s:.2g} s"
            )


def beating_speeds(scene: Scene) -> Iterator[str]:
    """Yield a warning if two exciters or drives are told to turn at nearly the same speed.

    Motors may synchronise: what became of them is a result of the run.  Drives without amplitude hold their
    frames.
    """
    told = [(one.speed_rad_per_s, f"exciter {one.name}") for one in scene.plan.exciters if one.motor is None]
    told += [
        (one.speed_rad_per_s, f"the drive of {name_frame(one.body)}")
        for one in scene.plan.drives
        if one.amplitude_m.any() or one.rotation_rad.any()
    ]
    for (slow_rad_per_s, slow), (fast_rad_per_s, fast) in pairwise(sorted(told)):
        if slow_rad_per_s < fast_rad_per_s < BEATING * slow_rad_per_s:
            beat_s = 2 * math.pi / (fast_rad_per_s - slow_rad_per_s)
            yield (
                f"{slow} and {fast} turn at {slow_rad_per_s:.6g} and {fast_rad_per_s:.6g} rad/s: "
                f"they beat, in step once every {beat_s:.3g} s, so that no stroke is steady; "
                "shafts that are geared together need the same speed_rad_per_s"
            )


def normal_strokes(scene: Scene) -> Iterator[str]:
    """Yield warnings about strokes normal to the panels and across them.

    The ends of a flip-flow panel must move against each other along the panel.  A panel whose ends move
    together carries material on a level deck only if its stroke leans downhill.
    """
    sheared, lifted = [], []
    for moving, spring in zip(scene.panels, scene.springs, strict=True):
        relative = [shaking.relative_m(spring.frames) for shaking in scene.shaken]
        along_m, normal_m = _parts_m(relative, moving)
        across_m = sum(float(abs(amplitude_m @ moving.panel.rectangle.across)) for amplitude_m in relative)
        side_m, way = max((normal_m, "normal to"), (across_m, "across"))
        if side_m > SHEARED * along_m:
            sheared.append((moving.panel.name, spring.frames, way, side_m, along_m))
        own = [shaking.amplitude_m[spring.frames[0]] for shaking in scene.shaken]
        own_along_m, own_normal_m = _parts_m(own, moving)
        level = abs(spring.along[2]) < LEVEL and scene.case.bed.feeds
        if level and along_m == normal_m == 0 and own_along_m < UPRIGHT * own_normal_m:
            lifted.append((moving.panel.name, spring.frames[0]))
    if sheared:
        name, frames, way, side_m, along_m = sheared[0]
        yield (
            f"the stroke between {name_frame(frames[0])} and {name_frame(frames[1])} is {way} panel "
            f"{name}{_more(len(sheared))}: {1e3 * side_m:.2g} mm against {1e3 * along_m:.2g} mm along it, "
            "which shears the panel and hardly stretches it; directions are in deck axes, x along the deck"
        )
    if lifted:
        name, frame = lifted[0]
        yield (
            f"the stroke of {name_frame(frame)} is normal to the level panel {name}{_more(len(lifted))}: it "
            "throws material up and does not carry it along the deck"
        )


def exits_in_swing(scene: Scene) -> Iterator[str]:
    """Yield a warning for each exit into which a panel reaches while it swings: below its straight shape
    by its sag, a sine arch, and by the stroke of its clamps normal to it."""
    turn = axes(scene.case)
    along, across, below = (share.ravel() for share in np.meshgrid(*[SHARES] * 3, indexing="ij"))
    for name, row in scene.case.screen.exits.items():
        low, high = np.array(row.box_m)
        reached_m = {}
        for moving, spring in zip(scene.panels, scene.springs, strict=True):
            at = moving.panel.rectangle
            own = [[shaking.amplitude_m[frame] for shaking in scene.shaken] for frame in spring.frames]
            deep_m = max(_parts_m(amplitudes_m, moving)[1] for amplitudes_m in own)
            deep_m += moving.sag_m * np.sin(math.pi * along)
            flat_m = at.mounted(np.column_stack([along * at.length_m, across * at.width_m]))
            places_m = (flat_m - (below * deep_m)[:, None] * at.normal) @ turn
            inside = ((places_m > low) & (places_m < high)).all(axis=1)
            if inside.any():
                reached_m[moving.panel.name] = float((high[2] - places_m[inside, 2]).max())
        if reached_m:
            panel, most_m = max(reached_m.items(), key=lambda item: item[1])
            yield (
                f'panel {panel}{_more(len(reached_m))} swings into exit "{name}", by up to '
                f"{1e3 * most_m:.3g} mm: an exit of the undersize there takes only particles below the "
                f"panel, any other takes them off the deck; lower the upper face of screen.exits.{name}.box_m"
            )


def _parts_m(amplitudes_m: list[Array], moving: MovedPanel) -> tuple[float, float]:
    """Return the parts of complex amplitudes (3,) along a panel and normal to it, summed over all speeds."""
    at = moving.panel.rectangle
    along_m = sum(float(abs(amplitude_m @ at.along)) for amplitude_m in amplitudes_m)
    normal_m = sum(float(abs(amplitude_m @ at.normal)) for amplitude_m in amplitudes_m)
    return along_m, normal_m


def _more(count: int) -> str:
    return f" and {count - 1} more" if count > 1 else ""
