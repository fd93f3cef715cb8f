"""What the runs at the corners of the materials' ranges found, beside the run of the case as it is given.

``flipflow study corners`` makes these runs.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from orchestrator.case.file.folder import read_json
from orchestrator.output.report.formatting import number

FILE, CENTRE = "corners.json", "as-given"
"""The file in the study's folder, and the run of the case as it is given."""
WORDS = {"restitution": "restitution", "rolling_friction": "rolling friction"}


def corner_lines(folder: Path) -> list[str]:
    """Return a line for each result of the study whose centre is the run in ``folder``; none of other runs.

    A file that is not as the study writes it says nothing.
    """
    file = folder.resolve().parent / FILE
    if folder.resolve().name != CENTRE or not file.is_file():
        return []
    try:
        return [*_lines(read_json(file))]
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return []


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
