"""What the runs at the corners of the materials' ranges found, or that nobody has made them.

``flipflow study corners`` makes these runs.
"""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from orchestrator.case.file.folder import read_json
from orchestrator.figures.results import Results
from orchestrator.output.report.formatting import number
from orchestrator.preflight.judge import JudgedCase
from orchestrator.preflight.material_ranges import ranged_contacts

NAME, FILE, CENTRE = "corners", "corners.json", "as-given"
"""The study, the file in its folder, and the run of the case as it is given."""
WORDS = {"restitution": "restitution", "rolling_friction": "rolling friction"}
OWN_RANGES = " --restitution LOW:HIGH --rolling-friction LOW:HIGH"


def range_lines(folder: Path, judged: JudgedCase, results: Results) -> list[str]:
    """Return how far the results of a run go within the ranges of its materials, or how to compute that.

    There is nothing to say of a run without screening, and nothing to compute of one without an efficiency.
    """
    if results.screening is None:
        return []
    if (lines := corner_lines(folder)) or results.screening.efficiency_percent is None:
        return lines
    options = "" if any(each.ranges for each in ranged_contacts(judged, {})) else OWN_RANGES
    command = f"flipflow study corners {shlex.quote(str(folder))}{options}"
    return [
        "how far the efficiency goes within the ranges of restitution and rolling friction, which stand "
        f"until they are measured, was not computed: {command} does"
    ]


def corner_lines(folder: Path) -> list[str]:
    """Return a line for each result of the corners of the run in ``folder``; none where they were not run.

    The run is the centre of the study, or it is the case that the study was made of, as it still is.  A file
    that is not as the study writes it says nothing.
    """
    folder = folder.resolve()
    study = folder.parent if folder.name == CENTRE else folder.with_name(f"{folder.name}-{NAME}")
    try:
        if not _same(folder / "case.toml", study / CENTRE / "case.toml"):
            return []
        return [*_lines(read_json(study / FILE))]
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return []


def _same(one: Path, other: Path) -> bool:
    """Return whether two files have the same content.  Raises OSError if one is missing."""
    return one == other or one.read_bytes() == other.read_bytes()


def _lines(table: Mapping[str, Any]) -> Iterator[str]:
    ranges = "; ".join(map(_describe, table["ranges"]))
    doubtful = table["doubtful"]
    doubt = f"; {len(doubtful)} of them did not end well: {', '.join(map(str, doubtful))}" if doubtful else ""
    for name, found in table["results"].items():
        low, high = (number(float(found[end])) for end in ("from", "to"))
        yield (
            f"{name} from {low} to {high} {found['unit']} within the ranges of the materials, by "
            f"{int(found['runs'])} runs of one seed each ({ranges}){doubt}"
        )


def _describe(row: Mapping[str, Any]) -> str:
    spans = (
        f"{words} {row[key][0]:g} to {row[key][1]:g}" if key in row else f"{words} as given"
        for key, words in WORDS.items()
    )
    return f"{' on '.join(map(str, row['between']))}: {', '.join(spans)}"
