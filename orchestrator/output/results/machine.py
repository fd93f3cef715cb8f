"""The machine's motion: orbits of frames, accelerations and pulls of panels, and ranges of points."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import combinations, pairwise
from operator import itemgetter

import numpy as np
from scipy.spatial.transform import Rotation

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.solver_plans import bushings
from orchestrator.case.tables.quantities import GROUND
from orchestrator.figures.estimate import Estimate
from orchestrator.figures.machine import (
    FrameRunDown,
    GroundForce,
    Orbit,
    PanelMotion,
    PointAcceleration,
    PointRange,
    RelativeOrbit,
    RunDown,
)
from orchestrator.output.cycles import cycle_numbers, named_speeds_rad_per_s, within
from orchestrator.output.results import fatigue, mats
from orchestrator.output.results.estimate import IntervalOf, mean
from orchestrator.output.results.harmonics import Harmonic, drift, first_harmonic
from orchestrator.output.results.run_reader import RunReader
from orchestrator.output.results.sampling import rows_too_seldom
from orchestrator.ports import Array
from orchestrator.ports.acceleration import BAND_HZ, QUOTED_HZ, acceleration_m_per_s2, band_hz
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.ports.plans import BushingPlan
from orchestrator.preflight.checks.motion import BEATING

FEWEST_FILTERED = 20  # rows: fewer show hardly any motion
SMALL_MOTION = 0.05  # of the largest motion of a frame
LARGEST_DRIFT = 0.05  # of an amplitude or a range, from the first half of the window to the second
OUT_OF_STEP_RAD = 0.05  # since t = 0, between shafts that are told to turn at nearly the same speed
SLOW_SHAFT = 0.8  # of its named speed: a rated slip is at most 0.2
APART = 0.005  # of a speed: motors' shafts that differ by more have not synchronised
FEWEST_CYCLES = 4  # in a window whose halves are compared
RANGE_CYCLES = 2  # last whole cycles that give the ranges of points


@dataclass(frozen=True)
class Orbits:
    """The first harmonics of a machine's motion.

    ``frames`` has every frame's centre of mass and every probe on a frame.  ``relative`` has, for every two
    frames in the case's order, the motion of the second frame against the first.  ``mostly_other`` names a
    motion that is mostly of other frequencies; it is empty if there is none.
    """

    frames: dict[str, Orbit] = field(default_factory=dict)
    relative: dict[str, RelativeOrbit] = field(default_factory=dict)
    drift: float | None = None
    speed_rad_per_s: float | None = None
    mostly_other: str = ""

    @property
    def all(self) -> dict[str, Orbit]:
        """All of them by name."""
        return {**self.frames, **self.relative}


def orbits(run: RunReader, start_s: float, end_s: float, interval_of: IntervalOf) -> Orbits:
    """Return the first harmonics of the machine's motion in deck axes over a span."""
    frames = [name for name in run.case.screen.frames if run.has(f"frames/{name}")]
    probes = [name for name, probe in run.case.probes.items() if probe.frame and run.has(f"probes/{name}")]
    moved_m = {name: run.read(f"frames/{name}/displacement_m") for name in frames}
    moved_m |= {name: run.read(f"probes/{name}/position_m") for name in probes}
    time_s, turn_s = run.series_s(), run.turn_s(start_s, end_s)

    def harmonics(motions: dict[str, Array]) -> dict[str, Harmonic]:
        return {
            name: first_harmonic(time_s, place_m @ run.deck_axes, turn_s, start_s, end_s, interval_of)
            for name, place_m in motions.items()
        }

    single, relative = harmonics(moved_m), harmonics(relative_motions_m(run))
    return Orbits(
        frames={name: motion.orbit() for name, motion in single.items()},
        relative={
            name: RelativeOrbit(**vars(motion.orbit()), along_m=motion.estimate(0))
            for name, motion in relative.items()
        },
        drift=drift(list(single.values())),
        speed_rad_per_s=2 * np.pi / turn_s,
        mostly_other=mostly_other(single | relative),
    )


def force_on_ground(
    run: RunReader, start_s: float, end_s: float, interval_of: IntervalOf
) -> GroundForce | None:
    """Return the force of all bushings on the ground in the cycles from ``start_s`` to ``end_s``.

    Return None without bushings on the ground, and where a frame moves as prescribed: what moves it stands on
    the ground, too.
    """
    case = run.case
    if not case.frames.adapter.moved_by_forces or any(one.drive for one in case.screen.frames.values()):
        return None
    standing = [
        bushing
        for bushing in bushings(case)
        if GROUND in bushing.bodies and run.has(f"bushings/{bushing.name}")
    ]
    if not standing:
        return None
    time_s = run.series_s()
    force_N = np.sum([_on_ground_N(run, bushing) for bushing in standing], axis=0)
    turn_s = run.turn_s(start_s, end_s)
    harmonic = first_harmonic(time_s, force_N, turn_s, start_s, end_s, interval_of)
    inside_N = force_N[within(time_s, start_s, end_s, run.cycle_s)]
    mean_N = inside_N.mean(axis=0)
    return GroundForce(
        amplitude_N={axis: harmonic.estimate(number) for number, axis in enumerate("xyz")},
        mean_N=mean_N,
        largest_N=np.abs(inside_N - mean_N).max(axis=0),
    )


def _on_ground_N(run: RunReader, bushing: BushingPlan) -> Array:
    """Return the force (rows, 3) of a bushing on the ground, in world axes.

    Its record is the force that holds the second end, along axes that turn with the first body.
    """
    first, second = bushing.bodies
    force_N: Array = run.read(f"bushings/{bushing.name}/force_N") @ bushing.axes
    if second == GROUND:
        force_N = -Rotation.from_rotvec(run.read(f"frames/{first}/rotation_rad")).apply(force_N)
    return force_N


def mostly_other(motions: dict[str, Harmonic]) -> str:
    """Return the name of a motion that is mostly not of the cycle's frequency; empty if there is none.

    Small motions, such as those of frames that move alike against each other, do not count.
    """
    sizes_m = {name: float(np.linalg.norm(one.amplitude)) for name, one in motions.items()}
    others_m = {name: float(np.linalg.norm(one.other)) for name, one in motions.items()}
    largest_m = max([*sizes_m.values(), *others_m.values()], default=0.0)
    for name, other_m in others_m.items():
        if other_m > max(sizes_m[name], SMALL_MOTION * largest_m):
            return name
    return ""


def relative_motions_m(run: RunReader) -> dict[str, Array]:
    """Return the displacement (rows, 3) of the second against the first, for every two frames."""
    frames = [name for name in run.case.screen.frames if run.has(f"frames/{name}")]
    moved_m = {name: run.read(f"frames/{name}/displacement_m") for name in frames}
    return {f"{two}-{one}": moved_m[two] - moved_m[one] for one, two in combinations(frames, 2)}


def why_not_settled(
    run: RunReader, start_s: float, end_s: float, drift_share: float | None, other: str
) -> str:
    """Return why the frames' motion from ``start_s`` to ``end_s`` has not settled; empty if it has.

    ``drift_share`` is the change of the first harmonics (``harmonics.drift``), and ``other`` names a motion
    that is mostly of other frequencies.  Other motions show in the range of each cycle, too, which is
    recorded from every sync point.
    """
    if not run.is_driven:
        return "nothing drives the machine: it has no steady motion"
    speeds_rad_per_s = run.shaft_speeds_rad_per_s(start_s, end_s)
    for name, speed_rad_per_s in speeds_rad_per_s.items():
        share = speed_rad_per_s / run.case.screen.exciters[name].speed_rad_per_s
        if share < SLOW_SHAFT:
            return (
                f"the motor of {name} turns its shaft at {speed_rad_per_s:.3g} rad/s, {share:.2g} of its "
                "speed_rad_per_s: it is too weak for this machine, or still runs up"
            )
    all_rad_per_s = {**named_speeds_rad_per_s(run.case), **speeds_rad_per_s}
    for (slow, slow_speed), (fast, fast_speed) in pairwise(sorted(all_rad_per_s.items(), key=itemgetter(1))):
        told = not {slow, fast} & set(speeds_rad_per_s)
        apart_rad, motors_apart = end_s * (fast_speed - slow_speed), fast_speed > (1 + APART) * slow_speed
        if fast_speed < BEATING * slow_speed and (apart_rad > OUT_OF_STEP_RAD if told else motors_apart):
            return (
                f"{slow} and {fast} turn at {slow_speed:.6g} and {fast_speed:.6g} rad/s: "
                f"{'' if told else 'they have not synchronised, and '}the motion beats"
            )
    for name in run.names("frames"):
        rows = run.read_cycles(f"point_cycles/{name}", start_s, end_s)
        range_m = np.linalg.norm(rows["most_m"] - rows["least_m"], axis=1)
        count = len(range_m)
        if count < FEWEST_CYCLES:
            cycles = f"{count} cycle{'' if count == 1 else 's'}"
            return f"averaged over {cycles}; {FEWEST_CYCLES} are needed to see it settle"
        early_m, late_m = range_m[: count // 2].mean(), range_m[-(count // 2) :].mean()
        changed = float(abs(late_m - early_m) / early_m) if early_m > 0 else 0.0
        if changed > LARGEST_DRIFT:
            return _describe_change(f"the range of {name} in a cycle", changed, count)
    if other:
        return (
            f"most of the motion of {other} is not of the cycle's frequency ({1 / run.cycle_s:.3g} Hz, that "
            "of the slowest exciter or drive): its amplitude is not the stroke"
        )
    if drift_share is not None and drift_share > LARGEST_DRIFT:
        return _describe_change("the first harmonic", drift_share, round((end_s - start_s) / run.cycle_s))
    return mats.why_not_settled(run, start_s, end_s)


def _describe_change(what: str, share: float, cycles: int) -> str:
    return (
        f"{what} still changes: by {100 * share:.3g} % from the first half of the {cycles} cycles to the "
        f"second; up to {100 * LARGEST_DRIFT:g} % counts as settled"
    )


def why_no_band(run: RunReader) -> str:
    """Return why the series show no accelerations up to BAND_HZ, although sync points would.

    The reason is empty if the series show them, or if sync points are as far apart as the rows.
    """
    time_s = run.series_s()
    if len(time_s) < 2:
        return "the series have one row only (output.series_s)"
    step_s = float(time_s[1] - time_s[0])
    if band_hz(step_s) == BAND_HZ or step_s < 1.5 * run.case.coupling.sync_interval_s:
        return ""
    return (
        f"the series have a row every {step_s:.2g} s: too seldom for accelerations up to "
        f"{BAND_HZ:g} Hz (output.series_s of at most {0.5 / BAND_HZ:.2g} s)"
    )


def acceleration_series(run: RunReader) -> dict[str, tuple[Array, Array]]:
    """Return times (n,) and accelerations (n, 3) in m/s2 of every frame's centre of mass, and of every probe
    on a frame or panel, by name.

    They come from the rows of the series, and show frequencies up to ``band_hz`` of their step.  A series of
    fewer than ``FEWEST_FILTERED`` rows has none, and so has one whose steps a resumed run has changed.
    """
    points = {name: f"frames/{name}" for name in run.names("frames")}
    on_machine = [name for name, probe in run.case.probes.items() if probe.particle is None]
    points |= {name: f"probes/{name}" for name in on_machine if run.has(f"probes/{name}")}
    table = {}
    for name, group in points.items():
        time_s = run.read(f"{group}/time_s")
        if len(time_s) < FEWEST_FILTERED or np.ptp(steps_s := np.diff(time_s)) > 1e-6 * steps_s[0]:
            continue
        velocity_m_per_s = run.read(f"{group}/velocity_m_per_s")
        table[name] = time_s, acceleration_m_per_s2(velocity_m_per_s, float(steps_s[0]))
    return table


def panel_points(
    run: RunReader, start_s: float, end_s: float, interval_of: IntervalOf
) -> dict[str, PointAcceleration]:
    """Return the accelerations of the probes on panels."""
    normals = {panel.name: panel.rectangle.normal for panel in single_panels(run.case)}
    table = {}
    for name, probe in run.case.probes.items():
        if probe.panel is None or not run.has(f"probes/{name}"):
            continue
        time_s = run.read(f"probes/{name}/time_s")
        step_s = float(time_s[1] - time_s[0])
        window = within(time_s, start_s, end_s, run.cycle_s)
        velocity_m_per_s = run.read(f"probes/{name}/velocity_m_per_s")
        acceleration = acceleration_m_per_s2(velocity_m_per_s, step_s)[window]
        quoted = acceleration_m_per_s2(velocity_m_per_s, step_s, QUOTED_HZ)[window]
        quoted_g = np.linalg.norm(quoted, axis=1) / STANDARD_GRAVITY_M_PER_S2
        size_g = np.linalg.norm(acceleration, axis=1) / STANDARD_GRAVITY_M_PER_S2
        normal_g = acceleration @ normals[probe.panel] / STANDARD_GRAVITY_M_PER_S2
        cycle = cycle_numbers(time_s[window], run.cycle_s, start_s)
        parts = [size_g[cycle == number] for number in np.unique(cycle)]
        squares = np.array([float(np.mean(part**2)) for part in parts])
        table[name] = PointAcceleration(
            panel=probe.panel,
            at=list(probe.at or ()),
            band_Hz=band_hz(step_s),
            peak_g=float(size_g.max()),
            rms_g=root(rms(size_g), mean(squares, interval_of)),
            peak_normal_g=float(np.abs(normal_g).max()),
            rms_normal_g=rms(normal_g),
            cycle_peak_g=mean(np.array([float(part.max()) for part in parts]), interval_of),
            cycle_peak_100_Hz_g=mean(
                np.array([float(quoted_g[cycle == number].max()) for number in np.unique(cycle)]), interval_of
            ),
        )
    return table


def rms(values: Array) -> float:
    """Return the root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))


def root(value: float, square: Estimate) -> Estimate:
    """Return the estimate of a root, ``value``, whose uncertainty follows from that of its square."""
    if not value:
        return Estimate(value, None, square.batches)
    half_width, error = (size and size / (2 * value) for size in (square.half_width, square.standard_error))
    return Estimate(value, half_width, square.batches, standard_error=error, reason=square.reason)


def run_down(run: RunReader) -> RunDown | None:
    """Return how far each frame swings while the machine runs down, None if no exciter does."""
    if run.stop_s >= run.end_s:
        return None
    frames = {}
    for name in run.case.screen.frames:
        group = f"point_cycles/{name}"
        if not run.has(group):
            continue
        time_s, farthest_m = run.read(f"{group}/time_s"), run.read(f"{group}/farthest_m")
        falls = time_s > run.stop_s * (1 + 1e-9)
        if not falls.any():
            continue
        before_m, after_m = farthest_m[~falls][-RANGE_CYCLES:], farthest_m[falls]
        frames[name] = FrameRunDown(
            running_m=float(before_m.max(initial=0.0)),
            peak_m=float(after_m.max()),
            peak_s=float(time_s[falls][after_m.argmax()]),
        )
    return RunDown(stop_s=run.stop_s, frames=frames)


def panel_loads(run: RunReader, start_s: float, end_s: float) -> dict[str, PanelMotion]:
    """Return pull on the clamps, load of the bed, stretch of the middle line and turns up of every panel.

    They come from every sync point of the cycles from ``start_s`` to ``end_s``.
    """
    cycles = {
        name: run.read_cycles(f"panel_cycles/{name}", start_s, end_s) for name in run.names("panel_cycles")
    }
    strains = {
        name: fatigue.strain_cycles(run, name, rows["stretch_least"], rows["stretch_most"])
        for name, rows in cycles.items()
    }
    ranks = fatigue.ranked({name: damage for name, (_, damage) in strains.items()})
    table = {}
    for name, rows in cycles.items():
        weight = rows["sync_points"] / rows["sync_points"].sum()
        turns_up_share, repeats_after_turns = mats.mat_turns(run, name, start_s, end_s)
        table[name] = PanelMotion(
            tension_mean_N=float(weight @ rows["pull_mean_N"]),
            tension_largest_N=float(rows["pull_most_N"].max()),
            tension_smallest_N=float(rows["pull_least_N"].min()),
            largest_clamp_force_N=float(rows["clamp_most_N"].max()),
            stretch_largest_percent=100 * float(rows["stretch_most"].max()),
            stretch_smallest_percent=100 * float(rows["stretch_least"].min()),
            load_N=weight @ rows["load_mean_N"] @ run.deck_axes,
            turns_up_share=turns_up_share,
            repeats_after_turns=repeats_after_turns,
            strain_range_percent=strains[name][0],
            fatigue_share=ranks[name],
        )
    return table


def point_ranges(run: RunReader) -> dict[str, PointRange]:
    """Return the ranges of motion of every frame's centre of mass and of every probe.

    Points on frames and panels are evaluated at every sync point.  A particle is evaluated at the rows of its
    series, as long as it is present.
    """
    table = {name: _range_of_point(run, f"point_cycles/{name}") for name in run.names("point_cycles")}
    for name in run.names("probes"):
        if name not in table:
            table[name] = _range_of_particle(run, f"probes/{name}")
    return table


def _range_of_point(run: RunReader, group: str) -> PointRange:
    rows = {name: run.read(f"{group}/{name}") for name in run.names(group)}
    last = last_cycles(rows["time_s"], run.cycle_s if run.is_driven else None)
    count = rows["sync_points"][last]
    return PointRange(
        half_range_m=(rows["most_m"][last].max(axis=0) - rows["least_m"][last].min(axis=0)) / 2,
        mean_m=count @ rows["mean_m"][last] / count.sum(),
        peak_m=float(rows["farthest_m"].max()),
        peak_speed_m_per_s=float(rows["fastest_m_per_s"].max()),
        reason="",
    )


def last_cycles(end_s: Array, cycle_s: float | None) -> slice:
    """Return the rows of the last ``RANGE_CYCLES`` whole cycles, among rows of cycles that end at ``end_s``.

    Return all rows if there are fewer whole cycles, or no cycles (``cycle_s`` is None).
    """
    if cycle_s is None:
        return slice(None)
    number = cycle_numbers(end_s, cycle_s)
    is_whole = abs(end_s[-1] - (number[-1] + 1) * cycle_s) < 1e-6 * cycle_s
    whole = int(number[-1]) + is_whole
    if whole < RANGE_CYCLES:
        return slice(None)
    return slice(*np.searchsorted(number, [whole - RANGE_CYCLES, whole]).tolist())


def _range_of_particle(run: RunReader, group: str) -> PointRange:
    time_s, place_m = run.read(f"{group}/time_s"), run.read(f"{group}/position_m")
    there = np.isfinite(place_m).all(axis=1)
    if not there.any():
        return _unknown_range("it never was there")
    span = "a cycle" if run.is_driven else "a fiftieth of the run,"
    if why := rows_too_seldom(time_s, run.cycle_s, run.case.coupling.sync_interval_s, span, 0):
        return _unknown_range(why)
    moved_m, time_s = place_m[there] - place_m[there][0], time_s[there]
    lasting_s = RANGE_CYCLES * run.cycle_s if run.is_driven else np.inf
    last_m = moved_m[time_s >= time_s[-1] - lasting_s]
    return PointRange(
        half_range_m=np.ptp(last_m, axis=0) / 2,
        mean_m=last_m.mean(axis=0),
        peak_m=float(np.linalg.norm(moved_m, axis=1).max()),
        peak_speed_m_per_s=float(np.linalg.norm(run.read(f"{group}/velocity_m_per_s")[there], axis=1).max()),
        reason="",
    )


def _unknown_range(why: str) -> PointRange:
    """Return the range of a point that is not known."""
    return PointRange(half_range_m=None, mean_m=None, peak_m=None, peak_speed_m_per_s=None, reason=why)
