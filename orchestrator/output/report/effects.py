"""What a run left out, with the numbers for and against it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from orchestrator.output.report.words import number
from orchestrator.preflight.scene.effect import in_words


def left_out_rows(summary: dict[str, Any]) -> Iterator[tuple[str, str]]:
    """Rows (name, words): why, and what was judged before and after the run."""
    for name, why in summary["left_out"].items():
        yield name, why
        entry = summary.get("effects", {}).get(name, {})
        for when in ("before", "after"):
            if verdict := entry.get(when):
                yield f"{when} the run", _verdict(verdict)


def _verdict(verdict: dict[str, Any]) -> str:
    deciding = f"{verdict['number']} {number(verdict['value'])}, threshold {verdict['threshold']}"
    return f"{in_words(verdict['matters'])}: {deciding}"
