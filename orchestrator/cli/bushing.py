"""The answer of ``flipflow bushing``: tests of a bushing, the elements fitted to them, and their picture."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path

from pydantic import ValidationError

from orchestrator.case.file.bushing_curve import CurveFit, Point, curve_points, faults_of_points, fit_points
from orchestrator.case.file.bushing_loop import Loop, read_test
from orchestrator.case.file.data_file import read_data_file
from orchestrator.case.file.data_table import Answers, TableError
from orchestrator.case.file.errors import CaseError, CaseProblem, from_validation
from orchestrator.case.file.units import parse_quantity
from orchestrator.case.tables.frames import BushingCurve
from orchestrator.cli.console import refuse


def fit_files(
    files: Sequence[Path], columns: Sequence[str], decimal: str, frequency: str | None, out: Path
) -> Iterator[str]:
    """Fit elements to the tests in files, draw them into ``out``, and yield lines about them.

    Raises CaseError for files that cannot be read, and for points that are no tests of a bushing.
    """
    if wrong := [each for each in columns if "=" not in each]:
        refuse(f"--column {wrong[0]}: NAME=CLEAR NAME is wanted, such as 'k=stiffness / kN/mm'")
    if decimal not in ("", ".", ","):
        refuse(f'--decimal {decimal}: "." or "," is wanted')
    answers = Answers(dict(each.split("=", 1) for each in columns), decimal)
    frequency_Hz = _frequency_Hz(frequency)
    points: list[Point] = []
    loops: dict[str, Loop] = {}
    for file in files:
        text = read_data_file(file.parent, file.name, (), str(file))
        try:
            rows, loop = read_test(text, answers, frequency_Hz)
        except TableError as error:
            raise CaseError(
                [CaseProblem((), why, file=str(file), kind="file") for why in error.reasons]
            ) from None
        points += _points(rows, str(file))
        if loop is not None:
            loops[file.name] = loop
            yield (
                f"{file.name}: a loop of {1e3 * loop.amplitude_m:.4g} mm at {loop.frequency_Hz:.4g} Hz, "
                f"{loop.stiffness_N_per_m:.4g} N/m, loss factor {loop.loss_factor:.3g}; "
                f"{loop.residual:.1%} of the force is beside its first harmonic"
            )
        else:
            yield f"{file.name}: {len(rows)} points"
    fit = fit_points(tuple(points))
    yield from _lines(fit)
    _draw(points, loops, fit, out)
    yield f"written: {out}"


def _frequency_Hz(frequency: str | None) -> float | None:
    try:
        return None if frequency is None else parse_quantity(frequency, "frequency_Hz")
    except ValueError as error:
        refuse(f"--frequency {frequency}: {error}")


def _points(rows: Sequence[dict[str, float]], file: str) -> tuple[Point, ...]:
    try:
        curve = BushingCurve.model_validate({"points": rows})
    except ValidationError as error:
        raise CaseError([*from_validation(error, BushingCurve)]) from None
    if problems := [*faults_of_points((file,), curve)]:
        raise CaseError(problems)
    return curve_points(curve)


def _lines(fit: CurveFit) -> Iterator[str]:
    """Yield the elements as lines of a case, and how well they meet the points."""
    elements = fit.elements
    yield f"elastic_N_per_m = {elements.elastic_N_per_m:.5g}"
    for stiffness_N_per_m, slip_m in elements.friction:
        yield f"friction: stiffness_N_per_m = {stiffness_N_per_m:.5g}, slip_m = {slip_m:.4g}"
    for stiffness_N_per_m, relaxation_s in elements.maxwell:
        yield f"maxwell: stiffness_N_per_m = {stiffness_N_per_m:.5g}, relaxation_s = {relaxation_s:.4g}"
    yield f"stiffness off by {fit.stiffness_error:.1%} at most, loss factor by {fit.loss_error:.0%}"


def _draw(points: Sequence[Point], loops: dict[str, Loop], fit: CurveFit, out: Path) -> None:
    from orchestrator.views.bushing_fit import draw_bushing_fit
    from orchestrator.views.style import save

    try:
        save(draw_bushing_fit(points, loops, fit), out)
    except (OSError, ValueError) as error:
        refuse(f"{out}: {error}")
