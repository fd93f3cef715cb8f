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
    """The [first harmonic](theory/screening.md#amplitude-and-phase) of centres of mass and probes on
    frames, in deck axes."""

    amplitude_m: Numbers = figure("amplitude along x, y and z", shown_in="mm", resolution=1e-6)
    half_width_m: Numbers | None = figure("half widths of its 95 % intervals")
    phase_rad: Numbers = figure("phase", "of cos(ωt + φ)")
    major_m: float = figure("long half axis in x and z", shown_in="mm", resolution=1e-6)
    minor_m: float = figure("short half axis", "positive from x to z")
    tilt_deg: float = figure("angle of the long axis from x to z")
    other_m: Numbers = figure("half range of the rest", shown_in="mm")


@dataclass(frozen=True, kw_only=True)
class RelativeOrbit(Orbit):
    """The second frame against the first (`driven-driving`)."""

    along_m: Estimate = figure("amplitude along the deck", shown_in="mm", resolution=1e-6)


@dataclass(frozen=True, kw_only=True)
class GroundForce:
    """The force of the bushings on the ground in world axes since t = 0, without the weight carried then."""

    amplitude_N: dict[str, Estimate] = figure(
        "amplitude of the first harmonic", is_extensive=True, shown_in="kN"
    )
    mean_N: Numbers = figure("mean over these cycles", is_extensive=True)
    largest_N: Numbers = figure(
        "largest distance from the mean, in series", is_extensive=True, is_decisive=False
    )


@dataclass(frozen=True, kw_only=True)
class PointAcceleration:
    """The acceleration of a probe on a panel, up to `band_Hz`."""

    panel: str = figure("panel")
    at: list[float] = figure("place as shares")
    band_Hz: float = figure("highest frequency", "500 or less")
    peak_g: float = figure("peak", is_decisive=False)
    rms_g: Estimate = figure("RMS", resolution=1e-3)
    peak_normal_g: float = figure("peak, normal", is_decisive=False)
    rms_normal_g: float = figure("RMS, normal")
    cycle_peak_g: Estimate = figure(
        "mean peak of a cycle",
        "depends on [cells](theory/screening.md#machine)",
        resolution=1e-2,
        is_decisive=False,
    )
    cycle_peak_100_Hz_g: Estimate = figure(
        "mean peak of a cycle below 100 Hz", "the makers' band", resolution=1e-2, is_decisive=False
    )


@dataclass(frozen=True, kw_only=True)
class PanelMotion:
    """The panels, from every sync point, in deck axes."""

    tension_mean_N: float = figure("pull on the clamps, mean", is_extensive=True, resolution=1e-2)
    tension_largest_N: float = figure(
        "pull on the clamps, most", is_extensive=True, resolution=1e-1, is_decisive=False
    )
    tension_smallest_N: float = figure("pull on the clamps, least", is_extensive=True)
    largest_clamp_force_N: float = figure("force on a clamp, most", is_extensive=True, is_decisive=False)
    stretch_largest_percent: float = figure("stretch, most", resolution=1e-3, is_decisive=False)
    stretch_smallest_percent: float = figure("stretch, least")
    load_N: Numbers = figure("mean load of the bed", is_extensive=True)
    turns_up_share: float | None = figure(
        "turns arched up",
        ("share of cycles with the middle [more](theory/mats.md#the-regime-of-a-mat) above than below"),
        resolution=1e-2,
    )
    repeats_after_turns: int | None = figure("repeats after turns", "cycles, up to 8, until places repeat")
    strain_range_percent: float = figure("strain range, mean", "of the middle line (rainflow, ASTM E1049-85)")
    fatigue_share: float | None = figure(
        "fatigue over the worst", "by Miner's rule and `fatigue`: a rank, not a life"
    )


@dataclass(frozen=True, kw_only=True)
class FrameRunDown:
    """The distance of a frame's centre of mass from its place at t = 0 while the machine stops."""

    running_m: float = figure("farthest while it runs", "in two cycles before", shown_in="mm")
    peak_m: float = figure("farthest on the way down", shown_in="mm", is_decisive=False)
    peak_s: float = figure("end of its cycle")


@dataclass(frozen=True, kw_only=True)
class RunDown:
    """The swing while the machine stops (`screen.exciters.*.stop_s`)."""

    stop_s: float = figure("time when the first exciter slows")
    frames: dict[str, FrameRunDown] = figure("for every frame", "centre of mass since t = 0")


@dataclass(frozen=True, kw_only=True)
class Motion:
    """The machine over whole cycles before an exciter stops."""

    start_s: float = figure("beginning of averaged cycles", "steady, else in the second half")
    end_s: float = figure("their end")
    cycles: int = figure("their number")
    is_settled: bool = figure("whether the machine has settled", "[conditions](theory/screening.md#machine)")
    drift: float | None = figure(
        "drift", ("change of a first harmonic from half to half, over the largest amplitude")
    )
    reason: str = figure("why not, or empty")
    frames: dict[str, Orbit] = figure("each frame's centre of mass, and probe on a frame", part="frames")
    relative: dict[str, RelativeOrbit] = figure(
        "each pair (`driven-driving`), the second against the first", part="frames"
    )
    speed_rad_per_s: float | None = figure(
        "speed of the first harmonics",
        "of the slowest shaft or drive, with slip",
        optional=True,
        part="frames",
    )
    shafts_rad_per_s: dict[str, float] = figure("speed of the shaft", "mean, with a motor", part="frames")
    ground: GroundForce | None = figure(
        "force of the bushings on the ground",
        ("in world axes, less the weight carried at t = 0; null with driven frames"),
        part="frames",
    )
    panel_points: dict[str, PointAcceleration] = figure("panel acceleration", "of probes", part="panels")
    panels: dict[str, PanelMotion] = figure("each panel", part="panels")
    run_down: RunDown | None = figure("swing while the machine stops", part="frames")


@dataclass(frozen=True, kw_only=True)
class PanelWear:
    """The wear of a panel."""

    worn_m3: float = figure("volume worn off since t = 0", is_extensive=True)
    mean_m_per_h: Estimate = figure("depth worn off, mean")
    largest_m_per_h: float = figure("depth worn off, deepest patch", resolution=1e-12, is_decisive=False)
    largest_at: Numbers = figure("its middle", "in shares")
    worn_through_h: float | None = figure("worn through after", "at the largest rate")
    depth_m_per_h: Numbers = figure("depth worn off in patches", "8 along, 4 across")


@dataclass(frozen=True, kw_only=True)
class WearProfile:
    """Means across the width, along the deck."""

    along_m: Numbers = figure("distance along the deck")
    mean_m_per_h: Numbers = figure("mean depth worn off")


@dataclass(frozen=True, kw_only=True)
class Wear:
    """Depths per hour of operation ([definitions](theory/wear.md))."""

    start_s: float = figure("first averaged time", "steady, else in the second half")
    end_s: float = figure("last one")
    panels: dict[str, PanelWear] = figure("each panel")
    profile: WearProfile | None = figure("means across the width")


@dataclass(frozen=True, kw_only=True)
class Power:
    """[Means](theory/screening.md#power) over whole cycles, by the energy ledger."""

    start_s: float = figure("first sync point")
    end_s: float = figure("last sync point")
    drives_W: Estimate | None = figure(
        "power of the drives",
        "without `prescribed` frames on lossy bushings",
        optional=True,
        is_extensive=True,
        shown_in="kW",
        resolution=1e-3,
    )
    lost_W: dict[str, Estimate] = figure(
        "mean power of each loss", "by [its name](#energy_ledger_j) without `lost.`", is_extensive=True
    )
    drives_J_per_kg: Estimate | None = figure(
        "work of the drives over the mass fed", optional=True, resolution=1e-3
    )


@dataclass(frozen=True, kw_only=True)
class PairInTime:
    """The stroke of two frames in windows."""

    along_m: list[float] = figure("amplitude along the deck", shown_in="mm")
    half_width_m: Numbers = figure("half widths")


@dataclass(frozen=True, kw_only=True)
class Course:
    """Stroke and load in windows of twelve cycles, if there are two frames and three windows."""

    end_s: Numbers = figure("ends of the windows")
    relative: dict[str, PairInTime] = figure("each pair of frames")
    on_deck_kg: Numbers | None = figure("mass on the deck", optional=True, is_extensive=True)
    velocity_m_per_s: Numbers | None = figure("velocity of that mass", optional=True)


@dataclass(frozen=True, kw_only=True)
class PointRange:
    """The range of motion of a point: from all sync points, of a particle from rows."""

    half_range_m: Numbers | None = figure(
        "half range along x, y, z", "of the last two cycles or the whole run; no amplitude"
    )
    mean_m: Numbers | None = figure("mean displacement then")
    peak_m: float | None = figure("largest displacement since t = 0", is_decisive=False)
    peak_speed_m_per_s: float | None = figure("largest speed", is_decisive=False)
    reason: str = figure("why they are null")
