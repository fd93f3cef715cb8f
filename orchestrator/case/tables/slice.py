"""``[slice]``: a strip of the machine's width instead of all of it."""

from __future__ import annotations

from typing import Literal

from orchestrator.case.tables.quantities import Positive, Table


class Slice(Table):
    """The middle of the machine's width.  The case describes the whole machine; masses, bushings,
    exciters and feeds take their share, so that the frames move as the whole machine's.  Usually
    stands in a level."""

    width_m: Positive
    """Width of the slice."""
    sides: Literal["periodic", "walls"] = "periodic"
    """periodic: what leaves at one side comes back at the other, and walls along the sides are left
    out.  walls: they stand at the sides of the slice."""
