"""All cases at all levels, the names of the effects, and the command."""

from __future__ import annotations

import subprocess
import sys
from io import StringIO
from pathlib import Path

import pytest
from rich.console import Console
from typer.testing import CliRunner

from orchestrator.case.file.base import level_names
from orchestrator.cli import explain
from orchestrator.cli.explain import COLUMNS, effects_table
from orchestrator.cli.main import app
from orchestrator.figures.short_names import SHORT_NAMES
from orchestrator.preflight import effects
from orchestrator.preflight.check import find_table_problems
from orchestrator.preflight.judge import load_judged
from orchestrator.preflight.judgement.catalogue import EFFECTS, find_dispensable, judge_effects
from orchestrator.preflight.judgement.weighing import weigh_effects
from tests.cases import CASE, case_folder, load_case
from tests.effects.verdicts import STILL_CASE

CASES = Path(__file__).parents[2] / "cases"
LEVELS = [
    (case.parent.name, level)
    for case in sorted(CASES.glob("*/case.toml"))
    for level in level_names(case.parent)
]
CALL = CliRunner()


@pytest.mark.parametrize(("case", "level"), LEVELS)
def test_every_case_is_explained_at_every_level(case: str, level: str) -> None:
    loaded = load_judged(CASES / case, level)
    verdicts = judge_effects(loaded.case).values()
    names = [row.effect for row in verdicts]
    assert len(names) == len(set(names))
    present = {row.effect: row.present for row in verdicts}
    assert not any(present.get(name, False) for name in loaded.left_out)
    assert set(loaded.left_out) <= set(names)
    assert all(row.verdict.why and row.verdict.number and row.verdict.threshold for row in verdicts)


@pytest.mark.parametrize(("case", "level"), LEVELS)
@pytest.mark.parametrize("effects", ["auto", "[]"])
def test_every_case_can_do_without_what_may_be_left_out(case: str, level: str, effects: str) -> None:
    """The case is then without mistakes in its tables, and has none of these effects."""
    judged = load_judged(CASES / case, level, [f"effects={effects}"])
    assert find_table_problems(judged) == []
    asked = weigh_effects(judged.case, None, (*SHORT_NAMES,))
    here = [row for row in asked.values() if row.present]
    spare = find_dispensable(here) if effects == "auto" else [row.effect for row in here if row.can_go]
    assert spare == []


def test_the_column_auto_is_what_auto_does() -> None:
    """The empty machine has effects that do not matter: with "auto" the case no longer has them."""
    judged = explain.judge_effects(load_judged(CASES / "empty-machine", "default"))
    table = effects_table(judged, COLUMNS)
    names, words = (table.columns[COLUMNS.index(column)].cells for column in ("effect", "auto"))
    marked = {str(name) for name, word in zip(names, words, strict=True) if word == "leaves out"}
    left_out = load_judged(CASES / "empty-machine", "default", ["effects=auto"]).left_out
    assert marked
    assert marked == {name for name in left_out if judged[name].present}


def test_every_file_is_an_effect_and_needs_only_those_there_are() -> None:
    files = {file.stem for file in Path(effects.__path__[0]).glob("*.py")} - {"__init__"}
    assert {name.replace("_", "-") for name in files} == set(EFFECTS)
    assert all(need in EFFECTS for effect in EFFECTS.values() for need in effect.needs)
    assert not set(EFFECTS) & {law for effect in EFFECTS.values() for law in effect.laws}


def test_the_command_says_what_matters_and_what_does_not() -> None:
    done = CALL.invoke(app, ["explain", str(CASES / "ffs0827-slice"), "--level", "dry"])
    assert done.exit_code == 0, done.output
    lacking = done.output[done.output.index("matters, and the case does not have it:") :]
    assert "  adhesion: the pull-off force is" in lacking
    assert "  frame-rotation: " in lacking
    assert "change of the stroke" in done.output  # larger than the panels' share of the stiffness
    assert "panels / bushings" not in done.output
    assert "docs/theory/effects.md" in done.output
    sets = ["--set", "panel.solver=rigid", "--set", "exchange.panel_motion=false"]
    done = CALL.invoke(app, ["explain", str(CASES / "quickstart"), *sets])
    assert "  panel-deformation: panels' middles are thrown with" in done.output
    assert "may be left out, and the case has it:\n  frame-rotation: " in done.output
    assert "panel-motion: particles are thrown with" in done.output


def test_parts_that_are_not_there_are_said_to_be_absent() -> None:
    done = CALL.invoke(app, ["explain", str(CASES / "bushing-hysteresis")])
    assert done.exit_code == 0
    assert "no particles: nothing to decide" in done.output
    assert "no panels: nothing to decide" in done.output
    assert "nothing that matters is lacking" in done.output


def test_a_scene_that_nothing_shakes_is_explained(tmp_path: Path) -> None:
    judged = judge_effects(load_case(tmp_path, STILL_CASE).case)
    frames = {name: row for name, row in judged.items() if row.part == "frames"}
    assert frames["panel-reaction"].verdict.why == "nothing shakes the frames"
    assert frames["bushing-damping"].verdict.value is None
    assert set(frames) == {"frame-dynamics", "frame-motion", "panel-reaction", "bushing-damping"}


def test_particles_on_a_plate_without_panels_are_explained(tmp_path: Path) -> None:
    plate = """
[screen.surfaces.plate]
corner_m = [0.0, 0.0, 0.0]
edges_m = [[0.3, 0.0, 0.0], [0.0, 0.2, 0.0]]
frame = "ground"
material = "PU"

"""
    ball = CASE[CASE.index("[bed.particles") : CASE.index("[probes.middle]")]
    case = CASE[: CASE.index("[screen.panels.deck]")] + plate + ball
    done = CALL.invoke(app, ["explain", str(case_folder(tmp_path, case))])
    assert done.exit_code == 0, done.output
    assert "no panels: nothing to decide" in done.output
    assert "infinite" in done.output


def test_narrow_terminals_get_fewer_columns(tmp_path: Path) -> None:
    judged = judge_effects(load_case(tmp_path).case)
    assert len(effects_table(judged, COLUMNS).columns) == 8
    console = Console(width=100, record=True, file=StringIO())
    console.print(effects_table(judged, COLUMNS[:-1]))
    text = console.export_text()
    assert "frame-rotation" in text
    assert "frames.solver" not in text


def test_a_case_with_mistakes_is_refused(tmp_path: Path) -> None:
    done = CALL.invoke(app, ["explain", str(case_folder(tmp_path)), "--set", "duration_s=2e4"])
    assert done.exit_code == 2
    assert "looks like ms" in done.stderr
    without = CASE.replace("[materials.PU]", "[materials.PI]")
    done = CALL.invoke(app, ["explain", str(case_folder(tmp_path, without))])
    assert done.exit_code == 2
    assert "Traceback" not in done.output


@pytest.mark.process
def test_nothing_of_the_solvers_is_imported() -> None:
    """A process of its own has only the adapter's door of a solver, and no MPI."""
    say = (
        "import sys\n"
        "from orchestrator.cli.main import app\n"
        f"app(['explain', {str(CASES / 'ffs0827-slice')!r}], standalone_mode=False)\n"
        "heads = {name.split('.')[0] for name in sys.modules}\n"
        "bad = heads & {'dolfinx', 'ufl', 'petsc4py', 'exudyn', 'mpi4py'}\n"
        "bad |= {n for n in sys.modules if n[:9] == 'adapters.' and n.endswith(('_kernel', '_liggghts'))}\n"
        "sys.exit(f'imported: {bad}' if bad else 0)\n"
    )
    done = subprocess.run(
        [sys.executable, "-c", say], capture_output=True, encoding="utf-8", check=False, timeout=60
    )
    assert done.returncode == 0, done.stderr
    assert "ffs0827-slice" in done.stdout
