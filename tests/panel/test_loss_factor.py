"""Free vibration decays as the loss factor says that was asked for.

A straight panel without weight is struck along itself, in the shape of its first longitudinal
mode: all its strain is the material's (a taut panel's transverse vibration has a share of
tension, which loses nothing).  With a modulus E (1 + sum g s tau / (1 + s tau)) of the complex
rate s the mode obeys  s^2 + w0^2 (1 + sum ...) = 0;  its root s = -d + i w has  2 d / w = loss
factor at w  to the second order in it (Nashif, Jones and Henderson, Vibration Damping, 1985,
chapter 4): 0.12^2 / 4 = 0.4 %.
"""

from __future__ import annotations

from importlib import import_module

import numpy as np
import pytest

from orchestrator.case.file.loss_curve import fit_branches
from orchestrator.ports import Array, Load, Motion
from orchestrator.ports.clock import Interval
from tests.panel.elastic_plans import plan

WANTED = 0.12
STEP_s = 1e-4
MODELS = {"strip": 0.0, "sheet explicit": 0.0, "sheet implicit": 2.5e-5}


def moved_m(model: str, branches: tuple[tuple[float, float], ...], intervals: int) -> Array:
    """Displacement along the panel of its middle after each interval since the strike."""
    solver, _, integrator = model.partition(" ")
    given = plan(
        gravity_m_per_s2=0.0,
        cells=(12, 1),
        integrator=integrator or "explicit",
        step_s=MODELS[model],
        branches=branches,
        sync_interval_s=STEP_s,
    )
    panel = import_module(f"adapters.panel.{solver}").build(given)
    start = panel.initial().surface
    clamps = Motion(panel.mount.position_m, np.zeros_like(panel.mount.position_m))
    s_m = start.position_m[:, 0] - given.rectangle.corner_m[0]
    shape = np.sin(np.pi * np.clip(s_m / given.rectangle.length_m, 0.0, 1.0))
    strike = Load(np.outer(shape, [1.0, 0.0, 0.0]))
    still = Load.zero(len(start))
    states = [panel.advance(Interval(k, STEP_s), clamps, still if k else strike) for k in range(intervals)]
    return np.array([(one.surface.position_m - start.position_m)[:, 0] @ shape for one in states])


def rate_1_s(values: Array, apart: int) -> complex:
    """s of  Re(a exp(s t))  by least squares over  u(t + 2 T) + p u(t + T) + q u(t) = 0."""
    first, second, third = values[: -2 * apart], values[apart:-apart], values[2 * apart :]
    p, q = np.linalg.lstsq(np.column_stack([second, first]), -third, rcond=None)[0]
    root = np.roots([1.0, p, q])[0]
    return complex(np.log(root) / (apart * STEP_s))


@pytest.mark.parametrize(
    "model", [pytest.param(m, marks=[pytest.mark.solver] if "sheet" in m else []) for m in MODELS]
)
def test_a_free_vibration_has_the_loss_factor_asked_for(model: str) -> None:
    """5 %: 3 % of the fit, 0.4 % of the second order, and what creeps besides the mode."""
    fit = fit_branches(tuple((f, WANTED, None) for f in (10.0, 30.0, 100.0, 300.0)))
    values = moved_m(model, fit.branches, 300)
    s = rate_1_s(values[60:], 10)
    assert 150.0 < abs(s.imag) / (2 * np.pi) < 350.0
    assert -2 * s.real / abs(s.imag) == pytest.approx(WANTED, rel=0.05)
