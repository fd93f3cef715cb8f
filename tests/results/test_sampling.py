"""The spacing of rows and output times that tells a cycle, and that which does not."""

from __future__ import annotations

import numpy as np
import pytest

from orchestrator.output.results.sampling import phases_missed, rows_too_seldom

CYCLE_S = 0.08004


@pytest.mark.parametrize(
    ("step_s", "sync_interval_s", "key"),
    [
        (4e-3, 1e-4, ""),
        (4.1e-3, 1e-4, "output.series_s of at most 0.004 s"),
        (1e-2, 1e-2, ""),  # at every sync point: the coupling has seen no more
        (3e-2, 3e-2, "coupling.sync_interval_s of at most 0.02 s"),
    ],
)
def test_rows_of_a_series(step_s: float, sync_interval_s: float, key: str) -> None:
    why = rows_too_seldom(np.arange(100) * step_s, CYCLE_S, sync_interval_s)
    assert key in why
    assert bool(why) is bool(key)


def test_rows_at_every_sync_point_are_all_there_is() -> None:
    """The run has no drive and is cut into parts shorter than its sync intervals."""
    time_s = np.arange(20) * 1e-4
    assert rows_too_seldom(time_s, 4e-5, 1e-4, "a fiftieth of the run,", 0) == ""
    assert "a fiftieth of the run, of 4e-05 s" in rows_too_seldom(
        time_s[::2], 4e-5, 1e-4, "a fiftieth of the run,", 0
    )


@pytest.mark.parametrize(
    ("interval_s", "times", "enough"),
    [
        (0.02, 200, True),  # four phases of the cycle
        (0.03, 200, True),  # eight, one after the other
        (0.05, 200, True),
        (0.04, 50, False),  # two: forth and back
        (0.08, 200, False),  # one
        (0.8, 4500, True),  # one, which goes round in the hour
        (0.8, 100, False),
    ],
)
def test_output_times(interval_s: float, times: int, enough: bool) -> None:
    assert (phases_missed(np.arange(1, times + 1) * interval_s, CYCLE_S) == "") is enough


def test_what_nothing_drives_has_no_phases() -> None:
    assert phases_missed(np.array([1.0]), None) == ""
    assert "no output time" in phases_missed(np.empty(0), None)
