"""How the scatter of the efficiency falls with the time and the width that are counted.

    python -m tools.scatter RUN [RUN ...] [--from SECONDS]

Of each run, what left from a time on (by default from the first cycle that its results count) is divided by
the time at which it left and by the place across the width at which it did.  The deviation of the parts'
efficiencies from that of their run, over the root of their number, is what chance leaves in the whole run if
the parts do not depend on each other: it is the same in every line if chance falls with the root of seconds
times width.  Runs of the same setting with several seeds have their own scatter in the last line.
Measured figures: docs/measured/accuracy.md, "Cheap runs beside dear ones".
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from orchestrator.output.results.events import Events, read_events
from orchestrator.output.results.listed_feed import listed_feed
from orchestrator.output.results.run_reader import RunReader, cut_size_m
from orchestrator.output.results.screening import fine_or_coarse, placements
from orchestrator.ports import Array

DIVISIONS = ((2, 1), (3, 1), (4, 1), (1, 2), (1, 4), (2, 2), (4, 2))
"""Parts in time and across the width."""


def efficiencies(
    run: RunReader, from_s: float, to_s: float | None = None, parts: int = 1, strips: int = 1
) -> Array:
    """Return the efficiency in % of what left in equal parts of the time from ``from_s`` to ``to_s``, or to
    the run's end, and in strips across the width with equally many particles, (parts * strips,)."""
    tables = read_events(run.history)
    assert tables is not None, "the run counts what leaves"
    end_s = run.end_s if to_s is None else to_s
    events, feeds = Events(*tables, run.edges_s), tuple(run.case.bed.feeds.values())
    if feeds:
        events = replace(events, listed=listed_feed(feeds, (from_s, end_s)))
    removed, exits = events.removed, events.exits
    group = 2 * removed.exit + fine_or_coarse(removed.sieve_size_m, cut_size_m(run.case) or np.inf)
    counts = (removed.exit >= 0) & (removed.time_s > from_s) & (removed.time_s <= end_s)
    across_m = removed.position_m[:, 1]
    edges_m = np.quantile(across_m[counts], np.arange(1, strips) / strips)
    part = np.searchsorted(np.linspace(from_s, end_s, parts + 1)[1:-1], removed.time_s)
    place = part * strips + np.searchsorted(edges_m, across_m)
    out_kg = np.zeros((parts * strips, 2 * len(exits.names)))
    np.add.at(out_kg, (place[counts], group[counts]), events.left_kg[counts])
    return np.array([100.0 * placements(kg.reshape(-1, 2), exits)["efficiency"] for kg in out_kg])


def chance_of_whole(parts: Sequence[Array]) -> float:
    """Return the standard deviation of a whole run's efficiency by that of its parts, pooled over runs."""
    squares = sum(float(((each - each.mean()) ** 2).sum()) for each in parts)
    return float(np.sqrt(squares / sum(len(each) - 1 for each in parts) / len(parts[0])))


def main(words: Sequence[str]) -> None:
    """Print the chance of a whole run by its parts, division by division."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("runs", nargs="+", type=Path)
    parser.add_argument("--from", dest="from_s", type=float)
    given = parser.parse_args(words)
    readers = [RunReader(folder) for folder in given.runs]
    begins_s = [
        run.summary["results"]["steady"]["start_s"] if given.from_s is None else given.from_s
        for run in readers
    ]
    print("parts in time | strips of the width | chance of the whole run / % | known within")
    for parts, strips in DIVISIONS:
        each = [efficiencies(*one, None, parts, strips) for one in zip(readers, begins_s, strict=True)]
        known = 100 / np.sqrt(2 * len(each) * (parts * strips - 1))
        print(f"{parts} | {strips} | {chance_of_whole(each):.2f} | {known:.0f} %")
    whole = [efficiencies(*one)[0] for one in zip(readers, begins_s, strict=True)]
    own = [run.summary["results"]["screening"]["efficiency_percent"].get("standard_error") for run in readers]
    known_own = [error for error in own if error is not None]
    print(f"efficiencies / %: {', '.join(f'{value:.1f}' for value in whole)}")
    if known_own:
        print(f"standard errors of the runs' own intervals, root of the mean square: {_rms(known_own):.2f} %")
    if len(whole) > 1:
        print(f"deviation between the runs: {np.std(whole, ddof=1):.2f} %")


def _rms(values: Sequence[float]) -> float:
    return float(np.sqrt(np.mean(np.square(values))))


if __name__ == "__main__":
    main(sys.argv[1:])
