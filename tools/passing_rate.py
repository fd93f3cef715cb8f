"""Published efficiencies and velocities on one curve, with runs beside them.

``python -m tools.passing_rate TABLE DECK_LENGTH_M [RUN ...] [--out PICTURE]``

TABLE is a CSV file with the columns ``velocity`` in m/s and ``efficiency`` in percent.  If fines pass at one
rate k for as long as they are on a deck of length L, the efficiency is  1 - exp(-k L / v).  The command gives
the k that fits all rows best, by least squares, and what a rate that falls with the velocity,  k v^-m, adds;
of each RUN it prints the rate of its fines from ``results.contacts``.  ``--out`` draws both.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas

from orchestrator.figures.material import Contacts
from orchestrator.output.results.contacts import fit_rate
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array
from orchestrator.views.style import WIDE, figure, save

EXPONENTS = (0.0, 0.5)
"""Of the velocity, by which a rate falls with it."""


@dataclass(frozen=True)
class Collapse:
    """The fit of  1 - exp(-rate L v^-(1 + exponent))  to efficiencies.

    ``r_squared`` is the share of their variance that it has, ``rms`` the root mean square of what is left.
    """

    exponent: float
    rate: float
    r_squared: float
    rms: float


def collapse(velocity_m_per_s: Array, efficiency: Array, length_m: float, exponent: float) -> Collapse:
    """Return the fit to rows (n,) of velocities and efficiencies, which are shares."""
    rate, rms = fit_rate(length_m * velocity_m_per_s ** -(1.0 + exponent), efficiency)
    return Collapse(exponent, rate, 1.0 - (rms / float(np.std(efficiency))) ** 2, rms)


def read_rows(table: Path) -> tuple[Array, Array]:
    """Return the velocities and the efficiencies, as shares, of a table."""
    rows = pandas.read_csv(table, comment="#")
    return rows["velocity"].to_numpy(float), rows["efficiency"].to_numpy(float) / 100.0


def draw(time_s: Array, efficiency: Array, rate_per_s: float, runs: dict[str, Contacts]) -> Any:
    """Draw the rows over L / v with their curve, and what of each run has passed at each panel's end."""
    fig, ((axes,),) = figure(1, 1, WIDE, 4.0)
    axes.plot(
        time_s, 100.0 * efficiency, "o", color="#8a8f98", ms=4, label=f"published, {len(time_s)} rows: L / v"
    )
    longest_s = max([float(time_s.max()), *(run.fit.time_s[-1] for run in runs.values())])
    times_s = np.linspace(0.0, longest_s, 200)
    label = f"1 − exp(−k L / v), k = {rate_per_s:.2f} 1/s"
    axes.plot(times_s, -100.0 * np.expm1(-rate_per_s * times_s), color="#8a8f98", label=label)
    for name, run in runs.items():
        passed = [row.passed_percent for row in run.along]
        label = f"{name}: panel by panel, k = {run.fit.rate_per_s:.2f} 1/s"
        axes.plot(run.fit.time_s, passed, "s-", ms=4, label=label)
    axes.set(xlabel="time over the deck / s", ylabel="fines that have passed, efficiency / %")
    axes.set_ylim(0, 105)
    axes.legend(loc="lower right")
    return fig


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the rates, and draw them where asked."""
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("table", type=Path)
    words.add_argument("deck_length_m", type=float)
    words.add_argument("runs", nargs="*", type=Path)
    words.add_argument("--out", type=Path)
    given = words.parse_args(arguments)
    velocity_m_per_s, efficiency = read_rows(given.table)
    fits = [collapse(velocity_m_per_s, efficiency, given.deck_length_m, m) for m in EXPONENTS]
    for fit in fits:
        law = f"k v^-{fit.exponent:g}" if fit.exponent else "k"
        print(f"{law}: k {fit.rate:.3f}, R2 {fit.r_squared:.3f}, rms {100 * fit.rms:.1f} points")
    runs: dict[str, Contacts] = {}
    for folder in given.runs:
        with RunReader(folder) as run:
            why = run.results.contacts
            if why is None:
                raise SystemExit(f"{folder}: has no results.contacts: {run.results.missing}")
        runs[folder.name] = why
        print(
            f"{folder.name}: passed over time {why.rate_per_s.value:.3f} 1/s, "
            f"fit {why.fit.rate_per_s:.3f} 1/s within {why.fit.rms_percent:.1f} points; "
            f"counted {why.counted_percent:.1f} %, rebuilt {why.rebuilt_percent:.1f} %"
        )
    if given.out:
        time_s = given.deck_length_m / velocity_m_per_s
        save(draw(time_s, efficiency, fits[0].rate, runs), given.out)


if __name__ == "__main__":
    main()
