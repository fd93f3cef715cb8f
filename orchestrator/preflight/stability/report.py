"""The stability report of a case: every bound of its sync interval, and the scheme that it calls for.

``stability_report`` needs a case without problems.  It asks the panels' solver for its largest
step, which for a sheet takes about a second.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from orchestrator.case.bed.contact_times import LARGEST_RAYLEIGH_FRACTION, shortest_rayleigh_s
from orchestrator.case.solver_plans import particle_step_s
from orchestrator.case.tables.case import Case, has_particles
from orchestrator.preflight.scene.moved_panel import loss_factor
from orchestrator.preflight.scene.scene import Scene, scene
from orchestrator.preflight.stability.bounds import Bound, contact_bounds, frame_bounds, surface_bounds
from orchestrator.preflight.stability.modes import FrameMatrices, frame_matrices, highest_rad_per_s

PLAIN, STRONGER, AUTO = "particles-first", "robin", "auto"

BECAUSE = {
    "light points": "{where} knocks a light spot of the panel to and fro between exchanges",
    "lasting contacts, panels' modes": "{where} lies there and feeds the panel's fastest vibration",
    "lasting contacts, light points": "{where} lies there and rocks on a light spot of the panel",
    "foreseen contacts, panels' modes": "the load of {where} on the panel's fastest vibration is "
    "foreseen wrongly",
    "foreseen contacts, spheres": "the load of {where}, which jumps off light spots of the panel, "
    "is foreseen wrongly",
    "late contacts": "the load of {where} comes an exchange late and feeds the panel's vibration",
    "late contacts, light points": "the load of {where} on a light spot of the panel comes an exchange late",
    "extrapolated clamps": "the frames swing on their panels faster than exchanges can follow",
    "late reaction": "the panels' pull on the frames comes an exchange late and feeds their swing",
    "carried mass": "the panels are too heavy for a frame that carries them",
    "shortest impact": "an impact of {where} should last ten exchanges",
    "moving surface": "between exchanges a surface is taken to go straight on, which {where} feels",
    "driven surface": "the smooth path of a driven surface between exchanges must not leave its "
    "true one by what {where} feels",
}
"""Why no longer interval, in a designer's words: a clause for each bound by its name; ``where`` are
the particles."""

REMEDIES = {
    "carried mass": "make that frame heavier or its panels lighter",
    "late reaction": 'give the bushings damping, or set coupling.scheme = "auto"',
    "late contacts": 'set a restitution below 1, or coupling.scheme = "auto"',
    "late contacts, light points": 'set a restitution below 1, or coupling.scheme = "auto"',
}
"""What helps where no interval is short enough."""


@dataclass(frozen=True)
class StabilityReport:
    """All bounds of a case under one scheme, and what is said of them.

    ``facts`` are the numbers behind them, name -> text; ``why`` says why the program chose the
    scheme, and is empty where the case names it.
    """

    scheme: str
    interval_s: float
    bounds: tuple[Bound, ...]
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
        finite = [b for b in self.bounds if b.kind == kind and math.isfinite(b.interval_s)]
        return min(finite, key=lambda bound: bound.interval_s, default=None)

    @property
    def limit(self) -> str:
        """The safe interval, and what sets it."""
        return f"{self.safe_s:.2g} s ({self.stable.name})" if self.stable else "unlimited"

    @property
    def unsafe(self) -> bool:
        """Whether the case is beyond what is sure to be stable."""
        return self.interval_s > self.safe_s

    def short_lines(self) -> Iterator[str]:
        """Yield how often forces are exchanged, how often they should be, and why."""
        scheme = f"scheme {self.scheme}" + (", chosen by the program" if self.why else "")
        yield (
            f"  particles, panels and frames exchange motion and forces every {self.interval_s:.3g} s "
            f"(coupling.sync_interval_s; {scheme})"
        )
        if self.stable is None:
            yield "  stable at any interval"
        elif self.safe_s == 0:
            yield f"  stable at no interval: {because(self.stable)}; {remedy(self.stable)}"
        else:
            yield f"  sure to be stable up to {self.safe_s:.3g} s: {because(self.stable)}"
        if self.accurate is not None:
            limit_s, why = self.accurate.interval_s, because(self.accurate)
            yield f"  accurate by the usual rules up to {limit_s:.3g} s: {why}"
        yield "  (--detail: all limits, and the numbers behind them)"

    def detail_lines(self) -> Iterator[str]:
        """Yield all of it: numbers, bounds from the least up, and what follows."""
        if self.why:
            yield f"  scheme: {self.scheme}, taken by the program: {self.why}"
        for name, text in self.facts.items():
            yield f"  {name}: {text}"
        for bound in sorted(self.bounds, key=lambda bound: bound.interval_s):
            limit = f"{bound.interval_s:.3g} s" if math.isfinite(bound.interval_s) else "no limit"
            yield f"  {limit} for {bound.kind}, {bound.name}: {bound.why} ({bound.source})"
        yield f"  {self.verdict()}"

    def verdict(self) -> str:
        """Return the largest safe interval, and where the case is."""
        if self.stable is None:
            return f"nothing limits the sync interval of {self.interval_s:.3g} s ({self.scheme})"
        if self.safe_s == 0:
            return f"no sync interval is short enough ({self.scheme}, {self.stable.name})"
        return (
            f"largest safe sync interval {self.safe_s:.3g} s ({self.scheme}, {self.stable.name}); "
            f"the case takes {self.interval_s:.3g} s, {self.interval_s / self.safe_s:.2g} of it"
        )

    def warnings(self) -> Iterator[str]:
        """Yield where the case is beyond a limit: one line for stability, one for accuracy."""
        begin, accurate = f"coupling.sync_interval_s = {self.interval_s:.3g} s", self.accurate
        if self.stable is not None and self.unsafe:
            why = because(self.stable)
            if self.safe_s == 0:
                yield f"{begin}: no interval is short enough: {why}; {remedy(self.stable)}"
            else:
                times = self.interval_s / self.safe_s
                yield f"{begin}: {times:.2g} times what is sure to be stable, {self.safe_s:.2g} s: {why}"
        if accurate is not None and self.interval_s > accurate.interval_s:
            limit_s = accurate.interval_s
            yield f"{begin}: accurate by the usual rules is at most {limit_s:.2g} s: {because(accurate)}"

    def advice(self) -> str:
        """Return a sentence for a run that became unstable."""
        if self.stable is None or not self.unsafe:
            return "A smaller coupling.sync_interval_s or solver step usually helps."
        if self.safe_s == 0:
            return f"No shorter interval helps: {because(self.stable)}; {remedy(self.stable)}."
        safe = f"coupling.sync_interval_s = {self.safe_s:.2g} s"
        return f"At most {safe} is sure to be stable: {because(self.stable)}."

    def as_json(self) -> dict[str, Any]:
        """Return what ``summary.json`` has: bounds in s (None: no limit), the one that limits, and
        what to do where the case is beyond it."""
        return {
            "scheme": self.scheme,
            "taken_because": self.why or None,
            "safe_interval_s": self.safe_s if math.isfinite(self.safe_s) else None,
            "limited_by": self.stable.name if self.stable else None,
            "advice": self.advice() if self.unsafe else None,
            "bounds_s": {
                bound.name: bound.interval_s if math.isfinite(bound.interval_s) else None
                for bound in self.bounds
            },
        }


def because(bound: Bound) -> str:
    """Return why the bound allows no longer interval, in a designer's words; what the theory says of a
    bound that has none."""
    clause = BECAUSE.get(bound.name)
    return clause.format(where=bound.where) if clause else f"{bound.name} ({bound.why})"


def remedy(bound: Bound) -> str:
    """Return what helps where the bound allows no interval at all."""
    return REMEDIES.get(bound.name, 'set coupling.scheme = "auto"')


def stability_report(case: Case) -> StabilityReport:
    """Return the report of a case without problems.

    Where the case leaves its scheme to the program, it is the plain scheme's report if the sync
    interval is safe there or ``robin`` allows no longer one; else it is ``robin``'s.
    """
    if case.coupling.scheme != AUTO:
        return _report(case)
    plain = _report(with_scheme(case, PLAIN))
    if not plain.unsafe:
        return replace(plain, why=f"the sync interval is within its safe one, {plain.limit}")
    beyond = f"the sync interval of {plain.interval_s:.3g} s is above {PLAIN}'s {plain.limit}"
    if not has_particles(case):
        return replace(plain, why=f"{beyond}, and without particles {STRONGER} is no other")
    stronger = _report(with_scheme(case, STRONGER))
    if stronger.safe_s > plain.safe_s:
        return replace(stronger, why=f"{beyond}; {STRONGER}'s is {stronger.limit}")
    return replace(plain, why=f"{beyond}, and {STRONGER}'s is no longer: {stronger.limit}")


def case_with_scheme(case: Case) -> Case:
    """Return the case with the scheme that it names, or else with the one that its report calls for."""
    return with_scheme(case, stability_report(case).scheme) if case.coupling.scheme == AUTO else case


def with_scheme(case: Case, name: str) -> Case:
    """Return the case with another scheme."""
    coupling = case.coupling.model_copy(update={"scheme": name})
    return case.model_copy(update={"coupling": coupling})


def _report(case: Case) -> StabilityReport:
    """Return the report of a case that names its scheme."""
    there = scene(case)
    modes_rad_per_s, unknown = highest_rad_per_s(case)
    frames = frame_matrices(there)
    bounds: list[Bound] = []
    if has_particles(case):
        bounds += surface_bounds(there)
        if there.panels:
            bounds += contact_bounds(there, modes_rad_per_s, frames)
    if frames is not None and there.panels:
        bounds += frame_bounds(there, frames)
    return StabilityReport(
        scheme=case.coupling.scheme,
        interval_s=case.coupling.sync_interval_s,
        bounds=tuple(bounds),
        facts=dict(_facts(there, modes_rad_per_s, unknown, frames)),
    )


def _facts(
    scene: Scene, modes_rad_per_s: Mapping[str, float], unknown: str, frames: FrameMatrices | None
) -> Iterator[tuple[str, str]]:
    """Yield times, masses, modes and damping of a scene, and the particles' step, by name."""
    case, rayleigh_s = scene.case, shortest_rayleigh_s(scene.case)
    if has_particles(case):
        yield "Rayleigh time", f"{rayleigh_s:.3g} s, the smallest particle's"
        if scene.panels:
            bed = scene.bed_kg_per_m2
            ratio = bed / min(panel.mass_kg_per_m2 for panel in scene.panels)
            yield "bed on panel", f"{ratio:.3g} times the panel's mass, up to {bed:.3g} kg/m2"
        restitution = [row.restitution for row in case.contacts]
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
    if has_particles(case):
        share = LARGEST_RAYLEIGH_FRACTION
        why = f"{share:g} of the smallest one's Rayleigh time {rayleigh_s:.3g} s"
        yield "particles' step", f"{particle_step_s(case):.3g} s, at most {share * rayleigh_s:.3g} s ({why})"
