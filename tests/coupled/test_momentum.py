"""Momentum across all interfaces of a full three-way run, to rounding.

Law: what one member gives the other receives, and a member's momentum changes by what it
received.  Measured: at most 6e-14 of the impulses that should balance.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cases import load_case
from tests.coupled.machines import opened
from tests.coupled.screen import CASE

pytestmark = pytest.mark.solver


@pytest.mark.smoke
@pytest.mark.parametrize("scheme", ["particles-first", "robin", "serial-staggered"])
@pytest.mark.parametrize("integrator", ["explicit", "implicit"])
def test_momentum_to_rounding(tmp_path: Path, scheme: str, integrator: str) -> None:
    settings = [f"coupling.scheme={scheme}", f"panel.integrator={integrator}"]
    with opened(load_case(tmp_path, CASE, settings)) as run:
        run.advance(400)
        residuals = run.momentum_residual()
        assert set(residuals) == {"frames", "panel", "particles", "panel-frames", "particles-panel"}
        assert max(residuals.values()) < 1e-12, residuals
        # the bed was really thrown: it gave the panels more than a third of its first momentum
        given_N_s = run.machine.members.particles.given.impulse_N_s
        assert abs(given_N_s[2]) > 0.005
