"""Comparison of what two runs left behind, to the last bit."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from orchestrator.output import checkpoints
from orchestrator.ports import Saved
from tests.saved_states import differences

OF_THE_CLOCK = (
    "wall_s",
    "wall_by_part_s",
    "repeated_by_part_s",
    "particle_steps_per_s",
    "processor_s",
    "processor_before_s",
    "peak_memory_MiB",
)
OF_THE_CLOCK += ("status", "reason")


def run_differences(first: Path, other: Path) -> list[str]:
    """Names of what differs: series, files for ParaView, summary, and the state at the end."""
    lines = differences(_history(first), _history(other), "history.h5")
    lines += differences(_pictured(first), _pictured(other), "files")
    lines += differences(_summary(first), _summary(other), "summary.json")
    return lines + differences(_end(first), _end(other), "end")


def _history(run: Path) -> Saved:
    series: Saved = {}
    with h5py.File(run / "history.h5") as history:
        history.visititems(
            lambda name, item: (
                series.update({name: item[()]})
                if isinstance(item, h5py.Dataset) and not name.startswith("results")
                else None
            )
        )
    return series


def _pictured(run: Path) -> Saved:
    shown = [*run.glob("*.pvd"), *run.glob("*/*.vtu")]
    return {str(file.relative_to(run)): np.frombuffer(file.read_bytes(), np.uint8) for file in shown}


def _summary(run: Path) -> Saved:
    figures: dict[str, Any] = json.loads((run / "summary.json").read_text())
    text = json.dumps({name: figures[name] for name in figures if name not in OF_THE_CLOCK})
    return {"text": np.array(text)}


def _end(run: Path) -> Saved:
    save = checkpoints.find_newest(run)
    assert save is not None
    return save.state(None)
