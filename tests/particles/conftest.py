"""Every particle solver, for tests that all of them pass."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import ExitStack, closing

import pytest

from orchestrator.ports.adapters import ParticlesAdapter
from orchestrator.ports.plans import ParticlesPlan
from tests.particles.contract import SOLVERS, Run, solver_adapter


def pytest_generate_tests(metafunc: pytest.Metafunc) -> None:
    """Ask every solver, or those that a file names as ``ASKED``.

    Closed forms of the laws are asked of the solver that users have; the slow reference of the tests
    passes the contract of the port, and is compared with LIGGGHTS (test_spheres_against_liggghts.py).
    """
    if "module" in metafunc.fixturenames:
        metafunc.parametrize("module", getattr(metafunc.module, "ASKED", SOLVERS), indirect=True)


@pytest.fixture
def module(request: pytest.FixtureRequest) -> ParticlesAdapter:
    return solver_adapter(request.param)


@pytest.fixture
def build(module: ParticlesAdapter) -> Iterator[Callable[[ParticlesPlan], Run]]:
    """Opens a plan, and closes the solver when the test ends."""
    with ExitStack() as opened:
        yield lambda plan: Run(opened.enter_context(closing(module.build(plan))), plan)
