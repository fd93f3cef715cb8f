"""The unit that a name carries at its end.

Units that multiply stand side by side, those that divide stand after ``per``: ``force_N``,
``damping_N_s_per_m``, ``rate_kg_per_s_m`` (kilograms per second and metre).  Names of keys, columns
and results follow this one rule.
"""

from __future__ import annotations

import re

_UNIT = r"(?:m|mm|kg|s|min|h|N|J|W|Pa|Hz|rad|deg|percent|g)\d?"
_END = re.compile(rf"(?:^|_)({_UNIT}(?:_{_UNIT})*)(?:_per_({_UNIT}(?:_{_UNIT})*))?$")
_WRITTEN = {"deg": "degree", "percent": "%", "g": "9.80665 m/s2"}


def unit_of(name: str, without: str = "1") -> str:
    """The unit of a name: ``velocity_m_per_s`` has m/s, ``wear_m3_per_N_m`` m3/(N m).

    A name that ends in no unit belongs to a pure number and has the unit ``without``.
    """
    end = _END.search(name)
    if end is None:
        return without
    above, below = end.groups()
    unit = " ".join(_WRITTEN.get(part, part) for part in above.split("_"))
    if below is None:
        return unit
    return f"{unit}/({below.replace('_', ' ')})" if "_" in below else f"{unit}/{below}"
