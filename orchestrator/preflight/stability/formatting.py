"""A stability report as text: in a designer's words, and in the theory's words and numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from orchestrator.preflight.stability.bounds import Bound
from orchestrator.preflight.stability.report import StabilityReport

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
"""Why no longer interval: a clause for each bound by its name; ``where`` are the particles."""

REMEDIES = {
    "carried mass": "make that frame heavier or its panels lighter",
    "late reaction": 'give the bushings damping, or set coupling.scheme = "auto"',
    "late contacts": 'set a restitution below 1, or coupling.scheme = "auto"',
    "late contacts, light points": 'set a restitution below 1, or coupling.scheme = "auto"',
}
"""What helps where no interval is short enough."""

USUALLY = "A smaller coupling.sync_interval_s or solver step usually helps."


def short_lines(report: StabilityReport) -> Iterator[str]:
    """How often forces are exchanged, how often they should be, and why."""
    scheme = f"scheme {report.scheme}" + (", chosen by the program" if report.why else "")
    yield (
        f"  particles, panels and frames exchange motion and forces every {report.interval_s:.3g} s "
        f"(coupling.sync_interval_s; {scheme})"
    )
    if report.stable is None:
        yield "  stable at any interval"
    elif report.safe_s == 0:
        yield f"  stable at no interval: {because(report.stable)}; {remedy(report.stable)}"
    else:
        yield f"  sure to be stable up to {report.safe_s:.3g} s: {because(report.stable)}"
    if report.accurate is not None:
        limit_s, why = report.accurate.interval_s, because(report.accurate)
        yield f"  accurate by the usual rules up to {limit_s:.3g} s: {why}"
    yield "  (--detail: all limits, and the numbers behind them)"


def warnings(report: StabilityReport) -> Iterator[str]:
    """Where the case is beyond a limit: one line for stability, one for accuracy."""
    interval_s, stable, accurate = report.interval_s, report.stable, report.accurate
    if stable is not None and interval_s > stable.interval_s:
        yield f"coupling.sync_interval_s = {interval_s:.3g} s: {_too_long(report, stable)}"
    if accurate is not None and interval_s > accurate.interval_s:
        yield (
            f"coupling.sync_interval_s = {interval_s:.3g} s: accurate by the usual rules is at "
            f"most {accurate.interval_s:.2g} s: {because(accurate)}"
        )


def advice(report: StabilityReport) -> str:
    """For a run that became unstable: a sentence."""
    stable = report.stable
    if stable is None or report.interval_s <= stable.interval_s:
        return USUALLY
    if stable.interval_s == 0:
        return f"No shorter interval helps: {because(stable)}; {remedy(stable)}."
    return (
        f"At most coupling.sync_interval_s = {stable.interval_s:.2g} s is sure to be stable: "
        f"{because(stable)}."
    )


def beyond(report: StabilityReport) -> bool:
    """Whether the case is beyond what is sure to be stable."""
    return report.interval_s > report.safe_s


def because(bound: Bound) -> str:
    """Why the bound allows no longer interval; what the theory says of a bound that has no words
    here."""
    clause = BECAUSE.get(bound.name)
    return clause.format(where=bound.where) if clause else f"{bound.name} ({bound.why})"


def remedy(bound: Bound) -> str:
    """What helps where the bound allows no interval at all."""
    return REMEDIES.get(bound.name, 'set coupling.scheme = "auto"')


def _too_long(report: StabilityReport, stable: Bound) -> str:
    if stable.interval_s == 0:
        return f"no interval is short enough: {because(stable)}; {remedy(stable)}"
    times = report.interval_s / stable.interval_s
    return f"{times:.2g} times what is sure to be stable, {stable.interval_s:.2g} s: {because(stable)}"


def detail_lines(report: StabilityReport) -> Iterator[str]:
    """All of it: numbers, bounds from the least up, and what follows."""
    if report.why:
        yield f"  scheme: {report.scheme}, taken by the program: {report.why}"
    for name, text in report.facts.items():
        yield f"  {name}: {text}"
    for step in report.steps:
        yield f"  {step.name}: {step.step_s:.3g} s, at most {step.limit_s:.3g} s ({step.why})"
    for bound in sorted(report.bounds, key=lambda bound: bound.interval_s):
        limit = f"{bound.interval_s:.3g} s" if math.isfinite(bound.interval_s) else "no limit"
        yield f"  {limit} for {bound.kind}, {bound.name}: {bound.why} ({bound.source})"
    yield f"  {verdict(report)}"


def verdict(report: StabilityReport) -> str:
    """The largest safe interval, and where the case is."""
    if report.stable is None:
        return f"nothing limits the sync interval of {report.interval_s:.3g} s ({report.scheme})"
    if report.safe_s == 0:
        return f"no sync interval is short enough ({report.scheme}, {report.stable.name})"
    share = report.interval_s / report.safe_s
    return (
        f"largest safe sync interval {report.safe_s:.3g} s ({report.scheme}, {report.stable.name}); "
        f"the case takes {report.interval_s:.3g} s, {share:.2g} of it"
    )


def metrics(report: StabilityReport) -> dict[str, Any]:
    """For ``summary.json``: bounds in s (None: no limit), the one that limits, and what to do where
    the case is beyond it."""
    return {
        "scheme": report.scheme,
        "taken_because": report.why or None,
        "safe_interval_s": report.safe_s if math.isfinite(report.safe_s) else None,
        "limited_by": report.stable.name if report.stable else None,
        "advice": advice(report) if beyond(report) else None,
        "bounds_s": {
            bound.name: bound.interval_s if math.isfinite(bound.interval_s) else None
            for bound in report.bounds
        },
    }
