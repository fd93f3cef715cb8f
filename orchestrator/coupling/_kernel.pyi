"""What the coupling computes at all points in every interval, in C++ (``kernel/module.cpp``).

Vectors at points have the shape (points, 3).  Every function raises ValueError, with the array's name, for
another shape.
"""

from __future__ import annotations

from orchestrator.ports import Array, Indices, InterfaceData, Load, Motion

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

class NormalOffsets:
    """Points at an offset from a surface along its normal.

    The surface's own points are at x (own points, 3).  Point i is ``offset_m[i]`` times the unit normal

        n = a / |a|,    a = (along[i] x) x (across[i] x)

    from its foot on the surface.  ``along`` and ``across`` are matrices (points, own points).
    """

    def __init__(self, along: PointMatrix, across: PointMatrix, offset_m: Array) -> None: ...
    def add_motion(
        self, own_m: Array, own_m_per_s: Array, position_m: Array, velocity_m_per_s: Array
    ) -> None:
        """Add the offsets, of a surface with own points at ``own_m`` that move with ``own_m_per_s``, to
        ``position_m`` and their rates to ``velocity_m_per_s`` (points, 3) of the points' feet.

        A point where the surface has no normal becomes NaN.
        """

    def add_load(self, own_m: Array, force_N: Array, own_force_N: Array) -> None:
        """Add to ``own_force_N`` (own points, 3) the couples of forces ``force_N`` (points, 3) at the points
        about the points' feet, with the surface's own points at ``own_m``.

        Their sum is zero, and their power on any motion of the own points is that of the forces on the rates
        that ``add_motion`` adds.
        """

def add_handed_over(sums: Array, load: Load, start: Motion, end: Motion, length_s: float) -> None:
    """Add to ``sums`` (7,) what a mean load hands over in an interval in which its points move from ``start``
    to ``end``.

    It is the impulse (3,) in N s, the angular impulse (3,) about the world's origin in N m s, and the sum of
    the sizes of all components of the impulse at all points, in which loads that cancel each other count.
    The points move smoothly (cubic Hermite); the load acts at their mean places.
    """

def contact_works(
    intervals: list[InterfaceData],
    *,
    counted: int,
    before_m: Array,
    path_before_m: Array,
    load_before_N: Array,
    load_twice_before_N: Array,
    slow_m_per_s: float,
) -> list[Works]:
    """Return the works between particles and panels in successive intervals, by the formula of
    ``monitor/interface_work.py``.

    Before the first one, the surface is at ``before_m``, the particles' last path has ended at
    ``path_before_m``, and the last two loads were those given.  The first ``counted`` points count.  In the
    absolute work every point counts as faster by ``slow_m_per_s``.
    """

def clamp_works(
    intervals: list[InterfaceData],
    *,
    counted: int,
    before_m: Array,
    target_before_m: Array,
    slow_m_per_s: float,
) -> list[Works]:
    """Return the works between panels and frames in successive intervals, by the formula of
    ``monitor/interface_work.py``.

    Before the first one, the frames are at ``before_m``, and the panels' clamps were told to go to
    ``target_before_m``.  The first ``counted`` points count.  In the absolute work every point counts as
    faster by ``slow_m_per_s``.
    """

def sizes_and_changes(values: list[Array]) -> list[tuple[float, float]]:
    """Return, for each of successive values (points, 3) after the first two, the sum of its squares and the
    size of the largest component of the second difference that ends with it."""
