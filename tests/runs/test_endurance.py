"""A long run holds no more than a short one.  An hour of it: docs/reliability.md, "Long runs"."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from tests.runs.outside import QUICK, flipflow, summary

# what the process holds, at two sync points
COUNTED = """
import ctypes, gc, os
from adapters.frames import two_mass
advance = two_mass.TwoMassFrames.advance
def counted(self, interval, reaction):
    if interval.index in (2000, 6000):
        gc.collect()
        ctypes.CDLL(None).malloc_trim(0)  # or what the allocator keeps counts, 2 MB more or less
        pages = int(open("/proc/self/statm").read().split()[1])
        files = len(os.listdir("/proc/self/fd"))
        with open({file!r}, "a") as out:
            print(pages * os.sysconf("SC_PAGE_SIZE"), files, len(gc.get_objects()), file=out)
    return advance(self, interval, reaction)
two_mass.TwoMassFrames.advance = counted
"""
OFTEN = ("output.interval_s=0.08", "bed.feeds.thin.rate_kg_per_s=0.05", "checkpoint.every_s=0.4")


@pytest.mark.solver
@pytest.mark.slow
def test_fifty_cycles_hold_no_more_than_before(tmp_path: Path) -> None:
    """4000 sync intervals, 50 output times, 10 checkpoints and some 40 particles that came and went.  A
    kilobyte kept of each interval would be 4 MB."""
    file = tmp_path / "held"
    words = ["run", "cases/quickstart", "--level", "hour", "--out", str(tmp_path / "run")]
    sets = [*QUICK, *OFTEN, "duration_s=6.4"]
    before = COUNTED.format(file=str(file))
    done = flipflow(*words, *(word for key in sets for word in ("--set", key)), before=before)
    assert done.returncode == 0, done.stderr
    assert summary(tmp_path / "run")["results"]
    (early, files, objects), (late, files_late, objects_late) = np.loadtxt(file)
    assert late - early < 2**20
    assert files_late == files
    assert objects_late - objects < 200
