"""The numbers of one run, in SI units, by which criteria judge it and studies compare it.

A question (``Question``) asks for a number by the name of a measure (``MEASURES``), and names the data that
the measure evaluates.  Some measures are quantities (``QUANTITIES``), which need no further data: they are
taken over the last whole cycles of a run (at most four, and only from its second half), quantities of panels
are means over the panels, and studies of accuracy compare runs by them.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, ClassVar, Literal

import numpy as np

from orchestrator.case.bed.saved_bed import grains_of, shapes_in
from orchestrator.case.deck.panels import SinglePanel, single_panels
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.quantities import Number, OneLine, Table
from orchestrator.coupling.ledger import share_created
from orchestrator.figures.figure import Figure
from orchestrator.figures.results import FIGURES, orbit_places, why_no_orbits
from orchestrator.figures.short_names import SHORT_NAMES, Value, unit_at, value_at
from orchestrator.output.cycles import cycle_numbers, cycle_s
from orchestrator.output.records import trust
from orchestrator.output.records.summary import processor_by_part_s
from orchestrator.output.results import machine
from orchestrator.output.results.bed import deck_area_m2
from orchestrator.output.results.compute import interval_of
from orchestrator.output.results.estimate import NORMAL_95
from orchestrator.output.results.run_reader import RunReader, summary_of
from orchestrator.ports import Array
from orchestrator.ports.acceleration import acceleration_m_per_s2
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.ports.shape_grid import ShapeGrid


class Unknown(Exception):
    """An error of a number that a run does not have; the message says why."""


class Question(Table):
    """A question for one number of a run."""

    measure: OneLine
    """The measure that gives the number (``quantities.MEASURES``)."""
    of: OneLine = ""
    """The data that the measure evaluates: a dataset of history.h5, keys of summary.json with dots or a
    short name of a result, a frame, a probe or a pair of frames."""
    axis: Literal["", "x", "y", "z", "size"] = ""
    """The component of vectors (x along the deck, z normal to it, for amplitudes), or their size."""
    take: OneLine = "last"
    """The statistic of a series that counts (``quantities.TAKES``)."""
    between_s: tuple[Number, Number] | None = None
    """The part of a series that counts, from its start to its end."""

    @staticmethod
    def words(key: Literal["measure", "take"]) -> list[str]:
        """Return the words that a key may be."""
        return [*(MEASURES if key == "measure" else TAKES)]


AXES = {"x": 0, "y": 1, "z": 2}
TAKES: dict[str, Callable[[Array, Array], float]] = {
    "first": lambda time_s, values: float(values[0]),
    "last": lambda time_s, values: float(values[-1]),
    "mean": lambda time_s, values: float(values.mean()),
    "lowest": lambda time_s, values: float(values.min()),
    "highest": lambda time_s, values: float(values.max()),
    "range": lambda time_s, values: float(np.ptp(values)),
    "largest": lambda time_s, values: float(np.abs(values).max()),
    "impulse": lambda time_s, values: float(np.diff(time_s) @ values[1:]),  # rows are means
}


def number_of(question: Question, run: Path) -> float:
    """Return the number that a question asks of one run.

    Only a trustworthy run has a number, unless the question asks whether the run is trustworthy.  Raises
    Unknown.
    """
    state = str(summary_of(run).get("status", "missing"))
    if question.measure not in ABOUT_TRUST and state != trust.DONE:
        raise Unknown(f"{run.name}: {state}")
    return MEASURES[question.measure](question, run)


def half_width_of(question: Question, run: Path) -> float | None:
    """Return half the width of the 95 % confidence interval of the number that a question asks of one run.

    It is that of the run's results, or, for a share without one, that of the count of its particles.  None
    stands for a number without an interval.  Raises Unknown.
    """
    if question.measure == "result":
        value, unit = _entry_at(run, question.of), _unit_of_result(question.of)
        if value.half_width is not None:
            return value.half_width * unit
        return None if value.counting is None else NORMAL_95 * value.counting * unit
    if question.measure == "amplitude":
        return _first_harmonic(question, run)[1]
    return None


def _entry_at(run: Path, path: str) -> Value:
    """Return a number of summary.json with its interval.  Raises Unknown."""
    value = value_at(summary_of(run), path)
    if value is None:
        raise Unknown(f"{run.name}: {path} is not known")
    return value


def _unit_of_result(path: str) -> float:
    """Return the factor that converts a number of summary.json to SI units: percentages become shares."""
    return 0.01 if unit_at(path) == "%" else 1.0


def _value_at(run: Path, path: str) -> float:
    """Return a number of summary.json; percentages are converted to shares."""
    return _entry_at(run, path).value * _unit_of_result(path)


def _series(question: Question, run: Path) -> float:
    group = question.of.rpartition("/")[0]
    time_s, values = read_dataset(run, f"{group}/time_s"), read_dataset(run, question.of)
    if question.axis == "size":
        values = np.linalg.norm(values, axis=-1)
    elif question.axis:
        values = values[..., AXES[question.axis]]
    if values.ndim > 1:
        raise Unknown(f"{question.of} is a vector: which component (axis = x, y, z or size) is not said")
    low, high = question.between_s or (-np.inf, np.inf)
    inside = (low <= time_s) & (time_s <= high)
    if not inside.any():
        raise Unknown(f"{question.of} has no row between {low:g} and {high:g} s")
    return TAKES[question.take](time_s[inside], values[inside])


def _first_harmonic(question: Question, run: Path) -> tuple[float, float | None]:
    """Return the amplitude of a point's first harmonic along an axis, in the results' cycles or those
    ``between_s``, and half the width of its interval.

    Raises Unknown.
    """
    summary, axis = summary_of(run), AXES.get(question.axis, 0)
    known = orbit_places(summary)
    if not known:
        raise Unknown(f"{run.name}: {why_no_orbits(summary)}")
    if question.of not in known:
        raise Unknown(f'no point "{question.of}"; there are {", ".join(known)}')
    if question.between_s is not None:
        try:
            with RunReader(run) as reader:
                orbit = machine.orbits(reader, *question.between_s, interval_of(reader, None)).all[
                    question.of
                ]
        except ValueError as error:
            raise Unknown(f"{run.name}: {error}") from None
        width_m = None if orbit.half_width_m is None else float(orbit.half_width_m[axis])
        return float(orbit.amplitude_m[axis]), width_m
    amplitude, width = (
        value_at(summary, f"{known[question.of]}.{key}.{axis}") for key in ("amplitude_m", "half_width_m")
    )
    if amplitude is None:
        raise Unknown(f"{run.name}: {question.of} has no amplitude")
    return amplitude.value, None if width is None else width.value


def _arch(question: Question, run: Path) -> float:
    names = (f"panel_cycles/{question.of}/{name}" for name in ("time_s", "sag_most_m"))
    time_s, sag_m = (read_dataset(run, name) for name in names)
    return float(sag_m[time_s > 0.5 * time_s[-1]].max())


def _rise(question: Question, run: Path) -> float:
    before, _, after = question.of.partition(".*.")
    values: list[float] = []
    while value_at(summary_of(run), f"{before}.{len(values)}.{after}") is not None:
        values.append(_value_at(run, f"{before}.{len(values)}.{after}"))
    if len(values) < 2:
        raise Unknown(f"{run.name}: {question.of} is not known")
    return float(np.diff(values).max())


def _deck_load(question: Question, run: Path) -> float:
    mass_kg, _ = _on_deck(question, run)
    with RunReader(run) as reader:
        return float(mass_kg.sum(axis=1).mean() / deck_area_m2(reader))


def _deck_velocity(question: Question, run: Path) -> float:
    mass_kg, momentum = _on_deck(question, run)
    if not mass_kg.any():
        raise Unknown(f"{run.name}: nothing is on the deck")
    return float(momentum.sum() / mass_kg.sum())


def _on_deck(question: Question, run: Path) -> tuple[Array, Array]:
    """Return the mass (rows, bins) along the deck and its momentum, at the output times ``between_s``.

    Raises Unknown.
    """
    time_s = read_dataset(run, "profile/time_s")
    low, high = question.between_s or (-np.inf, np.inf)
    inside = (low <= time_s) & (time_s <= high)
    if not inside.any():
        raise Unknown(f"{run.name}: no output time between {low:g} and {high:g} s")
    names = ("profile/mass_kg", "profile/velocity_m_per_s")
    mass_kg, velocity_m_per_s = (np.nan_to_num(read_dataset(run, name)[inside]) for name in names)
    return mass_kg, np.asarray(mass_kg * velocity_m_per_s, dtype=float)


def read_dataset(run: Path, name: str) -> Array:
    """Return a dataset of ``history.h5``.  Raises Unknown where there is none."""
    try:
        with RunReader(run) as reader:
            return np.asarray(reader.read(name), dtype=float)
    except (OSError, KeyError):
        raise Unknown(f"{run.name}: history.h5 has no {name}") from None


def _energy_J(run: Path) -> dict[str, Array]:
    with RunReader(run) as reader:
        return {name: reader.read(f"energy/{name}") for name in reader.names("energy")}


def _largest_sum_J(run: Path, **signs: float) -> float:
    """Return the largest absolute value, over time, of the sum of whole accounts, each with its sign."""
    accounts = ((name.partition(".")[0], values_J) for name, values_J in _energy_J(run).items())
    terms = [signs[account] * values_J for account, values_J in accounts if account in signs]
    return float(np.abs(np.sum(terms, axis=0)).max())


def _unexplained_J(run: Path) -> float:
    return _largest_sum_J(run, stored=1.0, lost=1.0, supplied=-1.0)


def _turned_over_J(run: Path) -> float:
    accounts = _energy_J(run).items()
    return sum(abs(float(J[-1])) for name, J in accounts if name.startswith(("supplied.", "lost.")))


Outcome = Literal["stable", "warned", "stopped", "not run"]
COUPLING_CHECKS = ("created_energy", "created_in_total", "growing_modes")  # of the monitor


def outcome(run: Path) -> Outcome:
    """Return the outcome of a run.

    ``stable``: the run came to its end, the monitor gave no warning of its energy or its modes, and it is
    not doubtful.  ``warned``: the run came to its end, but one of these conditions failed.  ``stopped``: the
    run ended early with a reason that lies in its case.  ``not run``: the run is missing, was interrupted, or
    ended by an internal error, or because memory or the disk was full.
    """
    summary = summary_of(run)
    state, reason = str(summary.get("status")), str(summary.get("reason"))
    if state == "failed" and not reason.startswith((trust.INTERNAL_ERROR, trust.REFUSED)):
        return "stopped"
    if not trust.came_to_its_end(state):
        return "not run"
    monitored = summary.get("monitor", {}).get("figures", {})
    has_warned = any(monitored[key]["times"] for key in COUPLING_CHECKS if key in monitored)
    return "warned" if has_warned or state == trust.DOUBTFUL else "stable"


def _outcome_is(*wanted: Outcome) -> Callable[[Question, Path], float]:
    def measure(question: Question, run: Path) -> float:
        if (state := outcome(run)) == "not run":
            raise Unknown(f"{run.name}: not run")
        return float(state in wanted)

    return measure


@dataclass(frozen=True)
class Quantity(Figure):
    """A figure by which runs are compared.

    ``short`` is its head of a column.  ``is_defect``: it ought to be zero, so that it needs no reference.  A
    value up to ``floor`` is rounding or the remainder that a solver's tolerance leaves, and is not compared:
    coordinates of a few metres are rounded at 1e-15 m, resting shapes are computed to 1e-11 m, and a
    nanometre at a machine's speed of 100 rad/s is 1e-6 g.
    """

    short: str = ""
    is_defect: bool = False


def _of_results(path: str, short: str) -> Quantity:
    """Return the quantity that is a figure of the results."""
    return Quantity(**vars(FIGURES[f"results.{path}"]), short=short)


def _own(name: str, words: str, short: str, **known: Any) -> Quantity:
    """Return a quantity that is measured from the series of a run."""
    return Quantity(words, short=short, path=name, **known)


def _of_headline(name: str, short_name: str, short: str) -> Quantity:
    """Return the quantity that is a result with a short name, of the whole width; it is compared, but does
    not decide."""
    record = SHORT_NAMES[short_name].figure
    return Quantity(**vars(replace(record, path=name, is_extensive=False, is_decisive=False)), short=short)


NAMED = {
    "stroke_m": ("stroke", "stroke"),
    "points_rms_g": ("rms_g", "points rms"),
    "points_peak_g": ("cycle_peak_g", "points peak"),
    "stretch_percent": ("stretch", "stretch"),
    "power_W": ("power", "power"),
}
"""Quantities that are results with short names: by their own names, which end with a unit, the short name of
the result and the head of a column."""
_EVERY = (
    _own("deflection_m", "panel: half range of the middle against its clamps, in a cycle", "deflection"),
    _own("shape", "panel: shape over the cycles", "shape", is_decisive=False),
    _own("clamp_peak_N", "clamp force: peak", "clamp peak", is_decisive=False, is_extensive=True),
    _own("clamp_rms_N", "clamp force: rms", "clamp rms", is_extensive=True),
    _own(
        "middle_peak_g",
        "panel's middle: peak acceleration in a cycle",
        "acc. peak",
        resolution=1e-6,
        is_decisive=False,
    ),
    _own("middle_rms_g", "panel's middle: rms acceleration", "acc. rms", resolution=1e-6),
    _own("frame_half_range_m", "frames: largest half range of a centre of mass", "frame"),
    _own("passing_kg_per_s", "passing: through the exits", "passing", is_extensive=True),
    _of_results("screening.efficiency_percent", "efficiency"),
    _of_results("bed.velocity_m_per_s", "velocity"),
    *(_of_headline(name, *names) for name, names in NAMED.items()),
    _own(
        "energy_defect",
        "energy created by the coupling, of what was exchanged and lost",
        "energy",
        is_decisive=False,
        is_defect=True,
    ),
    _own(
        "momentum_defect",
        "momentum residual of the worst member",
        "momentum",
        is_decisive=False,
        is_defect=True,
    ),
)
QUANTITIES = {each.path.rpartition(".")[2]: each for each in _EVERY}
CYCLES = 4


@dataclass(frozen=True)
class Metrics:
    """The metrics of one run.

    ``values`` are by name of QUANTITIES, without "shape" and without quantities that the case does not have.
    A value that is not resolved is 0 and is not compared.  The values of a slice are for the whole width.
    ``shapes_m`` (rows, values) are the shapes to be compared, and ``summary`` is the summary of the run.
    """

    values: dict[str, float]
    shapes_m: Array
    summary: Mapping[str, Any]
    quantities: ClassVar[Mapping[str, Quantity]] = QUANTITIES

    @property
    def processor_by_part_s(self) -> dict[str, float]:
        """The processor time of the run in s by part of the program."""
        return processor_by_part_s(self.summary)

    def shape_error(self, reference: Metrics) -> float:
        """Return the relative difference of as many shapes; infinite where the reference's do not change."""
        return relative(self.shapes_m, reference.shapes_m)


def measure(folder: Path) -> Metrics:
    """Return the metrics of a finished run.  Raises KeyError for a run without ``output.shapes_s``."""
    with RunReader(folder) as run:
        summary, case, history = run.summary, run.case, run.history
        end_s, cycle = summary["simulated_s"], cycle_s(case)
        count = max(1, min(CYCLES, int(end_s / 2 / cycle + 1e-9)))
        start_s = max(0.0, end_s - count * cycle)
        panels = [_panel_metrics(history, case, panel, start_s, cycle) for panel in single_panels(case)]
        values = {"frame_half_range_m": _frame_half_range_m(history, start_s)} if case.screen.frames else {}
        if case.screen.exits:  # without exits nothing flows, and a mean velocity is the velocity of a swing
            values |= _exit_values(history, summary, start_s, end_s)
    of_results = {name: value_at(summary, short_name) for name, (short_name, _) in NAMED.items()}
    values |= {name: value.value for name, value in of_results.items() if value is not None}
    for name in panels[0][0] if panels else ():
        values[name] = float(np.mean([of_panel[name] for of_panel, _ in panels]))
    for name, value in values.items():
        share = summary["share_of_width"] if QUANTITIES[name].is_extensive else 1.0
        values[name] = value / share if is_resolved(name, value / share) else 0.0
    values["energy_defect"] = abs(share_created(summary))
    values["momentum_defect"] = summary["momentum_residual_relative"]
    shapes_m = np.hstack([shape_m for _, shape_m in panels]) if panels else np.empty((0, 0))
    if not values.get("deflection_m"):  # a shape that is only rounding is not compared either
        shapes_m = shapes_m[:, :0]
    return Metrics(values, shapes_m, summary)


def is_resolved(name: str, value: float) -> bool:
    """Return whether the value of a quantity is more than rounding and the solvers' noise."""
    return abs(value) > QUANTITIES[name].floor


def relative(values: Array, reference: Array) -> float:
    """Return the L2 norm of the difference over the norm of the reference about its mean over time.

    It is infinite where the reference does not change over time.
    """
    size = float(np.linalg.norm(reference - reference.mean(axis=0)))
    return float(np.linalg.norm(values - reference)) / size if size else math.inf


def _frame_half_range_m(history: Any, start_s: float) -> float:
    """Return half the range of motion, as the size of a vector, of the frame that moves most."""
    return max(
        float(np.linalg.norm(np.ptp(group["displacement_m"][:][group["time_s"][:] >= start_s], axis=0) / 2))
        for group in history["frames"].values()
    )


def _exit_values(history: Any, summary: Mapping[str, Any], start_s: float, end_s: float) -> dict[str, float]:
    """Return efficiency and velocity from the run's results, and the mass that left through exits per second.

    Values that are not defined are missing.
    """
    known = {
        "efficiency_percent": value_at(summary, "efficiency"),
        "velocity_m_per_s": value_at(summary, "velocity"),
    }
    values = {name: value.value for name, value in known.items() if value is not None}
    if "removed" in history and "time_s" in history["removed"]:
        removed = history["removed"]
        late = (removed["time_s"][:] > start_s) & (removed["exit"][:] >= 0)
        mass_kg = grains_of(removed, shapes_in(removed.attrs)).mass_kg
        values["passing_kg_per_s"] = float(mass_kg[late].sum() / (end_s - start_s))
    return values


def _panel_metrics(
    history: Any, case: Case, panel: SinglePanel, start_s: float, cycle: float
) -> tuple[dict[str, float], Array]:
    """Return a panel's values by name of ``QUANTITIES``, and the shape (rows, values) of its middle line.

    Both are taken from ``start_s`` on.  ``cycle`` is the length of a cycle in s.
    """
    shapes = history[f"shapes/{panel.name}"]
    time_s = shapes["time_s"][:]
    last = time_s >= start_s - 1e-9
    grid, at = ShapeGrid.of(panel.rectangle, case.panel.surface_cells), panel.rectangle
    turn = np.stack([at.along, at.across, at.normal], axis=1)
    place_m, velocity_m_per_s = shapes["position_m"][:], shapes["velocity_m_per_s"][:]
    carried = grid.carried(at)
    corners = [int(number) for number in carried.argmax(axis=0)]
    shape_m = (place_m - carried @ place_m[:, corners])[last] @ turn
    # the line along the middle, or beside it where no grid line runs there
    line = np.arange(len(grid.rows_m)) * len(grid.columns_m) + len(grid.columns_m) // 2
    middle = line[len(line) // 2]
    step_s = float(np.diff(time_s).mean())
    acceleration = acceleration_m_per_s2(velocity_m_per_s[:, middle], step_s)[last]
    size_g = np.linalg.norm(acceleration, axis=1) / STANDARD_GRAVITY_M_PER_S2
    forces = history[f"forces/{panel.name}"]
    pull_N = np.linalg.norm(forces["first_clamp_N"][:], axis=1)[forces["time_s"][:] > start_s]
    values = {
        "deflection_m": mean_of_cycles(np.ptp, shape_m[:, middle, 2], time_s[last], cycle) / 2,
        "clamp_peak_N": float(pull_N.max()),
        "clamp_rms_N": float(np.sqrt(np.mean(pull_N**2))),
        "middle_peak_g": mean_of_cycles(np.max, size_g, time_s[last], cycle),
        "middle_rms_g": float(np.sqrt(np.mean(size_g**2))),
    }
    return values, shape_m[:, line][:, :, [0, 2]].reshape(len(shape_m), -1)


def mean_of_cycles(statistic: Callable[[Array], Any], values: Array, time_s: Array, cycle_s: float) -> float:
    """Return the mean, over the cycles from the first time to the last, of a statistic of each cycle."""
    number = cycle_numbers(time_s, cycle_s, float(time_s[0]))
    return float(np.mean([statistic(values[number == each]) for each in range(number.max() + 1)]))


def _quantity(question: Question, run: Path) -> float:
    try:
        values = measure(run).values
    except KeyError:
        raise Unknown(f"{run.name}: no shapes were recorded; run it with --set output.shapes_s=") from None
    if question.measure not in values:
        raise Unknown(f"{run.name}: {question.measure} is not known")
    return values[question.measure]


ABOUT_TRUST = ("trusted", "clear")
MEASURES: dict[str, Callable[[Question, Path], float]] = {
    "result": lambda question, run: _value_at(run, question.of),
    "series": _series,
    # the first harmonic of a point's motion, in m
    "amplitude": lambda question, run: _first_harmonic(question, run)[0],
    # the largest distance, in m, of a panel's middle line from the straight line between its ends, on
    # either side, in the cycles that end in the run's second half
    "arch": _arch,
    # the mean mass on the deck per area of the deck, in kg/m2, and its mean velocity along the deck by mass
    "deck_load": _deck_load,
    "deck_velocity": _deck_velocity,
    # the largest rise from one entry of a list of results to the next (* stands for the entry's number
    # in the keys); it is negative if all entries fall
    "rise": _rise,
    "created": lambda question, run: abs(share_created(summary_of(run))),
    # the largest absolute value, at any output time, of stored + lost - supplied: the energy, in J,
    # that coupling or solvers created or lost; as a share, over all energy supplied and lost by the end
    "unexplained": lambda question, run: _unexplained_J(run),
    "share_unexplained": lambda question, run: _unexplained_J(run) / _turned_over_J(run),
    # the largest absolute value of stored - supplied, in J: the change of all energy in a case that
    # must not lose any
    "kept": lambda question, run: _largest_sum_J(run, stored=1.0, supplied=-1.0),
    "trusted": _outcome_is("stable"),
    "clear": _outcome_is("stable", "stopped"),  # 0 for a run that came to its end with a warning
    **{name: _quantity for name in QUANTITIES if name != "shape"},
}
