"""Read from a run of this case who has been thrown out: ``python released.py RUN [FOLDER]``.

It writes into a folder, by default this one, from which docs/pictures/wedged_grains.py reads:

- ``released.csv``: for each turn the largest stretch of the slots so far and the share of grains out;
- ``turn.csv``: places of one grain and of its slot's walls over the turn in which it comes free.
"""

from __future__ import annotations

import csv
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pyvista

import flipflow

HERE = Path(__file__).parent
SLOT_M, HALF_DEPTH_M = 0.012, 0.003
FRAMES = 6
EDGES = {"left_upper": (-1, 1), "right_upper": (1, 1), "left_lower": (-1, -1), "right_lower": (1, -1)}
"""The edges of a slot's walls: along the mat and up."""


def series(run: Path, name: str) -> list[tuple[float, Any]]:
    """Return times and meshes of a ParaView series of the run, without the tray."""
    reader = pyvista.get_reader(str(run / f"{name}.pvd"))
    meshes = []
    for time_s in reader.time_values:
        reader.set_active_time_value(time_s)
        meshes.append((time_s, max(reader.read(), key=lambda block: block.n_points)))
    return meshes


def write(file: Path, rows: list[dict[str, float]]) -> None:
    """Write rows of numbers as a CSV file."""
    with file.open("w", newline="", encoding="utf-8") as text:
        writer = csv.DictWriter(text, rows[0])
        writer.writeheader()
        writer.writerows({key: f"{value:.6g}" for key, value in row.items()} for row in rows)


def walls(mat_m: Any, slots_m: Any) -> Any:
    """Return the points (n, 4) of the mat that are the edges of the slots' walls, ``EDGES`` of each."""
    corners = []
    for slot_m in slots_m:
        away_m = mat_m - slot_m
        beside = np.abs(away_m[:, 1]) < 0.016
        for side, up in EDGES.values():
            far_m = np.hypot(away_m[:, 0] - side * SLOT_M / 2, away_m[:, 2] - up * HALF_DEPTH_M)
            corners.append(np.argmin(np.where(beside, far_m, np.inf)))
    return np.array(corners).reshape(-1, len(EDGES))


def main(run: Path, folder: Path) -> None:
    """Write both tables."""
    grains, mats = series(run, "particles"), series(run, "surface")
    first = grains[0][1]
    size_m, corners = first["sieve_size_m"], walls(mats[0][1].points, first.points)
    times_s = np.array([time_s for time_s, _ in grains])
    places_m = np.full((len(times_s), *first.points.shape), np.nan)
    for row, (_, now) in enumerate(grains):
        places_m[row, np.searchsorted(first["id"], now["id"])] = now.points
    edges_m = np.array([now.points[corners] for _, now in mats])  # (times, grains, edges, 3)
    wide_m = np.linalg.norm(edges_m[:, :, 1] - edges_m[:, :, 0], axis=2)
    out = places_m[:, :, 2] < edges_m[:, :, 2:, 2].mean(axis=2)
    widest_m = np.maximum.accumulate(wide_m)
    ends_s = flipflow.open_run(run).history("panel_cycles/mat").index.to_numpy()
    rows = [
        {
            "until_s": times_s[row],
            "stretch_percent": 100 * (widest_m[row].mean() / SLOT_M - 1),
            "released_percent": 100 * out[: row + 1].any(axis=0).mean(),
            "smaller_percent": 100 * (size_m < widest_m[row]).mean(),
        }
        for row in [0, *(np.searchsorted(times_s, ends_s + 1e-9) - 1)]
    ]
    write(folder / "released.csv", rows)
    fell = np.where(out.any(axis=0), out.argmax(axis=0), len(times_s))
    chosen = int(np.argsort(fell)[round(0.6 * np.isin(fell, len(times_s), invert=True).sum())])
    turn_s = ends_s[1] - ends_s[0]
    write(
        folder / "turn.csv",
        [
            {"time_s": times_s[row], "size_mm": 1e3 * size_m[chosen]}
            | relative_mm(places_m[row, chosen], edges_m[row, chosen])
            for row in np.searchsorted(
                times_s, times_s[fell[chosen]] + turn_s * np.linspace(-0.9, 0.08, FRAMES)
            )
        ],
    )


def relative_mm(grain_m: Any, edges_m: Any) -> dict[str, float]:
    """Return the places of a grain and of the edges (4, 3) of its slot from the middle of the slot."""
    places = {"grain": grain_m, **dict(zip(EDGES, edges_m, strict=True))}
    middle_m = edges_m.mean(axis=0)
    return {
        f"{name}_{axis}_mm": 1e3 * (place[at] - middle_m[at])
        for name, place in places.items()
        for at, axis in ((0, "x"), (2, "z"))
    }


if __name__ == "__main__":
    main(Path(sys.argv[1]), Path(sys.argv[2]) if len(sys.argv) > 2 else HERE)
