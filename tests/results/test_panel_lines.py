"""Pull, stretch and height of lines and forces known by hand."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.records.panel_lines import PanelLines, clamped_length_m, panel_pull_N
from orchestrator.ports import Array
from orchestrator.ports.geometry import Rectangle

AT = Rectangle(
    corner_m=np.zeros(3),
    along=np.array([1.0, 0.0, 0.0]),
    across=np.array([0.0, 1.0, 0.0]),
    length_m=0.3,
    span_m=0.2,
    width_m=0.2,
    clamp_m=0.02,
)


def line(radius_m: float = 0.1, points: int = 401) -> Array:
    """Half an ellipse between clamps 0.2 m apart, with 0.02 m of straight clamp at both ends."""
    angle = np.linspace(np.pi, 0.0, points)
    arc = np.column_stack([0.1 * (1 + np.cos(angle)), 0 * angle, radius_m * np.sin(angle)])
    return np.vstack([[-0.02, 0.0, 0.0], arc, [0.22, 0.0, 0.0]])


def test_a_panel_pulls_its_clamps_together() -> None:
    """200 N of pull: +x on the first clamp, -x on the second; weight is no pull."""
    first, second = np.array([[200.0, 0.0, -3.0]]), np.array([[-200.0, 0.0, -3.0]])
    assert panel_pull_N(first, second, np.array([1.0, 0.0, 0.0])) == pytest.approx([200.0])
    assert panel_pull_N(-first, -second, np.array([1.0, 0.0, 0.0])) == pytest.approx([-200.0])


def test_the_stretch_of_an_arc() -> None:
    """A half circle over 0.2 m is pi * 0.1 long; lines of two panels do not mix."""
    assert clamped_length_m(AT, line()) == pytest.approx(0.04)
    lines = PanelLines([AT, AT], [line(), line(points=301)])
    stretch = lines.stretch(np.vstack([line(), line(points=301) + np.array([5.0, 0.0, 0.0])]))
    assert stretch == pytest.approx([np.pi * 0.1 / 0.3 - 1] * 2, abs=2e-5)


@pytest.mark.parametrize("tilt_rad", [0.0, 0.3])
def test_heights_are_over_the_chord(tilt_rad: float) -> None:
    """Heights are positive upwards, so that a panel which snaps through travels by both of its arches."""
    c, s = np.cos(tilt_rad), np.sin(tilt_rad)
    turn = np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])
    lines = PanelLines([AT, AT], [line(), line()])
    largest_m, middle_m = lines.heights_m(np.vstack([line(0.04), line(-0.03)]) @ turn)
    assert largest_m == pytest.approx([0.04, 0.03], rel=1e-9)
    assert middle_m == pytest.approx([0.04, -0.03], rel=1e-9)
