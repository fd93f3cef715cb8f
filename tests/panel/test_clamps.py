"""A clamp does the same to the panel's end with every solver that bends.

``clamp_m = 0`` is a hinge: the end cannot move, but it can turn.  A clamp with depth, however
short, is built in: the end can do neither.
"""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest

from orchestrator.ports.plans import PanelPlan
from tests.panel.elastic_plans import plan

pytestmark = pytest.mark.solver

LENGTH_M, SIDE_M, GRAVITY_M_PER_S2, DENSITY_KG_PER_M3, YOUNGS_PA = 0.3, 0.004, 0.02, 1200.0, 21e6


def narrow(solver: str, clamp_m: float) -> PanelPlan:
    """A panel as narrow as it is thick, so that a sheet bends like a beam, under so little weight
    that it sags by 2 % of its thickness and its ends do not pull."""
    return plan(
        length_m=LENGTH_M,
        thickness_m=SIDE_M,
        width_m=SIDE_M,
        clamp_m=clamp_m,
        gravity_m_per_s2=GRAVITY_M_PER_S2,
        cells=(60, 1),
        integrator="explicit" if solver == "strip" else "implicit",
    )


@pytest.mark.parametrize("solver", ["strip", "sheet", "solid"])
@pytest.mark.parametrize(
    ("clamp_m", "share"),
    [(0.0, 5 / 384), (0.005, 1 / 384), (0.02, 1 / 384)],
    ids=["hinges", "built in over 5 mm", "built in over 20 mm"],
)
def test_sag_under_its_own_weight(solver: str, clamp_m: float, share: float) -> None:
    """The middle of a beam sags by  5 q L^4 / (384 E I)  between hinges and by a fifth of that
    where it is built in (S. Timoshenko, Strength of Materials, part I, 1955, ch. 5).

    Within 1 %: measured -0.2 to +0.01 % between hinges; built in +0.2 % (strip), -0.4 % (sheet,
    held across, too) and -0.8 % (solid, whose ends are held over their whole section).
    """
    given = narrow(solver, clamp_m)
    panel = import_module(f"adapters.panel.{solver}").build(given)
    middle = panel.interpolation(np.array([[LENGTH_M / 2, SIDE_M / 2]])).values
    sag_m = 0.3 - (middle @ panel.initial().surface.position_m)[0, 2]
    panel.close()
    weight_N_per_m = DENSITY_KG_PER_M3 * GRAVITY_M_PER_S2 * SIDE_M**2
    bending_N_m2 = YOUNGS_PA * SIDE_M**4 / 12
    assert sag_m == pytest.approx(share * weight_N_per_m * LENGTH_M**4 / bending_N_m2, rel=0.01)


@pytest.mark.parametrize("solver", ["sheet", "solid"])
def test_a_taut_panel_pulls_as_much_on_hinges(solver: str) -> None:
    """The middle line of its end carries the solid's pull as well as the whole end does: a panel of
    30 mm between hinges pulls with  N = A P(1.025)  of uniaxial stretch, within 3 %."""
    length_m, stretch = 0.3, 1.025
    given = plan(
        length_m=length_m,
        span_m=length_m * stretch,
        width_m=0.03,
        clamp_m=0.0,
        gravity_m_per_s2=0.0,
        cells=(30, 3),
        integrator="implicit",
    )
    panel = import_module(f"adapters.panel.{solver}").build(given)
    driven = np.array([frame == "driven" for frame in panel.mount.frame])
    pull_N = -panel.initial().reaction.force_N[driven, 0].sum()
    panel.close()
    stress_Pa = 2 * (stretch - stretch**-2) * (7e5 + 2.8e6 / stretch)
    assert pull_N == pytest.approx(stress_Pa * 0.03 * 0.004, rel=0.03)
