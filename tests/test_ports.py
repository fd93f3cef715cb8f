"""Values that cross a port are checked, and the examples in the ports' docstrings run, alone and coupled."""

from __future__ import annotations

import doctest
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

import numpy as np
import pytest

import orchestrator.ports
from orchestrator.coupling.schemes import create_scheme
from orchestrator.coupling.schemes.scheme import Solvers, initial_state
from orchestrator.ports import BrokenRecord, Frames, Interval, Load, Motion, Panel, Particles
from tests.grains import one_sphere


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_cannot_cross(bad: float) -> None:
    velocity_m_per_s = np.zeros((4, 3))
    velocity_m_per_s[2, 1] = bad
    with pytest.raises(BrokenRecord, match=r"^Motion\.velocity_m_per_s:.*\b2\b"):
        Motion(np.zeros((4, 3)), velocity_m_per_s)


def test_numbers_whose_square_overflows_cross() -> None:
    assert Load(np.full((2, 3), -1e200)).force_N[0, 0] == -1e200


MODULES = [f"orchestrator.ports.{module.name}" for module in iter_modules(orchestrator.ports.__path__)]


@pytest.mark.parametrize("name", ["orchestrator.ports", *MODULES])
def test_examples_run(name: str) -> None:
    result = doctest.testmod(import_module(name))
    assert result.failed == 0


def example(protocol: type) -> dict[str, Any]:
    """Everything that the example in a protocol's docstring has defined once it has run."""
    (doc,) = doctest.DocTestFinder(recurse=False).find(protocol, protocol.__name__)
    assert doctest.DocTestRunner(verbose=False).run(doc, clear_globs=False).failed == 0
    return doc.globs


@pytest.mark.parametrize("scheme", ["particles-first", "serial-staggered", "aitken", "quasi-newton"])
def test_the_examples_make_a_machine(scheme: str) -> None:
    """The ball falls on the panel on its springs, which the frame on its springs carries."""
    clamps_m = np.array([[-0.5, -0.5, 0.0], [0.5, -0.5, 0.0], [0.0, 0.5, 0.0]])
    frames = example(Frames)["SwingingFrame"](clamps_m, 10.0, 4e4)
    panel = example(Panel)["SpringPanel"](clamps_m, "deck", 0.1, 1e4, 1e-5)
    particles = example(Particles)["Ball"](0.0101, one_sphere(0.02, 2500.0), 1e4, 1e-5)
    solvers = Solvers(frames, panel, particles)
    state, way = initial_state(solvers), create_scheme(scheme)
    for index in range(200):
        state = way.advance(solvers, Interval(index, 5e-5), state)
    accounts = [solver.account() for solver in (frames, panel, particles)]
    momentum_kg_m_per_s = sum(account.momentum_kg_m_per_s for account in accounts)
    outside_N_s = sum(account.outside_impulse_N_s for account in accounts)
    pending = way.pending(state, Interval(200, 5e-5))
    transit_N_s = pending.load_N_s + pending.reaction_N_s
    np.testing.assert_allclose(momentum_kg_m_per_s + transit_N_s, outside_N_s, atol=1e-12)
    for account in accounts:
        had_J = sum(account.received_J.values()) + sum(account.supplied_J.values())
        assert sum(account.stored_J.values()) == pytest.approx(had_J, abs=1e-6)
    assert particles.velocity_m_per_s > 0.0, "it has rebounded"
