"""What a panel bears: its pull on the clamps, and its stretch."""

from __future__ import annotations

import numpy as np

from orchestrator.ports import Array


def line_length_m(line_m: Array) -> Array:
    """(rows,) lengths of polylines (rows, points, 3)."""
    return np.asarray(np.linalg.norm(np.diff(line_m, axis=1), axis=2).sum(axis=1))


def stretch(line_m: Array, free_length_m: float, clamped_m: float) -> Array:
    """(rows,) mean strain along centre lines (rows, points, 3): length between the clamps over
    the stress-free length, less one.  ``clamped_m``: how much of the line lies under clamps.

    A chord is shorter than its arc: with pieces h on a curvature k by h^2 k^2 / 24.
    """
    return (line_length_m(line_m) - clamped_m) / free_length_m - 1.0


def tension_N(first_N: Array, second_N: Array, chord_m: Array) -> Array:
    """(rows,) pull of a panel: half the difference of its forces (rows, 3) on its first and
    second clamp, along the line between them (3,); negative where it pushes."""
    along = chord_m / np.linalg.norm(chord_m)
    return np.asarray((first_N - second_N) @ along / 2)
