"""The runs that are doubtful, on both sides of each limit: whole runs, and summaries made by hand."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from orchestrator.cli.launch import run
from orchestrator.coupling.ledger import created_shares
from orchestrator.output.records import trust
from orchestrator.output.records.summary import write_summary
from orchestrator.output.results.quantities import Unknown, outcome
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.judgement.account import account
from orchestrator.studies import points as sweep
from orchestrator.studies.accuracy.combinations import Combination
from orchestrator.studies.criteria import Criterion, Runs, evaluate
from orchestrator.workbench import Case
from tests.runs.outside import ROOT, summary

ONLY_WARN = ["monitor.created_energy=warn", "monitor.growing_modes=warn"]
PLAIN = "coupling.scheme=particles-first"
# a case, its --set overlays, and whether its coupling is right
SCENES: dict[str, tuple[str, list[str], bool]] = {
    "panels with balls at rest": ("hard/at-rest", ["duration_s=0.1"], True),
    "a taut panel that nothing touches": ("ball-on-panel", ["duration_s=0.05"], True),
    "no gravity, so that nothing happens": ("ball-on-panel", ["gravity_m_per_s2=[0, 0, 0]"], True),
    "a machine that hardly turns": (
        "quickstart",
        ["particles.solver=none", "screen.exciters.shaft.speed_rad_per_s=0.1", "duration_s=0.1"],
        True,
    ),
    "a machine that hardly more than rounding moves": (
        "quickstart",
        [
            "particles.solver=none",
            "screen.exciters.shaft.mass_moment_kg_m=1e-5",
            "screen.exciters.shaft.speed_rad_per_s=0.1",
            "duration_s=0.1",
        ],
        True,
    ),
    "a ball that comes back from a panel": ("ball-on-panel", [], True),
    "elastic balls that bounce for ever": ("hard/elastic", [], True),
    "an impact in five intervals": (
        "ball-on-panel",
        ["coupling.sync_interval_s=2e-3", PLAIN, *ONLY_WARN],
        False,
    ),
    "elastic balls under late loads": (
        "hard/elastic",
        ["coupling.sync_interval_s=5e-4", "coupling.scheme=serial-staggered", *ONLY_WARN],
        False,
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_a_run_is_doubtful_where_its_coupling_is_wrong(tmp_path: Path, name: str) -> None:
    case, sets, right = SCENES[name]
    sets = [*sets, "output.pictures=false"]
    code = run(ROOT / "cases" / case, "draft", tmp_path / "run", sets)
    table = summary(tmp_path / "run")
    assert table["doubts"] == [] if right else "The coupling created" in table["doubts"][0]
    assert (table["status"] == trust.DOUBTFUL) is not right
    assert (code == 5) is not right
    assert table["momentum_residual_relative"] < 1e-12


def test_an_interface_is_judged_by_what_went_through_it() -> None:
    """Created between particles and panels, it does not hide behind the frames' dampers; nor is an
    interface condemned whose hand-over is turned off."""
    terms_J = {
        "lost.frames.bushing_damping": 1000.0,
        "lost.particles.contact_dissipation": 1.0,
        "created.particles-panel": 0.5,
        "created.panel-frames": -0.5,
    }
    shares = created_shares(terms_J, {"particles-panel": 1.0, "panel-frames": 0.0})
    assert shares == pytest.approx({"particles-panel": 0.25, "panel-frames": -5e-4})
    assert created_shares(terms_J, {}) == {}
    assert created_shares({}, {"panel-frames": 0.0}) == {"panel-frames": 0.0}


GOOD: dict[str, Any] = {
    "sync_intervals": 1000,
    "energy_ledger_J": {
        "lost.particles.contact_dissipation": 1.0,
        "stored.particles.kinetic": 0.3,  # of 2.3 J that were turned over
        "created.particles-panel": 0.015,
        "defect.particles": 0.05,
    },
    "energy_exchanged_J": {"particles-panel": 1.0},
    "momentum_residuals": {"panel": 1e-11, "panel-frames": 1.0},
    "iterations": {"unsolved": 9, "worst": 0.5},
    "material": {
        "fed": {"number": 1000, "mass_kg": 1.0},
        "exits": {"under": {"number": 0, "mass_kg": 0.0}},
        "lost": {"number": 9, "mass_kg": 0.009},
        "escaped": {"number": 9, "mass_kg": 0.009},
    },
}


@pytest.mark.parametrize(
    ("key", "worse", "says"),
    [
        ("energy_exchanged_J", {"particles-panel": 0.4}, "The coupling created 1.07 %"),
        ("energy_ledger_J", {"created.particles-panel": -0.04}, "The coupling destroyed 2 %"),
        ("energy_ledger_J", {"defect.particles": -0.2}, "particles' solver destroyed 8.7 %"),
        ("momentum_residuals", {"panel": 2e-9}, "Momentum does not close (panel)"),
        ("energy_exchanged_J", {"panel-frames": 1.0}, "(panel and frames)"),
        ("iterations", {"unsolved": 11}, "11 of 1000 sync intervals were not solved"),
        ("material", {"lost": {"number": 11, "mass_kg": 0.011}}, "11 particles, 1.1 % of the mass"),
        ("material", {"lost": {"number": 999, "mass_kg": 0.999}}, "999 particles, 99.9 % of the mass"),
        ("energy_ledger_J", {"defect.particles": -4.6}, "destroyed 200 %"),
        ("material", {"escaped": {"number": 11, "mass_kg": 0.011}}, "fit through no opening"),
        ("material", {"deepest_overlaps": {"surface_per_diameter": 0.26}}, "sank into the surface by 0.52"),
        ("material", {"deepest_overlaps": {"between_per_diameter": 0.26}}, "sank into each other by 0.52"),
    ],
)
def test_each_ground(key: str, worse: dict[str, Any], says: str) -> None:
    assert trust.doubts(GOOD) == []
    (doubt,) = trust.doubts(GOOD | {key: GOOD[key] | worse})
    assert says in doubt


@pytest.mark.parametrize(("level", "largest"), [("dry", 0.5), ("fine", 0.9)])
def test_contacts_as_stiff_as_the_materials_may_be_deeper(level: str, largest: float) -> None:
    """Of the two levels, ``fine`` has the materials' own stiffness, so that a lump that presses a fine grain
    into rubber is a fact; ``dry`` has softer contacts."""
    judged = load_judged(ROOT / "cases/ffs0827-effects", level, ())
    entries = account(judged.described, judged.left_out)
    effects = {name: entry.figures() for name, entry in entries.items()}

    def doubts(overlap: float) -> list[str]:
        material = GOOD["material"] | {"deepest_overlaps": {"surface_per_diameter": overlap / 2}}
        return trust.doubts(GOOD | {"effects": effects, "material": material})

    assert doubts(largest - 0.02) == []
    (doubt,) = doubts(largest + 0.02)
    assert f"of a radius, more than {largest:g}" in doubt
    assert ("largest_youngs_modulus_Pa" in doubt) is (level == "dry")  # it helps there alone


@pytest.mark.parametrize(
    ("key", "harmless"),
    [
        ("iterations", {"unsolved": 900, "worst": 0.09}),  # as good as the plain scheme
        ("material", {"lost": {"number": 900, "mass_kg": 0.9}, "exits": {}}),  # no products
        ("material", {"deepest_overlaps": {"surface_per_diameter": 0.24, "between_per_diameter": 0.24}}),
        ("material", {"fed": {"number": 0, "mass_kg": 0.0}, "lost": {"number": 0, "mass_kg": 0.0}}),
    ],
)
def test_what_does_no_harm(key: str, harmless: dict[str, Any]) -> None:
    table = GOOD | {key: GOOD[key] | harmless}
    table["material"] = table["material"] | {"escaped": {"number": 0, "mass_kg": 0.0}}
    assert trust.doubts(table) == []


def test_a_case_may_set_its_own_limit() -> None:
    figures = {"created_in_total": {"limit": 0.005}}
    (doubt,) = trust.doubts(GOOD | {"monitor": {"figures": figures}})
    assert "0.5" in doubt.split()


def test_a_run_that_failed_early_has_nothing_to_doubt() -> None:
    assert trust.doubts({"status": "failed", "sync_intervals": 0}) == []


@pytest.fixture
def doubtful(tmp_path: Path) -> sweep.Point:
    """A run that came to its end and is not to be trusted."""
    (tmp_path / "run").mkdir()
    write_summary(tmp_path / "run", {"status": "doubtful"})
    loaded = Case.load(ROOT / "cases/quickstart", "draft")
    return sweep.Point("1.0", loaded, (), tmp_path / "run")


def test_studies_take_no_doubtful_run_as_data(doubtful: sweep.Point) -> None:
    """Studies do not run it again, either: it would be as doubtful. Sweeps mark it as what it is
    (``tests/test_sweep_table.py``)."""
    assert doubtful.ended(doubtful.run)
    row = Criterion(what="a", run="one", measure="amplitude", of="driving")
    with pytest.raises(Unknown, match="run: doubtful"):  # what a paper is compared with
        evaluate(row, {"one": Runs((doubtful,))})
    point = Combination("parameter", "one", runs=(doubtful,))
    assert point.has_ended
    assert not point.with_metrics().metrics
    assert outcome(doubtful.folder) == "warned"
