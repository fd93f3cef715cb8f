"""The computation of all results of a run from its folder: the table ``results`` of ``summary.json``."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator, Mapping
from contextlib import AbstractContextManager, contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.deck.openings import open_share, openings_m, smaller_sides_m
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.scalars import COHORT, WHOLE_FEED
from orchestrator.case.tables.case import has_particles
from orchestrator.case.tables.frames import Bushing
from orchestrator.output.results import machine
from orchestrator.output.results.bed import bed_metrics, retained_metrics, transport
from orchestrator.output.results.cohort import FEWEST, cohort
from orchestrator.output.results.contacts import contacts
from orchestrator.output.results.course import course
from orchestrator.output.results.estimate import Estimate, IntervalOf, chance, remaining_drift, unknown
from orchestrator.output.results.events import BATCH, Events, read_events
from orchestrator.output.results.listed_feed import listed_feed
from orchestrator.output.results.power import power_metrics
from orchestrator.output.results.run_reader import RunReader, cut_size_m
from orchestrator.output.results.sampling import phases_missed, rows_too_seldom
from orchestrator.output.results.screening import screening
from orchestrator.output.results.wear import wear_metrics
from orchestrator.output.results.whole_feed import feed_fines, whole_feed

FEWEST_FINES = 100
TOO_EARLY = (
    f"the run ends before {FEWEST} grains or more that were fed first have nearly all left: what has left is "
    "mostly what leaves fast"
)
NO_CUT = "no openings and no output.cut_size_m: fine and coarse are not told apart"
SEVERAL_CUTS = "the panels form no single deck: output.cut_size_m says which size counts as fine"
NO_BUSHING_LOSS = "the frames move as told: what their bushings lose is in no account"
NO_CYCLE = "nothing drives the machine: it has no cycle, and no first harmonic"


def compute_results(folder: Path) -> dict[str, Any]:
    """Return the results as a table of numbers, lists and None, documented in docs/run-folder.md.

    ``missing`` gives the reason for each part that the run cannot have: a case without particles has no
    bed.  ``failed`` gives the error for each part that could not be computed; the other parts are still
    there.  Raises OSError, OtherFormat or CaseError if the folder holds no run.
    """
    with RunReader(folder) as run:
        table: dict[str, Any] = to_json(_gather(run))
        return table


def _gather(run: RunReader) -> dict[str, Any]:
    whole = run.case.whole_machine
    table: dict[str, Any] = {"missing": {}, "failed": {}, "share_of_width": run.share_of_width}
    if len(run.edges_s) < 2:
        table["missing"]["everything"] = "the run did not last for one cycle of the machine"
        return table
    table["slice_width_m"] = None if whole.slice is None else whole.slice.width_m
    events: Events | None = None
    with _record_failure(table, "steady"):
        events = _add_steady(run, table)
    for part, add in (
        ("screening", _add_screening),
        ("bed", _add_bed),
        ("motion", _add_motion),
        ("wear", _add_wear),
        ("power", _add_power),
    ):
        with _record_failure(table, part):
            add(run, events, table)
    return table


def _record_failure(table: dict[str, Any], part: str) -> AbstractContextManager[None]:
    """Record an error that prevents a part in ``table["failed"]``, and leave the part out of the table."""
    return record_error(table["failed"], part, partial(table.pop, part, None))


@contextmanager
def record_error(failed: dict[str, str], part: str, react: Callable[[], object]) -> Iterator[None]:
    """Call ``react`` after an error that prevents a part, record the error in ``failed``, and go on.

    An OSError is raised again, since then nothing more can be written.
    """
    try:
        yield
    except OSError:
        raise
    except Exception as error:
        react()
        place = traceback.extract_tb(error.__traceback__)[-1]
        raised = f"{Path(place.filename).name}, line {place.lineno}"
        failed[part] = f"{type(error).__name__}: {error} ({raised})"


def _add_steady(run: RunReader, table: dict[str, Any]) -> Events | None:
    """Add the steady state, and return the events; None if the run did not count particles in and out."""
    tables = read_events(run.history)
    if tables is None:
        return None
    feeds = run.case.bed.feeds.values()
    changes_s = tuple(at_s for row in feeds for at_s in (row.start_s, row.stop_s) if at_s is not None)
    events = Events(*tables, run.edges_s, changes_s)
    if feeds:
        events = replace(events, listed=listed_feed(tuple(feeds), events.window_s))
    state, (start_s, end_s) = events.steady, events.window_s
    table["steady"] = {
        "is_steady": not state.reason,
        "reason": state.reason,
        "start_s": start_s,
        "end_s": end_s,
        "cycles": state.last - state.first if run.is_driven else 0,
        "imbalance_percent": None if state.imbalance is None else 100 * state.imbalance,
        "drift_percent": None if state.drift is None else 100 * state.drift,
    }
    return events


def _add_screening(run: RunReader, events: Events | None, table: dict[str, Any]) -> None:
    missing = table["missing"]
    if not has_particles(run.case):
        missing["screening"] = "the case has no particles"
    elif events is None or not events.exits.names:
        missing["screening"] = "no exits: undersize and oversize are not told apart"
    else:
        one_cut = run.case.output.cut_size_m is not None or run.deck is not None
        cut_m = cut_size_m(run.case) if one_cut else None
        table["screening"] = screening(events, cut_m)
        table["transport"] = transport(events, run.deck)
        early = _add_cohort(events, cut_m, table)
        if cut_m is None:
            missing["efficiency"] = NO_CUT if one_cut else SEVERAL_CUTS
        elif early is not None:
            _add_whole_feed(run, early, cut_m, table)
            _add_contacts(run, early, cut_m, table)
        if not table["screening"]["particles"]:
            missing["products"] = "no particle left through an exit"


def _add_cohort(events: Events, cut_m: float | None, table: dict[str, Any]) -> Events | None:
    """Add the figures of the grains that were fed so early that nearly all have left, to a run that is fed
    and not steady.

    Return the events that tell the separation without bias: these, or all of them; None if there are none.
    """
    if not events.steady.reason or events.steady.reason == BATCH:
        return events
    early = cohort(events)
    if early is None:
        table["missing"][COHORT] = TOO_EARLY
        return None
    told = screening(early, cut_m)
    shares = ("efficiency_percent", "fine_placement_percent", "oversize_yield_percent")
    table["screening"]["cohort"] = {
        "fed_until_s": early.until_s,
        "remaining_percent": 100.0 * early.remaining,
        "particles": told["particles"],
        **{name: told[name] for name in shares if name in told},
    }
    return early


def _add_whole_feed(run: RunReader, events: Events, cut_m: float, table: dict[str, Any]) -> None:
    """Add the separation of the whole feed where ``smallest_fed_m`` leaves out its finest sizes."""
    feeds, openings_m = tuple(run.case.bed.feeds.values()), [*smaller_sides_m(run.case)]
    if not feeds or not openings_m:
        return
    fines = feed_fines(feeds, cut_m, events.window_s)
    if not fines.left_out:
        return
    number = int((events.left_in_window & (events.removed.sieve_size_m < cut_m)).sum())
    if number < FEWEST_FINES:
        table["missing"][WHOLE_FEED] = f"{number} fine particles left; its curve needs {FEWEST_FINES}"
        return
    if min(openings_m) < max(openings_m):
        table["missing"][WHOLE_FEED] = "the openings differ: one curve does not continue through them"
        return
    completed = whole_feed(events, fines, openings_m[0], open_share(run.case))
    if isinstance(completed, str):
        table["missing"][WHOLE_FEED] = completed
    else:
        table["screening"]["whole_feed"] = completed


def _add_contacts(run: RunReader, events: Events, cut_m: float, table: dict[str, Any]) -> None:
    """Add why so much of the fines passes, where the contacts with a deck were counted."""
    names, panels = run.counted_panels, {panel.name: panel for panel in single_panels(run.case)}
    if not names:
        return
    told = contacts(events, cut_m, names, [panels[name].apertures for name in names])
    if isinstance(told, str):
        table["missing"]["contacts"] = told
    else:
        table["contacts"] = told


def _add_bed(run: RunReader, events: Events | None, table: dict[str, Any]) -> None:
    if not has_particles(run.case):
        return
    if not run.has("profile"):
        along_deck = ("bed", "held", "passing", "velocity by residence time")
        table["missing"] |= dict.fromkeys(
            along_deck, "the panels form no deck in which one follows the other"
        )
        return
    steady = table.get("steady", {"start_s": 0.0, "end_s": run.end_s, "is_steady": False})
    start_s, end_s = steady["start_s"], steady["end_s"]
    time_s = run.read("profile/time_s")[run.output_rows("profile", start_s, end_s)]
    if why := phases_missed(time_s, run.cycle_s if run.is_driven else None):
        table["missing"] |= {"bed": why, "held": why}
        return
    times = (start_s, end_s, steady["is_steady"], interval_of(run, events))
    table["bed"] = bed_metrics(run, *times)
    table["held"] = {"openings": len(openings_m(run.case)), **retained_metrics(run, *times)}


def _add_motion(run: RunReader, events: Events | None, table: dict[str, Any]) -> None:
    start_s, end_s = motion_window(run, events)
    motion: dict[str, Any] = {
        "start_s": start_s,
        "end_s": end_s,
        "cycles": round((end_s - start_s) / run.cycle_s) if run.is_driven else 0,
        "frames": {},
        "relative": {},
        "drift": None,
        "shafts_rad_per_s": {},
        "ground": None,
        "panel_points": {},
        "panels": machine.panel_loads(run, start_s, end_s),
        "run_down": machine.run_down(run),
    }
    table["motion"] = motion
    missing, other = table["missing"], ""
    seldom = rows_too_seldom(run.series_s(), run.cycle_s, run.case.coupling.sync_interval_s)
    if not run.names("frames"):
        missing["orbits"] = "the case has no frames"
    elif why := NO_CYCLE if not run.is_driven else seldom:
        missing["orbits"] = why
    else:
        table_of_orbits, other = machine.orbits(run, start_s, end_s, interval_of(run, events))
        motion |= table_of_orbits
        motion["ground"] = machine.force_on_ground(run, start_s, end_s, interval_of(run, events))
        if (whole := course(run, interval_of(run, None))) is not None:
            table["course"] = whole
    motion["reason"] = machine.why_not_settled(run, start_s, end_s, motion["drift"], other)
    motion["is_settled"] = not motion["reason"]
    if all(probe.panel is None for probe in run.case.probes.values()):
        missing["panel acceleration"] = "no probe is on a panel"
    elif why := (seldom if run.is_driven else "") or machine.why_no_band(run):
        missing["panel acceleration"] = why
    else:
        motion["panel_points"] = machine.panel_points(run, start_s, end_s, interval_of(run, events))
    if not motion["panels"]:
        missing["panels"] = "the case has no panels"


def interval_of(run: RunReader, events: Events | None) -> IntervalOf:
    """Return the interval of motions, powers and the bed: of chance with particles, else of the remaining
    drift."""
    if not has_particles(run.case):
        return remaining_drift
    short = events is not None and not events.steady.reason and not events.has_interval
    return unknown if short else chance


def _add_wear(run: RunReader, events: Events | None, table: dict[str, Any]) -> None:
    if not run.has("wear"):
        return
    metrics = wear_metrics(run, *motion_window(run, events), _has_steady_bed(table))
    if metrics is None:
        table["missing"]["wear"] = "fewer than two output times in the part that is averaged over"
    else:
        table["wear"] = metrics


def _has_steady_bed(table: Mapping[str, Any]) -> bool:
    return bool(table.get("steady", {}).get("is_steady", False))


def _add_power(run: RunReader, events: Events | None, table: dict[str, Any]) -> None:
    if not run.is_driven:
        table["missing"]["power"] = NO_CYCLE
        return
    if "motion" in table["failed"]:
        return
    has_bed = has_particles(run.case)
    is_steady = table["motion"]["is_settled"] and (not has_bed or _has_steady_bed(table))
    metrics = power_metrics(run, *motion_window(run, events), events, is_steady, interval_of(run, events))
    if metrics is None:
        table["missing"]["power"] = "no whole cycle in the part that is averaged over"
        return
    bushings = run.case.screen.bushings.values()
    if not run.case.frames.adapter.moved_by_forces and any(_loses(row) for row in bushings):
        table["missing"]["power of the drives"] = NO_BUSHING_LOSS
        metrics = {name: value for name, value in metrics.items() if not name.startswith("drives_")}
    table["power"] = metrics


def _loses(bushing: Bushing) -> bool:
    """Return whether energy is lost in a bushing that moves."""
    return any(bushing.damping_N_s_per_m) or bool(bushing.curves)


def motion_window(run: RunReader, events: Events | None) -> tuple[float, float]:
    """Return the begin and the end of the cycles over which motion is evaluated.

    They are the steady state of the bed, or else the second half of the whole cycles.
    """
    if events is not None and not events.steady.reason:
        return events.window_s
    return run.second_half_s


def to_json(value: Any) -> Any:
    """Return a value for JSON: estimates become tables, arrays lists, and NaN and infinity None."""
    if isinstance(value, Estimate):
        return to_json(value.table())
    if isinstance(value, dict):
        return {key: to_json(inner) for key, inner in value.items()}
    if isinstance(value, (list, tuple)):
        return [to_json(inner) for inner in value]
    if isinstance(value, np.ndarray):
        return [to_json(inner) for inner in value.tolist()]
    if isinstance(value, float) and not np.isfinite(value):
        return None
    return value
