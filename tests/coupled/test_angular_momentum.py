"""Angular momentum about the world's origin between spinning balls and panels on free frames.

Law: what the particles give the surface, in their own steps, is the moment of the mean load on the
panel's mean place, but for  sum over intervals of the integral of (x - mean x) x (f - mean f).
Where forces last, that is v f' H^2 / 12 of each second.  A damper with the constant c feels a wall that
goes on with its speed from the sync point while its frame of mass M slows down, so that its force is off by
c f H / M at the interval's end: v c f H / (12 M) of each second, of first order.
"""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cases import load_case
from tests.coupled.machines import opened
from tests.coupled.screen import MACHINE
from tests.reference.spheres.triangle_spin import TriangleSpin

BALLS = [
    f"bed.particles.ball-{i}-{j}={{position_m=[{0.03 + 0.03 * i}, {0.03 + 0.04 * j}, 0.0101], "
    "velocity_m_per_s=[0.1, 0.0, -0.05], spin_rad_per_s=[30, -80, 10], sieve_size_m=0.02, "
    'axes="deck", material="coal"}'
    for i in range(3)
    for j in range(2)
]
ROLLING = [f"contacts.{pair}.rolling_friction=0.1" for pair in (0, 1)]


def residual(folder: Path, solver: str, law: str, sync_interval_s: float) -> dict[str, float]:
    """Return the residual after 20 ms on rigid panels, inclined by 15 degrees, on frames that move freely."""
    settings = [
        "panel.solver=rigid",
        "frames.solver=planar",
        f"particles.solver={solver}",
        f"particles.rolling={law}",
        f"coupling.sync_interval_s={sync_interval_s}",
    ]
    with opened(load_case(folder, MACHINE, [*BALLS, *ROLLING, *settings])) as run:
        run.advance(round(0.02 / sync_interval_s))
        return run.angular_momentum_residual()


@pytest.mark.parametrize("solver", ["spheres", pytest.param("liggghts", marks=pytest.mark.solver)])
@pytest.mark.parametrize("law", ["epsd2", "cdt"])
def test_spinning_balls_on_free_frames(tmp_path: Path, solver: str, law: str) -> None:
    residuals = residual(tmp_path, solver, law, 1e-4)
    assert residuals["particles"] < 1e-12
    assert 0.0 < residuals["particles-panel"] < 1e-7  # 6.7e-8 measured, and half of it at half the interval
    assert residuals["panel-frames"] < 1e-8


def test_without_the_couple_it_does_not_close(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(TriangleSpin, "forces", lambda self, couple_N_m: 0.0 * self.arms_m)
    assert residual(tmp_path, "spheres", "epsd2", 1e-4)["particles"] > 1e-3
