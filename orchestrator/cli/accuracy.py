"""What stored studies of accuracy say about a run that begins."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path

from orchestrator.case.file.whole import write_json
from orchestrator.case.provenance import read_provenance
from orchestrator.figures.accuracy import Accuracy
from orchestrator.preflight.judge import JudgedCase

STUDIES = Path("runs")
OBSERVES = (
    "output.pictures",
    "output.interval_s",
    "output.series_s",
    "output.shapes_s",
    "monitor.",
    "checkpoint.",
    "duration_s=",
)
"""The beginnings of overlays that a study does without."""


def found(loaded: JudgedCase, folder: Path, is_resumed: bool) -> Accuracy:
    """Return what a stored study says about a run, and keep it in the run's ``provenance.json``.

    A run that goes on in its folder keeps what was found at its begin: its case is no longer told from others
    there.
    """
    about = read_provenance(folder)
    if is_resumed:
        table = about.get("accuracy")
        return Accuracy.from_json(table) if table else Accuracy("not known", "no study was looked for")
    accuracy = look_up(loaded)
    write_json(folder / "provenance.json", about | {"accuracy": accuracy.as_json()})
    return accuracy


def look_up(loaded: JudgedCase) -> Accuracy:
    """Return what the nearest stored study says about a run of a case.

    Studies are searched beside the case, in the study's usual folder, and in the other folders in ``runs``.
    """
    name = Accuracy.stored_in
    usual = (loaded.folder / name, STUDIES / f"{loaded.name}-accuracy" / name)
    every = dict.fromkeys((*usual, *sorted(STUDIES.glob(f"*/{name}"))))
    found = Accuracy("not known", "no study of this case and level")
    if files := [file for file in every if file.is_file()]:
        # these imports take a second, and few have a study
        from orchestrator.studies.accuracy.nearest import accuracy_of
        from orchestrator.workbench import Case

        found = accuracy_of(Case(loaded), files)
    return found if found.basis != "not known" else replace(found, command=study_command(loaded))


def study_command(loaded: JudgedCase) -> str:
    """Return the command of a study of this case, in a folder that no study has yet."""
    usual = f"{loaded.name}-accuracy"
    names = (usual, *(f"{usual}-{number}" for number in range(2, 100)))
    free = next((name for name in names if not (STUDIES / name).exists()), usual)
    here, case = Path.cwd(), loaded.folder.resolve()
    shown = case.relative_to(here) if case.is_relative_to(here) else case
    words = ["flipflow", "study", "accuracy", str(shown)]
    words += ["--level", loaded.level] if loaded.level else []
    overlays = (one for one in loaded.origin.overrides if not one.startswith(OBSERVES))
    words += [word for one in overlays for word in ("--set", one)]
    return shlex.join(words + (["--out", str(STUDIES / free)] if free != usual else []))
