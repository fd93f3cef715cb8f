"""The solvers by name: lists of their names, access to their adapters, and a function that opens one.

Every module in ``adapters/<port>`` that is not one of the port's shared parts is a solver, and so
is every entry point of an installed package in the group ``flipflow.<port>``.  Shapes of grains have names
in the same way.  An adapter is imported
only when a case asks for it, so that a solver which is not installed does no harm.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import import_module
from importlib.metadata import entry_points
from pkgutil import iter_modules
from typing import Any, Literal, cast

from pydantic import GetCoreSchemaHandler
from pydantic_core import CoreSchema, PydanticKnownError
from pydantic_core.core_schema import no_info_after_validator_function, str_schema

from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.ports.adapters import Adapter
from orchestrator.ports.failures import SolverMissing, solver_failure_context
from orchestrator.ports.grains import Shape

Port = Literal["panel", "frames", "particles"]
Door = Port | Literal["shapes"]
NONE = "none"
"""The value of ``particles.solver`` for a machine that runs empty."""


@dataclass(frozen=True)
class SolverName:
    """An annotation for a field of a case's table whose value is the name of a solver of ``port``."""

    port: Port

    @property
    def allowed(self) -> tuple[str, ...]:
        """The names that a case may give."""
        return (NONE, *names(self.port)) if self.port == "particles" else names(self.port)

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return no_info_after_validator_function(self._check, str_schema(strict=True))

    def _check(self, name: str) -> str:
        if name in self.allowed:
            return name
        *most, last = (repr(allowed) for allowed in self.allowed)
        expected = f"{', '.join(most)} or {last}"
        raise PydanticKnownError("literal_error", {"expected": expected})


@dataclass(frozen=True)
class ShapeNames:
    """An annotation for a field of a case's table whose value is the name of a shape of grains, or of one of
    the case's own (``[bed.shapes]``, whose table checks both)."""

    @property
    def allowed(self) -> tuple[str, ...]:
        """The names that every case may give."""
        return names("shapes")


@cache
def names(port: Door) -> tuple[str, ...]:
    """Return the names of a port's solvers, as cases give them, in alphabetical order."""
    folder = import_module(f"adapters.{port}")
    own = {module.name for module in iter_modules(folder.__path__)} - folder.SHARED
    own_solvers = {name.replace("_", "-") for name in own if not name.startswith("_")}
    return tuple(sorted(own_solvers | entry_points(group=f"flipflow.{port}").names))


@cache
def adapter(port: Door, solver: str) -> Adapter[Any, Any, Any]:
    """Return the adapter of a solver.

    Raises SolverMissing if the solver belongs to an installed package and cannot be loaded.
    """
    for entry in entry_points(group=f"flipflow.{port}", name=solver):
        try:
            return cast("Adapter[Any, Any, Any]", entry.load())
        except (ImportError, AttributeError) as error:
            raise SolverMissing(f"the solver {solver} of {entry.value} cannot be loaded: {error}") from error
    module = import_module(f"adapters.{port}.{solver.replace('-', '_')}")
    return cast("Adapter[Any, Any, Any]", module.ADAPTER)


def shape(name: str) -> Shape:
    """Return a shape of grains.  Raises SolverMissing if there is none of this name here."""
    if name not in (known := names("shapes")):
        raise SolverMissing(f'there is no shape "{name}" of grains here, but {", ".join(known)}')
    return cast("Shape", adapter("shapes", name))


def names_able_to(port: Port, can: Callable[[Any], bool]) -> str:
    """Return text for a hint, such as '"sheet" or "solid"', that names the solvers which pass ``can``."""
    able = [f'"{name}"' for name in names(port) if can(adapter(port, name))]
    return " or ".join(able)


def name_without(port: Port, effect: str) -> str:
    """Return the solver that leaves out an effect and few others; "" if no solver leaves it out."""
    able = [name for name in names(port) if effect in adapter(port, name).leaves_out]
    return min(able, key=lambda name: len(adapter(port, name).leaves_out), default="")


def open_solver(port: Port, solver: str, plan: Any) -> Any:
    """Open a solver for ``plan`` and return it.

    Raises SolverMissing and SolverFailed, and CaseError if the adapter refuses the plan with a
    ValueError, for example because the step is above its limit.
    """
    build = adapter(port, solver).build
    try:
        with solver_failure_context(f"{port} ({solver})", None):
            return build(plan)
    except ValueError as error:
        refusal = CaseProblem((port,), f"{solver} cannot take this case", str(error), kind="solver")
        raise CaseError([refusal]) from error
