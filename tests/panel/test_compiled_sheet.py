"""The compiled explicit sheet against the DOLFINx forms with explicit steps in Python."""

from __future__ import annotations

from contextlib import closing
from itertools import combinations

import numpy as np
import pytest

from orchestrator.coupling.metered import Stopwatch, TimedPanel
from orchestrator.coupling.panel_set import PanelSet
from orchestrator.ports import HermitePath, Load, Motion
from orchestrator.ports.clock import Interval
from orchestrator.ports.geometry import AperturePattern
from orchestrator.ports.plans import SolverFailed
from tests.panel.elastic_plans import BRANCHES, difference, plan, shaken

pytestmark = pytest.mark.solver

SLOTS = AperturePattern("rectangle", 0.009, 0.003, 0.012, 0.006, 0.0, 0.03, 0.012)
PATTERNS = pytest.mark.parametrize("pattern", [None, SLOTS], ids=["plain", "perforated"])
ROUNDING = 1e-12  # of sums over cells in another order, with products fused


LONG = {"width_m": 0.06, "span_m": 0.328, "cells": (11, 3)}
WIDE = {"width_m": 0.2, "span_m": 0.12, "cells": (2, 5)}  # more cells across than along, clamps included
SINGLE = {"width_m": 0.06, "span_m": 0.328, "cells": (1, 1)}


def given(pattern, branches=BRANCHES, shape=LONG, joined=False):
    """Cells of several sizes; their number no multiple of those that stand side by side."""
    return plan(**shape, branches=branches, apertures=pattern, joined_sides=joined)


@PATTERNS
@pytest.mark.parametrize("shape", [LONG, WIDE, SINGLE], ids=["long", "wide", "single"])
def test_force_and_energy_of_deformed_shapes(pattern, shape):
    """Stretched, turned and crumpled at random: force and energies to rounding.  Stretch and turn
    cancel out of the energy of bending, so its rounding is that of the sum of absolute terms.  The
    direction with more cells runs fastest in the compiled sheet's memory."""
    from adapters.panel.finite_element.compiled_sheet import CompiledSheet
    from adapters.panel.finite_element.sheet_forms import sheet

    wanted = given(pattern, shape=shape)
    structure, grid, nodes = sheet(wanted)
    with closing(structure):
        compiled = CompiledSheet(wanted, grid, structure, nodes, structure.bending.flat_m, 1e-5)
        rng = np.random.default_rng(1)
        flat_m, matrix = structure.bending.flat_m, abs(structure.bending.matrix)
        for crumple_m in (1e-5, 1e-4, 1e-3):
            turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
            stretch = np.eye(3) + 0.1 * rng.uniform(-1.0, 1.0, size=(3, 3))
            shape_m = flat_m @ stretch @ turn + rng.normal(scale=crumple_m, size=flat_m.shape)
            structure.rest(shape_m)
            force_N = structure.force_N(shape_m)[nodes]
            compiled.rest(shape_m[nodes])
            assert difference(compiled.internal_N, force_N) < ROUNDING
            stored_J, expected_J = compiled.stored_J(), structure.stored_J()
            terms_J = np.vdot(abs(shape_m - flat_m), matrix @ abs(shape_m - flat_m))
            assert stored_J["membrane"] == pytest.approx(expected_J["membrane"], rel=ROUNDING)
            assert abs(stored_J["bending"] - expected_J["bending"]) < 1e-3 * ROUNDING * terms_J


@pytest.mark.parametrize(
    ("pattern", "branches", "joined"),
    [(None, (), False), (None, BRANCHES, False), (SLOTS, (), False), (SLOTS, BRANCHES, True)],
    ids=["plain", "damped", "perforated", "perforated-damped-joined"],
)
def test_a_shaken_and_loaded_panel(pattern, branches, joined):
    """One cycle and a half of a slack panel under a load that jumps.  1e-9 of the surface's
    motion, the reaction and every entry of the account: the shape at rest, of 1e-7 N out of
    balance, and rounding are all that differs."""
    from adapters.panel import sheet
    from adapters.panel.finite_element.elastic_panel import open_panel
    from adapters.panel.finite_element.panel_at_rest import at_rest
    from adapters.panel.finite_element.sheet_forms import sheet as forms

    wanted = given(pattern, branches, joined=joined)
    panels = open_panel(wanted, at_rest(wanted, forms), *forms(wanted)), sheet.build(wanted)
    rest_m, length_s = panels[0].initial().surface.position_m, 1e-4
    rng = np.random.default_rng(2)
    for k in range(1200):
        load = Load(rng.normal(scale=0.05, size=rest_m.shape))
        python, compiled = (
            panel.advance(Interval(k, length_s), shaken(panel, (k + 1) * length_s), load) for panel in panels
        )
        if k % 100 == 0:
            reached = compiled.surface.position_m - rest_m
            assert difference(reached, python.surface.position_m - rest_m) < 1e-9
            assert difference(compiled.surface.velocity_m_per_s, python.surface.velocity_m_per_s) < 1e-9
            assert difference(compiled.reaction.force_N, python.reaction.force_N) < 1e-9
    expected, actual = (panel.account() for panel in panels)
    assert actual.momentum_kg_m_per_s == pytest.approx(expected.momentum_kg_m_per_s, rel=1e-9, abs=1e-12)
    for books in ("stored_J", "lost_J", "received_J"):
        assert getattr(actual, books) == pytest.approx(getattr(expected, books), rel=1e-9)
    assert bool(actual.lost_J["panel_damping"]) == bool(branches)
    for panel in panels:
        panel.close()


def test_a_blow_up_is_reported_also_when_nothing_is_a_number():
    from adapters.panel import sheet

    panel = sheet.build(given(SLOTS))
    load = Load.zero(len(panel.initial().surface))
    panel._body.memory["strain_stress"][0, 0, 0, 0, 0] = np.nan
    with pytest.raises(SolverFailed, match=r"\b1,.*\b0\.0001\b"):
        panel.advance(Interval(0, 1e-4), shaken(panel, 1e-4), load)
    panel.close()


def test_sheets_of_a_set_advance_together_as_they_do_alone(monkeypatch):
    """The sheets agree to the last bit, and take one call; a surface of another kind stands beside them."""
    from adapters.panel import sheet
    from adapters.panel.common import carried, compiled_panel

    advance, called = compiled_panel.CompiledPanels.__call__, []

    def counted(panels, interval, clamps, load):
        called.append(len(panels))
        return advance(panels, interval, clamps, load)

    monkeypatch.setattr(compiled_panel.CompiledPanels, "__call__", counted)

    def opened(number):
        if number == 2:
            return carried.build(np.arange(6.0).reshape(2, 3), ("driven", "driven"))
        own = sheet.build(given([None, SLOTS, None, SLOTS][number]))
        return TimedPanel(own, f"panel {number}", "panel", Stopwatch())

    alone, members = [opened(number) for number in range(4)], PanelSet(4, opened)
    load = Load(np.random.default_rng(3).normal(scale=0.05, size=(len(members.initial().surface), 3)))
    for k in range(3):
        clamps = shaken(members, (k + 1) * 1e-4)
        called.clear()
        of_set = members.advance(Interval(k, 1e-4), clamps, load)
        assert called == [2, 1]
        for panel, points, held in zip(alone, members.surface, members.clamps, strict=True):
            state = panel.advance(Interval(k, 1e-4), clamps.part(held), load.part(points))
            assert np.array_equal(of_set.surface.position_m[points], state.surface.position_m)
            assert np.array_equal(of_set.surface.velocity_m_per_s[points], state.surface.velocity_m_per_s)
            assert np.array_equal(of_set.reaction.force_N[held], state.reaction.force_N)
    accounts = [panel.account() for panel in alone]
    assert members.account().received_J["load"] == sum(own.received_J["load"] for own in accounts)
    members._own[1]._solver._body.memory["strain_stress"][0, 0, 0, 0, 0] = np.nan
    members._own[1]._solver._name = "panel of slots"
    with pytest.raises(SolverFailed, match=r"panel of slots, t = 0.0004 s: unstable"):
        members.advance(Interval(3, 1e-4), shaken(members, 4e-4), load)
    for panel in (*alone, members):
        panel.close()


def test_arrays_of_a_wrong_size_or_type_are_refused():
    """Arrays are never converted: what is written to a copy would be lost."""
    from adapters.panel import sheet

    panel = sheet.build(given(None))
    kernel = panel._body.kernel
    held = np.zeros((len(panel.mount.frame), 3))
    steps = {
        "start_m": held,
        "start_m_per_s": held,
        "end_m": held,
        "end_m_per_s": held,
        "outside_N": np.zeros((len(panel.initial().surface), 3)),
        "length_s": 1e-4,
        "steps": 5,
        "impulse_N_s": held,
    }
    wanted = steps["outside_N"].size
    with pytest.raises(ValueError, match=rf"^outside_N:.*\b{wanted}\b.*\b3$"):
        kernel.advance(**steps | {"outside_N": np.zeros(3)})
    with pytest.raises(TypeError):
        kernel.advance(**steps | {"impulse_N_s": held.astype(np.float32)})
    with pytest.raises(TypeError):
        kernel.advance(*steps.values())
    panel.close()


def bound(arrays, change=()):
    """A compiled sheet that stands still and bent under a load, and takes ``arrays`` by other names, and
    others by ``change`` (None: without it)."""
    from adapters.panel import _kernel
    from adapters.panel.finite_element import compiled_sheet, sheet_forms

    compiled = _kernel.Sheet

    def kernel(**named):
        given_arrays = named | {name: named[other] for name, other in arrays.items()} | dict(change)
        return compiled(**{name: array for name, array in given_arrays.items() if array is not None})

    structure, grid, nodes = sheet_forms.sheet(given(None))
    bent_m = structure.bending.flat_m.copy()
    bent_m[nodes[1::2], 2] += 1e-3
    with closing(structure), pytest.MonkeyPatch.context() as patch:
        patch.setattr(_kernel, "Sheet", kernel)
        sheet = compiled_sheet.CompiledSheet(given(None), grid, structure, nodes, bent_m, 1e-5)
        sheet.velocity_m_per_s[:] = 0.01
        sheet.rest(bent_m[nodes])
    return sheet


def advanced(sheet):
    """All arrays of a sheet after two steps under a load."""
    held_m = sheet._flat_m[sheet.held]
    still = Motion(held_m, np.zeros_like(held_m))
    outside_N = np.full_like(sheet.position_m, 1e-3)
    sheet.move(HermitePath(still, still, 2e-5), outside_N, Interval(0, 2e-5))
    return sheet.memory


ALIKE = ("position_m", "velocity_m_per_s", "internal_N", "elastic_N")


@pytest.mark.parametrize("pair", list(combinations(ALIKE, 2)), ids="-".join)
def test_arrays_of_equal_size_cannot_be_exchanged_unnoticed(pair):
    """Names alone tell the arrays apart: with two exchanged they hold something else."""
    first, second = pair
    expected, actual = advanced(bound({})), advanced(bound({first: second, second: first}))
    assert not all(np.allclose(actual[name], expected[name], rtol=1e-6, atol=1e-9) for name in pair)


@pytest.mark.parametrize(
    "pair", [("strain", "strain_stress"), ("energy_J", "lost_J"), ("solid", "mobility_1_kg")]
)
def test_arrays_of_unequal_size_exchanged_are_named(pair):
    with pytest.raises(ValueError, match=rf"^({'|'.join(pair)}):"):
        bound({pair[0]: pair[1], pair[1]: pair[0]})


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"flat_m": None}, "flat_m"),
        ({"flat": np.zeros(3)}, "flat"),
        ({"flat_m": np.zeros((2, 3), dtype=np.float32)}, "flat_m"),
    ],
)
def test_names_and_types_of_arrays_are_checked_when_they_are_bound(change, name):
    with pytest.raises(TypeError, match=rf"\b{name}\b"):
        bound({}, change)
