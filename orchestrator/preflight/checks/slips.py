"""The slips that a case's numbers reveal: another unit, a start after the end, shafts that cancel each other.

Each is a problem with the key that it may be in.  Those of a motion beyond all screens prevent a run; the
others are warnings.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from orchestrator.case.bed.grains import sieve_sizes_m
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.file.plausible import MISTAKEN
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.case.tables.frames import Drive, Exciter
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.ports.plans import ExciterPlan
from orchestrator.preflight.scene.clamp_motion import has_moved_by_forces
from orchestrator.preflight.scene.frame_modes import name_frame
from orchestrator.preflight.scene.frame_motion import FrameMotion, least_motions, speed_in_words
from orchestrator.preflight.scene.scene import Scene, scene
from orchestrator.preflight.scene.shaking import exciter_N

SPEEDS_RAD_PER_S = (30.0, 160.0)
LARGEST_G = 15.0
LARGEST_STROKE_M = 0.03
LEAST_G = 0.3
"""What screens do, with a margin: 290 to 1530 rpm, 2 to 10 g, and amplitudes of 1 to 15 mm."""
BENCH_G = 0.01
"""Without panels, what moves so slowly is a bench of grains."""
CANCELLED = 0.02  # of the sum of the forces' sizes
SMALL_RAD = 0.05  # 3 degrees: a number of degrees from here to 1 may be meant in radians


def refused_motion(case: Case) -> Iterator[CaseProblem]:
    """Check that no frame would move harder than the case says to be meant."""
    shaken = scene(case)
    if _hardest(shaken).acceleration_g > _allowed_g(case):
        yield from unusual_motion(shaken)


def unusual_motion(shaken: Scene) -> Iterator[CaseProblem]:
    """Yield a problem for each speed that no screen has or, if there is none, for a motion that none has."""
    case, hardest = shaken.case, _hardest(shaken)
    if hardest.acceleration_g < BENCH_G and not [*single_panels(case)]:
        return
    moves = f"{name_frame(hardest.frame)} moves with {hardest.acceleration_g:.3g} g"
    moves += f" and a stroke of {1e3 * hardest.stroke_m:.3g} mm (amplitude)"
    if hardest.acceleration_g > (limit_g := _allowed_g(case)):
        moves += f", beyond {limit_g:.3g} g; if that is meant, raise screen.largest_acceleration_m_per_s2"
    low, high = SPEEDS_RAD_PER_S
    usual_speeds = True
    for key, row in _shakers(case):
        speed = row.speed_rad_per_s
        if not low <= speed <= high:
            usual_speeds = False
            what = f"is {speed_in_words(speed)}, and screens have {low:g} to {high:g} rad/s; {moves}"
            hints = (
                f"{speed:g} {unit} would be {speed * factor:.3g} rad/s"
                for unit, factor in MISTAKEN["_rad_per_s"].items()
                if low <= speed * factor <= high
            )
            yield CaseProblem(
                (*key, "speed_rad_per_s"), what, next(hints, ""), guesses_unit=True, kind="out-of-range"
            )
    if usual_speeds and not _is_usual(hardest):
        drive = ("drive",) if hardest.frame in {row.body for row in shaken.plan.drives} else ()
        key, hint = _mistaken_size(shaken) or (("screen", "frames", hardest.frame, *drive), "")
        what = f"{moves}; screens have some mm, and up to {LARGEST_G:g} g"
        yield CaseProblem(key, what, hint, guesses_unit=True, kind="out-of-range")


def _hardest(shaken: Scene) -> FrameMotion:
    """Return the motion of the frame that moves hardest, by what does not hang on a mode."""
    still = FrameMotion("", 0.0, 0.0, 0.0, (), near_mode=False)
    return max(least_motions(shaken), key=lambda motion: motion.acceleration_g, default=still)


def _allowed_g(case: Case) -> float:
    return case.screen.largest_acceleration_m_per_s2 / STANDARD_GRAVITY_M_PER_S2


def _is_usual(motion: FrameMotion) -> bool:
    return motion.acceleration_g <= LARGEST_G and motion.stroke_m <= LARGEST_STROKE_M


def _shakers(case: Case) -> Iterator[tuple[Key, Exciter | Drive]]:
    if has_moved_by_forces(case) and case.frames.adapter.moved_by_forces:
        for name, exciter in case.screen.exciters.items():
            yield ("screen", "exciters", name), exciter
    for name, frame in case.screen.frames.items():
        if frame.drive is not None and frame.drive.moves:
            yield ("screen", "frames", name, "drive"), frame.drive


def _mistaken_size(shaken: Scene) -> tuple[Key, str] | None:
    """Return the key of a size with which the machine moves as screens do if it was given in another unit.

    All sizes of its kind are then in that unit.  Return None if there is no such key.
    """
    plan = shaken.plan
    for table, field, unit, factor, own in (
        ("exciters", "mass_moment_kg_m", "kg mm", 1e-3, "kg m"),
        ("drives", "amplitude_m", "mm", 1e-3, "m"),
        ("bodies", "mass_kg", "t", 1e3, "kg"),
    ):
        rows = getattr(plan, table)
        meant: Any = {table: tuple(replace(row, **{field: factor * getattr(row, field)}) for row in rows)}
        moved = _hardest(replace(shaken, plan=replace(plan, **meant)))
        if rows and _is_usual(moved) and moved.acceleration_g >= LEAST_G:
            name = rows[0].body if table == "drives" else rows[0].name
            where = {"exciters": ("exciters", name), "drives": ("frames", name, "drive")}
            size = float(np.abs(getattr(rows[0], field)).max())
            key = ("screen", *where.get(table, ("frames", name)), field)
            return key, f"{size:g} {unit} would be {factor * size:g} {own}"
    return None


def late_exciters(case: Case) -> Iterator[CaseProblem]:
    """Yield a problem for each exciter that starts after the end of the run."""
    for name, exciter in case.screen.exciters.items():
        if exciter.start_s >= case.duration_s:
            what = f"is after the end of the run, duration_s = {case.duration_s:g}: it never turns"
            yield CaseProblem(
                ("screen", "exciters", name, "start_s"),
                what,
                "start it earlier, or run longer",
                kind="out-of-range",
            )


def cancelled_shafts(shaken: Scene) -> Iterator[CaseProblem]:
    """Yield a problem for the shafts of a frame if their forces cancel each other.

    Shafts with motors count not, because they find phases of their own.
    """
    groups: dict[tuple[str, float], list[ExciterPlan]] = {}
    for exciter in shaken.plan.exciters:
        if exciter.motor is None:
            groups.setdefault((exciter.body, exciter.speed_rad_per_s), []).append(exciter)
    for (body, _), exciters in groups.items():
        forces_N = np.array([exciter_N(exciter) for exciter in exciters])
        left = np.linalg.norm(forces_N.sum(axis=0)) / np.linalg.norm(forces_N, axis=1).sum()
        if left < CANCELLED:
            names = " and ".join(exciter.name for exciter in exciters)
            what = f"{names} cancel each other: their forces add up to nothing, and only a couple is left"
            hint = f"{name_frame(body)} then hardly moves; change phase_rad, start or axis of one of them"
            yield CaseProblem(("screen", "exciters", exciters[-1].name), what, hint)


def angles_in_other_units(given: Mapping[str, Any] | list[Any], key: Key = ()) -> Iterator[CaseProblem]:
    """Yield a problem for each small angle in degrees, and each large one in radians, in ``given`` tables."""
    for word, value in given.items() if isinstance(given, Mapping) else enumerate(given):
        at = (*key, word)
        if isinstance(value, Mapping | list):
            yield from angles_in_other_units(value, at)
        elif isinstance(value, int | float) and not isinstance(value, bool):
            name = next(str(part) for part in reversed(at) if not isinstance(part, int))
            if name.endswith("_deg") and SMALL_RAD <= abs(value) < 1:
                hint = f"{value:g} rad would be {math.degrees(value):.3g} degrees"
                yield CaseProblem(at, f"is {value:g} degrees", hint, guesses_unit=True, kind="unit")
            elif name.endswith("phase_rad") and abs(value) > 2 * math.pi:
                hint = f"{value:g} degrees would be {math.radians(value):.3g} rad"
                yield CaseProblem(
                    at, f"is {value:g} rad, more than a turn", hint, guesses_unit=True, kind="unit"
                )


def cut_beside_all_sizes(case: Case) -> Iterator[CaseProblem]:
    """Yield a problem for a cut size above all sizes of the particles, or below all of them."""
    cut_m = case.output.cut_size_m
    if cut_m is None or not has_particles(case) or not case.bed.has_material:
        return
    smallest_m, largest_m = sieve_sizes_m(case.original)
    if not smallest_m < cut_m < largest_m:
        where, kind = ("above", "fine") if cut_m >= largest_m else ("below", "coarse")
        sizes = f"{1e3 * smallest_m:.3g} to {1e3 * largest_m:.3g} mm"
        what = f"is {where} all sizes, {sizes}: all that comes is {kind}"
        yield CaseProblem(
            ("output", "cut_size_m"),
            what,
            "without it, the openings' smaller side counts",
            kind="out-of-range",
        )
