"""The rate at which fines pass, found in the published Table 5, whose rows are stored with the case."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from tests.results.synthetic import folder_of, results_table
from tools.passing_rate import collapse, main, read_rows

TABLE = Path(__file__).parents[2] / "cases" / "ffs0827-effects" / "studies" / "table5.csv"
DECK_M = 8 * 0.3375


def test_one_rate_describes_the_43_rows_of_the_paper() -> None:
    """The rate is that of a search over a grid of rates, which knows nothing of the fit."""
    velocity_m_per_s, efficiency = read_rows(TABLE)
    assert len(efficiency) == 43
    rates = np.arange(0.5, 1.2, 1e-4)
    for exponent in (0.0, 0.5):
        time = DECK_M * velocity_m_per_s ** -(1 + exponent)
        left = ((1 - np.exp(-np.outer(rates, time)) - efficiency) ** 2).sum(axis=1)
        fit = collapse(velocity_m_per_s, efficiency, DECK_M, exponent)
        assert fit.rate == pytest.approx(rates[left.argmin()], abs=1e-4)
        spread = ((efficiency - efficiency.mean()) ** 2).sum()
        assert fit.r_squared == pytest.approx(1 - left.min() / spread, abs=1e-5)
        assert fit.rms == pytest.approx(np.sqrt(left.min() / 43), abs=1e-5)


def test_the_command_prints_what_the_case_s_page_says(capsys: pytest.CaptureFixture[str]) -> None:
    main([str(TABLE), str(DECK_M)])
    printed = capsys.readouterr().out.splitlines()
    assert printed == ["k: k 0.771, R2 0.873, rms 5.0 points", "k v^-0.5: k 0.943, R2 0.945, rms 3.3 points"]
    page = (TABLE.parents[1] / "README.md").read_text()
    assert all(number in page for number in ("0.77 1/s", "0.873", "0.945", "5.0 points", "3.3 points"))


def test_a_run_stands_beside_the_table(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder, picture = folder_of(tmp_path), tmp_path / "rates.png"
    contacts = results_table(folder)["contacts"]
    file = folder / "summary.json"
    file.write_text(json.dumps(json.loads(file.read_text()) | {"results": results_table(folder)}))
    main([str(TABLE), str(DECK_M), str(folder), "--out", str(picture)])
    (printed,) = capsys.readouterr().out.splitlines()[2:]
    assert f"passed over time {contacts['rate_per_s']['value']:.3f} 1/s" in printed
    assert f"counted {contacts['counted_percent']:.1f} %" in printed
    assert picture.stat().st_size > 10_000
