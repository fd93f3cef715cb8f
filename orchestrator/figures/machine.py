"""The tables of the machine: motion of frames and panels, wear, power, and the course of a run.

docs/theory/screening.md, docs/theory/mats.md and docs/theory/wear.md have the definitions.
"""

from __future__ import annotations

from dataclasses import dataclass

from orchestrator.figures.estimate import Estimate
from orchestrator.figures.figure import figure
from orchestrator.figures.material import Numbers


@dataclass(frozen=True, kw_only=True)
class Orbit:
    """The first harmonic of a point's motion in deck axes.

    [Definition](theory/screening.md#amplitude-and-phase).
    """

    amplitude_m: Numbers = figure("amplitude along x, y and z", shown_in="mm", resolution=1e-6)
    half_width_m: Numbers | None = figure(
        "the half widths of its 95 % confidence intervals", "null with too few cycles"
    )
    phase_rad: Numbers = figure("phase", "of cos(ωt + φ), t from the start of the run")
    major_m: float = figure(
        "long half axis in the plane of x and z", "of the ellipse", shown_in="mm", resolution=1e-6
    )
    minor_m: float = figure("short half axis in that plane", "positive if the point turns from x towards z")
    tilt_deg: float = figure("the angle by which the long axis is turned from x towards z")
    other_m: Numbers = figure("half the range of the rest of the motion", shown_in="mm")


@dataclass(frozen=True, kw_only=True)
class RelativeOrbit(Orbit):
    """The same of a frame against another one."""

    along_m: Estimate = figure(
        "amplitude along the deck", "again, as an estimate", shown_in="mm", resolution=1e-6
    )


@dataclass(frozen=True, kw_only=True)
class GroundForce:
    """The force of the bushings on the ground, in the world's axes with z upwards.

    It counts from t = 0, as the forces of bushings do: add the weight that they carry then.
    """

    amplitude_N: dict[str, Estimate] = figure(
        "amplitude of the first harmonic", "along `x`, `y`, `z`", is_extensive=True, shown_in="kN"
    )
    mean_N: Numbers = figure("mean over these cycles", is_extensive=True)
    largest_N: Numbers = figure(
        "largest distance from the mean in a row of the series", is_extensive=True, is_decisive=False
    )


@dataclass(frozen=True, kw_only=True)
class PointAcceleration:
    """The acceleration of a probe on a panel, band-limited to `band_Hz`."""

    panel: str = figure("panel")
    at: list[float] = figure("place along and across, in shares")
    band_Hz: float = figure("highest frequency", "500, or what the sync interval allows")
    peak_g: float = figure("peak", is_decisive=False)
    rms_g: Estimate = figure("RMS", resolution=1e-3)
    peak_normal_g: float = figure("peak, normal", is_decisive=False)
    rms_normal_g: float = figure("RMS, normal")
    cycle_peak_g: Estimate = figure(
        "mean peak of a cycle",
        "Peaks hang on the panel's cells more than anything else does: 127, 95 and 85 g with strips of "
        "16, 32 "
        "and 48 cells in a machine with taut panels of 0.42 m, whose strokes and rms agree within some per "
        "cent; their intervals do not tell of it, `flipflow study accuracy` does",
        resolution=1e-2,
        is_decisive=False,
    )
    cycle_peak_100_Hz_g: Estimate = figure(
        "mean peak of a cycle below 100 Hz",
        "the band that makers quote and in which the blows of stones hardly count",
        resolution=1e-2,
        is_decisive=False,
    )


@dataclass(frozen=True, kw_only=True)
class PanelMotion:
    """The pull, stretch, load and turns of a panel, from every sync point."""

    tension_mean_N: float = figure("pull on the clamps, mean", is_extensive=True, resolution=1e-2)
    tension_largest_N: float = figure(
        "pull on the clamps, most", is_extensive=True, resolution=1e-1, is_decisive=False
    )
    tension_smallest_N: float = figure("pull on the clamps, least", is_extensive=True)
    largest_clamp_force_N: float = figure("force on a clamp, most", is_extensive=True, is_decisive=False)
    stretch_largest_percent: float = figure("stretch, most", resolution=1e-3, is_decisive=False)
    stretch_smallest_percent: float = figure("stretch, least")
    load_N: Numbers = figure("mean load of the bed", "in deck axes", is_extensive=True)
    turns_up_share: float | None = figure(
        "turns arched up",
        "the share of cycles in which the middle is farther above the line between the clamps than "
        "below, and "
        "at least 2 % of the length above it; null without a drive ([theory/mats.md]"
        "(theory/mats.md#the-regime-of-a-mat))",
        resolution=1e-2,
    )
    repeats_after_turns: int | None = figure(
        "repeats after turns",
        "the number of cycles, up to 8, after which its lowest and highest places are alike within a "
        "tenth of "
        "their scatter; null if there is none, and without a drive",
    )
    strain_range_percent: float = figure(
        "strain range, mean",
        "of the middle line, by rainflow counting (ASTM E1049-85) of the lowest and highest strain of each "
        "cycle",
    )
    fatigue_share: float | None = figure(
        "fatigue over the worst",
        "the damage by the line of the panel's material (`materials.*.fatigue`; Miner's rule) over that "
        "of the "
        "worst panel, null without a line: a rank, not a life",
    )


@dataclass(frozen=True, kw_only=True)
class FrameRunDown:
    """How far a frame swings while the machine stops.

    Distances of its centre of mass from its place at t = 0.
    """

    running_m: float = figure("farthest while it runs", "in the last two whole cycles before", shown_in="mm")
    peak_m: float = figure(
        "farthest on the way down", "in all later cycles", shown_in="mm", is_decisive=False
    )
    peak_s: float = figure("the end of the cycle with it")


@dataclass(frozen=True, kw_only=True)
class RunDown:
    """How far the frames swing while the machine stops (`screen.exciters.*.stop_s`)."""

    stop_s: float = figure("the time at which the first exciter begins to run down")
    frames: dict[str, FrameRunDown] = figure("for every frame")


@dataclass(frozen=True, kw_only=True)
class Motion:
    """The motion of the machine over whole cycles.

    All means but those of `run_down` are of cycles before an exciter stops.
    """

    start_s: float = figure(
        "the beginning of the averaged whole cycles", "in the steady state, or else in the run's second half"
    )
    end_s: float = figure("the end of these cycles")
    cycles: int = figure("their number", "0 where nothing drives the machine")
    is_settled: bool = figure(
        "whether the machine has settled",
        "from the first half of these cycles to the second, neither the range of any frame in a cycle "
        "nor any "
        "first harmonic (`drift`) changes by more than 5 %; no motion is mostly of another frequency "
        "than the "
        "cycle's; no two shafts with motors turn at speeds that differ by 0.5 to 50 %; no motor turns its "
        "shaft at less than 0.8 of its `speed_rad_per_s`; and no mat arches up in more turns, or moves "
        "farther "
        "(by a tenth), in one half of these cycles than in the other, beyond chance (eight cycles or more; "
        "Fisher's exact test and Welch's test at 1 % for all mats together)",
    )
    drift: float | None = figure(
        "drift",
        "the largest change, in amplitude or phase, of any first harmonic of `frames` from the first half of "
        "these cycles to the second, over the largest amplitude; null with fewer than four cycles",
    )
    reason: str = figure("why the machine has not settled", "empty if it has")
    frames: dict[str, Orbit] = figure(
        "for every frame's centre of mass and every probe on a frame", part="frames"
    )
    relative: dict[str, RelativeOrbit] = figure(
        "for each pair of frames, the second in the case against the first (`driven-driving`)", part="frames"
    )
    speed_rad_per_s: float | None = figure(
        "the speed of the first harmonics",
        "that of the slowest drive or exciter, by the shaft's own speed where a motor turns it. The cycles "
        "themselves are counted by the exciter's `speed_rad_per_s`",
        optional=True,
        part="frames",
    )
    shafts_rad_per_s: dict[str, float] = figure(
        "speed of the shaft", "mean in these cycles, for every exciter with a motor", part="frames"
    )
    ground: GroundForce | None = figure(
        "the force of the bushings on the ground",
        "null without bushings on the ground, where a frame moves as prescribed, and where nothing "
        "drives the "
        "machine",
        part="frames",
    )
    panel_points: dict[str, PointAcceleration] = figure(
        "panel acceleration", "for every probe on a panel", part="panels"
    )
    panels: dict[str, PanelMotion] = figure("for every panel", part="panels")
    run_down: RunDown | None = figure(
        "how far each frame swings while the machine stops", "null if no exciter does", part="frames"
    )


@dataclass(frozen=True, kw_only=True)
class PanelWear:
    """The wear of a panel."""

    worn_m3: float = figure("volume worn off since t = 0", is_extensive=True)
    mean_m_per_h: Estimate = figure("depth worn off, mean")
    largest_m_per_h: float = figure("depth worn off, deepest patch", resolution=1e-12, is_decisive=False)
    largest_at: Numbers = figure("the middle of that patch", "shares of length and width")
    worn_through_h: float | None = figure("worn through after", "the thickness over the largest rate")
    depth_m_per_h: Numbers = figure("depth worn off in patches", "8 along, 4 across")


@dataclass(frozen=True, kw_only=True)
class WearProfile:
    """Means across the width, along the deck."""

    along_m: Numbers = figure("distance along the deck")
    mean_m_per_h: Numbers = figure("depth worn off, mean across the width")


@dataclass(frozen=True, kw_only=True)
class Wear:
    """Depths in metres per hour of operation, from the averaged cycles.

    [theory/wear.md](theory/wear.md) has the definitions.
    """

    start_s: float = figure(
        "the first averaged output time", "in the steady state, or else in the run's second half"
    )
    end_s: float = figure("the last one")
    panels: dict[str, PanelWear] = figure("for every panel")
    profile: WearProfile | None = figure("means across the width", "null for panels that form no deck")


@dataclass(frozen=True, kw_only=True)
class Power:
    """Means over whole cycles, from the energy ledger at their ends.

    [Definitions](theory/screening.md#power).
    """

    start_s: float = figure("the sync point at which the first cycle begins")
    end_s: float = figure("the sync point at which the last one ends")
    drives_W: Estimate | None = figure(
        "power of the drives",
        "mean of all exciters, motors and drives; not where frames move as told (`prescribed`) "
        "and have "
        "bushings with damping or curves, whose losses are in no account",
        optional=True,
        is_extensive=True,
        shown_in="kW",
        resolution=1e-3,
    )
    lost_W: dict[str, Estimate] = figure(
        "mean power of each loss", "by its name in the ledger without `lost.`", is_extensive=True
    )
    drives_J_per_kg: Estimate | None = figure(
        "work of the drives over the mass fed",
        "in the same cycles; its value is null if nothing was fed in them. It exists only in runs that count "
        "particles in and out",
        optional=True,
        resolution=1e-3,
    )


@dataclass(frozen=True, kw_only=True)
class PairInTime:
    """The stroke of two frames in windows."""

    along_m: list[float] = figure("amplitude along the deck", shown_in="mm")
    half_width_m: Numbers = figure("half widths")


@dataclass(frozen=True, kw_only=True)
class Course:
    """How the stroke follows the load over the whole run, in windows of twelve cycles.

    It needs two frames, a drive and three windows.
    """

    end_s: Numbers = figure("the ends of the windows")
    relative: dict[str, PairInTime] = figure("for each pair of frames")
    on_deck_kg: Numbers | None = figure("mass on the deck", optional=True, is_extensive=True)
    velocity_m_per_s: Numbers | None = figure("velocity of that mass", optional=True)


@dataclass(frozen=True, kw_only=True)
class PointRange:
    """The range of motion of a probe.

    For points on frames and panels, the figures come from all sync points, however seldom rows are written.
    For a particle, they come from the rows of its series in the time in which it is present. An unknown
    figure is `null`.
    """

    half_range_m: Numbers | None = figure(
        "half the range of the motion along x, y, z",
        "with all harmonics, over the last two whole cycles of the machine; over the whole of a run that is "
        "shorter or that nothing drives. It is not an amplitude; `results.motion.frames` has the amplitude",
    )
    mean_m: Numbers | None = figure("the mean displacement along x, y, z over the same time")
    peak_m: float | None = figure(
        "the largest displacement from the place at t = 0, over the whole run", is_decisive=False
    )
    peak_speed_m_per_s: float | None = figure("the largest speed, over the whole run", is_decisive=False)
    reason: str = figure(
        "why the four are null",
        "the particle was never present, or its series have fewer than 20 rows in a cycle and are not "
        "written "
        "at every sync point; else empty",
    )
