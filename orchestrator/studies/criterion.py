"""The tables of ``criteria.toml``: the runs that it asks for, and the numbers that they must have."""

from __future__ import annotations

from typing import Annotated, Literal

from annotated_types import Len

from orchestrator.case.tables.quantities import Few, Name, Number, OneLine, Positive, Switch, Table

Band = tuple[Number | None, Number | None]


class WantedRun(Table):
    """One run of the case, or one for each value of a key."""

    vary: OneLine = ""
    """As ``flipflow study sweep --vary``; without it, a single run."""
    sets: tuple[OneLine, ...] = ()
    """As ``--set``."""
    interval_over_safe: Positive | None = None
    """The sync interval, in multiples of the largest safe one that the stability report gives."""
    resume_at_s: Positive | None = None
    """The run ends here and is resumed."""


class Criterion(Table):
    """One number of a case's runs, and the band in which it must be."""

    what: OneLine
    """What the number is."""
    run: Name
    """The entry of ``runs`` that it is taken from."""
    at: OneLine = ""
    """The value that picks one run of those of a varied key."""
    between: tuple[Number, Number] | None = None
    """Part of the values of a varied key."""
    measure: OneLine
    """How the number is found (``measures.MEASURES``)."""
    of: OneLine = ""
    """What the measure looks at: a dataset of history.h5, keys of summary.json with dots or a short
    name of a result, a frame, a probe or a pair of frames."""
    axis: Literal["", "x", "y", "z", "size"] = ""
    """The component of vectors (x along the deck, z normal to it, for amplitudes), or their size."""
    take: OneLine = "last"
    """What of a series (``measures.TAKES``)."""
    between_s: tuple[Number, Number] | None = None
    """Part of a series."""
    compare: OneLine = ""
    """How numbers are compared with each other (``measures.COMPARISONS``); without it, the number
    itself counts."""
    against: OneLine = ""
    """The run that it is compared with."""
    earlier_s: tuple[Number, Number] | None = None
    """The part of the series before that it is compared with, where there is no other run."""
    unit: OneLine = "1"
    """Unit of this criterion's numbers."""
    reference: Number | None = None
    """The number as it is known from elsewhere: a paper's, or a closed form's."""
    exact: Switch = False
    """Whether the reference is the answer, so that ``flipflow study accuracy`` measures errors
    against it."""
    experiment: Number | None = None
    """The same, from an experiment."""
    band: Band | None = None
    """From, to; none where there is nothing to hold the number against."""
    ratio: Band | None = None
    """The same in multiples of the reference."""
    why: OneLine = ""
    """Where band and reference come from."""
    fitted: Switch = False
    """Whether the case's values were chosen to meet it."""
    known_failure: OneLine = ""
    """Why it is not met; empty of what must be."""


class Criteria(Table):
    """``criteria.toml``."""

    source: OneLine = ""
    """Where the numbers are from, of all criteria."""
    number: Few | None = None
    """Its place in a list of benchmarks."""
    happens: OneLine = ""
    """What is done to the machine."""
    expected: OneLine = ""
    """What must come of it."""
    runs: dict[Name, WantedRun]
    """What must be run, by name."""
    criteria: Annotated[tuple[Criterion, ...], Len(1)]
    """What must be true."""
