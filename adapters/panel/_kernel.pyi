"""Explicit loops of sheet and strip in C++ (``kernel/module.cpp``)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array

Ints = npt.NDArray[np.int32]

LANES: int
"""Number of cells that stand side by side in the arrays of Gauss points."""

class _Body:
    """A body that works on arrays which Python owns.

    All arrays are contiguous, of the given type, and passed by name; TypeError for another type,
    ValueError, with the array's name, for a wrong size.
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
    """The sheet of ``finite_element/compiled_sheet.py``."""

    def __init__(
        self,
        *,
        along_m: Array,
        across_m: Array,
        c10_N_per_m: float,
        c01_N_per_m: float,
        solid: Array,
        rest: Array,
        strain_entries: Array,
        offset: Ints,
        entry: Array,
        flat_m: Array,
        mobility_1_kg: Array,
        held: Ints,
        ratio: Array,
        time_s: Array,
        position_m: Array,
        velocity_m_per_s: Array,
        internal_N: Array,
        strain: Array,
        strain_stress: Array,
        elastic_N: Array,
        bending_stress_N: Array,
        energy_J: Array,
        lost_J: Array,
    ) -> None:
        """Bind the constants, which are copied, and the arrays of the state.

        Constants: sizes of the cells; the membrane's law by cell (``kernel/membrane.h``); the
        bending matrix by diagonals and the positions without bending; mobility (nodes,), zero where
        ``held``; Maxwell branches.  State, from ``position_m`` on: position, velocity and internal
        force (nodes, 3), and the arrays of ``compiled_sheet.SheetMemory``.
        """

    def membrane_J(self) -> float:
        """Elastic energy of the membrane at the present positions."""

class Chain(_Body):
    """The chain of ``strip/motion.py``."""

    def __init__(
        self,
        *,
        first: int,
        rest_m: float,
        c10_Pa: float,
        c01_Pa: float,
        area_m2: Array,
        bending_N_m3: Array,
        curvature_1_m2: Array,
        at_clamp: Ints,
        along: Array,
        mass_kg: Array,
        held: Ints,
        free: Ints,
        across: Array,
        share: Array,
        ratio: Array,
        time_s: Array,
        position_m: Array,
        velocity_m_per_s: Array,
        internal_N: Array,
        strain: Array,
        stress: Array,
        energy_J: Array,
        lost_J: Array,
    ) -> None:
        """Bind the constants, which are copied, and the arrays of the state.

        Constants: springs from row ``first`` on; curvatures (bends, 3) of three rows each, of which
        those ``at_clamp`` (0 or 1) do not count ``along`` it; rows; ``share`` (rows, held): how all
        follow the held ones ``across``; Maxwell branches.  State, from ``position_m`` on: position,
        velocity and internal force (rows, 3), strains, and the branches' stresses and energies.
        """
