"""Every figure has one record, and every reader of results tells the same number by it."""

from __future__ import annotations

import csv
import shutil
from collections.abc import Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import h5py
import numpy as np
import pytest

from orchestrator.figures.figure import to_json
from orchestrator.figures.results import FIGURES, Results, figure_at, parse_results
from orchestrator.figures.short_names import SHORT_NAMES, named, value_at
from orchestrator.output.records.history import write_results
from orchestrator.output.records.summary import write_summary
from orchestrator.output.report.headline import headline
from orchestrator.output.report.page import Film, page, shown
from orchestrator.output.results.compute import compute_results
from orchestrator.output.results.quantities import number_of
from orchestrator.output.results.run_reader import RunReader
from orchestrator.output.results.tidy import read_results
from orchestrator.studies.criteria import Criterion
from orchestrator.studies.points import Vary
from orchestrator.studies.sweep import write_sweep
from orchestrator.workbench import Run
from tests.results.synthetic import folder_of
from tests.runs.outside import ROOT
from tools.results_reference.__main__ import results_reference

SHARE = 0.5  # of the width
OF_OTHERS = (
    "results.screening.cohort",
    "results.screening.whole_feed",
    "results.motion.run_down",
    "results.motion.ground",
    "results.bulk",
)
"""Tables that a steady run of all sizes, of a machine in the air that does not stop and without boxes of
``[bulk]``, does not have."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A slice of half of the width, with its results written as a run writes them."""
    folder = folder_of(tmp_path_factory.mktemp("every") / "run")
    case = folder / "case.toml"
    case.write_text(case.read_text() + "\n[slice]\nwidth_m = 0.1\n")
    table = to_json(compute_results(folder))
    write_summary(folder, RunReader(folder).summary | {"results": table})
    write_results(folder / "history.h5", table)
    return folder


@pytest.fixture(scope="module")
def summary(folder: Path) -> dict[str, Any]:
    return RunReader(folder).summary


def leaves(value: Any, path: str) -> Iterator[tuple[str, Any]]:
    """Yield every figure in a table with its path: numbers, vectors and estimates."""
    if isinstance(value, dict) and "value" not in value:
        for key, inner in value.items():
            yield from leaves(inner, f"{path}.{key}")
    elif isinstance(value, list) and value and isinstance(value[0], dict):
        for number, inner in enumerate(value):
            yield from leaves(inner, f"{path}.{number}")
    else:
        yield path, value


def numbers(table: dict[str, Any]) -> dict[str, Any]:
    """Return the figures of a summary that are one number, by path: estimates have their table."""
    return {
        path: value
        for path, value in leaves(table["results"], "results")
        if isinstance(value, int | float | dict) and not isinstance(value, bool)
    }


def test_every_entry_of_a_summary_has_a_record(summary: dict[str, Any]) -> None:
    reasons = ("results.missing.", "results.failed.")
    for path, _ in leaves(summary["results"], "results"):
        if not path.startswith(reasons):
            assert figure_at(path) is not None, path
    assert len(numbers(summary)) > 80


def test_every_record_is_met_by_a_run(summary: dict[str, Any]) -> None:
    """A reader could otherwise be wrong of it unseen."""
    met = {path for path, _ in leaves(summary["results"], "results")}
    words = {tuple(path.split(".")) for path in met}

    def is_met(pattern: str) -> bool:
        keys = pattern.split(".")
        return any(
            len(each) == len(keys) and all(a in ("*", b) for a, b in zip(keys, each, strict=True))
            for each in words
        )

    absent = [path for path in FIGURES if not is_met(path) and not path.endswith(".*")]
    assert not [path for path in absent if not path.startswith(OF_OTHERS)]


def test_a_summary_is_parsed_to_the_same_bits(summary: dict[str, Any]) -> None:
    assert to_json(parse_results(summary)) == summary["results"]


def test_the_whole_width_has_what_a_slice_has_its_share_of(summary: dict[str, Any]) -> None:
    whole = {"results": to_json(parse_results(summary).of_the_whole_width)}
    scaled = 0
    for path, value in numbers(whole).items():
        record, part = figure_at(path), numbers(summary)[path]
        assert record is not None
        times = 1.0 / SHARE if record.is_extensive else 1.0
        scaled += record.is_extensive
        for key in ("value", "half_width") if isinstance(value, dict) else ("",):
            first, other = (each[key] if key else each for each in (value, part))
            assert first == (other and times * other), path
    assert scaled > 15


def test_units_tell_what_a_slice_has_its_share_of() -> None:
    """Masses, rates, forces, powers and energies of one number are extensive, and nothing else of a unit."""
    of_the_slice = {"kg", "kg/s", "m3", "N", "W", "J"}
    for path, record in FIGURES.items():
        assert record.is_extensive is (record.unit in of_the_slice) or record.unit in (
            "1",
            "kg/m",
            "kg/(s m)",
        ), path


def test_rows_names_and_columns_have_the_bits_of_the_summary(
    folder: Path, summary: dict[str, Any], tmp_path: Path
) -> None:
    """``results`` and ``compare`` (tidy rows), paths, ``history.h5``, the sweep's table, and criteria."""
    rows = read_results([folder])[0]
    point: Any = SimpleNamespace(value="78.5", folder=folder, run=Run(folder))
    vary = Vary("screen.exciters.shaft.speed_rad_per_s", ("78.5",))
    (swept,) = csv.DictReader(write_sweep(vary, [point], tmp_path)[0].read_text().splitlines())
    with h5py.File(folder / "history.h5") as history:
        for path, value in numbers(summary).items():
            wanted = value["value"] if isinstance(value, dict) else value
            if wanted is None:
                continue
            figure = value_at(summary, path)
            assert figure is not None
            assert figure.value == wanted, path
            keys = path.removeprefix("results.").split(".", 2 if ".lost_W." in path else -1)
            stored = history["results"]
            for key in keys:
                stored = stored[str(int(key) + 1) if key.isdecimal() else key]
            assert stored[()] == wanted, path
            asked = Criterion(what="a", run="speed", measure="result", of=path)
            in_si = 0.01 if named(path).figure.unit == "%" else 1.0
            assert number_of(asked, folder) == in_si * wanted, path
            if "sections" in keys or "along" in keys:
                continue  # rows and columns name the entries of these lists by their exits and numbers
            assert rows.results[".".join(keys)].value == wanted, path
            assert float(swept[".".join(keys)]) == wanted, path
            whole = rows.of_the_whole_width().results[".".join(keys)].value
            assert whole == wanted / (SHARE if named(path).figure.is_extensive else 1.0), path


def test_short_names_are_of_the_whole_width(summary: dict[str, Any]) -> None:
    known = numbers(summary)
    for name, short in SHORT_NAMES.items():
        if short.figure.path in known and (value := short.of(summary)) is not None:
            wanted = known[short.figure.path]["value"]
            assert value.value == pytest.approx(
                wanted / (SHARE if short.figure.is_extensive else 1.0), rel=1e-15
            ), name


def test_the_page_and_the_headline_tell_the_whole_width(folder: Path) -> None:
    """Each figure of the page's tables, and each tile."""
    results = compute_results(folder)
    whole = results.of_the_whole_width
    text = page(folder, results, lambda *_: Film(b"", reason="none"))
    assert whole.screening is not None
    assert whole.bed is not None
    assert whole.motion is not None
    for place, table in (("screening", whole.screening), ("bed", whole.bed)):
        for name, value in vars(table).items():
            record = FIGURES.get(f"results.{place}.{name}")
            if record is not None and hasattr(value, "half_width") and f"<td>{record.label}</td>" in text:
                assert f"<td>{record.label}</td><td>{shown(f'{place}.{name}', value)}</td>" in text
    for name, panel in whole.motion.panels.items():
        row = text.split("Panels: pull")[1].split(f"<td>{name}</td>")[1].split("</tr>")[0]
        for key in ("tension_mean_N", "stretch_largest_percent"):
            assert shown(f"motion.panels.*.{key}", getattr(panel, key)) in row
    tiles = {tile.name: tile for tile in headline(results)}
    feed, on_deck = tiles["feed, of the whole width"], tiles["mass on the deck, of the whole width"]
    assert whole.screening.feed_kg_per_s.value is not None
    assert float(feed.value) == pytest.approx(3.6 * whole.screening.feed_kg_per_s.value, rel=1e-3)
    assert whole.bed.on_deck_kg.value is not None
    assert float(on_deck.value) == pytest.approx(whole.bed.on_deck_kg.value, rel=1e-3)


def test_the_manual_is_made_of_the_records() -> None:
    manual = (ROOT / "docs/run-folder.md").read_text()
    assert manual == results_reference(manual), "python -m tools.results_reference docs/run-folder.md"


def test_a_damaged_table_is_named(summary: dict[str, Any]) -> None:
    damaged = {"results": summary["results"] | {"steady": {"is_steady": True}}}
    with pytest.raises(ValueError, match=r"results.steady.reason: .* \(6 such places\)"):
        parse_results(damaged)
    assert parse_results({}) == Results()
    assert np.isnan(parse_results(summary).screening.in_time.feed_kg_per_s).sum() == 0  # type: ignore[union-attr]


def test_a_copy_keeps_its_results(folder: Path, tmp_path: Path) -> None:
    copy = Path(shutil.copytree(folder, tmp_path / "copy"))
    assert RunReader(copy).summary["results"] == to_json(compute_results(copy))
