"""The checks that records show enough of a cycle.

Figures come from sync points wherever that costs little (``output/records/cycle_record.py``).  Figures
from the rows of a series or from output times are refused if these are too far apart.
"""

from __future__ import annotations

import numpy as np

from orchestrator.ports import Array

FEWEST_ROWS = 20  # in a cycle: the range of n samples of a sine falls short by up to 1 - cos(pi/n)
FEWEST_AT_ALL = 4  # in a cycle, if every sync point has a row: the fit has four unknowns
FEWEST_PHASES = 4  # in a cycle: the mean of n even phases has none of the harmonics below the n-th


def rows_too_seldom(
    time_s: Array,
    cycle_s: float,
    sync_interval_s: float,
    span: str = "a cycle",
    fewest_at_all: int = FEWEST_AT_ALL,
) -> str:
    """Return why the rows of a series at ``time_s`` do not show a motion within a cycle; empty if they do.

    ``span`` names ``cycle_s`` in the message.  A series with a row at every sync point shows all that the
    coupling has seen, and needs ``fewest_at_all`` rows only.
    """
    if len(time_s) < 2:
        return "the series have one row only (output.series_s)"
    step_s = float(np.diff(time_s).max())
    rows = cycle_s / step_s
    every = step_s < 1.5 * sync_interval_s
    needed = fewest_at_all if every else FEWEST_ROWS
    if rows >= needed * (1 - 1e-9):
        return ""
    key = "coupling.sync_interval_s" if every else "output.series_s"
    return (
        f"the series have {rows:.3g} rows in {span} of {cycle_s:.3g} s; "
        f"{needed} are needed: {key} of at most {cycle_s / needed:.2g} s"
    )


def phases_missed(time_s: Array, cycle_s: float | None) -> str:
    """Return why a mean over output times would cover only some phases of the cycle; empty if it covers all.

    ``cycle_s`` is None if nothing drives the machine.
    """
    if not len(time_s):
        return "no output time lies in the part that is averaged over (output.interval_s)"
    if cycle_s is None:
        return ""
    phase = np.sort(time_s / cycle_s % 1.0)
    gap = float(np.diff(np.append(phase, phase[0] + 1.0)).max())
    if gap <= (1 + 0.05) / FEWEST_PHASES:
        return ""
    return (
        f"the output times leave out {100 * gap:.0f} % of the machine's cycle of {cycle_s:.3g} s: "
        f"a mean over them is none over the cycle; at least {FEWEST_PHASES} even phases are "
        f"needed, such as by output.interval_s of at most {cycle_s / FEWEST_PHASES:.2g} s"
    )
