"""All results of a run, from its folder: the table ``results`` of ``summary.json``."""

from __future__ import annotations

import traceback
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from orchestrator.case.deck.line import DeckLine, deck_line
from orchestrator.case.deck.opening_places import openings_m
from orchestrator.case.file.contents import has_particles
from orchestrator.case.file.slice import share
from orchestrator.output.results import machine
from orchestrator.output.results.bed import averaged, bed_figures, held_figures, transport
from orchestrator.output.results.estimate import Estimate
from orchestrator.output.results.events import Events, balanced, read
from orchestrator.output.results.run_reader import RunData, cut_size_m, run_data
from orchestrator.output.results.sampling import phases_missed, rows_too_seldom
from orchestrator.output.results.screening import screening
from orchestrator.output.results.wear import wear_figures

NO_EXITS = "no exits: undersize and oversize are not told apart"
NO_CUT = "no openings and no output.cut_size_m: fine and coarse are not told apart"
NO_CYCLE = "nothing drives the machine: it has no cycle, and no first harmonic"


def results(folder: Path) -> dict[str, Any]:
    """Plain numbers, lists and None, documented in docs/run-folder.md.

    ``missing`` says what the run cannot have, and why: a case without particles has no bed.
    ``failed`` says what it ought to have and could not be computed, by the name of the part, with
    the error; one part that fails loses no other.  Raises OSError or CaseError if the folder holds
    no run.
    """
    with h5py.File(folder / "history.h5") as history:
        found: dict[str, Any] = plain(_gathered(run_data(folder, history)))
        return found


def _gathered(data: RunData) -> dict[str, Any]:
    found: dict[str, Any] = {"missing": {}, "failed": {}, "share_of_width": share(data.case.whole)}
    if len(data.edges_s) < 2:
        found["missing"]["everything"] = "the run did not last for one cycle of the machine"
        return found
    events: list[Events] = []
    _make(found, "steady", lambda: _add_steady(data, events, found))
    balance = events[0] if events else None
    if has_particles(data.case):
        _make(found, "screening", lambda: _add_screening(data, balance, found))
        _make(found, "bed", lambda: _add_bed(data, found))
    else:
        found["missing"]["screening"] = "the case has no particles"
    _make(found, "motion", lambda: _add_machine(data, balance, found))
    if "wear" in data.history:
        _make(found, "wear", lambda: _add_wear(data, balance, found))
    return found


def _make(found: dict[str, Any], part: str, add: Callable[[], None]) -> None:
    """Adds a part, or notes the error that prevented it."""
    try:
        add()
    except OSError:
        raise
    except Exception as error:
        found.pop(part, None)
        found["failed"][part] = named_error(error)


def named_error(error: Exception) -> str:
    """The error, and the line of the program that raised it."""
    place = traceback.extract_tb(error.__traceback__)[-1]
    file = Path(place.filename).name
    return f"{type(error).__name__}: {error} ({file}, line {place.lineno})"


def _add_steady(data: RunData, events: list[Events], found: dict[str, Any]) -> None:
    """To ``events`` what went in and out, where that was counted."""
    tables = read(data.history)
    if tables is None:
        return
    balance = balanced(*tables, data.edges_s)
    state = balance.steady
    found["steady"] = {
        "is_steady": not state.reason,
        "reason": state.reason,
        "start_s": float(data.edges_s[state.first]),
        "end_s": float(data.edges_s[state.last]),
        "cycles": state.last - state.first if data.is_driven else 0,
        "imbalance_percent": None if state.imbalance is None else 100 * state.imbalance,
        "drift_percent": None if state.drift is None else 100 * state.drift,
    }
    events.append(balance)


def _add_screening(data: RunData, events: Events | None, found: dict[str, Any]) -> None:
    if events is None or not events.exits.names:
        found["missing"]["screening"] = NO_EXITS
        return
    cut_m = cut_size_m(data.case)
    found["screening"] = screening(events, cut_m)
    found["transport"] = transport(events, _deck(data))
    if cut_m is None:
        found["missing"]["efficiency"] = NO_CUT
    if not found["screening"]["particles"]:
        found["missing"]["products"] = "no particle left through an exit"


def _add_bed(data: RunData, found: dict[str, Any]) -> None:
    if "profile" not in data.history:
        found["missing"]["bed"] = "the panels form no deck in which one follows the other"
        return
    steady = found.get("steady", {"start_s": 0.0, "end_s": data.end_s, "is_steady": False})
    start_s, end_s = steady["start_s"], steady["end_s"]
    time_s = data.read("profile/time_s")
    time_s = time_s[averaged(time_s, start_s, end_s)]
    if why := phases_missed(time_s, data.cycle_s if data.is_driven else None):
        found["missing"]["bed"] = why
        return
    times = (start_s, end_s, steady["is_steady"])
    found["bed"] = bed_figures(data, *times)
    found["held"] = {"openings": len(openings_m(data.case)), **held_figures(data, *times)}


def _add_machine(data: RunData, events: Events | None, found: dict[str, Any]) -> None:
    start_s, end_s = motion_window(data, events)
    reason = machine.not_settled(data, start_s, end_s)
    motion: dict[str, Any] = {
        "start_s": start_s,
        "end_s": end_s,
        "cycles": round((end_s - start_s) / data.cycle_s) if data.is_driven else 0,
        "is_settled": not reason,
        "reason": reason,
        "frames": {},
        "relative": {},
        "panel_points": {},
        "panels": machine.panel_loads(data, start_s, end_s),
    }
    found["motion"] = motion
    missing = found["missing"]
    seldom = rows_too_seldom(data.series_s(), data.cycle_s, data.case.coupling.sync_interval_s)
    if not data.names("frames"):
        missing["orbits"] = "the case has no frames"
    elif why := NO_CYCLE if not data.is_driven else seldom:
        missing["orbits"] = why
    else:
        motion["frames"] = machine.frame_points(data, start_s, end_s)
        motion["relative"] = machine.relative_motion(data, start_s, end_s)
    if all(probe.panel is None for probe in data.case.probes.values()):
        missing["panel acceleration"] = "no probe is on a panel"
    elif why := (seldom if data.is_driven else "") or machine.band_missed(data):
        missing["panel acceleration"] = why
    else:
        motion["panel_points"] = machine.panel_points(data, start_s, end_s)
    if not motion["panels"]:
        missing["panels"] = "the case has no panels"


def _add_wear(data: RunData, events: Events | None, found: dict[str, Any]) -> None:
    start_s, end_s = motion_window(data, events)
    is_steady = found.get("steady", {}).get("is_steady", False)
    figures = wear_figures(data, start_s, end_s, is_steady, _deck(data))
    if figures is None:
        found["missing"]["wear"] = "fewer than two output times in the part that is averaged over"
    else:
        found["wear"] = figures


def motion_window(data: RunData, events: Events | None) -> tuple[float, float]:
    """The steady state of the bed, or else the last half of the whole cycles."""
    edges = data.edges_s
    if events is not None and not events.steady.reason:
        return float(edges[events.steady.first]), float(edges[events.steady.last])
    return float(edges[(len(edges) - 1) // 2]), float(edges[-1])


def _deck(data: RunData) -> DeckLine | None:
    names = data.names("panels")
    return deck_line([data.history[f"panels/{name}/centre_line_m"][0] for name in names])


def plain(value: Any) -> Any:
    """As JSON has it: estimates as tables, arrays as lists, None for what is not a number."""
    if isinstance(value, Estimate):
        return plain(asdict(value))
    if isinstance(value, dict):
        return {key: plain(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(inner) for inner in value]
    if isinstance(value, np.ndarray):
        return [plain(inner) for inner in value.tolist()]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
