"""The force of the bushings on the ground, against the transmissibility of one mass on springs."""

from __future__ import annotations

import math
import tomllib
from pathlib import Path

import pytest

from tests.cases import CASE, LEVEL, case_folder
from tests.results.synthetic import results_table
from tests.runs.outside import QUICK, flipflow, run_words

pytestmark = pytest.mark.solver

SPEED_RAD_PER_S, UNBALANCE_KG_M, MASS_KG = 78.5, 0.35, 76.0
STIFFNESS_N_PER_M = {"x": 4e4, "z": 8e4}  # of both bushings together
DAMPING_N_S_PER_M = 1200.0
GROUND_FIRST, GROUND_LAST = '["ground", "driving"]', '["driving", "ground"]'
OTHER = (
    f"{{between={GROUND_LAST}, positions_m=[[0.4, 0.1, 0.0]], stiffness_N_per_m=[2e4, 3e4, 4e4], "
    "damping_N_s_per_m=[600, 600, 600]}"
)
ALONE = (  # the frame feels no panel
    *QUICK,
    "exchange.panel_reaction=false",
    "frames.solver=two-mass",
    "screen.bushings.isolation.damping_N_s_per_m=[600, 600, 600]",
    "duration_s=3",
    "coupling.sync_interval_s=4e-4",
)


@pytest.mark.parametrize(
    ("between", "turn_deg"), [(GROUND_FIRST, 0), (GROUND_LAST, 0), (GROUND_LAST, 90), ("", 0)]
)
def test_one_mass_passes_on_what_its_transmissibility_says(
    between: str, turn_deg: int, tmp_path: Path
) -> None:
    """Den Hartog, Mechanical Vibrations (4th ed. 1956), section 2.12: of the unbalance's force m e w^2 the
    ground gets  sqrt((k^2 + c^2 w^2) / ((k - m w^2)^2 + c^2 w^2)).

    It is met to 0.2 %, of which rows every 0.4 ms and bushing forces in the middle of an interval explain
    (w dt)^2 / 12 = 8e-5.  Without ``between``, one of two bushings names the ground first.  Bushings that are
    turned by 90 degrees have their axes x and z exchanged.
    """
    empty = {key: table for key, table in tomllib.loads(CASE).items() if key != "bed"}
    case = case_folder(tmp_path / "case", empty, draft=LEVEL)
    sets = [*ALONE, f"screen.bushings.isolation.between={between or GROUND_FIRST}"]
    if not between:
        sets += ["screen.bushings.isolation.positions_m=[[-0.4, 0.1, 0.0]]", f"screen.bushings.other={OTHER}"]
    sets.append(f"screen.bushings.isolation.rotation_deg=[0, {turn_deg}, 0]")
    done = flipflow(*run_words(str(case), tmp_path / "run", sets), "--level", "draft")
    assert done.returncode == 0, done.stderr
    results = results_table(tmp_path / "run")
    ground, force_N = results["motion"]["ground"], UNBALANCE_KG_M * SPEED_RAD_PER_S**2
    damping = (DAMPING_N_S_PER_M * SPEED_RAD_PER_S) ** 2
    for along, stiffness in STIFFNESS_N_PER_M.items():
        axis = along if turn_deg == 0 else "zx"["xz".index(along)]
        inertia = MASS_KG * SPEED_RAD_PER_S**2
        expected_N = force_N * math.sqrt((stiffness**2 + damping) / ((stiffness - inertia) ** 2 + damping))
        assert ground["amplitude_N"][axis]["value"] == pytest.approx(expected_N, rel=2e-3)
    assert "force of the bushings on the ground, vertical amplitude: " in done.stderr
