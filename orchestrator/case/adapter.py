"""Adapters by name: imported when a case calls for them, so that what is absent costs nothing."""

from __future__ import annotations

from importlib import import_module
from types import ModuleType
from typing import Any, cast

from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.ports.failures import solver_failure_context
from orchestrator.ports.plans import Cost


def imported(port: str, solver: str) -> ModuleType:
    """The module adapters.<port>.<solver>.  Raises SolverMissing."""
    return import_module(f"adapters.{port}.{solver.replace('-', '_')}")


def cost(port: str, solver: str, work: Any) -> Cost:
    """What so much work (``ports/plans/work.py``) takes the solver; it need not be installed."""
    costs = import_module(f"adapters.{port}.costs")
    return cast(Cost, getattr(costs, solver.replace("-", "_"))(work))


def opened(port: str, solver: str, plan: Any) -> Any:
    """The open solver of ``plan``.

    Raises SolverMissing, SolverFailed, and CaseError where the adapter refuses the plan with a
    ValueError, for example a step above its limit.
    """
    build = imported(port, solver).build
    try:
        with solver_failure_context(f"{port} ({solver})", None):
            return build(plan)
    except ValueError as error:
        refusal = CaseProblem((port,), f"{solver} cannot take this case", str(error))
        raise CaseError([refusal]) from error
