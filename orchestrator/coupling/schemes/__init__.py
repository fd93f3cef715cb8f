"""The schemes by the names that a case knows them by."""

from __future__ import annotations

from collections.abc import Callable

from orchestrator.coupling.schemes import iterated, robin, staggered
from orchestrator.coupling.schemes.scheme import Scheme
from orchestrator.preflight.effort import Effort

SCHEMES: dict[str, Callable[[Effort], Scheme]] = {
    "particles-first": lambda effort: Scheme(staggered.particles_first),
    "serial-staggered": lambda effort: Scheme(staggered.serial_staggered, late=True),
    "aitken": iterated.aitken,
    "quasi-newton": iterated.quasi_newton,
    "robin": lambda effort: robin.robin(),
}


def create_scheme(name: str, effort: Effort | None = None) -> Scheme:
    """A scheme that has not begun; without ``effort`` with the usual one."""
    return SCHEMES[name](effort or Effort())
