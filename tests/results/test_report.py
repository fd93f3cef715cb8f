"""``flipflow report``: a page that stands alone, for every kind of run, seen in a real browser."""

from __future__ import annotations

import json
import os
import re
import shutil
import signal
import tomllib
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from types import SimpleNamespace
from typing import Any, cast

import matplotlib.image
import matplotlib.pyplot as plt
import numpy as np
import pytest
import tomli_w

from orchestrator.case.file.folder import FolderUnusable
from orchestrator.figures.estimate import Estimate
from orchestrator.figures.machine import PanelWear
from orchestrator.figures.material import Section
from orchestrator.output.records.run_folder import RUN_LOCK, lock
from orchestrator.output.report.facts import left_out_facts
from orchestrator.output.report.formatting import interval, number
from orchestrator.output.report.page import Film, page, report
from orchestrator.output.report.pictures import draw_bushing_loops, draw_energy, draw_sections, draw_wear
from orchestrator.output.report.rendering import last_snapshots
from orchestrator.output.results.compute import compute_results
from orchestrator.output.results.run_reader import RunReader
from orchestrator.views.style import figure
from tests.results.browser import browser, seen
from tests.results.synthetic import ROTATION, folder_of
from tests.runs.outside import flipflow, said_plainly

IN_BROWSER = pytest.mark.skipif(
    browser() is None, reason="no browser: apt-get install chromium-headless-shell"
)


@pytest.fixture(scope="module", params=["screen", "empty machine"])
def folder(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the folder of a run with its report."""
    made = folder_of(tmp_path_factory.mktemp("report") / "run", request.param == "screen")
    done = flipflow("report", str(made))
    assert done.returncode == 0, done.stderr
    said_plainly(done)
    assert done.stdout.strip() == str(made / "report.html")
    return made


@pytest.mark.process
@IN_BROWSER
def test_a_browser_shows_all_of_it(folder: Path, tmp_path: Path) -> None:
    page = seen(folder / "report.html", tmp_path)
    assert page.errors == ""
    assert page.log == []
    assert page.asked == []
    assert page.overflow <= 0
    screen = (folder / "particles.pvd").is_file()
    assert len(page.images) == (14 if screen else 9)  # screen: no walls.stl, no side view
    assert min(min(size) for size in page.images) > 100  # 0 is what does not decode
    assert len(page.tables) >= 7
    assert all(cell for table in page.tables for cell in table)
    pixels = matplotlib.image.imread(page.screenshot)[..., :3]
    assert pixels.shape[:2] == (5000, 1280)
    inked = np.abs(pixels - pixels[0, 0]).max(axis=-1) > 0.1
    assert 0.02 < inked.mean() < 0.5


@pytest.mark.process
def test_the_page_needs_nothing_else(folder: Path) -> None:
    text = (folder / "report.html").read_text()
    assert len(text) < 6e6
    for address in re.findall(r'(?:src|href)="([^"]*)"', text):
        assert address.startswith("data:")
    assert "<h3>Designer's sheet: rule, not result</h3>" in text
    for name in ("deck-1", "deck-2"):  # neighbours, which open at opposite ends of a turn
        assert f"Mats: how {name} flips alone, before the run" in text
    assert text.count('alt="how the mat flips over some turns') == 2
    assert "<script" not in text
    assert "url(" not in text.split("</style>")[0]


def test_a_picture_without_a_place_of_its_own_is_on_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The page's template needs no change for a new picture."""
    run = folder_of(tmp_path / "run", cycles=15)
    drawn = [("new_picture", figure(1, 1, 2.0, 1.0)[0])]
    monkeypatch.setattr("orchestrator.output.report.page.draw_results", lambda results: iter(drawn))
    text = page(run, compute_results(run), lambda *_: Film(b"", reason="left out by the test"))
    assert text.count('alt="new_picture"') == 1
    assert text.count('alt="energy ledger"') == 1


def labels_below(fig: Any) -> list[Any]:
    """Draw the figure and return the boxes of the labels below its first axes, from left to right."""
    fig.draw_without_rendering()
    return [label.get_window_extent() for label in fig.axes[0].get_xticklabels()]


@pytest.mark.parametrize("count", [2, 8, 16])
def test_names_of_many_sections_and_panels_do_not_overlap(count: int) -> None:
    share, depth = Estimate(50.0, 5.0), np.ones((8, 4))
    shares = {f"{name}_percent": share for name in ("yield", "local_efficiency", "cumulative_efficiency")}
    rows = [Section(exit=f"section-{n}", **shares) for n in range(count)]
    panel = PanelWear(
        worn_m3=1.0,
        mean_m_per_h=Estimate(1.0),
        largest_m_per_h=1.0,
        largest_at=np.array([0.5, 0.5]),
        worn_through_h=None,
        depth_m_per_h=depth,
    )
    for fig in (draw_sections(rows), draw_wear({f"upper-deck-{n}": panel for n in range(count)})):
        boxes = labels_below(fig)
        assert len(boxes) == count
        assert all(left.x1 < right.x0 for left, right in pairwise(boxes))
        for legend in fig.legends:
            assert legend.get_window_extent().y1 < min(box.y0 for box in boxes)
        if count == 2:
            assert {label.get_rotation() for label in fig.axes[0].get_xticklabels()} == {0.0}
        plt.close(fig)


def test_the_page_of_a_slice_says_how_wide_it_is_and_what_is_scaled(tmp_path: Path) -> None:
    run = folder_of(tmp_path / "run", cycles=15)
    results = replace(compute_results(run), share_of_width=0.25, slice_width_m=0.05)
    text = re.sub(r"\s+", " ", page(run, results, lambda *_: Film(b"", reason="left out by the test")))
    assert "Computed is a slice of 50.0 mm, 25.0 % of the width" in text
    assert ">feed, of the whole width<" in text
    for phrase in (
        "panel widths, feed rates and numbers of particles here are of the slice",
        "Energies here are of",
    ):
        assert phrase in text


def test_bushings_of_a_slice_are_drawn_as_those_of_the_whole_width() -> None:
    """A bushing of a slice has its share of the force and of the energy lost; the ledger is the slice's."""
    turn = np.linspace(0.0, 2.0 * np.pi, 401)
    loop = {"deformation_m": 0.001 * np.cos(turn), "force_N": 500.0 * np.sin(turn)}
    along = {name: np.outer(values, [1.0, 0.0, 0.0]) for name, values in loop.items()}
    run = SimpleNamespace(
        cycle_s=1.0,
        names=lambda group: ["one"] if group == "bushings" else ["supplied.a_J"],
        read=lambda _: turn,
        read_between=lambda _, what, *__: along[what],
    )
    for part, largest_kN, loss in ((1.0, 0.5, "1.57 J"), (0.25, 2.0, "6.28 J")):
        run.share_of_width = part
        (axes, *_) = draw_bushing_loops(cast("RunReader", run)).axes
        assert np.ptp(axes.lines[0].get_ydata()) == pytest.approx(2.0 * largest_kN)
        assert axes.get_title(loc="left") == f"one, x: {loss}"
        ledger = draw_energy(cast("RunReader", run)).axes[0]
        assert ("whole width" in axes.get_ylabel()) == ("slice" in ledger.get_ylabel()) == (part < 1.0)
    plt.close("all")


def test_the_page_tells_the_sizes_along_a_curve(tmp_path: Path) -> None:
    """Straight between 6 and 10 mm, half of the mass lies below 7 mm."""
    run = folder_of(tmp_path / "run", cycles=15)
    case = tomllib.loads((run / "case.toml").read_text())
    points = ((0.0005, 0.0), (0.006, 0.45), (0.01, 0.65), (0.02, 1.0))
    for block in case["bed"]["blocks"].values():
        del block["sizes"]
        block["curve"] = [{"sieve_size_m": diameter_m, "passing": passing} for diameter_m, passing in points]
    (run / "case.toml").write_text(tomli_w.dumps(case))
    text = page(run, compute_results(run), lambda *_: Film(b"", reason="left out by the test"))
    assert ": curve 0.5 to 20 mm, half of the mass below 7 mm<" in text


@pytest.mark.process
def test_the_figures_of_the_page_are_the_results(folder: Path) -> None:
    text = re.sub(r"<[^>]+>|\s+", " ", (folder / "report.html").read_text().split("<body>")[1])
    text = re.sub(r"\s+", " ", text)
    assert "relative amplitude driven-driving, along 6.0000 mm" in text
    assert "a warning of the log" in text
    if (folder / "particles.pvd").is_file():
        assert "screening efficiency η 79.262 %" in text
        assert "50 cycles" in text
    else:
        assert "the case has no particles" in text


@pytest.mark.process
def test_an_interrupted_and_a_failed_run(tmp_path: Path) -> None:
    """The parts that a failed run lacks are not asked for; the reason stands at the top."""
    folder = folder_of(tmp_path / "run", cycles=15)
    summary = json.loads((folder / "summary.json").read_text())
    summary |= {"status": "failed", "reason": "a <solver> failed"}
    del summary["momentum_residual_relative"], summary["energy_ledger_J"]
    (folder / "summary.json").write_text(json.dumps(summary))
    for series in ("surface", "particles"):
        shutil.rmtree(folder / series)
    done = flipflow("report", str(folder))
    assert done.returncode == 0, done.stderr
    text = (folder / "report.html").read_text()
    assert "The run was failed: a &lt;solver&gt; failed" in text
    assert "No steady state" in text
    assert "No film of the deck: " in text
    assert "no snapshots" in text


@pytest.mark.process
def test_what_is_no_run(tmp_path: Path) -> None:
    for folder, why in ((tmp_path / "nowhere", "no such folder"), (tmp_path, "no run")):
        done = flipflow("report", str(folder))
        assert done.returncode == 2
        assert why in done.stderr
        said_plainly(done)
    old = folder_of(tmp_path / "old", True)
    summary = json.loads((old / "summary.json").read_text())
    del summary["sync_intervals"]
    (old / "summary.json").write_text(json.dumps(summary))
    done = flipflow("report", str(old))
    assert done.returncode == 2
    assert "'sync_intervals'" in done.stderr
    assert "another version" in done.stderr
    said_plainly(done)
    half = tmp_path / "half"
    half.mkdir()
    for name in ("case.toml", "summary.json", "provenance.json", "history.h5"):
        (half / name).write_text("{}")
    done = flipflow("report", str(half))
    assert done.returncode == 2, done.stderr
    said_plainly(done)
    assert list(half.glob("report.html")) == []


def test_a_run_that_has_not_ended(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "run", cycles=15)
    (folder / "summary.json").unlink()
    with pytest.raises(FolderUnusable, match="killed"):
        report(folder)
    with lock(folder / RUN_LOCK), pytest.raises(FolderUnusable, match="going"):
        report(folder)
    assert not (folder / "report.html").exists()


def test_a_damaged_file(tmp_path: Path) -> None:
    folder = folder_of(tmp_path / "run", cycles=15)
    provenance = folder / "provenance.json"
    provenance.write_text(provenance.read_text().replace('"flipflow"', '"flipflop"'))
    with pytest.raises(FolderUnusable, match="something in its files is damaged"):
        report(folder)
    assert not (folder / "report.html").exists()


def test_a_file_that_crashes_its_library(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """HDF5 crashes on some damaged files, which the fuzzer finds; which, hangs on its version."""
    folder = folder_of(tmp_path / "run", cycles=15)
    crash = lambda _: os.kill(os.getpid(), signal.SIGKILL)  # noqa: E731
    monkeypatch.setattr("orchestrator.output.report.page.compute_results", crash)
    with pytest.raises(FolderUnusable, match=r"\bhistory\.h5\b"):
        report(folder)


@pytest.mark.parametrize(
    ("value", "scale", "text"),
    [
        (None, 1.0, "–"),
        (float("nan"), 1.0, "–"),
        (0.0, 1.0, "0"),
        (0.0123456, 1e3, "12.3"),
        (-4.0, 1.0, "−4.00"),
        (123456.0, 1.0, "123456"),
        (1.5e9, 1.0, "1.50e+09"),
    ],
)
def test_numbers(value: float | None, scale: float, text: str) -> None:
    assert number(value, scale) == text


@pytest.mark.parametrize(
    ("value", "width", "text"),
    [
        (82.312, 0.417, "82.31 ± 0.42"),
        (82.312, 14.2, "82 ± 14"),
        (0.8231, 0.0042, "0.8231 ± 0.0042"),
        (5.0, 0.0, "5.0000 ± 0.0000"),
        (5.0, None, "5.00"),
        (None, None, "–"),
    ],
)
def test_intervals(value: float | None, width: float | None, text: str) -> None:
    assert interval(Estimate(value, width)) == text


def test_what_was_left_out_is_said_with_its_number() -> None:
    summary = {
        "left_out": {"frame-rotation": "frames.solver two-mass", "adhesion": "auto"},
        "effects": {"frame-rotation": {"before": ROTATION, "after": ROTATION | {"matters": True}}},
    }
    assert list(left_out_facts(summary)) == [
        ("frame-rotation", "frames.solver two-mass"),
        ("before the run", "may be left out: rotation 0.0512, threshold 0.1"),
        ("after the run", "matters: rotation 0.0512, threshold 0.1"),
        ("adhesion", "auto"),
    ]


def test_the_film_of_a_run_with_one_output_time_shows_it(tmp_path: Path) -> None:
    """Undriven, the run lasts from that time to that time."""
    assert last_snapshots([(0.0, tmp_path)], 0.0) == [(0.0, tmp_path)]
    pairs = [(float(n), tmp_path) for n in range(5)]
    assert last_snapshots(pairs, 2.0) == pairs[3:]
