"""A side plate that CalculiX computes from the loads on a frame: nothing rests on its supports."""

from __future__ import annotations

import shutil
import subprocess
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from orchestrator.output.loads import Format
from orchestrator.output.loads.files import write_loads
from orchestrator.output.loads.forces import FrameForces
from orchestrator.ports import Array

COLUMNS, ROWS, SIDE_M = 10, 4, (0.1, 0.1, 0.02)
BALANCED = 1e-6
AT_NODES = ((0, 2, 0), (10, 1, 0), (4, 4, 1), (7, 0, 0))
WITHIN = ((2, 1, 0), (5, 2, 0))
"""Elements whose corners carry a place with a moment, in their middle."""
HELD = ((0, 0, 0), (COLUMNS, 0, 0), (0, ROWS, 0))


def node(i: int, j: int, k: int) -> int:
    return 1 + i + (COLUMNS + 1) * (j + (ROWS + 1) * k)


def corners(i: int, j: int, k: int) -> list[int]:
    around = ((0, 0), (1, 0), (1, 1), (0, 1))
    return [node(i + a, j + b, level) for level in (k, k + 1) for a, b in around]


def balanced_forces() -> FrameForces:
    """Forces at four nodes and a force with a moment within an element; the last place balances them."""
    random = np.random.default_rng(3)
    place_m = np.array([*AT_NODES, *(np.array(WITHIN) + 0.5)]) * SIDE_M
    force_N, moment_N_m = 1e3 * random.normal(size=(5, 6, 3)), np.zeros((5, 6, 3))
    moment_N_m[:, 4] = 50 * random.normal(size=(5, 3))
    force_N[:, 5] = -force_N[:, :5].sum(axis=1)
    of_forces_N_m = np.cross(place_m - place_m[5], force_N)
    moment_N_m[:, 5] = -(moment_N_m[:, :5] + of_forces_N_m[:, :5]).sum(axis=1)
    names = (*(f"clamp/deck-1-first/{k}" for k in range(1, 5)), "bushing/b/1", "inertia/frame/1")
    return FrameForces(0.4 + 0.01 * np.arange(5), names, place_m, force_N, moment_N_m, place_m[5])


def plate(place_m: Array) -> str:
    """The input of CalculiX, with three supports that hold nothing but motion as a rigid body."""
    numbers = [(i, j, k) for k, j, i in product((0, 1), range(ROWS + 1), range(COLUMNS + 1))]
    elements = [corners(i, j, 0) for j, i in product(range(ROWS), range(COLUMNS))]
    lines = ["*NODE", *(_row(node(*at), *(np.array(at) * SIDE_M)) for at in numbers)]
    lines += ["*ELEMENT, TYPE=C3D8I, ELSET=PLATE"]
    lines += [_row(number, *element) for number, element in enumerate(elements, start=1)]
    for number, at in enumerate(AT_NODES, start=1):
        lines += [f"*NSET, NSET=P{number}", _row(node(*at))]
    for number, at in enumerate(WITHIN, start=len(AT_NODES) + 1):
        reference, rotation = 1000 + 2 * number, 1001 + 2 * number
        lines += ["*NODE", *(_row(n, *place_m[number - 1]) for n in (reference, rotation))]
        lines += [f"*NSET, NSET=BODY{number}", _row(*corners(*at))]
        lines += [f"*RIGID BODY, NSET=BODY{number}, REF NODE={reference}, ROT NODE={rotation}"]
        lines += [f"*NSET, NSET=P{number}", _row(reference), f"*NSET, NSET=P{number}R", _row(rotation)]
    lines += ["*NSET, NSET=HELD", _row(*(node(*at) for at in HELD))]
    lines += ["*MATERIAL, NAME=STEEL", "*ELASTIC", "2.1e11, 0.3"]
    lines += ["*SOLID SECTION, ELSET=PLATE, MATERIAL=STEEL", "*INCLUDE, INPUT=amplitudes.inc"]
    lines += ["*BOUNDARY", *(_row(node(*at), first, 3) for first, at in enumerate(HELD, start=1))]
    lines += ["*STEP", "*STATIC", "0.04, 0.04", "*INCLUDE, INPUT=cloads.inc"]
    lines += ["*NODE PRINT, NSET=HELD", "RF, U", "*END STEP", ""]
    return "\n".join(lines)


def _row(*values: float) -> str:
    return ", ".join(f"{value:.9g}" for value in values)


@pytest.mark.process
@pytest.mark.skipif(shutil.which("ccx") is None, reason="no CalculiX: apt-get install calculix-ccx")
def test_nothing_rests_on_the_supports_of_a_side_plate(tmp_path: Path) -> None:
    """The file of results has seven digits, and the cards have nine."""
    forces = balanced_forces()
    assert max(forces.out_of_balance()) < 1e-12
    write_loads(forces, Format.CALCULIX, tmp_path, "a", "driving")
    (tmp_path / "plate.inp").write_text(plate(forces.place_m))
    done = subprocess.run(["ccx", "plate"], cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stdout
    rows = [line.split() for line in (tmp_path / "plate.dat").read_text().splitlines()]
    values = np.array(
        [[float(word) for word in row[1:]] for row in rows if len(row) == 4 and row[0].isdigit()]
    )
    reaction_N = values[: len(HELD)]
    assert len(values) == 2 * len(HELD), "forces and displacements"
    assert abs(reaction_N).max() < BALANCED * abs(forces.force_N).max()
