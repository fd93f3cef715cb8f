"""Free vibration decays as the loss factor says that was asked for.

A straight panel without weight is struck along itself, in the shape of its first longitudinal
mode: all its strain is the material's (a taut panel's transverse vibration has a share of
tension, which loses nothing).  A panel that is stretched between its clamps has the same loss
factor: its stiffness is then another one, and so is what its branches answer.  With a modulus
E (1 + sum g s tau / (1 + s tau)) of the complex rate s the mode obeys
s^2 + w0^2 (1 + sum ...) = 0;  its root s = -d + i w has  2 d / w = loss factor at w  to the second order
in it (Nashif, Jones and Henderson, Vibration Damping, 1985, chapter 4).
"""

from __future__ import annotations

from contextlib import closing
from importlib import import_module

import numpy as np
import pytest
from scipy.optimize import brentq

from orchestrator.case.file.loss_curve import fit_branches
from orchestrator.ports import Array, Load, Motion
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import AperturePattern
from tests.panel.elastic_plans import plan

WANTED = 0.12
STEP_s = 1e-4
MODELS = {"strip": 0.0, "sheet explicit": 0.0, "sheet implicit": 2.5e-5, "solid implicit": 2.5e-5}
LENGTH_M = 0.33
SLOTS = AperturePattern("rectangle", 0.012, 0.006, 0.016, 0.010, 0.0, 0.03, 0.0)


def moved_m(model: str, tension: float, branches: tuple[tuple[float, float], ...], intervals: int) -> Array:
    """Displacement along the panel of its middle after each interval since the strike."""
    solver, _, integrator = model.partition(" ")
    given = plan(
        length_m=LENGTH_M,
        span_m=LENGTH_M * (1 + tension),
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
    shape = np.sin(np.pi * np.clip(s_m / given.rectangle.span_m, 0.0, 1.0))
    strike = Load(np.outer(shape, [1.0, 0.0, 0.0]))
    still = Load.zero(len(start))
    states = [panel.advance(Interval(k, STEP_s), clamps, still if k else strike) for k in range(intervals)]
    return np.array([(state.surface.position_m - start.position_m)[:, 0] @ shape for state in states])


def loss_factor(branches: tuple[tuple[float, float], ...], frequency_Hz: float) -> float:
    """2 d / w of the root of a mode that vibrates at this frequency."""

    def rate_of(unrelaxed_rad_per_s: float) -> complex:
        s = 1j * unrelaxed_rad_per_s
        for _ in range(100):
            s = (
                1j
                * unrelaxed_rad_per_s
                * (1 + sum(g * s * tau / (1 + s * tau) for g, tau in branches)) ** 0.5
            )
        return complex(s)

    wanted = 2 * np.pi * frequency_Hz
    s = rate_of(brentq(lambda w: rate_of(w).imag - wanted, 0.5 * wanted, wanted))
    return -2 * s.real / s.imag


def rate_1_s(values: Array, apart: int) -> complex:
    """s of  Re(a exp(s t)), beside which something creeps, exp(-r t), by least squares over
    u(t + 3 T) + p u(t + 2 T) + q u(t + T) + r u(t) = 0  (Prony's method)."""
    *before, last = (values[k * apart : len(values) - (3 - k) * apart] for k in range(4))
    factors = np.linalg.lstsq(np.column_stack(before[::-1]), -last, rcond=None)[0]
    root = max(np.roots([1.0, *factors]), key=lambda value: abs(value.imag))
    return complex(np.log(root) / (apart * STEP_s))


@pytest.mark.parametrize("tension", [0.0, 0.02, 0.04])
@pytest.mark.parametrize(
    "model", [pytest.param(m, marks=[pytest.mark.solver] if m != "strip" else []) for m in MODELS]
)
def test_a_free_vibration_has_the_loss_factor_asked_for(model: str, tension: float) -> None:
    """The loss factor of the branches at this frequency, as far as other modes let the fit see it: a strip
    has none across, and 0.2 %; sheets and solids also move across, 4 %.  The fit of the branches is within
    3 % of what was asked for, and the second order raises it by up to 4 % where they stiffen the panel."""
    fit = fit_branches(tuple((f, WANTED, None) for f in (10.0, 30.0, 100.0, 300.0)))
    values = moved_m(model, tension, fit.branches, 300)
    s = rate_1_s(values[60:], 10)
    frequency_Hz = abs(s.imag) / (2 * np.pi)
    assert 150.0 < frequency_Hz < 350.0
    measured, wanted = -2 * s.real / abs(s.imag), loss_factor(fit.branches, frequency_Hz)
    assert measured == pytest.approx(wanted, rel=0.002 if model == "strip" else 0.04)
    assert wanted == pytest.approx(WANTED, rel=0.075)


@pytest.mark.solver
@pytest.mark.parametrize("tension", [0.0, 0.04])
@pytest.mark.parametrize("model", ["sheet", "sheet with openings", "solid"])
def test_branches_answer_a_small_change_as_the_stretched_panel_does(model: str, tension: float) -> None:
    """A branch that never relaxes doubles the stiffness against a small longitudinal load.  0.2 %:
    entries are those of each cell's mean strain, and a solid's branches do not answer a change of volume."""
    from adapters.panel.finite_element.panel_at_rest import at_rest
    from adapters.panel.finite_element.sheet_forms import sheet
    from adapters.panel.finite_element.solid_forms import solid
    from adapters.panel.finite_element.tangent import Tangent

    make = solid if model == "solid" else sheet
    given = plan(
        length_m=LENGTH_M,
        span_m=LENGTH_M * (1 + tension),
        gravity_m_per_s2=0.0,
        cells=(12, 1),
        branches=((1.0, 1e6),),
        apertures=SLOTS if "openings" in model else None,
    )
    resting_m = at_rest(given, make).from_corner_m + given.rectangle.corner_m
    structure = make(given)[0]
    structure.rest(resting_m)
    with closing(structure), closing(Tangent(structure)) as tangent:
        structure.force_N(resting_m)
        tangent.factorise(0.0, 1.0)
        load_N = np.zeros_like(resting_m)
        along = np.sin(np.pi * np.clip(structure.material_m[:, 0] / LENGTH_M, 0.0, 1.0))
        load_N[:, 0] = structure.mass_kg * along
        move_m = tangent.solve(load_N)
        move_m *= 1e-6 / np.abs(move_m).max()

        def work_J() -> float:
            both = structure.force_N(resting_m + move_m), structure.force_N(resting_m - move_m)
            return float(np.vdot(move_m, both[0] - both[1]))

        elastic_J = work_J()
        structure.begin_step(1e-6)
        assert work_J() == pytest.approx(2 * elastic_J, rel=0.002)
