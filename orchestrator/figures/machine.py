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
    """The first harmonic of a point in deck axes ([definition](theory/screening.md#amplitude-and-phase))."""

    amplitude_m: Numbers = figure("amplitude along x, y and z", shown_in="mm", resolution=1e-6)
    half_width_m: Numbers | None = figure(
        "half widths of its 95 % confidence intervals", "null with too few cycles"
    )
    phase_rad: Numbers = figure("phase", "of cos(ωt + φ), t from the run's start")
    major_m: float = figure("long half axis in the plane of x and z", shown_in="mm", resolution=1e-6)
    minor_m: float = figure("short half axis in that plane", "positive from x towards z")
    tilt_deg: float = figure("angle of the long axis from x towards z")
    other_m: Numbers = figure("half the range of the rest of the motion", shown_in="mm")


@dataclass(frozen=True, kw_only=True)
class RelativeOrbit(Orbit):
    """A frame against another one."""

    along_m: Estimate = figure("amplitude along the deck", "an estimate", shown_in="mm", resolution=1e-6)


@dataclass(frozen=True, kw_only=True)
class GroundForce:
    """The force of the bushings on the ground in world axes since t = 0, without the weight carried then."""

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
        "depends on the panel's cells ([why](theory/screening.md#machine))",
        resolution=1e-2,
        is_decisive=False,
    )
    cycle_peak_100_Hz_g: Estimate = figure(
        "mean peak of a cycle below 100 Hz",
        "the makers' band, in which blows hardly count",
        resolution=1e-2,
        is_decisive=False,
    )


@dataclass(frozen=True, kw_only=True)
class PanelMotion:
    """The panels, from every sync point; null where a drive or a line is missing."""

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
        (
            "share of cycles with the middle [farther](theory/mats.md#the-regime-of-a-mat) above the "
            "clamps' line than below"
        ),
        resolution=1e-2,
    )
    repeats_after_turns: int | None = figure(
        "repeats after turns", "cycles, up to 8, until places are alike within a tenth of their scatter"
    )
    strain_range_percent: float = figure(
        "strain range, mean", "of the middle line, by rainflow counting (ASTM E1049-85)"
    )
    fatigue_share: float | None = figure(
        "fatigue over the worst", "by the material's `fatigue` line (Miner's rule): a rank, not a life"
    )


@dataclass(frozen=True, kw_only=True)
class FrameRunDown:
    """The distance of a frame's centre of mass from its place at t = 0 while the machine stops."""

    running_m: float = figure("farthest while it runs", "two whole cycles before", shown_in="mm")
    peak_m: float = figure("farthest on the way down", shown_in="mm", is_decisive=False)
    peak_s: float = figure("end of the cycle with it")


@dataclass(frozen=True, kw_only=True)
class RunDown:
    """The swing of the frames while the machine stops (`screen.exciters.*.stop_s`)."""

    stop_s: float = figure("time at which the first exciter begins to run down")
    frames: dict[str, FrameRunDown] = figure(
        "for every frame", "distance of its centre of mass from its place at t = 0"
    )


@dataclass(frozen=True, kw_only=True)
class Motion:
    """The motion of the machine over whole cycles before an exciter stops."""

    start_s: float = figure(
        "beginning of the averaged whole cycles", "in the steady state, else in the second half"
    )
    end_s: float = figure("end of these cycles")
    cycles: int = figure("their number", "0 without a drive")
    is_settled: bool = figure(
        "whether the machine has settled", "its [conditions](theory/screening.md#machine)"
    )
    drift: float | None = figure(
        "drift",
        (
            "largest change of a first harmonic from the first half to the second, over the largest "
            "amplitude; four cycles"
        ),
    )
    reason: str = figure("why not, or empty")
    frames: dict[str, Orbit] = figure("each frame's centre of mass, and each probe on a frame", part="frames")
    relative: dict[str, RelativeOrbit] = figure(
        "each pair of frames, the second in the case against the first (`driven-driving`)", part="frames"
    )
    speed_rad_per_s: float | None = figure(
        "speed of the first harmonics",
        "of the slowest shaft or drive, with its motor's slip",
        optional=True,
        part="frames",
    )
    shafts_rad_per_s: dict[str, float] = figure("speed of the shaft", "mean, with a motor", part="frames")
    ground: GroundForce | None = figure(
        "force of the bushings on the ground",
        (
            "in world axes since t = 0, without the weight carried then; null without such bushings, "
            "with driven frames, without a drive"
        ),
        part="frames",
    )
    panel_points: dict[str, PointAcceleration] = figure(
        "panel acceleration", "of each probe on a panel", part="panels"
    )
    panels: dict[str, PanelMotion] = figure("each panel", part="panels")
    run_down: RunDown | None = figure(
        "swing while the machine stops", "null if no exciter does", part="frames"
    )


@dataclass(frozen=True, kw_only=True)
class PanelWear:
    """The wear of a panel."""

    worn_m3: float = figure("volume worn off since t = 0", is_extensive=True)
    mean_m_per_h: Estimate = figure("depth worn off, mean")
    largest_m_per_h: float = figure("depth worn off, deepest patch", resolution=1e-12, is_decisive=False)
    largest_at: Numbers = figure("middle of that patch", "shares of length and width")
    worn_through_h: float | None = figure("worn through after", "thickness over the largest rate")
    depth_m_per_h: Numbers = figure("depth worn off in patches", "8 along, 4 across")


@dataclass(frozen=True, kw_only=True)
class WearProfile:
    """Means across the width, along the deck."""

    along_m: Numbers = figure("distance along the deck")
    mean_m_per_h: Numbers = figure("depth worn off, mean across the width")


@dataclass(frozen=True, kw_only=True)
class Wear:
    """Depths per hour of operation, in the averaged cycles ([definitions](theory/wear.md))."""

    start_s: float = figure("first averaged output time", "in the steady state, else in the second half")
    end_s: float = figure("last one")
    panels: dict[str, PanelWear] = figure("each panel")
    profile: WearProfile | None = figure("means across the width", "null without a deck")


@dataclass(frozen=True, kw_only=True)
class Power:
    """Means over whole cycles, by the energy ledger ([definitions](theory/screening.md#power))."""

    start_s: float = figure("sync point at which the first cycle begins")
    end_s: float = figure("sync point at which the last one ends")
    drives_W: Estimate | None = figure(
        "power of the drives",
        "not if frames of `prescribed` have bushings with losses",
        optional=True,
        is_extensive=True,
        shown_in="kW",
        resolution=1e-3,
    )
    lost_W: dict[str, Estimate] = figure(
        "mean power of each loss", "by its name in the ledger without `lost.`", is_extensive=True
    )
    drives_J_per_kg: Estimate | None = figure(
        "work of the drives over the mass fed", "null if nothing was fed", optional=True, resolution=1e-3
    )


@dataclass(frozen=True, kw_only=True)
class PairInTime:
    """The stroke of two frames in windows."""

    along_m: list[float] = figure("amplitude along the deck", shown_in="mm")
    half_width_m: Numbers = figure("half widths")


@dataclass(frozen=True, kw_only=True)
class Course:
    """The stroke and the load in windows of twelve cycles; it needs two frames, a drive and three
    windows."""

    end_s: Numbers = figure("ends of the windows")
    relative: dict[str, PairInTime] = figure("each pair of frames")
    on_deck_kg: Numbers | None = figure("mass on the deck", optional=True, is_extensive=True)
    velocity_m_per_s: Numbers | None = figure("velocity of that mass", optional=True)


@dataclass(frozen=True, kw_only=True)
class PointRange:
    """The range of motion of a point, from all sync points, of a particle from its rows; null if unknown."""

    half_range_m: Numbers | None = figure(
        "half the range of the motion along x, y, z",
        "with all harmonics, in the last two cycles or the whole run; no amplitude",
    )
    mean_m: Numbers | None = figure("mean displacement along x, y, z over the same time")
    peak_m: float | None = figure(
        "largest displacement from the place at t = 0, over the whole run", is_decisive=False
    )
    peak_speed_m_per_s: float | None = figure("largest speed, over the whole run", is_decisive=False)
    reason: str = figure("why the four are null", "the particle was never there, or has too few rows")
