"""What crosses a port is checked."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.ports import BrokenRecord, Load, Motion


@pytest.mark.parametrize("bad", [np.nan, np.inf, -np.inf])
def test_what_is_no_number_cannot_cross(bad: float) -> None:
    velocity_m_per_s = np.zeros((4, 3))
    velocity_m_per_s[2, 1] = bad
    with pytest.raises(BrokenRecord, match=r"Motion\.velocity_m_per_s: point 2 is"):
        Motion(np.zeros((4, 3)), velocity_m_per_s)


def test_numbers_whose_square_overflows_cross() -> None:
    assert Load(np.full((2, 3), -1e200)).force_N[0, 0] == -1e200
