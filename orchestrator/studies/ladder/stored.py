"""What a ladder measured, for ``flipflow explain``: errors and costs in place of estimates."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.preflight.levels import LoadedCase
from orchestrator.preflight.scene.effect import TENTH, Verdict
from orchestrator.studies.figures import DECISIVE

NAME = "ladder.json"
RUNGS = {
    "panel-deformation": ("panel", "rigid"),
    "panel-response": ("panel", "recorded"),
    "variation-across": ("panel", "strip"),
    "frame-dynamics": ("frames", "prescribed"),
    "frame-rotation": ("frames", "two-mass"),
    "sideways-motion": ("frames", "planar"),
    "contact-stiffness": ("particles", "as it is"),
    "single-particles": ("particles", "coarser"),
}
"""The rung that does without an effect; of softened contacts, the case itself."""


def stored(loaded: LoadedCase, given: Path | None) -> dict[str, Any] | None:
    """The ladder of the file given, or of the one beside the case if it is of this case and level;
    None where there is none.  Raises CaseError for a file that is no ladder of this case."""
    file = given or loaded.folder / NAME
    if not file.is_file():
        if given is not None:
            raise CaseError([CaseProblem((), "no such file", file=str(given))])
        return None
    try:
        found: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        same = (found["case"], found["level"]) == (loaded.name, loaded.level)
    except (ValueError, KeyError, TypeError):
        raise CaseError([CaseProblem((), "is no ladder", file=str(file))]) from None
    if given is not None and not same:
        what = f'is of case "{found["case"]}", level "{found["level"]}"'
        raise CaseError([CaseProblem((), what, file=str(file))])
    return found if same else None


def measured(effect: str, verdict: Verdict, ladder: Mapping[str, Any]) -> Verdict:
    """The verdict with the error and cost of the rung that does without the effect; as it was
    where no such rung was run."""
    where = RUNGS.get(effect)
    rungs = {(entry["ladder"], entry["rung"]): entry for entry in ladder["rungs"]}
    rung = rungs.get(where) if where else None
    errors = {name: value for name, value in (rung or {}).get("error", {}).items()}
    decisive = {name: errors[name] for name in DECISIVE if name in errors}
    if rung is None or not decisive:
        return verdict
    best = rungs[(rung["ladder"], rung["reference"])]
    said = ", ".join(f"{name} {100 * value:.2g} %" for name, value in decisive.items())
    return replace(
        verdict,
        number=f"largest error of rung {rung['rung']}",
        value=max(decisive.values()),
        threshold="0.1 (measured against " + rung["reference"] + ")",
        matters=max(decisive.values()) > TENTH,
        why=f"measured: {said}",
        cost=f"{best['processor_s']:.3g} s instead of {rung['processor_s']:.3g} s of processor",
    )
