"""The recommendation for a tolerance: one rule for ``flipflow study accuracy`` and ``flipflow plan``."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TypeVar

from orchestrator.studies.accuracy.combinations import Error

T = TypeVar("T")


def recommend(
    candidates: Iterable[tuple[T, Sequence[Error], float]],
    reference: tuple[T, float | None, float],
    tolerance: float,
) -> tuple[T | None, bool]:
    """Return the recommended candidate and whether it is proven to be within a tolerance.

    A candidate has the errors that decide, against the reference, and its processor time in s.  The
    ``reference`` has the estimate of its own error, None or 0 where it is unknown, and its time.  Its own
    error comes to those against it.  The first that is found of these is taken: the cheapest candidate whose
    errors are within the tolerance at the upper ends of their confidence intervals; the one within it whose
    upper end is lowest; the reference, if its own error is within it.  No candidate that takes longer than
    the reference is taken.
    """
    best, own_error, reference_s = reference
    room = tolerance - (own_error or 0.0)
    within = [
        (one, errors)
        for one, errors, time_s in sorted(candidates, key=lambda each: each[2])
        if errors and time_s <= reference_s and all(error.value <= room for error in errors)
    ]
    for one, errors in within:
        if all(error.half_width is not None and error.at_most <= room for error in errors):
            return one, True
    if within:
        return min(within, key=lambda each: max(error.at_most for error in each[1]))[0], False
    return best if own_error and own_error <= tolerance else None, False
