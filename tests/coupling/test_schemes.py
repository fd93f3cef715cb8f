"""The schemes against exact answers: restitution, momentum, order of convergence."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from orchestrator.coupling.schemes import create_scheme as named
from orchestrator.coupling.schemes.scheme import initial_state
from orchestrator.ports.clock import Interval
from tests.coupling.line import FreeFrame, HungPlate, Sphere, members

CONTACT_S = np.pi * np.sqrt(4 / 5)  # half a period of 1 kg on 4 kg through 1 N/m


def impact(scheme: str, intervals_per_contact: int) -> tuple[float, float]:
    """(apparent restitution, momentum defect) of 1 kg at 1 m/s on a free plate of 4 kg."""
    length_s = CONTACT_S / intervals_per_contact
    sphere, plate = Sphere(1.0, 1.0, 0.3 * length_s, -1.0), HungPlate(4.0, 0.0)
    solvers = members(sphere, plate, FreeFrame(1.0))
    state, way = initial_state(solvers), named(scheme)
    for index in range(3 * intervals_per_contact):
        state = way.advance(solvers, Interval(index, length_s), state)
    return sphere.v - plate.v, sphere.v + 4 * plate.v + 1.0


@pytest.mark.smoke
@pytest.mark.parametrize(
    ("scheme", "intervals", "expected"),
    [
        # apparent restitution, exact 1: a one-dimensional study of the same impact, three digits
        ("particles-first", 5, 1.0025),
        ("particles-first", 10, 1.0003),
        # measured; it loses energy, and less of it with the fourth power of the interval
        ("robin", 5, 0.9973),
        ("robin", 10, 0.9998),
        ("serial-staggered", 5, 1.195),
        ("serial-staggered", 10, 1.101),
        ("serial-staggered", 50, 1.020),
    ],
)
def test_restitution_of_an_elastic_impact(scheme: str, intervals: int, expected: float) -> None:
    restitution, momentum_defect = impact(scheme, intervals)
    assert restitution == pytest.approx(expected, abs=5e-4)
    assert abs(momentum_defect) < 1e-12


@pytest.mark.parametrize(("scheme", "order"), [("particles-first", 3), ("robin", 4), ("serial-staggered", 1)])
def test_order_of_the_energy_that_the_coupling_creates(scheme: str, order: int) -> None:
    coarse, fine = (abs(impact(scheme, n)[0] - 1.0) for n in (8, 32))
    assert np.log(coarse / fine) / np.log(4) == pytest.approx(order, abs=0.25)


def chain(scheme: str, intervals: int, end_s: float) -> np.ndarray:
    """(x sphere, x plate, x frame) at ``end_s``: a bed mass held on a plate held on a frame."""
    sphere, plate, frame = Sphere(1.0, 4.0, -0.05, 0.0), HungPlate(2.0, 3.0), FreeFrame(5.0)
    solvers = members(sphere, plate, frame)
    state, way = initial_state(solvers), named(scheme)
    for index in range(intervals):
        state = way.advance(solvers, Interval(index, end_s / intervals), state)
    return np.array([sphere.x, plate.x, frame.x])


def exact_chain(end_s: float) -> np.ndarray:
    def rate(_: float, y: np.ndarray) -> list[float]:
        contact, hanger = 4.0 * max(0.0, y[1] - y[0]), 3.0 * (y[1] - y[2])
        return [y[3], y[4], y[5], contact / 1.0, (-contact - hanger) / 2.0, hanger / 5.0]

    start = [-0.05, 0.0, 0.0, 0.0, 0.0, 0.0]
    return solve_ivp(rate, (0, end_s), start, rtol=1e-11, atol=1e-13).y[:3, -1]


@pytest.mark.parametrize(("scheme", "order"), [("particles-first", 2), ("robin", 2), ("serial-staggered", 1)])
def test_order_of_the_whole_chain(scheme: str, order: int) -> None:
    """Position error of all three members while they stay in touch: at least this order."""
    end_s = 1.0
    exact = exact_chain(end_s)
    errors = [np.abs(chain(scheme, n, end_s) - exact).max() for n in (10, 40)]
    assert np.log(errors[0] / errors[1]) / np.log(4) > order - 0.25
