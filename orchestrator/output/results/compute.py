"""The computation of all results of a run from its folder: the table ``results`` of ``summary.json``."""

from __future__ import annotations

import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from pathlib import Path

from orchestrator.case.deck.openings import open_share, smaller_sides_m
from orchestrator.case.deck.panels import single_panels
from orchestrator.case.tables.case import has_particles
from orchestrator.case.tables.frames import Bushing
from orchestrator.figures.machine import Motion, Power
from orchestrator.figures.material import CohortShares, Screening, Steady, WholeFeed
from orchestrator.figures.results import BATCH, COHORT, WHOLE_FEED, Results
from orchestrator.output.results import machine
from orchestrator.output.results.bed import bed_metrics, mean_bulk, retained_metrics, transport
from orchestrator.output.results.cohort import FEWEST, cohort
from orchestrator.output.results.contacts import contacts
from orchestrator.output.results.course import course
from orchestrator.output.results.estimate import IntervalOf, chance, remaining_drift, unknown
from orchestrator.output.results.events import Events, read_events
from orchestrator.output.results.listed_feed import listed_feed
from orchestrator.output.results.power import power_metrics
from orchestrator.output.results.run_reader import RunReader, cut_size_m
from orchestrator.output.results.sampling import phases_missed, rows_too_seldom
from orchestrator.output.results.screening import screening, shares
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


def compute_results(folder: Path) -> Results:
    """Return the results of a run, documented in docs/run-folder.md.

    ``missing`` gives the reason for each part that the run cannot have: a case without particles has no
    bed.  ``failed`` gives the error for each part that could not be computed; the other parts are still
    there.  Raises OSError, OtherFormat or CaseError if the folder holds no run.
    """
    with RunReader(folder) as run:
        whole = run.case.whole_machine
        results = Results(
            share_of_width=run.share_of_width,
            slice_width_m=None if whole.slice is None else whole.slice.width_m,
        )
        with record_error(results.failed, "bulk"):
            results.bulk = mean_bulk(run)
        if len(run.edges_s) < 2:
            results.missing["everything"] = "the run did not last for one cycle of the machine"
            return results
        events: Events | None = None
        with record_error(results.failed, "steady"):
            events = _read_events(run)
            results.steady = _steady(run, events)
        for part, add in (
            ("screening", _add_screening),
            ("bed", _add_bed),
            ("motion", _add_motion),
            ("wear", _add_wear),
            ("power", _add_power),
        ):
            with record_error(results.failed, part, partial(setattr, results, part, None)):
                add(run, events, results)
        return results


@contextmanager
def record_error(
    failed: dict[str, str], part: str, react: Callable[[], object] = lambda: None
) -> Iterator[None]:
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


def _read_events(run: RunReader) -> Events | None:
    """Return what came and left; None if the run did not count particles in and out."""
    tables = read_events(run.history)
    if tables is None:
        return None
    feeds = run.case.bed.feeds.values()
    changes_s = tuple(at_s for row in feeds for at_s in (row.start_s, row.stop_s) if at_s is not None)
    events = Events(*tables, run.edges_s, changes_s)
    return replace(events, listed=listed_feed(tuple(feeds), events.window_s)) if feeds else events


def _steady(run: RunReader, events: Events | None) -> Steady | None:
    """Return the steady state of the bed."""
    if events is None:
        return None
    state, (start_s, end_s) = events.steady, events.window_s
    return Steady(
        is_steady=not state.reason,
        reason=state.reason,
        start_s=start_s,
        end_s=end_s,
        cycles=state.last - state.first if run.is_driven else 0,
        imbalance_percent=None if state.imbalance is None else 100 * state.imbalance,
        drift_percent=None if state.drift is None else 100 * state.drift,
    )


def _add_screening(run: RunReader, events: Events | None, results: Results) -> None:
    missing = results.missing
    if not has_particles(run.case):
        missing["screening"] = "the case has no particles"
    elif events is None or not events.exits.names:
        missing["screening"] = "no exits: undersize and oversize are not told apart"
    else:
        one_cut = run.case.output.cut_size_m is not None or run.deck is not None
        cut_m = cut_size_m(run.case) if one_cut else None
        results.screening = screening(events, cut_m)
        results.transport = transport(events, run.deck)
        early, results.screening = _with_cohort(events, cut_m, results.screening, missing)
        if cut_m is None:
            missing["efficiency"] = NO_CUT if one_cut else SEVERAL_CUTS
        elif early is not None:
            whole = _whole_feed(run, early, cut_m, missing)
            results.screening = replace(results.screening, whole_feed=whole)
            _add_contacts(run, early, cut_m, results)
        if not results.screening.particles:
            missing["products"] = "no particle left through an exit"


def _with_cohort(
    events: Events, cut_m: float | None, told: Screening, missing: dict[str, str]
) -> tuple[Events | None, Screening]:
    """Return the events that tell the separation without bias, and the screening results with the cohort.

    In a run that is fed and not steady, they are those of the grains that were fed so early that nearly all
    have left, or None if there are too few; in others, all of them.
    """
    if not events.steady.reason or events.steady.reason == BATCH:
        return events, told
    early = cohort(events)
    if early is None:
        missing[COHORT] = TOO_EARLY
        return None, told
    of_these = shares(early, cut_m)
    grains = CohortShares(
        fed_until_s=early.until_s,
        remaining_percent=100.0 * early.remaining,
        particles=int(early.left_in_window.sum()),
        efficiency_percent=of_these.get("efficiency"),
        fine_placement_percent=of_these.get("fine_placement"),
        oversize_yield_percent=of_these.get("oversize_yield"),
    )
    return early, replace(told, cohort=grains)


def _whole_feed(run: RunReader, events: Events, cut_m: float, missing: dict[str, str]) -> WholeFeed | None:
    """Return the separation of the whole feed where ``smallest_fed_m`` leaves out its finest sizes."""
    feeds, openings_m = tuple(run.case.bed.feeds.values()), [*smaller_sides_m(run.case)]
    if not feeds or not openings_m:
        return None
    fines = feed_fines(feeds, cut_m, events.window_s)
    if not fines.left_out:
        return None
    number = int((events.left_in_window & (events.removed.sieve_size_m < cut_m)).sum())
    if number < FEWEST_FINES:
        missing[WHOLE_FEED] = f"{number} fine particles left; its curve needs {FEWEST_FINES}"
        return None
    if min(openings_m) < max(openings_m):
        missing[WHOLE_FEED] = "the openings differ: one curve does not continue through them"
        return None
    completed = whole_feed(events, fines, openings_m[0], open_share(run.case))
    if isinstance(completed, str):
        missing[WHOLE_FEED] = completed
        return None
    return completed


def _add_contacts(run: RunReader, events: Events, cut_m: float, results: Results) -> None:
    """Add why so much of the fines passes, where the contacts with a deck were counted."""
    names, panels = run.counted_panels, {panel.name: panel for panel in single_panels(run.case)}
    if not names:
        return
    told = contacts(events, cut_m, names, [panels[name].apertures for name in names])
    if isinstance(told, str):
        results.missing["contacts"] = told
    else:
        results.contacts = told


def _add_bed(run: RunReader, events: Events | None, results: Results) -> None:
    if not has_particles(run.case):
        return
    if not run.has("profile"):
        along_deck = ("bed", "held", "passing", "velocity by residence time")
        results.missing |= dict.fromkeys(along_deck, "the panels form no deck in which one follows the other")
        return
    steady = results.steady
    start_s, end_s = (0.0, run.end_s) if steady is None else (steady.start_s, steady.end_s)
    time_s = run.read("profile/time_s")[run.output_rows("profile", start_s, end_s)]
    if why := phases_missed(time_s, run.cycle_s if run.is_driven else None):
        results.missing |= {"bed": why, "held": why}
        return
    times = (start_s, end_s, _has_steady_bed(results), interval_of(run, events))
    results.bed = bed_metrics(run, *times)
    results.held = retained_metrics(run, *times)


def _add_motion(run: RunReader, events: Events | None, results: Results) -> None:
    start_s, end_s = motion_window(run, events)
    missing, width_of = results.missing, interval_of(run, events)
    orbits, ground = machine.Orbits(), None
    seldom = rows_too_seldom(run.series_s(), run.cycle_s, run.case.coupling.sync_interval_s)
    if not run.names("frames"):
        missing["orbits"] = "the case has no frames"
    elif why := NO_CYCLE if not run.is_driven else seldom:
        missing["orbits"] = why
    else:
        orbits = machine.orbits(run, start_s, end_s, width_of)
        ground = machine.force_on_ground(run, start_s, end_s, width_of)
        results.course = course(run, interval_of(run, None))
    points = {}
    if all(probe.panel is None for probe in run.case.probes.values()):
        missing["panel acceleration"] = "no probe is on a panel"
    elif why := (seldom if run.is_driven else "") or machine.why_no_band(run):
        missing["panel acceleration"] = why
    else:
        points = machine.panel_points(run, start_s, end_s, width_of)
    panels = machine.panel_loads(run, start_s, end_s)
    if not panels:
        missing["panels"] = "the case has no panels"
    reason = machine.why_not_settled(run, start_s, end_s, orbits.drift, orbits.mostly_other)
    results.motion = Motion(
        start_s=start_s,
        end_s=end_s,
        cycles=round((end_s - start_s) / run.cycle_s) if run.is_driven else 0,
        is_settled=not reason,
        drift=orbits.drift,
        reason=reason,
        frames=orbits.frames,
        relative=orbits.relative,
        speed_rad_per_s=orbits.speed_rad_per_s,
        shafts_rad_per_s=run.shaft_speeds_rad_per_s(start_s, end_s) if orbits.frames else {},
        ground=ground,
        panel_points=points,
        panels=panels,
        run_down=machine.run_down(run),
    )


def interval_of(run: RunReader, events: Events | None) -> IntervalOf:
    """Return the interval of motions, powers and the bed: of chance with particles, else of the remaining
    drift."""
    if not has_particles(run.case):
        return remaining_drift
    short = events is not None and not events.steady.reason and not events.has_interval
    return unknown if short else chance


def _add_wear(run: RunReader, events: Events | None, results: Results) -> None:
    if not run.has("wear"):
        return
    results.wear = wear_metrics(run, *motion_window(run, events), _has_steady_bed(results))
    if results.wear is None:
        results.missing["wear"] = "fewer than two output times in the part that is averaged over"


def _has_steady_bed(results: Results) -> bool:
    return results.steady is not None and results.steady.is_steady


def _add_power(run: RunReader, events: Events | None, results: Results) -> None:
    if not run.is_driven:
        results.missing["power"] = NO_CYCLE
        return
    if results.motion is None:
        return
    has_bed = has_particles(run.case)
    is_steady = results.motion.is_settled and (not has_bed or _has_steady_bed(results))
    power = power_metrics(run, *motion_window(run, events), events, is_steady, interval_of(run, events))
    if power is None:
        results.missing["power"] = "no whole cycle in the part that is averaged over"
        return
    results.power = _known_power(run, power, results.missing)


def _known_power(run: RunReader, power: Power, missing: dict[str, str]) -> Power:
    """Return the powers without that of the drives where bushings lose what is in no account."""
    bushings = run.case.screen.bushings.values()
    if run.case.frames.adapter.moved_by_forces or not any(_loses(row) for row in bushings):
        return power
    missing["power of the drives"] = NO_BUSHING_LOSS
    return replace(power, drives_W=None, drives_J_per_kg=None)


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
