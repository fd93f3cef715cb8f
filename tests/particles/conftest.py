"""Every particle solver, for tests that all of them pass."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing

import pytest

from orchestrator.ports.adapters import ParticlesAdapter
from orchestrator.ports.plans import ParticlesPlan
from tests.particles.contract import SOLVERS, Run, solver_adapter


@pytest.fixture(params=SOLVERS)
def module(request: pytest.FixtureRequest) -> ParticlesAdapter:
    return solver_adapter(request.param)


@pytest.fixture
def build(module: ParticlesAdapter) -> Iterator[Callable[[ParticlesPlan], Run]]:
    """Opens a plan, and closes the solver when the test ends."""
    with ExitStack() as opened:
        yield lambda plan: Run(opened.enter_context(closing(module.build(plan))), plan)
