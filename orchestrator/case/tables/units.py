"""The units that end the names of keys, and the keys of numbers without one."""

from __future__ import annotations

# by the end of a key; the longest that fits counts
UNITS = {
    "_min": "min",
    "_m": "m",
    "_m_s": "m/s",
    "_m_s2": "m/s2",
    "_s": "s",
    "_kg": "kg",
    "_kg_s": "kg/s",
    "_kg_m": "kg m",
    "_kg_m2": "kg m2",
    "_kg_m3": "kg/m3",
    "_J_m2": "J/m2",
    "_Pa": "Pa",
    "_Pa_m": "Pa/m",
    "_N_m": "N/m",
    "_N_s_m": "N s/m",
    "_m3_N_m": "m3/(N m)",
    "_rad": "rad",
    "_rad_s": "rad/s",
    "_deg": "degree",
    "_Hz": "Hz",
    "_W": "W",
    "_N_m_s": "N m s",
}
DIMENSIONLESS = frozenset(
    {
        "along",
        "across",
        "axis",
        "stagger",
        "start",
        "at",
        "passing",
        "poisson_ratio",
        "ratio",
        "restitution",
        "sliding_friction",
        "rolling_friction",
        "rayleigh_fraction",
        "coarse_graining",
        "damping_ratio",
        "mass_fraction",
        "loss_factor",
        "storage_ratio",
        "rated_slip",
        "breakdown_ratio",
        "tolerance",
        "largest_created_share",
        "largest_created_in_total",
        "largest_growing_share",
        "largest_stretch",
        "largest_overlap",
        "largest_penetration",
        "largest_step_share",
    }
)


def unit(key: str) -> str:
    """The unit that a key's name ends with; empty without one."""
    ends = [end for end in UNITS if key.endswith(end)]
    return UNITS[max(ends, key=len)] if ends and key not in DIMENSIONLESS else ""
