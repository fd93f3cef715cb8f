"""The power of the drives and of each loss over whole cycles, and the drives' work per mass fed."""

from __future__ import annotations

import numpy as np

from orchestrator.figures.estimate import Estimate
from orchestrator.figures.machine import Power
from orchestrator.output.results.estimate import IntervalOf, ratio_by_cycles
from orchestrator.output.results.events import Events
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array

DRIVES = ("exciter", "drive", "motor")
"""The kinds of energy supplied to the frames that an operator pays for."""


def power_metrics(
    run: RunReader,
    start_s: float,
    end_s: float,
    events: Events | None,
    is_steady: bool,
    interval_of: IntervalOf,
) -> Power | None:
    """Return the mean powers from ``start_s`` to ``end_s``, both ends of cycles.

    They are differences of the energy ledger between the last sync points of cycles.  Only a steady motion
    has intervals.  Return None if the window has no whole cycle in the record.
    """
    time_s = run.read("energy_cycles/time_s")
    number = np.rint(time_s / run.cycle_s).astype(int)  # a cycle's last sync point is near to its end
    wanted = (number >= round(start_s / run.cycle_s)) & (number <= round(end_s / run.cycle_s))
    if wanted.sum() < 2:
        return None
    lasting_s = np.diff(time_s[wanted])
    cycle = np.arange(len(lasting_s))

    def mean_W(work_J: Array) -> Estimate:
        return ratio_by_cycles(work_J, lasting_s, cycle, is_steady, interval_of)

    work_J = {
        name.removesuffix("_J"): np.diff(run.read(f"energy_cycles/{name}")[wanted])
        for name in run.names("energy_cycles")
        if name.startswith(("supplied.frames.", "lost."))
    }
    drives_J = sum(
        (J for name, J in work_J.items() if name.removeprefix("supplied.frames.") in DRIVES),
        np.zeros(len(lasting_s)),
    )
    per_feed = None
    if events is not None:
        fed_kg = _fed_kg(events, number[wanted])
        per_feed = ratio_by_cycles(drives_J, fed_kg, cycle, is_steady, interval_of)
    losses_W = {
        name.removeprefix("lost."): mean_W(J) for name, J in work_J.items() if name.startswith("lost.")
    }
    return Power(
        start_s=float(time_s[wanted][0]),
        end_s=float(time_s[wanted][-1]),
        drives_W=mean_W(drives_J),
        lost_W=losses_W,
        drives_J_per_kg=per_feed,
    )


def _fed_kg(events: Events, number: Array) -> Array:
    """Return the mass fed in the cycles that end with the later ones of the ``number``-th cycles' ends."""
    fed_kg = events.balance.fed_kg
    summed_kg = np.concatenate([[0.0], np.cumsum(fed_kg)])
    return np.diff(summed_kg[np.minimum(number, len(fed_kg)).astype(int)])
