"""The coupling schemes, under the names that a case uses."""

from __future__ import annotations

from collections.abc import Callable

from orchestrator.coupling.schemes import staggered
from orchestrator.coupling.schemes.acceleration import Aitken, LeastSquares
from orchestrator.coupling.schemes.iterated import Effort, Iterated
from orchestrator.coupling.schemes.robin import Robin
from orchestrator.coupling.schemes.scheme import Scheme

SCHEMES: dict[str, Callable[[Effort], Scheme]] = {
    "particles-first": lambda effort: Scheme(staggered.particles_first),
    "serial-staggered": lambda effort: Scheme(staggered.serial_staggered, late=True),
    "aitken": lambda effort: _scheme_with_memory(Iterated(effort, Aitken())),
    "quasi-newton": lambda effort: _scheme_with_memory(Iterated(effort, LeastSquares())),
    "robin": lambda effort: _scheme_with_memory(Robin()),
}


def _scheme_with_memory(scheme: Iterated | Robin) -> Scheme:
    return Scheme(scheme.advance, memory=scheme)


def create_scheme(name: str, effort: Effort | None = None) -> Scheme:
    """Return a scheme that has not begun; without ``effort`` it takes the usual effort."""
    return SCHEMES[name](effort or Effort())
