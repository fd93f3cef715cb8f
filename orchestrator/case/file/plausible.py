"""The plausible ranges of values, which reveal numbers that were given in the wrong unit.

The ranges are wide: they are no physical limits, but guard against millimetres, tonnes and degrees.
A value out of its range is refused in three cases: it looks like another unit, it is out of all
proportion (``ABSURD`` times out of the range), or no such value exists (``IMPOSSIBLE``).  Any other
value out of its range may be intended, for example the stiffness of a steel panel, and causes a warning.
"""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.case.file.errors import CaseProblem, Key, dotted_key
from orchestrator.case.file.nested import leaves
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.quantities import unit_of

Limits = tuple[float, float]
ABSURD = 1e3
IMPOSSIBLE = ("inclination_deg", "rayleigh_fraction")  # No value exists outside of these ranges.
# The smallest and largest size of a value that is not zero, and the keys with this range.
_KEYS: dict[Limits, str] = {
    (1e-6, 1e4): "duration_s jam_s calm_s stop_s",
    (0.0, 100.0): (
        "position_m positions_m corner_m center_m center_of_mass_m point_m box_m gravity_m_per_s2 "
        "domain_m move_m phase_rad rotation_phase_rad rotation_rad edges_m"
    ),
    (50.0, 25e3): "density_kg_per_m3",
    (5e-6, 5e-5): "viscosity_Pa_s",
    (1e4, 2e12): "youngs_modulus_Pa largest_youngs_modulus_Pa",
    (1e3, 1e9): "c10_Pa c01_Pa",
    (1e5, 1e12): "bulk_modulus_Pa",
    (1e-7, 1e3): "relaxation_s",
    (0.1, 1e5): "mass_kg",
    (1e-4, 1e6): "inertia_kg_m2",
    (0.0, 1e6): "products_of_inertia_kg_m2 spin_rad_per_s",
    (10.0, 1e10): "stiffness_N_per_m elastic_N_per_m",
    (1e-9, 0.2): "slip_m",
    (0.0, 0.5): "deformation_m",
    (0.0, 1e7): "damping_N_s_per_m force_N",
    (0.0, 150.0): "works_at_degC measured_degC",
    (0.01, 100.0): "stiffness_ratio",
    (0.1, 1e3): "speed_rad_per_s",
    (1e-5, 1e3): "mass_moment_kg_m",
    (1.0, 1e6): "rated_power_W",
    (1e2, 1e8): "dynamic_rating_N",
    (1.0, 1e3): "synchronous_speed_rad_per_s",
    (1e-6, 1e3): "moment_of_inertia_kg_m2 rate_kg_per_s",
    (0.0, 1e3): "bearing_loss_N_m_s along across axis start",  # Directions may have any length.
    (0.0, 0.2): "amplitude_m",
    (0.0, 1.6): "rotation_rad",
    (1e3, 1e13): "stiffness_Pa_per_m",
    (0.0, 90.0): "inclination_deg clamp_angle_deg",
    (0.01, 5.0): "length_m span_m",
    (0.005, 10.0): "width_m",
    (2e-4, 0.05): "thickness_m",
    (1e-7, 0.05): "tolerance_m",
    (1e-4, 0.5): "clamp_m",
    (0.0, 0.1): "tension_m moulded_sag_m",
    (0.0, 5.0): "from_m margin_along_m",
    (1e-3, 5.0): "to_m",
    (0.01, 10.0): "pitch_m",
    (1e-4, 1.0): "pitch_along_m pitch_across_m rayleigh_fraction sensor_kg",
    (0.0, 10.0): "margin_across_m feed_interval_s depth_m drop_m sliding_friction rolling_friction",
    (2e-5, 0.5): "sieve_size_m smallest_m largest_m smallest_fed_m sampled_below_m sampled_as_m cut_size_m "
    "sjkr_diameter_m bond_diameter_m",
    (0.0, 50.0): "velocity_m_per_s",
    (1e-4, 100.0): "work_of_adhesion_J_per_m2",
    (1e-18, 1e-7): "specific_wear_m3_per_N_m",
    (1e-7, 0.02): "sync_interval_s",
    (1e-10, 0.02): "step_s",
    (1e-7, 1e4): "interval_s series_s shapes_s loads_s every_s",
    (1e-3, 1e5): "wall_min",
    (0.0, 1e4): "start_s stop_s run_up_s run_down_s from_time_s",
    (0.0, 360.0): "rotation_deg",
    (1e-3, 10.0): "height_m",
    (0.0, 1.0): "gap_m",
    (1e-9, 1e3): "ratio",
    (1e-9, 1e6): "scale",
    (1e-5, 1.0): "strain_amplitude",
    (1.0, 1e15): "cycles",
    (0.01, 50.0): "slope",
}
RANGES = {key: limits for limits, keys in _KEYS.items() for key in keys.split()}
OF_APERTURES = {"length_m": (1e-4, 1.0), "width_m": (1e-4, 1.0)}  # Openings are smaller than panels.
OF_AIR = {"density_kg_per_m3": (0.5, 2.0)}  # Up to 5000 m, and from -70 to 400 degrees Celsius.
# The units that each SI unit may have been mistaken for, in that SI unit.
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
    """Yield a problem for each value that must be a mistake, with the unit that it looks like."""
    for key, value, limits, hint, refused in _outside(case):
        if refused:
            what = f"{value:g} is out of the range {_range(limits)}{_in_unit(key)}"
            yield CaseProblem(key, what, hint, guesses_unit=bool(hint), kind="out-of-range")


def unusual_sizes(case: Case) -> Iterator[str]:
    """Yield a warning for each value that is out of its key's range but may be intended."""
    for key, value, limits, _, refused in _outside(case):
        if not refused:
            usual = f"{_range(limits)}{_in_unit(key)}"
            yield f"{dotted_key(key)}: {value:g} is out of the usual range {usual}; taken as meant"


def _outside(case: Case) -> Iterator[tuple[Key, float, Limits, str, bool]]:
    """Yield key, value, range and hint of each value out of its range, and whether to refuse it."""
    for key, value in leaves(case.model_dump()):
        if not isinstance(value, float):
            continue
        name = next(part for part in reversed(key) if isinstance(part, str))
        special = OF_APERTURES if "apertures" in key else OF_AIR if "air" in key else {}
        limits = (RANGES | special).get(name)
        if limits is not None and value != 0 and not _inside(value, limits):
            hint = _hint(name, value, limits)
            widened = (limits[0] / ABSURD, limits[1] * ABSURD)
            yield key, value, limits, hint, bool(hint) or name in IMPOSSIBLE or not _inside(value, widened)


def _inside(value: float, limits: Limits) -> bool:
    return limits[0] <= abs(value) <= limits[1]


def _range(limits: Limits) -> str:
    low, high = limits
    return f"{low:g} to {high:g}" if low else f"up to {high:g}"


def _in_unit(key: Key) -> str:
    """Return the unit of a key after a blank; "" for a key without one."""
    unit = unit_of(next(part for part in reversed(key) if isinstance(part, str)), "")
    return f" {unit}" if unit else ""


def _hint(name: str, value: float, limits: Limits) -> str:
    """Return a hint at the unit in which a value would be within its range; "" if there is none."""
    unit = max((unit for unit in MISTAKEN if name.endswith(unit)), key=len, default="")
    for other, factor in MISTAKEN.get(unit, {}).items():
        if _inside(value * factor, limits):
            return f"looks like {other}: if so, write {value * factor:g}"
    return ""
