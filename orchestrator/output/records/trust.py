"""The trust in a completed run: one definition for the console, the exit code, studies and reports.

A run ends with one of these states in ``summary.json``:

``done``
    The run is complete, and nothing in its own figures speaks against it.
``doubtful``
    The run is complete, but its own figures say that it cannot be trusted; ``doubts`` says why.
``incomplete``
    The run is complete, but some of its results could not be computed.
``interrupted``, ``failed``
    The run is not complete.

``GROUNDS`` lists all grounds for doubt; each is a small function of the summary.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from orchestrator.coupling.ledger import defect_shares, share_created
from orchestrator.ports.particle_records import largest_overlap

DONE, DOUBTFUL, INCOMPLETE = "done", "doubtful", "incomplete"
AT_THE_END = (DONE, DOUBTFUL, INCOMPLETE)
EXIT_CODES = {DONE: 0, DOUBTFUL: 5, INCOMPLETE: 6}
INTERNAL_ERROR, REFUSED = "internal error", "the computer refused"
"""The first words of the reason of a failed run that says nothing of its case: an error of the program, and
memory or a disk that was full."""

LARGEST_SHARE_CREATED = 0.01  # of the energy exchanged and lost, if the case has no limit for the coupling
LARGEST_SHARE_OF_A_SOLVER = 0.05  # of the energy that a solver turned over (defect_shares)
LARGEST_MOMENTUM_RESIDUAL = 1e-9  # relative; rounding is below 1e-12 in all runs of the tests
LARGEST_SHARE_UNSOLVED = 0.01  # of the sync intervals
LARGEST_DEVIATION = 0.1  # of the load's size, in an interval that was not solved
LARGEST_SHARE_ASTRAY = 0.01  # of the mass that came in

Summary = Mapping[str, Any]


def doubts(summary: Summary) -> list[str]:
    """Return a sentence for each reason not to trust a run, from the table of its ``summary.json``."""
    return [sentence for ground in GROUNDS for sentence in ground(summary)]


def state_at_end(summary: Summary) -> str:
    """Return the state of a completed run, from its ``doubts`` and its results."""
    if summary.get("doubts"):
        return DOUBTFUL
    results = summary.get("results")
    return INCOMPLETE if results is None or results.get("failed") else DONE


def came_to_its_end(state: str) -> bool:
    """Return whether a run with this state is complete and need not be run again."""
    return state in AT_THE_END


def is_trusted(state: str) -> bool:
    """Return whether the figures of a run with this state may be used as data."""
    return state == DONE


def _monitor_items(summary: Summary) -> dict[str, Any]:
    items: dict[str, Any] = summary.get("monitor", {}).get("figures", {})
    return items


def _energy_created(summary: Summary) -> Iterator[str]:
    """Yield a doubt if the coupling creates or destroys too much energy (``ledger.created_shares``).

    The case's ``monitor.largest_created_in_total`` sets the limit.
    """
    if "energy_ledger_J" not in summary:
        return
    share = share_created(summary)
    limit = _monitor_items(summary).get("created_in_total", {}).get("limit", LARGEST_SHARE_CREATED)
    if abs(share) > limit:
        advice = summary.get("stability", {}).get("advice") or "Shorten coupling.sync_interval_s."
        verb = "created" if share > 0 else "destroyed"
        yield (
            f"The coupling {verb} {100 * abs(share):.3g} % of the energy that was exchanged and "
            f"lost, more than {100 * limit:g} %. {advice}"
        )


def _effects_crossed(summary: Summary) -> Iterator[str]:
    """Yield a doubt for each left-out effect that matters by the run, against the estimate before it."""
    for name, entry in summary.get("effects", {}).items():
        after = entry.get("after") or {}
        if entry.get("left_out") and entry.get("crossed") and after.get("matters"):
            value = "infinite" if after["value"] is None else f"{after['value']:.3g}"
            yield (
                f"{name} is left out, and the run shows that it matters: {after['number']} is "
                f"{value}, threshold {after['threshold']}; do not leave it out."
            )


def _surfaces_penetrated(summary: Summary) -> Iterator[str]:
    """Yield a doubt if a panel went through a surface that would have stopped it."""
    observed = _monitor_items(summary).get("penetrated_surfaces", {})
    if observed.get("times"):
        yield (
            f"From t = {observed['first_s']:g} s on a panel went through a surface, by up to "
            f"{observed['worst']:.3g} of its thickness, and nothing held it there; tighten it, move "
            "one of them, or give the panel a stop."
        )


def _energy_of_solvers(summary: Summary) -> Iterator[str]:
    """Yield a doubt for each solver whose own time steps create or destroy energy."""
    if "energy_ledger_J" not in summary:
        return
    for member, share in defect_shares(summary).items():
        if abs(share) > LARGEST_SHARE_OF_A_SOLVER:
            whose, verb = f"{member.removesuffix('s')}s'", "created" if share > 0 else "destroyed"
            yield (
                f"The time steps of the {whose} solver {verb} {100 * abs(share):.3g} % "
                f"of the energy that it handled, more than "
                f"{100 * LARGEST_SHARE_OF_A_SOLVER:g} %; shorten its step or the sync interval."
            )


def _momentum(summary: Summary) -> Iterator[str]:
    """Yield a doubt for each momentum balance that does not close to rounding.

    The cause is an error in the program or in a solver.  Interfaces whose exchange is turned off are
    left out, because they lose momentum on purpose.
    """
    closed = summary.get("energy_exchanged_J", {})
    for name, residual in summary.get("momentum_residuals", {}).items():
        if residual > LARGEST_MOMENTUM_RESIDUAL and ("-" not in name or name in closed):
            yield (
                f"Momentum does not close ({name.replace('-', ' and ')}): {residual:.1e} of what "
                f"was handed over is missing, more than {LARGEST_MOMENTUM_RESIDUAL:g}."
            )


def _unsolved_intervals(summary: Summary) -> Iterator[str]:
    """Yield a doubt if many sync intervals were far from solved.

    An interval that was not solved to its tolerance is as good as an interval of the staggered scheme.
    If few intervals or small deviations do harm, the energy balance shows it.
    """
    iterations, intervals = summary.get("iterations") or {}, summary.get("sync_intervals", 0)
    unsolved, worst = iterations.get("unsolved", 0), iterations.get("worst", 0.0)
    if unsolved > LARGEST_SHARE_UNSOLVED * intervals and worst > LARGEST_DEVIATION:
        yield (
            f"{unsolved} of {intervals} sync intervals were not solved, with loads off by up to "
            f"{worst:.2g} of their size; shorten coupling.sync_interval_s or raise "
            "coupling.most_iterations."
        )


def _material(summary: Summary) -> Iterator[str]:
    """Yield a doubt for material that did not leave through the right exits, for particles that went through
    the surface, and for overlaps that are not small against the particles, where no contact law holds."""
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
                f"{amount['number']} particles, {100 * amount['mass_kg'] / fed_kg:.3g} % of the mass that "
                f"came, {what}: the masses of the products are wrong by as much."
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
    softened = not summary.get("effects", {}).get("contact-stiffness", {}).get("present", False)
    limit = largest_overlap(softened)
    help_ = (
        "; raise particles.largest_youngs_modulus_Pa, or shorten particles.step_s."
        if softened
        else ", with the materials' own stiffness: lumps press the finest grains in; leave these out."
    )
    for key, what in (("surface", "the surface"), ("between", "each other")):
        overlap = 2.0 * deepest.get(f"{key}_per_diameter", 0.0)
        if overlap > limit:
            yield f"Particles sank into {what} by {overlap:.2g} of a radius, more than {limit:g}{help_}"


GROUNDS: tuple[Callable[[Summary], Iterator[str]], ...] = (
    _energy_created,
    _effects_crossed,
    _surfaces_penetrated,
    _energy_of_solvers,
    _momentum,
    _unsolved_intervals,
    _material,
)
