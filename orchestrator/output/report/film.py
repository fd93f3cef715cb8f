"""The film of the page, made in a process of its own: a renderer that crashes loses nothing."""

from __future__ import annotations

import json
import tempfile
from dataclasses import dataclass
from pathlib import Path

from orchestrator.output.subprocesses import python


@dataclass(frozen=True)
class Film:
    """An animated WebP of ``frames`` pictures; empty, with the ``reason``, if there is none."""

    content: bytes
    frames: int = 0
    start_s: float = 0.0
    end_s: float = 0.0
    reason: str = ""


def make_film(folder: Path, lasting_s: float) -> Film:
    """Returns the film of the last ``lasting_s`` seconds of the run."""
    with tempfile.TemporaryDirectory() as place:
        made = Path(place) / "film.webp"
        module = "orchestrator.output.report.rendering"
        words = ["-m", module, str(folder), str(lasting_s), str(made)]
        done = python(*words, capture_output=True)
        if done.returncode or not made.is_file():
            why = done.stderr.strip().splitlines()[-1:] or ["the renderer ended without a word"]
            return Film(b"", reason=why[0])
        return Film(made.read_bytes(), **json.loads(done.stdout))
