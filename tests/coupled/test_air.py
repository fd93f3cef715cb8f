"""Air and a rebound over speed on a screen whose mats bend: the books of momentum and of energy."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cases import load_case
from tests.coupled.machines import Coupled, opened
from tests.coupled.screen import BED, CASE, MACHINE, SMOOTH_AND_ELASTIC

pytestmark = pytest.mark.solver

THICK = "air={density_kg_per_m3=10.0, viscosity_Pa_s=1e-3}"
"""Air in which grains of 2.5 mm at 0.5 m/s feel a fifth of their weight as drag."""


def points(restitution: float, of_fast: float) -> list[str]:
    """Return the settings of a restitution that is linear from 0.1 to 1 m/s for both pairs of materials."""
    rows = (
        f"[{{impact_m_per_s=0.1, restitution={restitution}}}, {{impact_m_per_s=1.0, restitution={of_fast}}}]"
    )
    return [f"contacts.{pair}.restitution={rows}" for pair in (0, 1)]


def bed_J(run: Coupled) -> float:
    bed = run.particles()
    return 0.5 * float(bed.grains.mass_kg @ (bed.velocity_m_per_s**2).sum(axis=1))


@pytest.mark.parametrize("scheme", ["particles-first", "robin", "serial-staggered"])
def test_momentum_to_rounding_in_air_and_with_rebound_over_speed(tmp_path: Path, scheme: str) -> None:
    """The air is an outside party; what it gives is booked, as what the bushings give is."""
    settings = [THICK, f"coupling.scheme={scheme}", *points(0.8, 0.3)]
    with opened(load_case(tmp_path, CASE, settings)) as run:
        run.advance(400)
        residuals = run.momentum_residual()
        assert max(residuals.values()) < 1e-12, residuals
        particles = run.machine.members.particles
        assert abs(particles.given.impulse_N_s[2]) > 0.005  # the bed was thrown
        assert run.energy_J("lost.particles.air_drag")["lost.particles.air_drag"] > 0.0


def test_energy_in_air_without_other_losses(tmp_path: Path) -> None:
    """Smooth grains whose restitution is 1 at both of its points fall through thick air on undamped panels.

    What is stored and what the air took, which is the work of its drag, make up what was there: the contacts'
    loss, which the books compute as what is missing, and what the coupling creates stay below half a per cent
    of the bed's first energy.  The air takes many times as much.
    """
    settings = [
        *SMOOTH_AND_ELASTIC,
        *points(1.0, 1.0),
        THICK,
        "bed.blocks.coal.count=800",
        "bed.blocks.coal.sizes=[{smallest_m=0.0025, largest_m=0.0025, mass_fraction=1.0}]",
        "particles.rayleigh_fraction=0.15",
        "screen.drawn_at_rest=false",
    ]
    with opened(load_case(tmp_path, MACHINE + BED, settings)) as run:
        first_J = bed_J(run)
        run.advance(400)
        stored_J = sum(run.energy_J("stored").values())
        lost_J = run.energy_J("lost.particles")
    assert lost_J["lost.particles.air_drag"] > 0.03 * first_J
    assert abs(lost_J["lost.particles.contact_dissipation"]) < 5e-3 * first_J
    assert abs(stored_J + lost_J["lost.particles.air_drag"]) < 5e-3 * first_J
