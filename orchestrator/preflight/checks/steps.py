"""The checks of time steps, of times in whole sync intervals, and of missing solvers."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.case.bed.adhesion import STEPS_PER_CONTACT, adhesive_step_s
from orchestrator.case.bed.contact_times import LARGEST_RAYLEIGH_FRACTION, shortest_rayleigh_s
from orchestrator.case.file.errors import CaseProblem, Key
from orchestrator.case.solver_plans import panel_plans, particle_step_s
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.ports.clock import steps_in
from orchestrator.ports.plans import SolverFailed, SolverMissing

ROUNDED = 1e-5  # change of a time that is not said, as a share of it: it does not show in six digits


def particle_step(case: Case) -> Iterator[CaseProblem]:
    """Check that the particles' step resolves contacts: it is at most 0.2 of the Rayleigh time.

    Adhesive contacts need shorter steps.
    """
    if not has_particles(case):
        return
    rayleigh_s, step_s = shortest_rayleigh_s(case), particle_step_s(case)
    limit_s = LARGEST_RAYLEIGH_FRACTION * rayleigh_s
    if step_s > limit_s * (1 + 1e-9):
        key = "step_s" if case.particles.step_s > 0 else "rayleigh_fraction"
        what = (
            f"a step of {step_s:.3g} s is {step_s / rayleigh_s:.2g} of the smallest particle's "
            f"Rayleigh time {rayleigh_s:.3g} s; the limit is {limit_s:.3g} s"
        )
        yield CaseProblem(
            ("particles", key), what, f"take {0.75 * limit_s:.2g} s or less", kind="out-of-range"
        )
    sticky_s = adhesive_step_s(case)
    if step_s > sticky_s * (1 + 1e-9):
        what = (
            f"a step of {step_s:.3g} s is longer than 1/{STEPS_PER_CONTACT} of the shortest "
            f"contact of particles that stick, {sticky_s:.3g} s"
        )
        yield CaseProblem(
            ("particles", "step_s"), what, "take 0 for the longest possible", kind="out-of-range"
        )


def panel_step(case: Case) -> Iterator[CaseProblem]:
    """Check that the step given for the panels is within their solver's limit, if the solver tells one.

    Nothing is checked if the solver is not installed, which missing_solvers reports, or finds no
    resting shape, which the run reports.
    """
    limit = case.panel.adapter.largest_step_s
    if case.panel.step_s == 0 or limit is None:
        return
    try:
        limit_s = min(limit(plan) for plan in panel_plans(case))
    except (SolverMissing, SolverFailed):
        return
    if case.panel.step_s > limit_s:
        what = f"{case.panel.step_s:g} s is above the limit {limit_s:.3g} s of panel.solver "
        hint = f"take {0.9 * limit_s:.2g} s, or 0 for the solver's own"
        yield CaseProblem(("panel", "step_s"), what + case.panel.solver, hint, kind="out-of-range")


def rounded_times(case: Case) -> Iterator[str]:
    """Yield warnings about times that are longer in the run, which has whole sync intervals."""
    interval_s, output = case.coupling.sync_interval_s, case.output
    times_s = {"duration_s": case.duration_s, "output.interval_s": output.interval_s}
    times_s |= {
        "output.series_s": output.series_s,
        "output.shapes_s": output.shapes_s,
        "output.loads_s": output.loads_s,
    }
    for key, wanted_s in times_s.items():
        taken_s = steps_in(wanted_s, interval_s) * interval_s
        if wanted_s > 0 and taken_s - wanted_s > ROUNDED * wanted_s:
            yield (
                f"{key} = {wanted_s:.9g} s is rounded up to {taken_s:.6g} s, a whole number of sync "
                f"intervals of {interval_s:g} s"
            )


def whole_times(case: Case) -> Iterator[CaseProblem]:
    """Check that the sync interval is not longer than the run or the time between records."""
    interval_s, output = case.coupling.sync_interval_s, case.output
    times_s: dict[Key, float] = {
        ("duration_s",): case.duration_s,
        ("output", "interval_s"): output.interval_s,
        ("output", "series_s"): output.series_s or interval_s,
        ("output", "shapes_s"): output.shapes_s or interval_s,
        ("output", "loads_s"): output.loads_s or interval_s,
    }
    for key, time_s in times_s.items():
        if time_s < interval_s:
            what = f"{time_s:g} s is shorter than coupling.sync_interval_s = {interval_s:g} s"
            yield CaseProblem(key, what, kind="out-of-range")


def missing_solvers(case: Case) -> Iterator[str]:
    """Yield a message for each solver that the case needs and this installation lacks.

    A case without panels needs no solver of panels, and one without particles none of particles.  The
    check loads the solvers, which takes some time.
    """
    is_called_for = {"particles": has_particles(case), "panel": bool(case.screen.panels)}
    for port, adapter in case.adapters.items():
        if not is_called_for.get(port, True):
            continue
        try:
            adapter.load()
        except SolverMissing as missing:
            yield str(missing)
