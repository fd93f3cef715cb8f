"""Explicit loops of sheet and strip in C++ (``kernel/module.cpp``)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array

Ints = npt.NDArray[np.int32]

def sheet_places(along: int, across: int) -> tuple[list[int], int, tuple[int, int, int]]:
    """Return the places (nodes,) of a sheet's nodes in its state, and the number of all places.

    Third is the shape of its Gauss points: groups of cells side by side, points of each, cells of a group.
    """

class _Body:
    """A body that works on arrays which Python owns."""

    def __init__(self, **arguments: Array | Ints | float) -> None:
        """Bind the constants, which are copied, and the arrays of the state.

        All arrays are contiguous, float64 or int32, and passed by name.  TypeError for another type
        and for a name that is missing or not known, ValueError, with the array's name, for a wrong
        size.
        """

    def rest(self) -> None:
        """Take the positions as the shape in which every branch is relaxed; computes the force."""

    def advance(
        self,
        *,
        start_m: Array,
        start_m_per_s: Array,
        end_m: Array,
        end_m_per_s: Array,
        outside_N: Array,
        length_s: float,
        steps: int,
        impulse_N_s: Array,
    ) -> float:
        """Move to the end of an interval in equal steps; other threads run meanwhile.

        The held points go from start to end, (held, 3) each; the others move under the constant
        force ``outside_N`` (points, 3).  Adds the impulse that the body gives to the held points to
        ``impulse_N_s`` (held, 3) and returns the work on them in J.
        """

class Sheet(_Body):
    """The sheet of ``finite_element/compiled_sheet.py``.

    Constants, which are copied: sizes of the cells, ``along_m`` and ``across_m``; the membrane's law
    by cell, ``c10_N_per_m``, ``c01_N_per_m``, ``solid``, ``rest`` and ``strain_entries``
    (``kernel/membrane.h``); the bending matrix, ``entry`` in ``row`` and ``column``, and the
    positions without bending, ``flat_m``; ``mobility_1_kg`` (nodes,), zero where ``held``; ``joined``, free
    nodes of equal mobility two by two that move alike; ``mass_kg`` (nodes,) and ``weight_N`` (nodes, 3);
    Maxwell branches, ``ratio`` and ``time_s``.  State:
    ``position_m``, ``velocity_m_per_s``, ``internal_N`` (3, places), and what ``CompiledSheet`` calls
    its memory.
    """

    def membrane_J(self) -> float:
        """Return the elastic energy of the membrane at the present positions."""

class Chain(_Body):
    """The chain of ``strip/motion.py``.

    Constants, which are copied: springs from row ``first`` on, ``rest_m``, ``c10_Pa``, ``c01_Pa``,
    ``sheared_Pa``, ``area_m2``; ``curvature_1_m2`` (bends, 3) of three rows each, of weight
    ``bending_N_m3``, of which those ``at_clamp`` (0 or 1) do not count ``along`` it; rows, ``mass_kg``,
    ``held`` and ``free``; ``share`` (rows, held), how all follow the held ones ``across``; Maxwell branches,
    ``ratio`` and ``time_s``; ``weight_N`` (rows, 3).  State: ``position_m``, ``velocity_m_per_s``,
    ``internal_N`` (rows, 3), and what ``ChainMotion`` calls its memory.
    """

def advance_together(
    panels: Sequence[Sheet | Chain],
    *,
    clamps_m: Array,
    clamps_m_per_s: Array,
    load_N: Array,
    length_s: float,
    steps: Sequence[int],
    surface_m: Array,
    surface_m_per_s: Array,
    reaction_N: Array,
) -> list[float] | list[tuple[float, float]]:
    """Move panels of one kind to the end of an interval, each in its number of steps; other threads run
    meanwhile.

    All arrays have one panel after the other: the clamps at the end (clamp points, 3), the load on the
    surface (points, 3), and three that are filled, which are the surface's motion at the end (points, 3) and
    the mean force on the clamps (clamp points, 3).  Returns each sheet's largest speed in m/s, or each
    strip's smallest and largest stretch; NaN if one of them is.
    """
