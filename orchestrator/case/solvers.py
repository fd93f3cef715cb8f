"""Solvers by name: which ones there are, what their adapters tell of them, and how one is opened.

Every module in ``adapters/<port>`` that is not one of the port's shared parts is a solver, and so
is every entry point of an installed package in the group ``flipflow.<port>``.  A door is imported
when a case calls for it, so that what is absent costs nothing.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import EntryPoint, entry_points
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, Literal, cast

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticKnownError
from pydantic_core.core_schema import no_info_after_validator_function, str_schema

from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.ports.failures import SolverMissing, solver_failure_context

if TYPE_CHECKING:
    from orchestrator.ports.adapters import Adapter

Port = Literal["panel", "frames", "particles"]
NONE = "none"
"""``particles.solver`` of a machine that runs empty."""


@dataclass(frozen=True)
class SolverName:
    """A value that is the name of a solver of ``port``: a mark for a case's table."""

    port: Port

    @property
    def allowed(self) -> tuple[str, ...]:
        """The values that a case may give."""
        return (NONE, *names(self.port)) if self.port == "particles" else names(self.port)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return no_info_after_validator_function(self._checked, str_schema(strict=True))

    def _checked(self, name: str) -> str:
        if name in self.allowed:
            return name
        *most, last = (repr(one) for one in self.allowed)
        expected = f"{', '.join(most)} or {last}"
        raise PydanticKnownError("literal_error", {"expected": expected})


@cache
def names(port: Port) -> tuple[str, ...]:
    """The solvers of a port, as cases name them."""
    folder = import_module(f"adapters.{port}")
    own = {module.name for module in iter_modules(folder.__path__)} - folder.SHARED
    doors = {name.replace("_", "-") for name in own if not name.startswith("_")}
    return tuple(sorted(doors | {entry.name for entry in _installed(port)}))


@cache
def adapter(port: Port, solver: str) -> Adapter[Any, Any, Any]:
    """The adapter of a solver.  Raises SolverMissing for an installed one that cannot be loaded."""
    for entry in _installed(port):
        if entry.name == solver:
            try:
                return cast("Adapter[Any, Any, Any]", entry.load())
            except (ImportError, AttributeError) as error:
                raise SolverMissing(
                    f"the solver {solver} of {entry.value} cannot be loaded: {error}"
                ) from error
    door = import_module(f"adapters.{port}.{solver.replace('-', '_')}")
    return cast("Adapter[Any, Any, Any]", door.ADAPTER)


def names_able_to(port: Port, can: Callable[[Any], bool]) -> str:
    """The solvers of a port that can do something, as words for a hint: "planar" or "exudyn"."""
    able = [f'"{name}"' for name in names(port) if can(adapter(port, name))]
    return " or ".join(able)


def without(port: Port, effect: str) -> str:
    """The solver that leaves out an effect and little else, "" if there is none."""
    able = [name for name in names(port) if effect in adapter(port, name).leaves_out]
    return min(able, key=lambda name: len(adapter(port, name).leaves_out), default="")


def open_solver(port: Port, solver: str, plan: Any) -> Any:
    """The open solver of ``plan``.

    Raises SolverMissing, SolverFailed, and CaseError where the adapter refuses the plan with a
    ValueError, for example a step above its limit.
    """
    build = adapter(port, solver).build
    try:
        with solver_failure_context(f"{port} ({solver})", None):
            return build(plan)
    except ValueError as error:
        refusal = CaseProblem((port,), f"{solver} cannot take this case", str(error))
        raise CaseError([refusal]) from error


def _installed(port: Port) -> tuple[EntryPoint, ...]:
    return tuple(entry_points(group=f"flipflow.{port}"))
