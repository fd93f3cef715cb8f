"""Fed = on deck + through the exits + lost, exactly, for every solver and on two ranks."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import h5py
import numpy as np
import pytest

from tests.cases import CASE, case_folder
from tests.runs.outside import flipflow, run_words, summary

# three block particles on the panel; a chute that pours beside it, one half into an exit, the other
# past it and out of the domain
BED = """
[bed.blocks.coal]
material = "coal"
box_m = [[0.05, 0.05, 0.02], [0.25, 0.15, 0.06]]
count = 3
sizes = [{ smallest_m = 0.008, largest_m = 0.010, mass_fraction = 1.0 }]

[bed.feeds.chute]
material = "coal"
rate_kg_per_s = 0.2
box_m = [[-0.5, 0.0, 0.0], [-0.3, 0.1, 0.1]]
velocity_m_per_s = [0.0, 0.0, -3.0]
sizes = [{ smallest_m = 0.008, largest_m = 0.010, mass_fraction = 1.0 }]

[screen.exits.section-1]
product = "undersize"
box_m = [[-0.45, -0.2, -0.3], [-0.4, 0.2, -0.1]]

[screen.exits.section-2]
product = "oversize"
box_m = [[-0.4, -0.2, -0.3], [-0.35, 0.2, -0.1]]

[coupling]
sync_interval_s = 2e-4
[frames]
solver = "two-mass"
[panel]
solver = "rigid"
surface_cells = [6, 4]
[output]
interval_s = 0.01
pictures = false
"""


def case(folder: Path) -> Path:
    text = CASE.replace("[[-1.0, -1.0, -1.0], [1.0, 1.0, 1.0]]", "[[-1.0, -0.5, -0.4], [1.0, 0.5, 0.5]]")
    return case_folder(folder, text.replace("duration_s = 0.1", "duration_s = 0.2") + BED)


def checked(folder: Path) -> dict[str, Any]:
    """The event tables, if they agree with each other and with the summary."""
    material = summary(folder)["material"]
    with h5py.File(folder / "history.h5") as history:
        fed = {name: rows[:] for name, rows in history["fed"].items()}
        removed = {name: rows[:] for name, rows in history["removed"].items()}
        names = list(history["removed"].attrs["names"])
        products = list(history["removed"].attrs["products"])
        assert history["removed/velocity_m_per_s"].attrs["unit"] == "m/s"
        assert history["fed/density_kg_per_m3"].attrs["unit"] == "kg/m3"
        present = history["bed/particles"][-1]
    np.testing.assert_array_equal(fed["id"], 1 + np.arange(len(fed["id"])))
    assert (np.diff(fed["time_s"]) >= 0).all()
    assert (np.diff(removed["time_s"]) >= 0).all()
    row = removed["id"] - 1
    assert len(np.unique(row)) == len(row)
    np.testing.assert_array_equal(removed["sieve_size_m"], fed["sieve_size_m"][row])
    np.testing.assert_array_equal(removed["density_kg_per_m3"], fed["density_kg_per_m3"][row])
    assert (removed["time_s"] > fed["time_s"][row]).all()
    assert dict(zip(names, products, strict=True)) == {
        name: table["product"] for name, table in material["exits"].items()
    }
    mass = np.pi / 6 * fed["density_kg_per_m3"] * fed["sieve_size_m"] ** 3
    assert material["fed"]["number"] == len(mass)
    assert material["fed"]["mass_kg"] == pytest.approx(mass.sum(), rel=1e-13)
    books = [material["lost"], *material["exits"].values()]
    for number, book in enumerate(books, start=-1):
        here = row[removed["exit"] == number]
        assert book["number"] == len(here)
        assert book["mass_kg"] == pytest.approx(mass[here].sum(), rel=1e-13)
    assert material["on_deck"]["number"] == present == len(mass) - len(row)
    out_kg = sum(book["mass_kg"] for book in books)
    assert material["fed"]["mass_kg"] == pytest.approx(material["on_deck"]["mass_kg"] + out_kg, rel=1e-13)
    return {"fed": fed, "removed": removed}


@pytest.mark.process
@pytest.mark.parametrize(
    ("solver", "ranks"),
    [
        ("spheres", 1),
        pytest.param("liggghts", 1, marks=pytest.mark.solver),
        pytest.param("liggghts", 2, marks=pytest.mark.solver),
    ],
)
def test_every_particle_is_accounted_for(tmp_path: Path, solver: str, ranks: int) -> None:
    words = run_words(str(case(tmp_path / "case")), tmp_path / "run", [f"particles.solver={solver}"])
    done = flipflow(*words, ranks=ranks)
    assert done.returncode == 5, done.stderr
    assert any("left" in doubt for doubt in summary(tmp_path / "run")["doubts"])
    history = checked(tmp_path / "run")
    removed = history["removed"]
    assert np.bincount(removed["exit"] + 1, minlength=3).min() > 3  # lost, and through both
    place = removed["position_m"][removed["exit"] == 0]
    assert (place >= [-0.45, -0.2, -0.3]).all()
    assert (place <= [-0.4, 0.2, -0.1]).all()
    # what fell freely, by the table: z0 - 3 t - g t2 / 2 for z0 in the chute's box
    free = removed["time_s"] - history["fed"]["time_s"][removed["id"] - 1]
    z0 = removed["position_m"][:, 2] + 3.0 * free + 4.905 * free**2
    assert (z0 > 0.003).all()
    assert (z0 < 0.097).all()
