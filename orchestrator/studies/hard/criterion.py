"""One number that is asked of a hard case, and the band in which it must be."""

from __future__ import annotations

from typing import Literal

from orchestrator.case.tables.quantities import Name, Number, OneLine, Table


class Criterion(Table):
    """One number of a run, and the band in which it must be."""

    what: OneLine
    """What the number is."""
    run: Name
    """The run that it is taken from."""
    measure: OneLine
    """How it is found (``measures.MEASURES``)."""
    of: OneLine = ""
    """What the measure looks at: a dataset of history.h5, or keys of summary.json."""
    axis: Literal["", "x", "y", "z", "size"] = ""
    """The component of a dataset of vectors, or their size."""
    take: OneLine = "last"
    """What of a series: ``measures.TAKES``."""
    between_s: tuple[Number, Number] | None = None
    """Part of a series."""
    earlier_s: tuple[Number, Number] | None = None
    """The part before that it is compared with."""
    against: OneLine = ""
    """The run that it is compared with."""
    reference: Number | None = None
    """What the measured number is divided by: the answer known from elsewhere."""
    unit: OneLine = "1"
    """Unit of the number and of its reference."""
    band: tuple[Number | None, Number | None]
    """From, to; with a reference, in multiples of it."""
    why: OneLine
    """Where band and reference come from."""
    known_failure: OneLine = ""
    """Why it is not met; empty of what must be."""
