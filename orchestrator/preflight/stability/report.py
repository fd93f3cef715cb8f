"""The stability report of a case: every bound of its sync interval, and the scheme that it calls for.

``stability_report`` needs a case without problems.  It asks the panels' solver for its largest
step, which for a sheet takes about a second.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace

from orchestrator.case.bed.contact_times import LARGEST_RAYLEIGH_FRACTION, shortest_rayleigh_s
from orchestrator.case.solver_plans import particle_step_s
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.preflight.scene.moved_panel import loss_factor
from orchestrator.preflight.scene.scene import Scene, scene
from orchestrator.preflight.stability.bounds import Bound, contact_bounds, frame_bounds, surface_bounds
from orchestrator.preflight.stability.modes import FrameMatrices, frame_matrices, highest_rad_per_s

PLAIN, STRONGER, AUTO = "particles-first", "robin", "auto"


@dataclass(frozen=True)
class StepBound:
    """The longest step of one solver, against the one it takes."""

    name: str
    step_s: float
    limit_s: float
    source: str
    why: str


@dataclass(frozen=True)
class StabilityReport:
    """All bounds of a case under one scheme.

    ``facts`` are the numbers behind them, name -> text; ``why`` says why the program chose the
    scheme, and is empty where the case names it.
    """

    scheme: str
    interval_s: float
    bounds: tuple[Bound, ...]
    steps: tuple[StepBound, ...]
    facts: Mapping[str, str]
    why: str = ""

    @property
    def stable(self) -> Bound | None:
        """The bound on stability that allows least; None if nothing limits it."""
        return self._least("stability")

    @property
    def accurate(self) -> Bound | None:
        """The bound on accuracy that allows least; None if nothing limits it."""
        return self._least("accuracy")

    @property
    def safe_s(self) -> float:
        """The largest interval within all bounds on stability."""
        return self.stable.interval_s if self.stable else math.inf

    def _least(self, kind: str) -> Bound | None:
        limits = [b for b in self.bounds if b.kind == kind and math.isfinite(b.interval_s)]
        return min(limits, key=lambda bound: bound.interval_s, default=None)


def stability_report(case: Case) -> StabilityReport:
    """Returns the report of a case without problems.

    Where the case leaves its scheme to the program, it is the plain scheme's report if the sync
    interval is safe there or ``robin`` allows no longer one; else it is ``robin``'s.
    """
    if case.coupling.scheme != AUTO:
        return _report(case)
    plain = _report(with_scheme(case, PLAIN))
    if plain.interval_s <= plain.safe_s:
        return replace(plain, why=f"the sync interval is within its safe one, {_limit(plain)}")
    beyond = f"the sync interval of {plain.interval_s:.3g} s is above {PLAIN}'s {_limit(plain)}"
    if not has_particles(case):
        return replace(plain, why=f"{beyond}, and without particles {STRONGER} is no other")
    stronger = _report(with_scheme(case, STRONGER))
    if stronger.safe_s > plain.safe_s:
        return replace(stronger, why=f"{beyond}; {STRONGER}'s is {_limit(stronger)}")
    return replace(plain, why=f"{beyond}, and {STRONGER}'s is no longer: {_limit(stronger)}")


def case_with_scheme(case: Case) -> Case:
    """Returns the case with the scheme that it names, or else with the one that its report calls for."""
    return with_scheme(case, stability_report(case).scheme) if case.coupling.scheme == AUTO else case


def with_scheme(case: Case, name: str) -> Case:
    """Returns the case with another scheme."""
    coupling = case.coupling.model_copy(update={"scheme": name})
    return case.model_copy(update={"coupling": coupling})


def _limit(report: StabilityReport) -> str:
    return f"{report.safe_s:.2g} s ({report.stable.name})" if report.stable else "unlimited"


def _report(case: Case) -> StabilityReport:
    """The report of a case that names its scheme."""
    there = scene(case)
    modes_rad_per_s, unknown = highest_rad_per_s(case)
    frames = frame_matrices(there)
    bounds: list[Bound] = []
    if has_particles(case):
        bounds += surface_bounds(there)
        if there.panels:
            bounds += contact_bounds(there, modes_rad_per_s, frames)
    if frames is not None and there.panels:
        bounds += frame_bounds(case, frames)
    return StabilityReport(
        scheme=case.coupling.scheme,
        interval_s=case.coupling.sync_interval_s,
        bounds=tuple(bounds),
        steps=tuple(_particle_steps(case)),
        facts=dict(_facts(there, modes_rad_per_s, unknown, frames)),
    )


def _particle_steps(case: Case) -> Iterator[StepBound]:
    """The particles' step against the Rayleigh time."""
    if has_particles(case):
        rayleigh_s = shortest_rayleigh_s(case)
        yield StepBound(
            "particles' step",
            particle_step_s(case),
            LARGEST_RAYLEIGH_FRACTION * rayleigh_s,
            "Li, Xu and Thornton 2005, and the share that is usual",
            f"{LARGEST_RAYLEIGH_FRACTION:g} of the smallest one's Rayleigh time {rayleigh_s:.3g} s",
        )


def _facts(
    scene: Scene, modes_rad_per_s: dict[str, float], unknown: str, frames: FrameMatrices | None
) -> Iterator[tuple[str, str]]:
    """Times, masses, modes and damping of a scene, by name."""
    if has_particles(scene.case):
        yield "Rayleigh time", f"{shortest_rayleigh_s(scene.case):.3g} s, the smallest particle's"
        if scene.panels:
            bed = scene.bed_kg_per_m2
            ratio = bed / min(panel.mass_kg_per_m2 for panel in scene.panels)
            yield "bed on panel", f"{ratio:.3g} times the panel's mass, up to {bed:.3g} kg/m2"
        restitution = [row.restitution for row in scene.case.contacts]
        if restitution:
            yield "restitution", f"{min(restitution):g} to {max(restitution):g}"
    if scene.panels:
        lowest = min(panel.frequency_rad_per_s for panel in scene.panels) / (2 * math.pi)
        highest = max(modes_rad_per_s.values(), default=0.0) / (2 * math.pi)
        shown = f"{highest:.3g} Hz, as their mesh and steps make it"
        if not modes_rad_per_s:
            shown = unknown or "what their solver does not resolve step by step"
        yield "panels' modes", f"{lowest:.3g} Hz (mounted, empty) to {shown}"
        factors = [loss_factor(panel.material, panel.frequency_rad_per_s) for panel in scene.panels]
        yield "panels' loss factor", f"{min(factors):.2g} at the lowest"
    if frames is not None:
        speeds = frames.modes()[0] / (2 * math.pi)
        yield "frames' modes", f"{speeds[0]:.3g} to {speeds[-1]:.3g} Hz, panels as springs"
