"""The memory, files and energy of a long run.

``python -m tools.endurance OUT [--set KEY=VALUE …]`` runs the quickstart's level "hour" into OUT and samples
its process and its folder.  OUT.csv gets a row every ten seconds, and OUT.log the output of the run.
``python -m tools.endurance --table OUT`` prints the growth of each figure and the course of the machine's
energy.  Measured figures: docs/reliability.md, "Long runs".
"""

from __future__ import annotations

import argparse
import csv
import os
import re
import sys
import time
from pathlib import Path

import h5py
import numpy as np

from tests.runs.outside import QUICK, started

EVERY_S = 10.0
COLUMNS = ("wall_s", "simulated_s", "processor_s", "resident_MiB", "files_open", "folder_MiB", "files")


def main(words: list[str]) -> int:
    """Run or print the table, as the words of the command line say, and return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("out", type=Path)
    parser.add_argument("--table", action="store_true")
    given, more = parser.parse_known_args(words)
    if given.table:
        print(table(given.out))
        return 0
    return run_and_sample(given.out, more)


def run_and_sample(out: Path, more: list[str]) -> int:
    """Run the case to its end, sample it meanwhile, and return its exit code."""
    sets = [word for key in QUICK for word in ("--set", key)]
    words = ["run", "cases/quickstart", "--level", "hour", "--out", str(out), *sets, *more]
    log = out.with_suffix(".log").open("w")  # a pipe would be full after an hour
    run, start = started(*words, output=log), time.monotonic()
    with log, out.with_suffix(".csv").open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(COLUMNS)
        while run.poll() is None:
            time.sleep(EVERY_S)
            if run.poll() is None and (out / "run.log").exists():
                rows.writerow([time.monotonic() - start, *sample(run.pid, out)])
                file.flush()
    print(out.with_suffix(".log").read_text()[-2000:])
    return int(run.returncode)


def sample(process: int, out: Path) -> list[float]:
    """Return the figures of a process and its folder, in the order of ``COLUMNS`` after the wall time."""
    system = Path(f"/proc/{process}")
    pages = int((system / "statm").read_text().split()[1])
    ticks = (system / "stat").read_text().rpartition(")")[2].split()[11:13]
    times_s = re.findall(r" t = ([0-9.]+) of ", (out / "run.log").read_text())
    sizes = [size(file) for file in out.rglob("*")]
    return [
        float(times_s[-1]) if times_s else 0.0,
        sum(map(int, ticks)) / os.sysconf("SC_CLK_TCK"),
        pages * os.sysconf("SC_PAGE_SIZE") / 2**20,
        len(list((system / "fd").iterdir())),
        sum(sizes) / 2**20,
        len(sizes),
    ]


def size(file: Path) -> int:
    """Return the size of a file in bytes; 0 for a file that has just been removed."""
    try:
        return file.stat().st_size
    except FileNotFoundError:
        return 0


def table(out: Path) -> str:
    """Return a Markdown table of each figure by tenths of the run, with the lines of the energy.

    The last row has the growth per hour of simulated time in the second half, by least squares.
    """
    data = np.loadtxt(out.with_suffix(".csv"), delimiter=",", skiprows=1)
    simulated = data[:, 1]
    rows = ["| simulated / s | " + " | ".join(COLUMNS[2:]) + " |", "|" + " --- |" * 6]
    for part in np.linspace(0, len(data) - 1, 11).astype(int):
        rows.append("| " + " | ".join(f"{value:.4g}" for value in data[part, 1:]) + " |")
    late = simulated > simulated[-1] / 2
    slopes = 3600 * np.polyfit(simulated[late], data[late, 2:], 1)[0]
    rows.append("| growth per hour | " + " | ".join(f"{slope:.4g}" for slope in slopes) + " |")
    return "\n".join([*rows, "", energy(out)])


def energy(out: Path) -> str:
    """Return the means of stored energies, and the changes of other accounts, by tenths of the run."""
    with h5py.File(out / "history.h5") as history:
        accounts = {name: series[:] for name, series in history["energy"].items()}
    time_s = accounts.pop("time_s")
    rows = []
    for name, values in accounts.items():
        if not values.any():
            continue
        tenths = np.array_split(values, 10)
        if name.startswith("stored."):
            figures, what = [part.mean() for part in tenths], "mean"
        else:
            figures, what = [part[-1] - part[0] for part in tenths], "change"
        numbers = " ".join(f"{figure:.4g}" for figure in figures)
        rows.append(f"{name} ({what} in each tenth of {time_s[-1]:g} s): {numbers}")
    return "\n".join(rows)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
