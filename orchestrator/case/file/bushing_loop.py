"""Tables of a bushing's tests: stiffness and loss over amplitude and frequency, or a loop of force over
displacement, from which these are fitted.

A loop is fitted by least squares: its displacement by a harmonic motion, whose frequency is sought, and its
force by the first three harmonics of that motion.  The first harmonic of the force, divided by the
displacement's, is k' + i k''.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from orchestrator.case.file.data_table import (
    IGNORE,
    Answers,
    Column,
    DataTable,
    TableError,
    answer,
    read_text,
)
from orchestrator.case.file.errors import did_you_mean, show_value
from orchestrator.ports import Array

AXIS = "(?:(?:axial|radial|shear|vertical|horizontal|crosshead) )?"
OF_DISPLACEMENT = rf"{AXIS}(?:displacement|deflection|deformation)|(?:feder|verformungs)?weg|auslenkung"
MEANINGS = {
    "amplitude_m": rf"(?:(?:{OF_DISPLACEMENT}) ?)?(?:amplitude|amplitude \(peak\))|amp",
    "range_m": rf"(?:amplitude |(?:{OF_DISPLACEMENT}) )?(?:peak to peak|p p|pp)(?: amplitude| displacement)?"
    r"|double amplitude",
    "frequency_Hz": "frequency|freq|f|frequenz",
    "stiffness_N_per_m": "(?:storage |elastic )?stiffness|k '|steifigkeit",
    "complex_N_per_m": r"(?:complex|modulus of) stiffness|stiffness modulus|\|? ?k ?\* ?\|?",
    "ahead_N_per_m": "loss stiffness|k ' '",
    "loss_factor": "loss factor|tan ?(?:delta|d|δ)|η|eta|verlustfaktor",
    "loss_rad": "(?:loss|phase) angle|phase(?: lag)?|δ|delta|verlustwinkel",
    "damping_N_s_per_m": "damping(?: coefficient)?|c|dämpfung",
    "time_s": "time|t|zeit",
    "displacement_m": rf"{OF_DISPLACEMENT}|disp|travel|extension|x",
    "force_N": rf"{AXIS}(?:force|load)|(?:feder|prüf)?kraft",
}
"""The names, in small letters, of each column that a table of a bushing may have."""
ASKED = {"dynamic stiffness", "k dyn", "kdyn", "dynamische steifigkeit"}
KNOWN = (
    *("amplitude_m", "frequency_Hz", "stiffness_N_per_m", "loss_factor", "damping_N_s_per_m"),
    *("time_s", "displacement_m", "force_N"),
)
HARMONICS = 3
LEAST_CYCLES = 0.95
OFF_HARMONIC = 0.1
"""Largest share of a displacement, by its root mean square, that is not one harmonic motion."""


@dataclass(frozen=True)
class Loop:
    """A loop of force over displacement and what was fitted to it.

    Parameters
    ----------
    displacement_m, force_N
        (n,) as measured, without their means.
    fitted_m, fitted_N
        (n,) the harmonic motion, and the first harmonic of the force.
    amplitude_m, frequency_Hz, stiffness_N_per_m, loss_factor
        A point of a bushing's curve.
    residual
        Root mean square of what the first harmonic leaves of the force, over that of the force.
    """

    displacement_m: Array
    force_N: Array
    fitted_m: Array
    fitted_N: Array
    amplitude_m: float
    frequency_Hz: float
    stiffness_N_per_m: float
    loss_factor: float
    residual: float

    @property
    def point(self) -> dict[str, float]:
        """The loop as a point of a bushing's curve."""
        names = ("amplitude_m", "frequency_Hz", "stiffness_N_per_m", "loss_factor")
        return {name: float(getattr(self, name)) for name in names}

    @property
    def damping_N_s_per_m(self) -> float:
        """The damping of the viscous damper that loses as much in a cycle."""
        return self.loss_factor * self.stiffness_N_per_m / (2 * np.pi * self.frequency_Hz)


def points_of(text: str, answers: Answers, frequency_Hz: float | None = None) -> list[dict[str, float]]:
    """Return the points of a bushing's curve that a table gives; a loop gives one.

    ``frequency_Hz`` is that of a loop without a column of times.  Raises TableError.
    """
    return read_test(text, answers, frequency_Hz)[0]


def read_test(
    text: str, answers: Answers, frequency_Hz: float | None = None
) -> tuple[list[dict[str, float]], Loop | None]:
    """Return the points of ``points_of``, and the loop if the table is one.  Raises TableError."""
    known = _known(read_text(text, answers))
    if "force_N" in known or "displacement_m" in known:
        loop = _loop(known, frequency_Hz)
        return [loop.point], loop
    numbers = {key: _numbers(key, column) for key, column in known.items()}
    if "range_m" in numbers:
        numbers["amplitude_m"] = numbers.pop("range_m") / 2
    if "loss_rad" in numbers:
        numbers["loss_factor"] = np.tan(numbers.pop("loss_rad"))
    if "complex_N_per_m" in numbers:
        if "loss_factor" not in numbers:
            raise TableError(
                "a complex stiffness has a part in phase only beside a loss factor or loss angle"
            )
        modulus = numbers.pop("complex_N_per_m")
        numbers["stiffness_N_per_m"] = modulus / np.sqrt(1 + numbers["loss_factor"] ** 2)
    if "ahead_N_per_m" in numbers and "stiffness_N_per_m" in numbers:
        numbers["loss_factor"] = numbers.pop("ahead_N_per_m") / numbers["stiffness_N_per_m"]
    rows = [dict(zip(numbers, row, strict=True)) for row in np.array([*numbers.values()]).T.tolist()]
    return [{key: value for key, value in row.items() if not np.isnan(value)} for row in rows], None


def force_over_displacement(text: str, answers: Answers) -> tuple[Array, Array]:
    """Return the displacements and forces (n,) of a static test.  Raises TableError."""
    known = _known(read_text(text, answers))
    for key in ("displacement_m", "force_N"):
        if key not in known:
            raise TableError(f"a characteristic has no column {show_value(key)}")
    if spare := [known[key].head for key in known if key not in ("displacement_m", "force_N")]:
        raise TableError(
            f"is {show_value(spare[0])} of a characteristic? {answer(spare[0], IGNORE)} leaves it out"
        )
    displacement_m, force_N = (_numbers(key, known[key]) for key in ("displacement_m", "force_N"))
    if np.isnan(displacement_m).any() or np.isnan(force_N).any():
        raise TableError("a characteristic has no empty cells")
    return displacement_m, force_N


def fit_loop(time_s: Array, displacement_m: Array, force_N: Array) -> Loop:
    """Return the fit to a loop, of which times, displacements and forces are given, (n,) each.

    Raises TableError for less than a cycle, for what is no harmonic motion, and for a loop that gains energy.
    """
    from scipy.optimize import minimize_scalar

    time_s = time_s - time_s[0]
    if len(time_s) < 4 * HARMONICS or not (np.diff(time_s) > 0).all():
        raise TableError(f"a loop needs {4 * HARMONICS} rows or more, in the order of time")
    displacement_m, force_N = displacement_m - displacement_m.mean(), force_N - force_N.mean()
    size_m, size_N = np.sqrt((displacement_m**2).mean()), np.sqrt((force_N**2).mean())
    if not size_m > 0 or not size_N > 0:
        raise TableError("a loop moves, and takes a force")

    def motion(frequency_Hz: float, count: int = 1) -> Array:
        angle = 2 * np.pi * frequency_Hz * np.outer(time_s, np.arange(1, count + 1))
        return np.hstack([np.cos(angle), np.sin(angle), np.ones((len(time_s), 1))])

    def rest(frequency_Hz: float) -> float:
        columns = motion(frequency_Hz)
        fitted = columns @ np.linalg.lstsq(columns, displacement_m, rcond=None)[0]
        return float(np.sqrt(((displacement_m - fitted) ** 2).mean()) / size_m)

    length_s = float(time_s[-1] * len(time_s) / (len(time_s) - 1))
    even_m = np.interp(np.linspace(0, time_s[-1], len(time_s)), time_s, displacement_m)
    place = int(np.argmax(np.abs(np.fft.rfft(even_m, 8 * len(even_m)))[1:])) + 1
    near_Hz = place / 8 / length_s
    bounds = (max(near_Hz - 0.5 / length_s, 0.25 / length_s), near_Hz + 0.5 / length_s)
    frequency_Hz = float(
        minimize_scalar(rest, bounds=bounds, method="bounded", options={"xatol": 1e-9 * near_Hz}).x
    )
    if frequency_Hz * length_s < LEAST_CYCLES:
        raise TableError(f"has {frequency_Hz * length_s:.2f} of a cycle, and a loop needs a whole one")
    if (off := rest(frequency_Hz)) > OFF_HARMONIC:
        raise TableError(
            f"its displacement is not harmonic motion: {off:.0%} of it is left at {frequency_Hz:.4g} Hz"
        )
    columns = motion(frequency_Hz)
    cosine_m, sine_m, mean_m = np.linalg.lstsq(columns, displacement_m, rcond=None)[0]
    of_force = np.linalg.lstsq(motion(frequency_Hz, HARMONICS), force_N, rcond=None)[0]
    cosine_N, sine_N, mean_N = of_force[0], of_force[HARMONICS], of_force[-1]
    ratio = complex(cosine_N, -sine_N) / complex(cosine_m, -sine_m)
    if ratio.real < 0 and ratio.imag <= 0:  # a force that is counted the other way
        ratio, cosine_N, sine_N, mean_N, force_N = -ratio, -cosine_N, -sine_N, -mean_N, -force_N
    if ratio.real <= 0 or ratio.imag < 0:
        raise TableError(
            "its loop gains energy: are the rows in the order of time, and the force that on the bushing?"
        )
    fitted_m, fitted_N = columns @ [cosine_m, sine_m, mean_m], columns @ [cosine_N, sine_N, mean_N]
    return Loop(
        displacement_m,
        force_N,
        fitted_m,
        fitted_N,
        float(np.hypot(cosine_m, sine_m)),
        frequency_Hz,
        ratio.real,
        ratio.imag / ratio.real,
        float(np.sqrt(((force_N - fitted_N) ** 2).mean()) / size_N),
    )


def _known(table: DataTable) -> dict[str, Column]:
    """Return the columns of a table by their meaning.  Raises TableError for all that have none."""
    known, others = table.meanings(MEANINGS)
    if others:
        raise TableError(*(_unknown(column) for column in others))
    return known


def _unknown(column: Column) -> str:
    head = show_value(column.head)
    if column.name in ASKED:
        unit = column.unit or "N/mm"
        choices = answer(column.head, f"storage stiffness / {unit}"), f'"complex stiffness / {unit}"'
        return f"is {head} the part in phase with the displacement or the modulus? {' or '.join(choices)}"
    return (
        f"no column {head}; {did_you_mean(column.head, KNOWN)}; {answer(column.head, IGNORE)} leaves it out"
    )


def _numbers(key: str, column: Column) -> Array:
    """Return the numbers of a column in the unit of its key.  Raises TableError, also for a missing unit."""
    if key == "loss_factor":
        if column.unit not in ("", "1", "%"):
            raise TableError(
                f"column {show_value(column.head)} is in {column.unit}, and a loss factor is a pure number"
            )
        signs = {cell.endswith("%") for cell in column.texts if cell}
        if len(signs) > 1:
            raise TableError(f"column {show_value(column.head)} has numbers with % and without")
        return column.numbers(empty=True) * (0.01 if column.unit == "%" or True in signs else 1.0)
    if not column.unit:
        example = {"amplitude_m": "mm", "frequency_Hz": "Hz", "stiffness_N_per_m": "N/mm"}.get(
            key, key.partition("_")[2]
        )
        unit = example.replace("_per_", "/").replace("_", " ")
        raise TableError(
            f"which unit has {show_value(column.head)}? {answer(column.head, f'{column.head} / {unit}')}"
        )
    return column.numbers(key, empty=True)


def _loop(known: dict[str, Column], frequency_Hz: float | None) -> Loop:
    """Return the loop in these columns.  Raises TableError for one that is not there, and for all else."""
    if missing := [key for key in ("displacement_m", "force_N") if key not in known]:
        raise TableError(f"a loop has no column {show_value(missing[0])}")
    if spare := [key for key in known if key not in ("time_s", "displacement_m", "force_N", "frequency_Hz")]:
        head = known[spare[0]].head
        raise TableError(f"is {show_value(head)} of a loop? {answer(head, IGNORE)} leaves it out")
    numbers = {key: _numbers(key, column) for key, column in known.items()}
    if any(np.isnan(values).any() for values in numbers.values()):
        raise TableError("a loop has no empty cells")
    if "frequency_Hz" in numbers and np.ptp(numbers["frequency_Hz"]) > 0:
        raise TableError("has several frequencies; a loop has one")
    told_Hz = numbers["frequency_Hz"][0] if "frequency_Hz" in numbers else frequency_Hz
    time_s = numbers.get("time_s")
    if time_s is None and not told_Hz:
        raise TableError(
            "at which frequency was the loop measured? frequency_Hz = 12.5 beside file answers it; a static "
            "test belongs to characteristics"
        )
    force_N, displacement_m = numbers["force_N"], numbers["displacement_m"]
    if time_s is not None:
        return fit_loop(time_s, displacement_m, force_N)
    fit = fit_loop(np.arange(len(force_N), dtype=float), displacement_m, force_N)
    return replace(fit, frequency_Hz=float(told_Hz or 0.0))
