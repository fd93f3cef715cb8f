"""Values of the wrong size: in SI no machine has them, in another unit one would.

Not a physical limit but a guard against millimetres, tonnes and degrees: the ranges are wide.  A
value out of its range is refused where it looks like another unit, where it is beyond all
proportion (``ABSURD`` times out of the range), and where no such value exists (``IMPOSSIBLE``).
Else it may be meant, as a panel of steel is, and is a warning.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from orchestrator.case.file.errors import CaseProblem, Key, dotted
from orchestrator.case.tables.case import Case

ABSURD = 1e3
IMPOSSIBLE = ("inclination_deg", "rayleigh_fraction")  # outside of their ranges
DIRECTION = (0.0, 1e3)  # of any length; nobody writes a huge one
# key: (smallest, largest) size of a value that is not zero
RANGES: dict[str, tuple[float, float]] = {
    "duration_s": (1e-6, 1e4),
    "position_m": (0.0, 100.0),
    "positions_m": (0.0, 100.0),
    "corner_m": (0.0, 100.0),
    "center_m": (0.0, 100.0),
    "center_of_mass_m": (0.0, 100.0),
    "point_m": (0.0, 100.0),
    "box_m": (0.0, 100.0),
    "gravity_m_per_s2": (0.0, 100.0),
    "domain_m": (0.0, 100.0),
    "density_kg_per_m3": (50.0, 25e3),
    "youngs_modulus_Pa": (1e4, 2e12),
    "c10_Pa": (1e3, 1e9),
    "c01_Pa": (1e3, 1e9),
    "bulk_modulus_Pa": (1e5, 1e12),
    "relaxation_s": (1e-7, 1e3),
    "mass_kg": (0.1, 1e5),
    "inertia_kg_m2": (1e-4, 1e6),
    "products_of_inertia_kg_m2": (0.0, 1e6),
    "stiffness_N_per_m": (10.0, 1e10),
    "damping_N_s_per_m": (0.0, 1e7),
    "speed_rad_per_s": (0.1, 1e3),
    "mass_moment_kg_m": (1e-5, 1e3),
    "rated_power_W": (1.0, 1e6),
    "synchronous_speed_rad_per_s": (1.0, 1e3),
    "moment_of_inertia_kg_m2": (1e-6, 1e3),
    "bearing_loss_N_m_s": (0.0, 1e3),
    "amplitude_m": (0.0, 0.2),
    "rotation_rad": (0.0, 1.6),
    "stiffness_Pa_per_m": (1e3, 1e13),
    "inclination_deg": (0.0, 90.0),
    "length_m": (0.01, 5.0),
    "width_m": (0.005, 10.0),
    "thickness_m": (2e-4, 0.05),
    "clamp_m": (1e-4, 0.5),
    "tension_m": (0.0, 0.1),
    "span_m": (0.01, 5.0),
    "from_m": (0.0, 5.0),
    "to_m": (1e-3, 5.0),
    "pitch_m": (0.01, 10.0),
    "pitch_along_m": (1e-4, 1.0),
    "pitch_across_m": (1e-4, 1.0),
    "margin_along_m": (0.0, 5.0),
    "margin_across_m": (0.0, 10.0),
    "diameter_m": (2e-5, 0.5),
    "smallest_m": (2e-5, 0.5),
    "largest_m": (2e-5, 0.5),
    "velocity_m_per_s": (0.0, 50.0),
    "spin_rad_per_s": (0.0, 1e6),
    "rate_kg_per_s": (1e-6, 1e3),
    "work_of_adhesion_J_per_m2": (1e-4, 1e2),
    "specific_wear_m3_per_N_m": (1e-18, 1e-7),
    "sjkr_diameter_m": (2e-5, 0.5),
    "sync_interval_s": (1e-7, 0.02),
    "step_s": (1e-10, 0.02),
    "feed_interval_s": (0.0, 10.0),
    "interval_s": (1e-7, 1e4),
    "series_s": (1e-7, 1e4),
    "shapes_s": (1e-7, 1e4),
    "every_s": (1e-7, 1e4),
    "wall_min": (1e-3, 1e5),
    "jam_s": (1e-6, 1e4),
    "calm_s": (1e-6, 1e4),
    "start_s": (0.0, 1e4),
    "stop_s": (1e-6, 1e4),
    "run_up_s": (0.0, 1e4),
    "phase_rad": (0.0, 100.0),
    "rotation_phase_rad": (0.0, 100.0),
    "rotation_deg": (0.0, 360.0),
    "edges_m": (0.0, 100.0),
    "along": DIRECTION,
    "across": DIRECTION,
    "axis": DIRECTION,
    "start": DIRECTION,
    "height_m": (1e-3, 10.0),
    "depth_m": (0.0, 10.0),
    "gap_m": (0.0, 1.0),
    "drop_m": (0.0, 10.0),
    "smallest_fed_m": (2e-5, 0.5),
    "cut_size_m": (2e-5, 0.5),
    "largest_youngs_modulus_Pa": (1e4, 2e12),
    "sliding_friction": (0.0, 10.0),
    "rolling_friction": (0.0, 10.0),
    "ratio": (1e-9, 1e3),
    "rayleigh_fraction": (1e-4, 1.0),
}
OF_APERTURES = {"length_m": (1e-4, 1.0), "width_m": (1e-4, 1.0)}  # smaller than panels are
# unit: what it may have been mistaken for, and that unit in SI
MISTAKEN: dict[str, dict[str, float]] = {
    "_m": {"mm": 1e-3, "cm": 1e-2, "um": 1e-6},
    "_kg": {"g": 1e-3, "t": 1e3},
    "_kg_per_m3": {"g/cm3": 1e3},
    "_kg_m2": {"kg mm2": 1e-6},
    "_kg_m": {"kg mm": 1e-3},
    "_Pa": {"MPa": 1e6, "GPa": 1e9},
    "_Pa_per_m": {"MPa/mm": 1e9, "N/mm3": 1e9},
    "_J_per_m2": {"mJ/m2": 1e-3},
    "_m3_per_N_m": {"mm3/(N m)": 1e-9},
    "_N_per_m": {"N/mm": 1e3, "kN/m": 1e3},
    "_rad_per_s": {"rpm": 0.10472, "Hz": 6.28319},
    "_rad": {"degrees": 0.0174533},
    "_s": {"ms": 1e-3, "us": 1e-6},
    "_m_per_s": {"mm/s": 1e-3},
    "_m_per_s2": {"cm/s2": 1e-2, "mm/s2": 1e-3},
    "_kg_per_s": {"t/h": 0.277778},
}


def wrong_sizes(case: Case) -> Iterator[CaseProblem]:
    """Values out of their key's range that must be mistakes, with the unit that they look like."""
    for key, name, value, limits in _outside(case.model_dump(), ()):
        hint = _hint(name, value, limits)
        if hint or name in IMPOSSIBLE or not _inside(value, _widened(limits)):
            yield CaseProblem(key, f"{value:g} is out of the range {_range(limits)}", hint)


def unusual_sizes(case: Case) -> Iterator[str]:
    """Every other value out of its key's range, in words."""
    for key, name, value, limits in _outside(case.model_dump(), ()):
        hint = _hint(name, value, limits)
        if not hint and name not in IMPOSSIBLE and _inside(value, _widened(limits)):
            what = f"{value:g} is out of the usual range {_range(limits)}; taken as meant"
            yield f"{dotted(key)}: {what}"


def _outside(value: Any, key: Key) -> Iterator[tuple[Key, str, float, tuple[float, float]]]:
    """Key, its last name, value and range of every value that is out of its range."""
    if isinstance(value, dict):
        for name, inner in value.items():
            yield from _outside(inner, (*key, name))
    elif isinstance(value, tuple):
        for number, inner in enumerate(value):
            yield from _outside(inner, (*key, number))
    elif isinstance(value, float):
        name = next(part for part in reversed(key) if isinstance(part, str))
        ranges = RANGES | OF_APERTURES if "apertures" in key else RANGES
        if name in ranges and value != 0 and not _inside(value, ranges[name]):
            yield key, name, value, ranges[name]


def _widened(limits: tuple[float, float]) -> tuple[float, float]:
    return limits[0] / ABSURD, limits[1] * ABSURD


def _inside(value: float, limits: tuple[float, float]) -> bool:
    return limits[0] <= abs(value) <= limits[1]


def _range(limits: tuple[float, float]) -> str:
    low, high = limits
    return f"{low:g} to {high:g}" if low else f"up to {high:g}"


def _hint(name: str, value: float, limits: tuple[float, float]) -> str:
    unit = max((unit for unit in MISTAKEN if name.endswith(unit)), key=len, default="")
    for other, factor in MISTAKEN.get(unit, {}).items():
        if _inside(value * factor, limits):
            return f"looks like {other}: that is {value * factor:g} in {name}"
    return ""
