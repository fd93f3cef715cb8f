"""Units by the ends of names."""

from __future__ import annotations


def unit_of(name: str) -> str:
    """The unit that a name carries: position_m -> m, speed_m_s -> m/s, force_N -> N."""
    for ending, unit in _UNITS.items():
        if name.endswith(ending):
            return unit
    return "1"


_UNITS = {
    "_kg_m_s": "kg m/s",
    "_kg_m3": "kg/m3",
    "_m_s2": "m/s2",
    "_rad_s": "rad/s",
    "_kg_s_m": "kg/(s m)",
    "_kg_s": "kg/s",
    "_kg_m": "kg/m",
    "_percent": "%",
    "_deg": "degree",
    "_rad": "rad",
    "_g": "9.80665 m/s2",
    "_Hz": "Hz",
    "_N_s": "N s",
    "_m_s": "m/s",
    "_m_h": "m/h",
    "_m3": "m3",
    "_kg": "kg",
    "_J": "J",
    "_N": "N",
    "_s": "s",
    "_h": "h",
    "_m": "m",
}
