"""Whether a run that came to its end can be trusted: one definition for the console, the exit
code, studies and reports.

A run ends with one of these states in ``summary.json``:

``done``
    It came to its end, and nothing in its own figures speaks against it.
``doubtful``
    It came to its end, and its own figures say that it cannot be trusted; ``doubts`` says why.
``incomplete``
    It came to its end, but some of its results could not be made.
``interrupted``, ``failed``
    It did not come to its end.

Each ground for doubt is a small function of the summary in ``GROUNDS``, and nowhere else.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from orchestrator.coupling.ledger import defect_shares, share_created
from orchestrator.ports.particle_records import LARGEST_CARRIED_OVERLAP

DONE, DOUBTFUL, INCOMPLETE = "done", "doubtful", "incomplete"
AT_THE_END = (DONE, DOUBTFUL, INCOMPLETE)
EXIT_CODES = {DONE: 0, DOUBTFUL: 5, INCOMPLETE: 6}

LARGEST_SHARE_CREATED = 0.01  # by the coupling, of the energy exchanged and lost, where the case has no limit
LARGEST_SHARE_OF_A_SOLVER = 0.05  # made by its steps, of the energy that it turned over (defect_shares)
LARGEST_MOMENTUM_RESIDUAL = 1e-9  # relative; rounding is below 1e-12 in all runs of the tests
LARGEST_SHARE_UNSOLVED = 0.01  # of the sync intervals
LARGEST_DEVIATION = 0.1  # of the load in an interval that was not solved, of its size
LARGEST_SHARE_ASTRAY = 0.01  # of the mass that came

Summary = Mapping[str, Any]


def doubts(summary: Summary) -> list[str]:
    """Return the reasons why the run behind ``summary`` (the table of ``summary.json``) is not to
    be trusted, a whole sentence each; none for a run that can be."""
    return [sentence for ground in GROUNDS for sentence in ground(summary)]


def state_at_end(summary: Summary) -> str:
    """Return the state of a run that came to its end, from its ``doubts`` and its results."""
    if summary.get("doubts"):
        return DOUBTFUL
    results = summary.get("results")
    return INCOMPLETE if results is None or results.get("failed") else DONE


def came_to_its_end(state: str) -> bool:
    """Return whether a run of this state need not be run again."""
    return state in AT_THE_END


def is_trusted(state: str) -> bool:
    """Return whether figures of a run of this state may be taken as data."""
    return state == DONE


def _monitored(summary: Summary) -> dict[str, Any]:
    items: dict[str, Any] = summary.get("monitor", {}).get("figures", {})
    return items


def _energy_created(summary: Summary) -> Iterator[str]:
    """Doubts a coupling that makes or destroys more than a small share of the energy that goes through
    it (``ledger.created_shares``); ``monitor.largest_created_in_total`` of the case says how much."""
    if "energy_ledger_J" not in summary:
        return
    share = share_created(summary)
    limit = _monitored(summary).get("created_in_total", {}).get("limit", LARGEST_SHARE_CREATED)
    if abs(share) > limit:
        advice = summary.get("stability", {}).get("advice") or "Shorten coupling.sync_interval_s."
        made = "created" if share > 0 else "destroyed"
        yield (
            f"The coupling {made} {100 * abs(share):.2g} % of the energy that was exchanged and "
            f"lost, more than {100 * limit:g} %. {advice}"
        )


def _effects_crossed(summary: Summary) -> Iterator[str]:
    """Doubts a run that contradicts the estimate by which an effect was left out of it."""
    for name, entry in summary.get("effects", {}).items():
        after = entry.get("after") or {}
        if entry.get("left_out") and entry.get("crossed") and after.get("matters"):
            value = "infinite" if after["value"] is None else f"{after['value']:.3g}"
            yield (
                f"{name} is left out, and by the run it matters: {after['number']} is "
                f"{value}, threshold {after['threshold']}; do not leave it out."
            )


def _surfaces_penetrated(summary: Summary) -> Iterator[str]:
    """Doubts a run in which a panel went through a surface that would have held it."""
    observed = _monitored(summary).get("penetrated_surfaces", {})
    if observed.get("times"):
        yield (
            f"From t = {observed['first_s']:g} s on a panel went through a surface, by up to "
            f"{observed['worst']:.3g} of its thickness, and nothing held it there; tighten it, move "
            "one of them, or give the panel a stop."
        )


def _energy_of_solvers(summary: Summary) -> Iterator[str]:
    """Doubts a solver whose own steps make or destroy energy."""
    if "energy_ledger_J" not in summary:
        return
    for member, share in defect_shares(summary).items():
        if abs(share) > LARGEST_SHARE_OF_A_SOLVER:
            whose, made = f"{member.removesuffix('s')}s'", "made" if share > 0 else "destroyed"
            yield (
                f"The time steps of the {whose} solver {made} {100 * abs(share):.2g} % "
                f"of the energy that it turned over, more than "
                f"{100 * LARGEST_SHARE_OF_A_SOLVER:g} %; shorten its step or the sync interval."
            )


def _momentum(summary: Summary) -> Iterator[str]:
    """Doubts momentum that does not close to rounding: an error in the program or in a solver.
    Interfaces whose hand-over is turned off lose it on purpose."""
    closed = summary.get("energy_exchanged_J", {})
    for name, residual in summary.get("momentum_residuals", {}).items():
        if residual > LARGEST_MOMENTUM_RESIDUAL and ("-" not in name or name in closed):
            yield (
                f"Momentum does not close ({name.replace('-', ' and ')}): {residual:.1e} of what "
                f"was handed over is missing, more than {LARGEST_MOMENTUM_RESIDUAL:g}."
            )


def _unsolved_intervals(summary: Summary) -> Iterator[str]:
    """Doubts many intervals that were far from solved.  One not solved to its tolerance is as good as one
    of the plain scheme: a few of them, or small deviations, do no harm that the energy would not show."""
    iterations, intervals = summary.get("iterations") or {}, summary.get("sync_intervals", 0)
    unsolved, worst = iterations.get("unsolved", 0), iterations.get("worst", 0.0)
    if unsolved > LARGEST_SHARE_UNSOLVED * intervals and worst > LARGEST_DEVIATION:
        yield (
            f"{unsolved} of {intervals} sync intervals were not solved, with loads off by up to "
            f"{worst:.2g} of their size; shorten coupling.sync_interval_s or raise "
            "coupling.most_iterations."
        )


def _material(summary: Summary) -> Iterator[str]:
    """Doubts products where material took another way than through the exits, a surface that particles
    went through, and contacts that are not small against them: then no contact law holds."""
    material = summary.get("material") or {}
    fed_kg = material.get("fed", {}).get("mass_kg", 0.0)
    ways = {
        "lost": "left elsewhere than through an exit",
        "escaped": "came out with the undersize although they fit through no opening",
    }
    for key, what in ways.items() if material.get("exits") else ():
        amount = material[key]
        if amount["mass_kg"] > LARGEST_SHARE_ASTRAY * fed_kg:
            yield (
                f"{amount['number']} particles, {100 * amount['mass_kg'] / fed_kg:.2g} % of the mass that "
                f"came, {what}: the products are off by as much."
            )
    crossings = material.get("crossings", {"number": 0})
    if crossings["number"]:
        place = ", ".join(f"{x:.4g}" for x in crossings["first_position_m"])
        yield (
            f"Particles went through the surface {crossings['number']} times, the first one "
            f"(number {crossings['first_id']}) at ({place}) m at t = "
            f"{crossings['first_time_s']:.6g} s; raise "
            "particles.largest_youngs_modulus_Pa, or shorten particles.step_s."
        )
    deepest = material.get("deepest_overlaps", {})
    for key, what in (("surface", "the surface"), ("between", "each other")):
        overlap = 2.0 * deepest.get(f"{key}_per_diameter", 0.0)
        if overlap > LARGEST_CARRIED_OVERLAP:
            yield (
                f"Particles sank into {what} by {overlap:.2g} of a radius, more than "
                f"{LARGEST_CARRIED_OVERLAP:g}; raise particles.largest_youngs_modulus_Pa, or "
                "shorten particles.step_s."
            )


GROUNDS: tuple[Callable[[Summary], Iterator[str]], ...] = (
    _energy_created,
    _effects_crossed,
    _surfaces_penetrated,
    _energy_of_solvers,
    _momentum,
    _unsolved_intervals,
    _material,
)
