"""Repeated intervals have no limit from contacts: the real loop, far above the plain one's."""

from __future__ import annotations

import math

import pytest

from tests.coupling.line import FreeFrame, HungPlate, Sphere
from tests.stability.growth import CONTACT, NEUTRAL, Line
from tests.stability.test_contact_limits import HEAVY_KG, bound_s, damping_N_s_per_m


@pytest.mark.parametrize("times", [1.0, 10.0])
@pytest.mark.parametrize("sphere_kg", [0.1, 1.0, 1e3, 1e4])
@pytest.mark.parametrize("mode_rad_per_s", [0.0, 0.5, 10.0])
def test_held_contacts_never_grow(mode_rad_per_s: float, sphere_kg: float, times: float) -> None:
    """A sphere of 0.1 to 10^4 times the plate's mass that stays, at so many times the limit of
    particles-first.  Measured up to thirty times: no radius above 1 + 1.3e-7.  The members' own
    steps are short enough for the plate's mode and for the sphere on its spring."""
    for restitution in (0.99, 0.34, 0.13):
        damping = damping_N_s_per_m(restitution, sphere_kg)
        interval_s = times * bound_s("particles-first", sphere_kg, damping, mode_rad_per_s)
        steps = 20 + math.ceil(interval_s * max(mode_rad_per_s, 2 / math.sqrt(min(sphere_kg, 1.0))))
        sphere = Sphere(sphere_kg, 1.0, 0.0, 0.0, steps, damping, stays=True)
        line = Line(sphere, HungPlate(1.0, mode_rad_per_s**2, steps), FreeFrame(HEAVY_KG))
        assert line.radius("aitken", interval_s, CONTACT) < 1 + NEUTRAL


def test_the_plain_scheme_does_grow_there() -> None:
    damping = damping_N_s_per_m(0.34, 1e3)
    interval_s = 10 * bound_s("particles-first", 1e3, damping, 0.5)
    sphere = Sphere(1e3, 1.0, 0.0, 0.0, 40, damping, stays=True)
    line = Line(sphere, HungPlate(1.0, 0.25, 40), FreeFrame(HEAVY_KG))
    assert line.radius("particles-first", interval_s, CONTACT) > 2
