"""Nothing that moves impossibly fast is computed any further."""

from __future__ import annotations

import numpy as np

from orchestrator.coupling.schemes.exchange import State
from orchestrator.ports.plans import SolverFailed

FASTEST_M_S = 300.0  # nothing on a screen moves at the speed of sound in air


def check_stable(state: State, time_s: float, advice: str) -> None:
    """Raises SolverFailed, with the ``advice`` at its end, when a surface or frame point moves
    impossibly fast."""
    for member, motion in (("frames", state.clamps), ("panel", state.panel.surface)):
        fastest = float(np.abs(motion.velocity_m_per_s).max(initial=0.0))
        if fastest > FASTEST_M_S:
            raise SolverFailed(
                f"{member} became unstable at t = {time_s:.6g} s: a point moves at "
                f"{fastest:.3g} m/s (limit {FASTEST_M_S:g} m/s). {advice}"
            )
