"""The explicit loops of sheet and strip in C++ (``kernel/module.cpp``)."""

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Array

Ints = npt.NDArray[np.int32]

LANES: int
"""How many cells stand side by side in the arrays of Gauss points."""

class Sheet:
    """See ``compiled_sheet``.  Arrays have to be contiguous, of the dtype given; ValueError for one
    of a wrong size."""

    def __init__(
        self,
        *,
        along_m: Array,
        across_m: Array,
        c10_N_per_m: float,
        c01_N_per_m: float,
        solid: Array,
        rest: Array,
        strain: Array,
        offset: Ints,
        entry: Array,
        flat_m: Array,
        mobility_1_kg: Array,
        held: Ints,
        ratio: Array,
        time_s: Array,
        state: Sequence[Array],
    ) -> None:
        """Cell sizes; the membrane's law by cell (``kernel/membrane.h``); the bending matrix by
        diagonals and the positions without bending; mobility (nodes,), zero where ``held``;
        Maxwell branches; and the arrays that it works on: position, velocity, internal force, and
        those of ``compiled_sheet.Memory``."""

    def rest(self) -> None:
        """Take the positions as the shape in which every branch is relaxed; finds the force."""

    def membrane_J(self) -> float: ...
    def advance(
        self,
        start_m: Array,
        start_m_per_s: Array,
        end_m: Array,
        end_m_per_s: Array,
        outside_N: Array,
        length_s: float,
        steps: int,
        impulse_N_s: Array,
    ) -> float:
        """Move to the end of an interval in equal steps: the held nodes from start to end, the
        others under a constant force (nodes, 3).  Adds the internal force's impulse (held, 3) and
        returns its work on the held nodes, in J.  Other threads run meanwhile."""

class Chain:
    """Arrays as for ``Sheet``; see ``chain_motion``."""

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
        state: Sequence[Array],
    ) -> None:
        """Springs from row ``first`` on; curvatures (bends, 3) of three rows each, ``at_clamp`` (0
        or 1) those that count across ``along`` only; rows; how all follow the held ones
        ``across``; Maxwell branches; and the arrays that it works on."""

    def rest(self) -> None:
        """Take the positions as the shape in which every branch is relaxed; finds the force."""

    def advance(
        self,
        start_m: Array,
        start_m_per_s: Array,
        end_m: Array,
        end_m_per_s: Array,
        outside_N: Array,
        length_s: float,
        steps: int,
        impulse_N_s: Array,
    ) -> float:
        """Move to the end of an interval in equal steps, under a constant force (rows, 3).  Adds
        the impulse (held, 3) that the chain gives to the held rows and returns its work on them,
        in J.  Other threads run meanwhile."""
