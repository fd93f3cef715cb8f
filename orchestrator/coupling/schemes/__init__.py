"""The coupling schemes, under the names that a case uses."""

from __future__ import annotations

from collections.abc import Callable

from orchestrator.coupling.schemes import iterated, robin, staggered
from orchestrator.coupling.schemes.iterated import Effort
from orchestrator.coupling.schemes.scheme import Scheme

SCHEMES: dict[str, Callable[[Effort], Scheme]] = {
    "particles-first": lambda effort: Scheme(staggered.particles_first),
    "serial-staggered": lambda effort: Scheme(staggered.serial_staggered, late=True),
    "aitken": iterated.aitken,
    "quasi-newton": iterated.quasi_newton,
    "robin": lambda effort: robin.robin(),
}


def create_scheme(name: str, effort: Effort | None = None) -> Scheme:
    """Returns a scheme that has not begun; without ``effort`` it takes the usual one."""
    return SCHEMES[name](effort or Effort())
