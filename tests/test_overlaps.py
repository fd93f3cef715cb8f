"""Overlaps up to which a contact law holds."""

from __future__ import annotations

import math

import pytest
from scipy.optimize import brentq

from orchestrator.ports.particle_records import LARGEST_OWN_OVERLAP


def sneddon(overlap: float) -> float:
    """Return the force on a rigid sphere in an elastic half space, over E* R^2.

    ``overlap`` is its depth over R, a the radius of contact over R (I. N. Sneddon, Int. J. Engng Sci. 3,
    1965, 47, doi 10.1016/0020-7225(65)90019-4):
    depth = a/2 ln((1 + a) / (1 - a)),  force = (a^2 + 1)/2 ln((1 + a) / (1 - a)) - a.
    """
    a = brentq(lambda a: a * math.atanh(a) - overlap, 1e-6, 1 - 1e-9)
    return float((a**2 + 1) * math.atanh(a) - a)


def test_hertz_s_force_is_a_tenth_too_large_at_the_largest_overlap() -> None:
    hertz = 4 / 3 * LARGEST_OWN_OVERLAP**1.5
    assert hertz / sneddon(LARGEST_OWN_OVERLAP) == pytest.approx(1.1, abs=0.005)
    assert 4 / 3 * 0.01**1.5 / sneddon(0.01) == pytest.approx(1.0, abs=0.002)
