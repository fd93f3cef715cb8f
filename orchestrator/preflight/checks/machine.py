"""The checks of the machine: contradicting tables, keys that solvers need, and drives."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np

from orchestrator.case import solvers
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.solver_plans import frames_plan, panel_plans
from orchestrator.case.solvers import Port
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.quantities import GROUND
from orchestrator.ports import Array, linear_frames
from orchestrator.ports.plans import BodyPlan
from orchestrator.preflight.checks.names import rows
from orchestrator.preflight.scene.scene import scene
from orchestrator.preflight.scene.shaking import PanelSpring, carry_panels

FASTEST_MOTOR = 1.25  # synchronous speed over the exciter's: motors slip by some per cent


def frames_and_their_solver(case: Case) -> Iterator[CaseProblem]:
    """Check that a solver that moves frames by forces has frames, that these have masses, and that the solver
    of driven frames knows drives.
    """
    solver, able = case.frames.solver, case.frames.adapter
    if not able.moved_by_forces:
        return
    if not case.screen.frames:
        still = solvers.names_able_to("frames", lambda frames: not frames.moved_by_forces)
        yield CaseProblem(
            ("frames", "solver"), f"{solver} has no frame to move", f"frames.solver = {still}", kind="solver"
        )
    driving = solvers.names_able_to("frames", lambda frames: frames.drives and frames.moved_by_forces)
    for key, frame in rows(case, "screen.frames"):
        if frame.drive is not None:
            if not able.drives:
                hint = f"take the drive out, or frames.solver = {driving}"
                yield CaseProblem(
                    (*key, "drive"), f"frames.solver {solver} knows no drives", hint, kind="solver"
                )
            continue
        if frame.mass_kg is None:
            hint = f"or move it by a drive, with frames.solver = {driving}"
            yield CaseProblem(
                (*key, "mass_kg"), f"missing: frames.solver {solver} needs it", hint, kind="missing"
            )
        if frame.inertia_kg_m2 is None and able.rotates:
            yield CaseProblem(
                (*key, "inertia_kg_m2"), f"missing: frames.solver {solver} needs it", kind="missing"
            )
        if frame.center_of_mass_m is None and able.rotates:
            what = "missing: it decides how the frame turns"
            yield CaseProblem(
                (*key, "center_of_mass_m"), what, _describe_middle(case, str(key[-1])), kind="missing"
            )


def _describe_middle(case: Case, frame: str) -> str:
    """Return a text with the middle of the bushings that hold a frame; "" if none does."""
    rows_m = [row.positions_m for row in case.screen.bushings.values() if frame in row.between]
    if not rows_m:
        return ""
    middle_m = np.round(np.concatenate([np.array(row_m) for row_m in rows_m]).mean(axis=0), 4) + 0.0
    return f"the middle of its bushings is {middle_m.tolist()}"


def inertia_tensors(case: Case) -> Iterator[CaseProblem]:
    """Check that principal moments are positive and that none exceeds the sum of the others.

    Only a body with negative mass somewhere could break these rules.
    """
    for key, frame in rows(case, "screen.frames"):
        if frame.inertia_kg_m2 is None:
            continue
        xy, xz, yz = frame.products_of_inertia_kg_m2
        tensor = np.diag(frame.inertia_kg_m2) + np.array([[0, xy, xz], [xy, 0, yz], [xz, yz, 0]])
        moments = np.linalg.eigvalsh(tensor)
        if moments[0] <= 0 or moments[2] > (1 + 1e-9) * (moments[0] + moments[1]):
            what = f"no body has the principal moments {', '.join(f'{m:.4g}' for m in moments)} kg m2"
            yield CaseProblem((*key, "inertia_kg_m2"), what, "none may exceed the sum of the others")


def frame_weights(case: Case) -> Iterator[CaseProblem]:
    """Check that bushings to the ground or to driven frames hold frames that are drawn at rest.

    The static equations K u = load must have a solution in the coordinates of the solver: for the weight of
    the frames, and for the panels on them.  What these weigh and pull together is known only when they are
    open, so that each clamp's weight and each panel's pull must be held alone, with the panels as springs.
    """
    able = case.frames.adapter
    if not (able.moved_by_forces and case.screen.drawn_at_rest):
        return
    coordinates = linear_frames.SPACE if able.rotates else linear_frames.TRANSLATIONS
    plan = frames_plan(case, np.empty((0, 3)), (), np.empty((0, 3)))
    free = [plan.bodies[number] for number in linear_frames.free(plan)]
    if not free:
        return
    weight = np.array([[*body.mass_kg * plan.gravity_m_per_s2, 0.0, 0.0, 0.0] for body in free])
    loads = [(linear_frames.linearise(plan, coordinates), weight)]
    springs = scene(case).springs if case.exchange.panel_reaction else ()
    with_panels = linear_frames.linearise(carry_panels(plan, springs), coordinates)
    loads += [(with_panels, load) for load in _panel_loads(free, springs, plan.gravity_m_per_s2)]
    unheld = np.zeros(len(free), dtype=np.bool_)
    for machine, load in loads:
        _, unmet = machine.hold(load[:, coordinates].ravel())
        left = np.abs(unmet).reshape(len(free), len(coordinates)).max(axis=1)  # in N and N m
        unheld |= left > linear_frames.IN_BALANCE * np.abs(load).max()
    for body, is_unheld in zip(free, unheld, strict=True):
        if is_unheld:
            what = "no bushing holds its weight, or keeps it from tipping over"
            hint = "add bushings to the ground, or let it drop: screen.drawn_at_rest = false"
            yield CaseProblem(("screen", "frames", body.name), what, hint)


def _panel_loads(
    free: Sequence[BodyPlan], springs: Sequence[PanelSpring], gravity_m_per_s2: Array
) -> Iterator[Array]:
    """Yield the loads (bodies, 6) of the weight of each panel at each of its ends, and of a pull along it."""
    for spring in springs:
        weight, pull = np.zeros((2, 2, len(free), 6))
        for end, sign in ((0, 1.0), (1, -1.0)):
            for number, body in enumerate(free):
                if body.name == spring.frames[end]:
                    arm = linear_frames.displacement(body, spring.ends_m[end])
                    weight[end, number] = arm.T @ (spring.mass_kg / 2 * gravity_m_per_s2)
                    pull[end, number] = arm.T @ (sign * spring.along)
        yield from (load for load in (*weight, pull.sum(axis=0)) if load.any())


def bushings_and_exciters(case: Case) -> Iterator[CaseProblem]:
    """Check that bushings join two different bodies, and that exciters have a valid shaft and frame.

    An exciter on a frame with a drive would have no effect.
    """
    for key, bushing in rows(case, "screen.bushings"):
        if bushing.between[0] == bushing.between[1]:
            yield CaseProblem((*key, "between"), f'"{bushing.between[0]}" twice', "name two frames")
        if not any(bushing.stiffness_N_per_m) and not bushing.characteristics:
            yield CaseProblem((*key, "stiffness_N_per_m"), "is zero in every direction", kind="out-of-range")
    able = case.frames.adapter
    for key, exciter in rows(case, "screen.exciters"):
        if exciter.frame == GROUND:
            yield CaseProblem((*key, "frame"), "the ground cannot be excited", "name a frame")
        frame = case.screen.frames.get(exciter.frame)
        if able.drives and able.moved_by_forces and frame is not None and frame.drive is not None:
            what = f'"{exciter.frame}" has a drive, which leaves nothing to an exciter'
            yield CaseProblem((*key, "frame"), what, "take one of them out")
        yield from right_angle(key, exciter, "axis", "start")
        if exciter.motor is not None:
            synchronous = exciter.motor.synchronous_speed_rad_per_s
            if exciter.speed_rad_per_s > synchronous:
                what = f"{synchronous:g} is below the exciter's speed_rad_per_s = "
                what += f"{exciter.speed_rad_per_s:g}"
                motor_key = (*key, "motor", "synchronous_speed_rad_per_s")
                yield CaseProblem(motor_key, what, "a motor lags behind it", kind="out-of-range")
            elif synchronous > FASTEST_MOTOR * exciter.speed_rad_per_s:
                what = f"{synchronous:g} is {synchronous / exciter.speed_rad_per_s:.2g} times the exciter's "
                what += f"speed_rad_per_s = {exciter.speed_rad_per_s:g}, by which cycles are counted"
                motor_key = (*key, "motor", "synchronous_speed_rad_per_s")
                yield CaseProblem(
                    motor_key, what, "both are in rad/s: 1000 rpm are 104.7 rad/s", kind="out-of-range"
                )


def right_angle(key: Key, row: Any, one: str, other: str) -> Iterator[CaseProblem]:
    """Check that two directions of a row are not zero and stand at right angles."""
    vectors = [getattr(row, one), getattr(row, other)]
    sizes = np.linalg.norm(vectors, axis=1)
    for name, size in zip((one, other), sizes, strict=True):
        if size == 0:
            yield CaseProblem((*key, name), "is zero", "give a direction", kind="out-of-range")
    if sizes.all() and abs(np.dot(*vectors)) > 1e-9 * sizes.prod():
        yield CaseProblem((*key, other), f"is not at right angles to {one}")


def solvers_objections(case: Case) -> Iterator[CaseProblem]:
    """Yield the objections of the panels' and frames' adapters to their plans.

    Plans can only be made of a case whose tables fit together.
    """
    asked: list[tuple[Port, list[Any]]] = [
        ("panel", list(panel_plans(case))),
        ("frames", [frames_plan(case, np.empty((0, 3)), (), np.empty((0, 3)))]),
    ]
    for port, plans in asked:
        objections = (o for plan in plans for o in case.adapters[port].objections(plan))
        for objection in dict.fromkeys(objections):
            yield CaseProblem(
                objection.key or (port, "solver"), objection.what, objection.hint, kind="solver"
            )


def probes(case: Case) -> Iterator[CaseProblem]:
    """Check that each probe is on exactly one frame, panel or particle, and says where on it."""
    for key, probe in rows(case, "probes"):
        on = [kind for kind in ("frame", "panel", "particle") if getattr(probe, kind) is not None]
        if len(on) != 1:
            what = f"is on {' and '.join(on)}" if on else "is on no part"
            yield CaseProblem(key, what, "give one of frame, panel, particle")
        for kind, place in (("frame", "point_m"), ("panel", "at")):
            given = getattr(probe, place) is not None
            if (kind in on) != given:
                what = f"is for a probe on a {kind}" if given else f"missing: where on the {kind}?"
                yield CaseProblem((*key, place), what, kind="conflict" if given else "missing")
        if probe.frame == GROUND:
            yield CaseProblem((*key, "frame"), "the ground does not move", "name a frame")
        if probe.sensor_kg > 0 and probe.panel is None:
            yield CaseProblem((*key, "sensor_kg"), "is for a probe on a panel", "add its mass to the frame's")
        if probe.sensor_kg > 0 and case.slice is not None:
            what = "is a mass at one point, of which a slice of the width has no share"
            yield CaseProblem((*key, "sensor_kg"), what, "take it away, or run the whole width")


def start_of_drives(case: Case) -> Iterator[CaseProblem]:
    """Check that a drive without run-up starts from the place in which its frame is drawn.

    Check as well that a drive that turns its frame says about which point.
    """
    for key, drive in rows(case, "screen.frames.drive"):
        if any(drive.rotation_rad) and drive.center_m is None:
            what = "missing: rotation_rad turns the frame about it"
            yield CaseProblem(
                (*key, "center_m"), what, "give the point that stays where it is", kind="missing"
            )
        if drive.run_up_s > 0:
            continue
        for phase, jump in drive.jumps.items():
            what = f"the frame would jump by {jump:.3g} {'m' if phase == 'phase_rad' else 'rad'} at t = 0"
            yield CaseProblem((*key, phase), what, "give run_up_s, or 0")


def stops_of_exciters(case: Case) -> Iterator[CaseProblem]:
    """Check that an exciter runs down after it has run up, and that its run-down begins at some time."""
    for name, exciter in case.screen.exciters.items():
        key = ("screen", "exciters", name)
        full_s = exciter.start_s + exciter.run_up_s
        if exciter.stop_s is None:
            if exciter.run_down_s > 0:
                yield CaseProblem((*key, "run_down_s"), "is of no use without stop_s", "give stop_s")
        elif exciter.stop_s < full_s:
            what = f"{exciter.stop_s:g} s is before the end of the run-up at {full_s:g} s"
            yield CaseProblem((*key, "stop_s"), what, "stop it later", kind="out-of-range")


def sudden_drives(case: Case) -> Iterator[str]:
    """Yield a warning for each drive without run-up whose frame holds panels that are at rest at t = 0."""
    for name, frame in case.screen.frames.items():
        drive = frame.drive
        panels = [panel.name for panel in single_panels(case) if name in panel.frames]
        if drive is None or drive.run_up_s > 0 or not panels:
            continue
        moving = np.multiply(drive.amplitude_m, np.cos(drive.phase_rad))
        turning = np.multiply(drive.rotation_rad, np.cos(drive.rotation_phase_rad))
        speeds = [
            f"{drive.speed_rad_per_s * size:.3g} {unit}"
            for size, unit in ((np.linalg.norm(moving), "m/s"), (np.linalg.norm(turning), "rad/s"))
            if size > 0
        ]
        if speeds:
            cycles_s = 2 * 2 * np.pi / drive.speed_rad_per_s
            more = f" and {len(panels) - 1} more" if len(panels) > 1 else ""
            yield (
                f'frame "{name}" moves at {" and ".join(speeds)} from t = 0, while panel '
                f"{panels[0]}{more} on it is at rest: a blow that no machine gives; give its drive a "
                f"run_up_s, two cycles are {cycles_s:.2g} s"
            )
