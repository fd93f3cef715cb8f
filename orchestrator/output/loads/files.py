"""The files of a frame's loads: tables, and cards of CalculiX and APDL."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np

from orchestrator.output.loads import Format
from orchestrator.output.loads.forces import FrameForces
from orchestrator.output.tables import Cell, write_csv
from orchestrator.ports import Array

SMALL = 1e-9
"""Components that never exceed this share of the largest force, or of the largest moment, have no card."""
README = "README.txt"
ABOUT = """Loads on the frame {frame} of {run}, from {first:.9g} to {last:.9g} s of the run, in {rows} rows.

Axes: the deck axes of the case, moving with the frame; x runs along the deck, z normal to it, and the
origin is that of the case at t = 0.  Units: m, N, N m, s.  Each row holds at one sync point: forces of
clamps, stops and walls are the means over the sync interval that ends there, as the frames felt them, and the
force of a motor's unbalance is the mean over the frames' last step; all others are those of that moment.

places.csv: a row for each place, with its name, kind, part and the number of the point there.
  clamp     a panel's pull on the frame, at the points of a clamp's line
  stop      a panel's force on a beam of the frame
  wall      the load of all walls on the frame, at the few points that carry them
  bushing   the force of a bushing at its drawn place, with the moment of its stretch
  exciter   the force of an unbalance at its shaft
  gravity   the frame's weight, at its centre of mass
  inertia   minus mass times acceleration, and minus the rate of angular momentum, at the centre of mass
  lag       the moment by which the loads of the frames' solver, which extrapolates lever arms, differ from
            the forces at these places
  held      the moment that keeps a frame from turning where the solver of frames has no rotation

The sum of all forces is zero to {force:.1e} of the largest, that of the moments about the centre of mass to
{moment:.1e}.  The frame was rigid in the run.  Spread gravity and inertia over your frame's mass, or couple
its nodes to a node at the centre of mass; a model with its own weight or mass would count them twice.
{files}"""
OF_CSV = "\nloads.csv: a row for each moment and place, with time_s of the run.\n"
OF_CALCULIX = """
amplitudes.inc belongs before the first *STEP, cloads.inc into it (*INCLUDE, INPUT=...).  Time 0 is the first
row.  Define a node set for each place of places.csv by its name: *NSET, NSET=P1, with one node.  A place with
a moment needs a *RIGID BODY, whose REF NODE is in the set P1 and whose ROT NODE is in the set P1R: CalculiX
takes moments at degrees 1 to 3 of the latter.
"""
OF_APDL = """
loads.mac: tables over TIME, whose 0 is the first row.  Before it, set a parameter for each place of
places.csv to the number of its node: P1_N = 4711 for the place P1.  A node with moments needs rotations (a
pilot node).
"""


def write_loads(forces: FrameForces, how: Format, folder: Path, run: str, frame: str) -> list[Path]:
    """Write the loads into a folder, and return the files.  Raises OSError."""
    texts, about = WRITERS[how](forces)
    folder.mkdir(parents=True, exist_ok=True)
    force, moment = forces.out_of_balance()
    texts[README] = ABOUT.format(
        frame=frame,
        run=run,
        first=forces.time_s[0],
        last=forces.time_s[-1],
        rows=len(forces.time_s),
        force=force,
        moment=moment,
        files=about,
    )
    for name, text in texts.items():
        (folder / name).write_text(text, encoding="utf-8")
    tables = {"places.csv": _places(forces)} | ({"loads.csv": _rows(forces)} if how is Format.CSV else {})
    return [write_csv(rows, folder / name) for name, rows in tables.items()] + [folder / n for n in texts]


def _places(forces: FrameForces) -> list[dict[str, Cell]]:
    return [
        {"place": f"P{number}", **_named(name), **_vector("", "m", place)}
        for number, (name, place) in enumerate(zip(forces.names, forces.place_m, strict=True), start=1)
    ]


def _rows(forces: FrameForces) -> list[dict[str, Cell]]:
    return [
        {
            "time_s": float(time_s),
            "place": f"P{k + 1}",
            **_named(name),
            **_vector("", "m", forces.place_m[k]),
            **_vector("force_", "N", forces.force_N[row, k]),
            **_vector("moment_", "N_m", forces.moment_N_m[row, k]),
        }
        for row, time_s in enumerate(forces.time_s)
        for k, name in enumerate(forces.names)
    ]


def _named(name: str) -> dict[str, Cell]:
    return dict(zip(("kind", "part", "point"), name.split("/"), strict=True))


def _vector(what: str, unit: str, values: Array) -> dict[str, Cell]:
    return {f"{what}{axis}_{unit}": float(value) for axis, value in zip("xyz", values, strict=True)}


def _components(forces: FrameForces) -> Iterator[tuple[str, int, Array]]:
    """Yield place, degree of freedom (1 to 6) and values (n,) of each component that is not zero."""
    both = np.concatenate([forces.force_N, forces.moment_N_m], axis=2)
    largest = np.repeat([np.abs(forces.force_N).max(), np.abs(forces.moment_N_m).max()], 3)
    for k, degree in np.argwhere(np.abs(both).max(axis=0) > SMALL * largest).tolist():
        yield f"P{k + 1}", degree + 1, both[:, k, degree]


def _calculix(forces: FrameForces) -> tuple[dict[str, str], str]:
    time_s, amplitudes, loads = forces.time_s - forces.time_s[0], [], []
    for place, degree, values in _components(forces):
        amplitudes.append(f"*AMPLITUDE, NAME={place}_{degree}")
        pairs = [f"{t:.9g}, {value:.9g}" for t, value in zip(time_s, values, strict=True)]
        amplitudes += [", ".join(pairs[k : k + 4]) for k in range(0, len(pairs), 4)]
        at = f"{place}, {degree}" if degree <= 3 else f"{place}R, {degree - 3}"
        loads += [f"*CLOAD, AMPLITUDE={place}_{degree}", f"{at}, 1."]
    return {"amplitudes.inc": _text(amplitudes), "cloads.inc": _text(loads)}, OF_CALCULIX


def _apdl(forces: FrameForces) -> tuple[dict[str, str], str]:
    time_s, lines = forces.time_s - forces.time_s[0], []
    for place, degree, values in _components(forces):
        table = f"{place}_{degree}"
        lines.append(f"*DIM,{table},TABLE,{len(time_s)},1,1,TIME")
        for row, (t, value) in enumerate(zip(time_s, values, strict=True), start=1):
            lines += [f"{table}({row},0)={t:.9g}", f"{table}({row},1)={value:.9g}"]
        label = ("FX", "FY", "FZ", "MX", "MY", "MZ")[degree - 1]
        lines.append(f"F,{place}_N,{label},%{table}%")
    return {"loads.mac": _text(lines)}, OF_APDL


def _text(lines: list[str]) -> str:
    return "\n".join([*lines, ""])


WRITERS: dict[Format, Callable[[FrameForces], tuple[dict[str, str], str]]] = {
    Format.CSV: lambda _: ({}, OF_CSV),
    Format.CALCULIX: _calculix,
    Format.APDL: _apdl,
}
