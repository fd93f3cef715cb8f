"""The stability report of a case: every bound on its sync interval, and the scheme that it calls for.

``stability_report`` needs a case without problems.  It asks the panels' solver for its largest
step, which takes about a second for a sheet.
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

AUTO = "auto"
IN_TURN = ("particles-first", "robin", "aitken")
"""The schemes that "auto" chooses from, from the cheapest to the dearest."""

BECAUSE = {
    "light points": "{where} pushes a light point of the panel's mesh back and forth between exchanges",
    "lasting contacts, panels' modes": "{where}, at rest on the panel, feeds its fastest vibration",
    "lasting contacts, light points": "{where}, at rest on the panel, rocks on a light point of its mesh",
    "foreseen contacts, panels' modes": "the load of {where} on the panel's fastest vibration is "
    "predicted wrongly",
    "foreseen contacts, spheres": "the load of {where}, which bounces off light points of the panel's "
    "mesh, is predicted wrongly",
    "late contacts": "the load of {where} comes an exchange late and feeds the panel's vibration",
    "late contacts, light points": "the load of {where} on a light point of the panel's mesh "
    "comes an exchange late",
    "extrapolated clamps": "the frames swing on their panels faster than exchanges can follow",
    "vibrating panels": "the frames answer undamped vibrations along the panels late",
    "late reaction": "the panels' pull on the frames comes an exchange late and feeds their swing",
    "carried mass": "the panels are too heavy for a frame that carries them",
    "shortest impact": "an impact of {where} should last ten exchanges",
    "whole impacts": "an impact of {where} must last so many exchanges that this scheme follows it",
    "moving surface": "between exchanges a surface is taken to move straight on, which {where} feels",
    "driven surface": "the smooth path of a driven surface between exchanges must not leave its "
    "true one by what {where} feels",
}
"""Clauses that explain each bound by its name in a designer's words; ``where`` names the particles."""

REMEDIES = {
    "carried mass": "make that frame heavier or its panels lighter",
    "late reaction": 'give the bushings damping, or set coupling.scheme = "auto"',
    "late contacts": 'set a restitution below 1, or coupling.scheme = "auto"',
    "late contacts, light points": 'set a restitution below 1, or coupling.scheme = "auto"',
}
"""Remedies by the name of the bound, for cases in which no interval is short enough."""


@dataclass(frozen=True)
class StabilityReport:
    """All bounds on the sync interval of a case under one scheme, with the texts about them.

    ``facts`` maps the names of the numbers behind the bounds to texts.  ``why`` says why the program
    chose the scheme, and is empty if the case names it.
    """

    scheme: str
    interval_s: float
    bounds: tuple[Bound, ...]
    facts: Mapping[str, str]
    why: str = ""

    @property
    def stability_bound(self) -> Bound | None:
        """The bound on stability with the shortest interval; None if nothing limits stability."""
        return self._least("stability")

    @property
    def accuracy_bound(self) -> Bound | None:
        """The bound on accuracy with the shortest interval; None if nothing limits accuracy."""
        return self._least("accuracy")

    @property
    def safe_s(self) -> float:
        """The largest interval within all bounds on stability; infinite if nothing limits it."""
        return self.stability_bound.interval_s if self.stability_bound else math.inf

    def _least(self, kind: str) -> Bound | None:
        finite = [b for b in self.bounds if b.kind == kind and math.isfinite(b.interval_s)]
        return min(finite, key=lambda bound: bound.interval_s, default=None)

    @property
    def grows_s(self) -> float:
        """The shortest interval beyond which something grows without end; infinite if nothing does."""
        return min((b.interval_s / b.sure for b in self.bounds if b.kind == "stability"), default=math.inf)

    @property
    def limit(self) -> str:
        """The safe interval as text, with the name of the bound that sets it."""
        bound = self.stability_bound
        return f"{at_most(self.safe_s)} s ({bound.name})" if bound else "unlimited"

    @property
    def is_unsafe(self) -> bool:
        """Whether the sync interval of the case is longer than the safe one."""
        return self.interval_s > self.safe_s

    def short_lines(self) -> Iterator[str]:
        """Yield lines about the sync interval, the longest safe and accurate ones, and the reasons."""
        scheme = f"scheme {self.scheme}" + (", chosen by the program" if self.why else "")
        stability, accuracy = self.stability_bound, self.accuracy_bound
        yield (
            f"  particles, panels and frames exchange motion and forces every {self.interval_s:.3g} s "
            f"(coupling.sync_interval_s; {scheme})"
        )
        if stability is None:
            yield "  stable at any interval"
        elif self.safe_s == 0:
            yield f"  stable at no interval: {because(stability)}; {remedy(stability)}"
        else:
            yield f"  sure to be stable up to {at_most(self.safe_s, 3)} s: {because(stability)}"
        if accuracy is not None:
            accurate = at_most(accuracy.interval_s, 3)
            yield f"  accurate by the usual rules up to {accurate} s: {because(accuracy)}"
        yield "  (--detail: all limits, and the numbers behind them)"

    def detail_lines(self) -> Iterator[str]:
        """Yield lines with the numbers, all bounds from the shortest interval up, and the conclusion."""
        if self.why:
            yield f"  scheme: {self.scheme}, chosen by the program: {self.why}"
        for name, text in self.facts.items():
            yield f"  {name}: {text}"
        for bound in sorted(self.bounds, key=lambda bound: bound.interval_s):
            limit = f"{bound.interval_s:.3g} s" if math.isfinite(bound.interval_s) else "no limit"
            yield f"  {limit} for {bound.kind}, {bound.name}: {bound.why} ({bound.source})"
        yield f"  {self.verdict()}"

    def verdict(self) -> str:
        """Return a clause that compares the case's sync interval with the largest safe one."""
        bound = self.stability_bound
        if bound is None:
            return f"nothing limits the sync interval of {self.interval_s:.3g} s ({self.scheme})"
        if self.safe_s == 0:
            return f"no sync interval is short enough ({self.scheme}, {bound.name})"
        return (
            f"largest safe sync interval {at_most(self.safe_s, 3)} s ({self.scheme}, {bound.name}); "
            f"the case takes {self.interval_s:.3g} s, {self.interval_s / self.safe_s:.2g} of it"
        )

    def warnings(self) -> Iterator[str]:
        """Yield a warning if the sync interval is beyond the safe one, and one if it is not accurate."""
        begin = f"coupling.sync_interval_s = {self.interval_s:.3g} s"
        stability = self.stability_bound
        if stability is not None and self.is_unsafe:
            why = because(stability)
            if self.safe_s == 0:
                yield f"{begin}: no interval is short enough: {why}; {remedy(stability)}"
            else:
                times = self.interval_s / self.safe_s
                yield f"{begin}: {times:.2g} times what is sure to be stable, {at_most(self.safe_s)} s: {why}"
        if inaccuracy := self.inaccuracy():
            yield f"{begin}: {inaccuracy}"

    def inaccuracy(self) -> str:
        """Return a clause on the interval beyond which the answer is not accurate by the usual rules, if the
        case's interval is longer; else an empty text."""
        accuracy = self.accuracy_bound
        if accuracy is None or self.interval_s <= accuracy.interval_s:
            return ""
        most = f"{at_most(accuracy.interval_s)} s"
        return f"for accuracy, the usual rules allow at most {most}: {because(accuracy)}"

    def advice(self) -> str:
        """Return a sentence of advice for a run that became unstable."""
        bound = self.stability_bound
        if bound is None or not self.is_unsafe:
            return "A smaller coupling.sync_interval_s or solver step usually helps."
        if self.safe_s == 0:
            return f"No shorter interval helps: {because(bound)}; {remedy(bound)}."
        safe = f"coupling.sync_interval_s = {at_most(self.safe_s)} s"
        return f"At most {safe} is sure to be stable: {because(bound)}."

    def as_json(self) -> dict[str, Any]:
        """Return the report as a table of ``summary.json``; a bound of None means no limit."""
        bound, accuracy = self.stability_bound, self.accuracy_bound
        return {
            "scheme": self.scheme,
            "taken_because": self.why or None,
            "safe_interval_s": self.safe_s if math.isfinite(self.safe_s) else None,
            "limited_by": bound.name if bound else None,
            "accurate_interval_s": accuracy.interval_s if accuracy else None,
            "inaccurate": self.inaccuracy() or None,
            "advice": self.advice() if self.is_unsafe else None,
            "bounds_s": {
                bound.name: bound.interval_s if math.isfinite(bound.interval_s) else None
                for bound in self.bounds
            },
        }


def at_most(interval_s: float, digits: int = 2) -> str:
    """Return an interval as text, rounded down so that what is given as sure is sure."""
    if not (math.isfinite(interval_s) and interval_s > 0):
        return f"{interval_s:g}"
    step = 10.0 ** (math.floor(math.log10(interval_s)) - digits + 1)
    return f"{math.floor(interval_s / step * (1 + 1e-12)) * step:.{digits}g}"


def because(bound: Bound) -> str:
    """Return a clause that explains the bound in a designer's words, or in the theory's if there is none."""
    clause = BECAUSE.get(bound.name)
    return clause.format(where=bound.where) if clause else f"{bound.name} ({bound.why})"


def remedy(bound: Bound) -> str:
    """Return a remedy for a case in which the bound allows no interval at all."""
    return REMEDIES.get(bound.name, 'set coupling.scheme = "auto"')


def stability_report(case: Case) -> StabilityReport:
    """Return the report of a case without problems.

    If the case leaves its scheme to the program, the report is that of the first scheme of ``IN_TURN`` for
    which the sync interval is safe.  If it is safe for none, it is that of the plain scheme or of robin,
    whichever grows at longer intervals.
    """
    behind = _Behind.of(case)
    if case.coupling.scheme != AUTO:
        return behind.report(case.coupling.scheme)
    beyond: list[StabilityReport] = []
    for name in IN_TURN if has_particles(case) else IN_TURN[:1]:
        report = behind.report(name)
        if not report.is_unsafe:
            within = f"the sync interval is within {report.scheme}'s safe one, {report.limit}"
            return replace(report, why="; ".join([*map(_too_long, beyond), within]))
        beyond.append(report)
    taken = max(beyond[:2], key=lambda report: report.grows_s)
    return replace(taken, why="; ".join(map(_too_long, beyond)))


def _too_long(report: StabilityReport) -> str:
    return f"the sync interval of {report.interval_s:.3g} s is above {report.scheme}'s {report.limit}"


def case_with_scheme(case: Case) -> Case:
    """Return the case with the scheme that it names or, if it names none, that its report calls for."""
    return with_scheme(case, stability_report(case).scheme) if case.coupling.scheme == AUTO else case


def with_scheme(case: Case, name: str) -> Case:
    """Return the case with another scheme."""
    coupling = case.coupling.model_copy(update={"scheme": name})
    return case.model_copy(update={"coupling": coupling})


@dataclass(frozen=True)
class _Behind:
    """The numbers behind the bounds of a case, whatever its scheme."""

    scene: Scene
    modes_rad_per_s: Mapping[str, float]
    unknown: str
    frames: FrameMatrices | None

    @staticmethod
    def of(case: Case) -> _Behind:
        numbers = scene(case)
        return _Behind(numbers, *highest_rad_per_s(case), frame_matrices(numbers))

    def report(self, scheme: str) -> StabilityReport:
        """Return the report of the case under a scheme."""
        numbers = replace(self.scene, case=with_scheme(self.scene.case, scheme))
        case, frames, bounds = numbers.case, self.frames, list[Bound]()
        if has_particles(case):
            bounds += surface_bounds(numbers)
            if numbers.panels:
                bounds += contact_bounds(numbers, self.modes_rad_per_s, frames)
        if frames is not None and numbers.panels:
            bounds += frame_bounds(numbers, self.modes_rad_per_s, frames)
        facts = dict(_facts(numbers, self.modes_rad_per_s, self.unknown, frames))
        return StabilityReport(scheme, case.coupling.sync_interval_s, tuple(bounds), facts)


def _facts(
    scene: Scene, modes_rad_per_s: Mapping[str, float], unknown: str, frames: FrameMatrices | None
) -> Iterator[tuple[str, str]]:
    """Yield names and texts of the times, masses, modes and damping behind the bounds of a scene."""
    case, rayleigh_s = scene.case, shortest_rayleigh_s(scene.case)
    if has_particles(case):
        yield "Rayleigh time", f"{rayleigh_s:.3g} s, the smallest particle's"
        if scene.panels:
            bed = scene.bed_kg_per_m2
            ratio = bed / min(panel.mass_kg_per_m2 for panel in scene.panels)
            yield "bed on panel", f"{ratio:.3g} times the panel's mass, up to {bed:.3g} kg/m2"
        restitution = [each for row in case.contacts for each in row.restitutions]
        if restitution:
            yield "restitution", f"{min(restitution):g} to {max(restitution):g}"
    if scene.panels:
        lowest_Hz = min(panel.frequency_rad_per_s for panel in scene.panels) / (2 * math.pi)
        highest_Hz = max(modes_rad_per_s.values(), default=0.0) / (2 * math.pi)
        end = f"{highest_Hz:.3g} Hz, as their mesh and steps make it"
        if not modes_rad_per_s:
            end = unknown or "what their solver does not resolve step by step"
        yield "panels' modes", f"{lowest_Hz:.3g} Hz (mounted, empty) to {end}"
        factors = [loss_factor(panel.material, panel.frequency_rad_per_s) for panel in scene.panels]
        yield "panels' loss factor", f"{min(factors):.2g} at the lowest"
    if frames is not None:
        frequencies_Hz = frames.modes()[0] / (2 * math.pi)
        yield "frames' modes", f"{frequencies_Hz[0]:.3g} to {frequencies_Hz[-1]:.3g} Hz, panels as springs"
    if has_particles(case):
        share = LARGEST_RAYLEIGH_FRACTION
        why = f"{share:g} of the smallest one's Rayleigh time {rayleigh_s:.3g} s"
        yield "particles' step", f"{particle_step_s(case):.3g} s, at most {share * rayleigh_s:.3g} s ({why})"
