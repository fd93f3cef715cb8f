"""expected.toml and the verdicts: what is read, refused, measured and judged; no solver runs."""

from __future__ import annotations

from pathlib import Path

import h5py
import numpy as np
import pytest

from orchestrator.case.file.errors import CaseError
from orchestrator.output.records.history import HISTORY_FORMAT
from orchestrator.output.records.summary import write_summary
from orchestrator.studies.hard import cases, measures, verdicts
from orchestrator.studies.hard.criterion import Criterion
from orchestrator.studies.hard.expected import Expected, read
from orchestrator.studies.hard.outcome import outcome

FOLDER = Path(__file__).parents[2] / "cases" / "hard"
HEAD = 'number = 1\nhappens = "a"\nexpected = "b"\n[runs.one]\n[runs.two]\n'
DONE = {"status": "done", "reason": "", "energy_ledger_J": {"lost.a": 1.0}}
ROW = '[[criteria]]\nwhat = "c"\nrun = "one"\nmeasure = "series"\nband = [0.0, 2.0]\nwhy = "d"\n'


def criterion(**given: object) -> Criterion:
    row = {"what": "c", "run": "one", "measure": "series", "band": (0.0, 2.0), "why": "d"}
    return Criterion.model_validate(row | given)


@pytest.fixture
def folders(tmp_path: Path) -> dict[str, Path]:
    """Two runs: x runs from 0 to 4 in the first, and to 8 in the second; energy comes from
    nowhere in the second."""
    for number, name in enumerate(("one", "two"), start=1):
        (tmp_path / name).mkdir()
        time_s = np.arange(5.0)
        with h5py.File(tmp_path / name / "history.h5", "w") as history:
            history.attrs["format_version"] = HISTORY_FORMAT
            history["probes/p/time_s"] = time_s
            history["probes/p/position_m"] = number * time_s[:, None] * [1.0, 0.0, -1.0]
            for book, values in (("stored.a", time_s), ("supplied.b", time_s / number)):
                history[f"energy/{book}_J"] = values
            history["energy/time_s"] = time_s
        ledger = {"created.panel-frames": 0.5 * (number - 1), "lost.panel.b": 1.0}
        status = ("done", "doubtful")[number - 1]
        figures = {
            "status": status,
            "reason": "",
            "energy_ledger_J": ledger,
            "energy_exchanged_J": {"panel-frames": 3.0},
            "n": number,
        }
        write_summary(tmp_path / name, figures)
    return {name: tmp_path / name for name in ("one", "two")}


@pytest.mark.parametrize(
    ("given", "value"),
    [
        ({"axis": "x", "take": "last"}, 4.0),
        ({"axis": "z", "take": "lowest"}, -4.0),
        ({"axis": "size", "take": "highest"}, 4.0 * np.sqrt(2)),
        ({"axis": "x", "take": "range", "between_s": (1.0, 3.0)}, 2.0),
        ({"axis": "x", "take": "mean"}, 2.0),
        ({"axis": "x", "take": "impulse"}, 1.0 + 2.0 + 3.0 + 4.0),
        ({"axis": "x", "measure": "relative", "against": "two"}, 0.5),
        ({"measure": "difference", "against": "two"}, 4.0),
        ({"axis": "x", "measure": "later", "between_s": (3, 4), "earlier_s": (0, 1)}, 4.0),
        ({"axis": "x", "measure": "moved", "take": "mean", "between_s": (0, 1), "earlier_s": (3, 4)}, 3.0),
        ({"run": "two", "measure": "unexplained"}, 2.0),
        ({"run": "two", "measure": "share_unexplained"}, 1.0),
        ({"run": "two", "measure": "kept"}, 2.0),
        ({"run": "two", "measure": "created"}, 0.5 / 4.0),
        ({"measure": "summary", "of": "energy_ledger_J.lost.panel.b"}, None),
        ({"measure": "summary", "of": "n"}, 1.0),
        ({"measure": "relative_summary", "of": "n", "against": "two"}, 0.5),
        ({"measure": "trusted"}, 1.0),
        ({"run": "two", "measure": "trusted"}, 0.0),
        ({"run": "two", "measure": "clear"}, 0.0),
    ],
)
def test_measures(folders: dict[str, Path], given: dict[str, object], value: float | None) -> None:
    row = criterion(**({"of": "probes/p/position_m"} | given))
    if value is None:
        with pytest.raises(measures.Unknown, match="no number"):
            measures.MEASURES[row.measure](folders, row)
        return
    assert measures.MEASURES[row.measure](folders, row) == pytest.approx(value, rel=1e-12)


def test_what_is_not_there_is_unknown(folders: dict[str, Path]) -> None:
    for given in ({"of": "probes/q/position_m"}, {"of": "probes/p/position_m", "run": "three"}):
        nowhere = folders | {"three": folders["one"] / "three"}
        with pytest.raises(measures.Unknown):
            measures.series(nowhere, criterion(**given))


@pytest.mark.parametrize(
    ("figures", "expected"),
    [
        ({"status": "failed", "reason": "unstable"}, "stopped"),
        ({"status": "failed", "reason": "internal error: x"}, "not run"),
        ({"status": "interrupted", "reason": "stopped by SIGINT"}, "not run"),
        (DONE, "stable"),
        (DONE | {"status": "doubtful"}, "warned"),
        (DONE | {"status": "incomplete"}, "stable"),
        (DONE | {"monitor": {"figures": {"growing_modes": {"times": 0}}}}, "stable"),
        (DONE | {"monitor": {"figures": {"growing_modes": {"times": 1}}}}, "warned"),
        (DONE | {"monitor": {"figures": {"deep_overlaps": {"times": 1}}}}, "stable"),
    ],
)
def test_outcomes(tmp_path: Path, figures: dict[str, object], expected: str) -> None:
    write_summary(tmp_path, figures)
    assert outcome(tmp_path) == expected
    assert outcome(tmp_path / "nowhere") == "not run"


@pytest.mark.parametrize(
    ("measured", "given", "verdict"),
    [
        (1.0, {}, "met"),
        (3.0, {}, "NOT MET"),
        (3.0, {"reference": 2.0}, "met"),
        (3.0, {"known_failure": "why"}, "known failure"),
        (1.0, {"known_failure": "why"}, "MET, but marked as failing"),
        (None, {}, "NOT MET"),
    ],
)
def test_verdicts(measured: float | None, given: dict[str, object], verdict: str) -> None:
    expected = Expected(number=1, happens="a", expected="b", runs={}, criteria=(criterion(**given),))
    case = cases.HardCase("a", Path(), expected, {})
    line = verdicts.Line(case, expected.criteria[0], measured, "not run")
    assert line.verdict == verdict
    assert verdict in verdicts.markdown([line])


@pytest.mark.parametrize(
    ("text", "said"),
    [
        (HEAD + ROW.replace("series", "serie"), 'no measure "serie"'),
        (HEAD + ROW.replace('"one"', '"three"'), 'no run "three"'),
        (HEAD + ROW + "bands = 3\n", "bands"),
        (HEAD, "criteria"),
    ],
)
def test_a_wrong_file_is_refused(tmp_path: Path, text: str, said: str) -> None:
    (tmp_path / "expected.toml").write_text(text)
    with pytest.raises(CaseError, match=said):
        read(tmp_path)


def test_every_hard_case_is_read_and_has_its_page() -> None:
    found = [file.parent for file in FOLDER.glob("*/expected.toml")]
    numbers = sorted(read(case).number for case in found)
    assert numbers == [*range(1, len(numbers) + 1)]
    for case in found:
        page = (case / "README.md").read_text()
        assert page.startswith(f"# {case.name}\n")
        assert "**Measured" in page
    assert len(found) == len([*FOLDER.glob("*/case.toml")])
