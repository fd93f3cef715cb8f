"""Pull and stretch of lines and forces known by hand."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.results.panel_load import stretch, tension_N


def test_a_panel_pulls_its_clamps_together() -> None:
    """200 N of pull: +x on the first clamp, -x on the second; weight is no pull."""
    first, second = np.array([[200.0, 0.0, -3.0]]), np.array([[-200.0, 0.0, -3.0]])
    assert tension_N(first, second, np.array([0.3, 0.0, 0.0])) == pytest.approx([200.0])
    assert tension_N(-first, -second, np.array([0.3, 0.0, 0.0])) == pytest.approx([-200.0])


def test_the_stretch_of_an_arc() -> None:
    """A half circle over 0.2 m is pi * 0.1 long; 0.02 m of straight clamp at both ends."""
    angle = np.linspace(np.pi, 0.0, 401)
    arc = 0.1 * np.column_stack([1 + np.cos(angle), 0 * angle, np.sin(angle)])
    line = np.vstack([[-0.02, 0.0, 0.0], arc, [0.22, 0.0, 0.0]])
    found = stretch(line[None], 0.3, 0.04)
    assert found == pytest.approx([np.pi * 0.1 / 0.3 - 1], abs=1e-5)
