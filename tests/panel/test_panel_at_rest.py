"""Equal panels share one resting shape and one largest step."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.panel.elastic_plans import plan

pytestmark = pytest.mark.solver


def test_panels_that_differ_in_their_place_alone_are_settled_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """The next panel of a deck, held by other frames over a stop; one that hangs otherwise is another."""
    from adapters.panel import sheet
    from adapters.panel.finite_element import panel_at_rest

    settled = []

    def settle(structure, tangent, start_m, weight_N):
        structure.force_N(start_m)  # so that it stands there
        settled.append(start_m)
        return start_m

    monkeypatch.setattr(panel_at_rest, "settle", settle)
    first = plan(span_m=0.3125, cells=(3, 1))  # of no other test
    moved_m = np.array([0.4, 0.0, -0.1])
    rectangle = replace(first.rectangle, corner_m=first.rectangle.corner_m + moved_m)
    second = replace(first, name="second", rectangle=rectangle, frames=("b", "a"), step_s=1e-9)
    panels = [sheet.build(each) for each in (first, second)]
    assert len(settled) == 1
    step_s = sheet.largest_step_s(second)
    assert sheet.largest_step_s(first) == step_s
    places_m = [panel.initial().surface.position_m for panel in panels]
    np.testing.assert_allclose(places_m[1] - places_m[0], np.tile(moved_m, (len(places_m[0]), 1)))
    assert len(settled) == 1
    heavier = replace(first, gravity_m_per_s2=2.0 * first.gravity_m_per_s2)
    assert sheet.largest_step_s(heavier) == pytest.approx(step_s)
    assert len(settled) == 2
    for panel in panels:
        panel.close()
