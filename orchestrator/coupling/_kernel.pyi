"""What the coupling computes at all points in every interval, in C++ (``kernel/module.cpp``).

Vectors at points have the shape (points, 3).  Every function raises ValueError, with the array's name, for
another shape.
"""

from __future__ import annotations

from orchestrator.ports import Array, Indices, Load, Motion

Works = tuple[float, float, float, float]
"""Of an interval: the work of a load on all points in J; the sum of the sizes of its components in N; and at
the points that count, the energy created in J and the sum of the absolute work along each axis in J."""

class PointMatrix:
    """A sparse matrix (rows, width) that takes vectors at points to vectors at others, by rows.

    Row i has the entries from ``starts[i]`` up to ``starts[i + 1]``.  Products are equal to SciPy's, to the
    bit.
    """

    def __init__(self, starts: Indices, columns: Indices, entries: Array, width: int) -> None: ...
    def times(self, values: Array) -> Array:
        """Return the matrix times ``values`` (width, 3), (rows, 3)."""

    def transposed_times(self, values: Array) -> Array:
        """Return the transposed matrix times ``values`` (rows, 3), (width, 3)."""

def add_handed_over(sums: Array, load: Load, start: Motion, end: Motion, length_s: float) -> None:
    """Add to ``sums`` (7,) what a mean load hands over in an interval in which its points move from ``start``
    to ``end``.

    It is the impulse (3,) in N s, the angular impulse (3,) about the world's origin in N m s, and the sum of
    the sizes of all components of the impulse at all points, in which loads that cancel each other count.
    The points move smoothly (cubic Hermite); the load acts at their mean places.
    """

def contact_works(
    *,
    load_N: Array,
    load_before_N: Array,
    load_twice_before_N: Array,
    panel_load_N: Array,
    before_m: Array,
    after_m: Array,
    path_start_m: Array,
    path_end_m: Array,
    path_before_m: Array,
    least_m: float,
) -> Works:
    """Return the works between particles and panels, by the formula of ``monitor/interface_work.py``.

    The surface goes from ``before_m`` to ``after_m``; the particles see it jump from ``path_before_m`` to
    ``path_start_m``, and go to ``path_end_m``.  The points of ``path_before_m`` and of the two older loads
    count; they are the surface's first.  In the absolute work every point counts as moved by ``least_m``
    more.
    """

def clamp_works(
    *,
    reaction_N: Array,
    frames_load_N: Array,
    before_m: Array,
    after_m: Array,
    missed_m: Array,
    missed_before_m: Array,
    least_m: float,
) -> Works:
    """Return the works between panels and frames, by the formula of ``monitor/interface_work.py``.

    The frames go from ``before_m`` to ``after_m``, and miss where the panels' clamps were told to go by
    ``missed_m``.  The points of ``missed_m`` count; they are the clamps' first.
    """
