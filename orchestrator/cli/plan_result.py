"""The output of ``flipflow plan --for``: how long, how wide and how often to run a case, and the price."""

from __future__ import annotations

import shlex
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from scipy.special import chdtri, stdtrit

from orchestrator.case.bed.grains import largest_length_m
from orchestrator.case.file.folder import FolderUnusable, admit
from orchestrator.case.file.slice import ENOUGH_DIAMETERS, between_openings_m, whole_width_m
from orchestrator.cli.chance import MOST_S, Basis, ChancePlan, Numerics, Priced
from orchestrator.cli.console import CONSOLE, UNLIMITED, refuse, reported_errors
from orchestrator.cli.planning import PART, Timing, filling, predict_wall_s, time_run
from orchestrator.figures.results import why_transient
from orchestrator.figures.short_names import Value, is_of_separation, named, unit_at, value_at
from orchestrator.output.cycles import counted_cycle_s
from orchestrator.output.records import trust
from orchestrator.output.records.summary import processor_by_part_s
from orchestrator.output.results.estimate import CONFIDENCE, COSINES
from orchestrator.output.results.events import FEWEST_CYCLES
from orchestrator.output.results.run_reader import RunReader
from orchestrator.output.tables import console_table
from orchestrator.preflight.cost import in_words
from orchestrator.preflight.judge import JudgedCase
from orchestrator.studies.accuracy.combinations import BASE, START
from orchestrator.studies.accuracy.stored import StoredStudy, find_study
from orchestrator.workbench import Case

POINTS = ("points", "point")
PILOT = 0.1
"""A pilot is made if it is predicted to take at most this share of the time that there is."""
WIDTHS = (0.5, 0.67, 1.0, 1.5, 2.0, 3.0, 4.0, 6.0, 8.0)
"""Widths of a slice that are offered, over that of the measured run."""
FREE = ("duration_s", "slice.width_m", "output.", "checkpoint.", "title", "description")
"""The beginnings of keys in which a measured run may differ from the case."""
GRAINS = ("slice.", "particles.coarse_graining")
"""The beginnings of keys of numerics that change the number of grains."""


@dataclass(frozen=True)
class Measured:
    """A measured run of the case: where it is, its summary, and the result that counts.

    ``folder`` is None for a pilot, which is not kept.
    """

    folder: Path | None
    summary: Mapping[str, Any]
    name: str
    value: Value

    @property
    def chance(self) -> float:
        """The part of the half width that chance alone makes, and that longer runs reduce."""
        assert self.value.half_width is not None, "only a result with an interval is a basis"
        if self.value.standard_error is None:
            return self.value.half_width
        student = float(stdtrit(COSINES, (1 + CONFIDENCE) / 2))
        return min(self.value.half_width, student * self.value.standard_error)

    @property
    def fixed(self) -> float:
        """The rest of the half width, such as the error of a curve that is continued to finer sizes."""
        assert self.value.half_width is not None, "only a result with an interval is a basis"
        return self.value.half_width - self.chance

    def basis(self, loaded: JudgedCase) -> Basis:
        """Return what the run says about chance and price."""
        summary, case = self.summary, loaded.case
        steady, parts_s = summary["results"]["steady"], processor_by_part_s(summary)
        start_s = sum(parts_s.get(part, 0.0) for part in START)
        simulated_s, total_s = summary["simulated_s"], sum(parts_s.values())
        share = parts_s.get("particles", 0.0) / (total_s - start_s)
        timing = Timing(start_s, simulated_s, start_s, 1.0, share, filling(case, simulated_s))
        counted_s = steady["end_s"] - steady["start_s"]
        stops_s = (feed.stop_s for feed in case.bed.feeds.values() if feed.stop_s is not None)
        return Basis(
            self.chance,
            counted_s,
            steady["start_s"],
            simulated_s,
            total_s,
            timing,
            summary["results"].get("slice_width_m"),
            # a run leaves out at most its first half
            max(FEWEST_CYCLES * counted_cycle_s(case), steady["start_s"]),
            min(stops_s, default=MOST_S),
            case.output.interval_s,
        )


@dataclass(frozen=True)
class Request:
    """What is asked for: a result of a case, its tolerance as it was typed, and the time in s."""

    loaded: JudgedCase
    case: Path
    overrides: Sequence[str]
    name: str
    tolerance: str
    budget_s: float
    run: Path | None
    study: Path | None
    cores: int


def plan_result(request: Request) -> bool:
    """Print the cheapest way to the tolerance with its price, and return whether it fits into the time."""
    _check_name(request.name)
    share, points = parse_tolerance(request.tolerance, request.name)
    with reported_errors():
        study = find_study(Case(request.loaded), request.study)
        measured = _measured(request, study)
    tolerance = points if share is None else share * abs(measured.value.value)
    plan = make_plan(request, measured, study, tolerance)
    if not CONSOLE.is_terminal:
        CONSOLE.width = UNLIMITED
    for line in _lines(request, measured, plan, tolerance, study):
        CONSOLE.print(line, soft_wrap=isinstance(line, str))
    return plan.choice is not None


def _check_name(name: str) -> None:
    try:
        named(name)
    except KeyError as error:
        refuse(f"--for: {error.args[0]}")
    if not is_of_separation(name):
        refuse(
            f"--for {name}: how chance falls with time and width is known of the separation alone: "
            "efficiency, recovery, oversize_yield or others of results.screening"
        )


def parse_tolerance(text: str, name: str) -> tuple[float | None, float]:
    """Return the share of the value that a tolerance is, or None and its size in points.

    "5%" and 0.05 are relative, and "2 points" are those of a result in per cent.
    """
    number, _, unit = text.replace("%", " %").strip().partition(" ")
    try:
        size = float(number)
    except ValueError:
        size = 0.0
    words = unit.strip()
    is_points, is_share = words in POINTS and unit_at(name) == "%", words in ("", "%")
    share = size / 100.0 if words == "%" else size
    if (is_points and 0 < size < 100) or (is_share and 0 < share < 1):
        return (None, size) if is_points else (share, 0.0)
    refuse(
        f"--tolerance {text}: is neither a share of the value, as 5% or 0.05, nor, of a result in per cent, "
        '"2 points"'
    )


def make_plan(
    request: Request, measured: Measured, study: StoredStudy | None, tolerance: float
) -> ChancePlan:
    """Return the plan for a tolerance in the unit of the result."""
    basis = measured.basis(request.loaded)
    if measured.fixed >= tolerance:
        refuse(
            f"± {tolerance:.3g} cannot be reached: ± {measured.fixed:.3g} of the interval are no chance "
            "but the error of the curve, which is continued to finer sizes: compute more (smallest_fed_m)"
        )
    return ChancePlan(
        basis,
        tolerance - measured.fixed,
        request.budget_s,
        request.cores,
        measured.folder is not None and any((measured.folder / "checkpoints").glob("*")),
        tuple(_widths_m(request.loaded, basis)),
        tuple(numerics(study, request.name, measured.value.value)),
    )


def _widths_m(loaded: JudgedCase, basis: Basis) -> Iterator[float]:
    """Yield widths of the slice that cut no opening, are not bridged, and are no wider than the machine."""
    case, own_m = loaded.case, basis.width_m
    if own_m is None or case.bed.particles or case.bed.is_carried:
        return
    whole = case.whole_machine
    low_m, high_m = ENOUGH_DIAMETERS * largest_length_m(case), whole_width_m(whole)
    wanted_m = {between_openings_m(whole, ratio * own_m) for ratio in WIDTHS}
    yield from sorted({own_m, *(width_m for width_m in wanted_m if low_m <= width_m <= high_m)})


def numerics(study: StoredStudy | None, name: str, value: float) -> Iterator[Numerics]:
    """Yield the settings of a study whose error of a result is bounded, in the unit of the result, and the
    case as it is, whose error may be unknown.

    A bound is the upper end of the interval of the error against the study's reference.  Settings that change
    the number of grains change chance as well, and are left out.
    """
    own = Numerics()
    column = named(name).figure.path.rpartition(".")[2]
    points = [] if study is None else [one for one in study.table["points"] if one["status"] == "done"]
    base = next((one for one in points if one["point"] == BASE), None)
    for one in points:
        error, half_width = one.get(f"{column}_error"), one.get(f"{column}_error_half_width")
        sets = tuple(shlex.split(one["sets"]))
        counts = all(Case.is_numeric(each) and not each.startswith(GRAINS) for each in sets)
        if base is None or error is None or half_width is None or not counts:
            continue
        bound = abs(value) * (error + half_width)
        if one is base:
            own = replace(own, at_most=bound)
        else:
            yield Numerics(one["settings"], sets, bound, one["processor_s"] / base["processor_s"])
    yield own


def _measured(request: Request, study: StoredStudy | None) -> Measured:
    """Return the run on which the plan is based; ends the program where there is none.

    Raises CaseError, SolverFailed or FolderUnusable.
    """
    if request.run is not None:
        return _usable(request, admit(request.run), RunReader(admit(request.run)).summary)
    name = request.loaded.name
    folders = [*sorted(Path("runs").glob(f"{name}-*"))]
    if study is not None:
        folders += sorted(study.file.parent.glob(f"{BASE}*"))
    found = [one for folder in folders if (one := _if_usable(request, folder)) is not None]
    if found:
        return max(found, key=lambda one: one.summary["simulated_s"])
    return _pilot(request)


def _if_usable(request: Request, folder: Path) -> Measured | None:
    try:
        summary = RunReader(admit(folder)).summary
    except (FolderUnusable, OSError, ValueError):  # what lies about in a folder of runs
        return None
    if _why_unusable(request, summary) or _changes(request, folder):
        return None
    return Measured(folder, summary, request.name, _value(request, summary))


def _usable(request: Request, folder: Path, summary: Mapping[str, Any]) -> Measured:
    if why := _why_unusable(request, summary):
        refuse(f"{folder}: {why}")
    if changes := _changes(request, folder):
        CONSOLE.print(
            f"warning: the run differs from the case in {', '.join(changes)}: its chance is of that"
        )
    return Measured(folder, summary, request.name, _value(request, summary))


def _value(request: Request, summary: Mapping[str, Any]) -> Value:
    value = value_at(summary, request.name)
    assert value is not None, "a usable run has the result"
    return value


def _why_unusable(request: Request, summary: Mapping[str, Any]) -> str:
    """Return why a run is no basis; empty if it is one."""
    loaded, value = request.loaded, value_at(summary, request.name)
    if (summary["case"], summary["level"]) != (loaded.name, loaded.level):
        return f'is of case "{summary["case"]}", level "{summary["level"]}"'
    if not trust.came_to_its_end(str(summary["status"])):
        return f"did not come to its end ({summary['status']})"
    if unsteady := why_transient(summary)[0]:
        longer_s = 2 * summary["simulated_s"]
        return (
            f"its bed is not steady, so that its chance is not known ({unsteady}); go on with it: "
            f"flipflow resume RUN --set duration_s={longer_s:g}"
        )
    if value is None or not value.half_width:
        return f"has no {request.name} with an interval"
    return ""


def _changes(request: Request, folder: Path) -> list[str]:
    changes = Case(request.loaded).changes_in(folder)
    return [key for key in changes if not key.startswith(FREE) and not key.endswith(".seed")]


def _pilot(request: Request) -> Measured:
    """Make a pilot if it is cheap; end the program where it is dear or of no use."""
    loaded, sets = request.loaded, list(request.overrides)
    level = loaded.level or None
    CONSOLE.print(
        f"no run of {loaded.name} whose chance is known; a part of it, 1 in {PART}, tells its price ..."
    )
    predicted_s = predict_wall_s(request.case, level, sets, Case(loaded))
    command = shlex.join(_command(request, "run", str(request.case)))
    if predicted_s > PILOT * request.budget_s:
        refuse(
            f"a run of it is the basis and would take about {in_words(predicted_s)} here, more than "
            f"{100 * PILOT:g} % of the time. First: {command}"
        )
    CONSOLE.print(f"a pilot, about {in_words(predicted_s)} ...")
    summary = time_run(request.case, level, sets)
    if why := _why_unusable(request, summary):
        refuse(f"the pilot cannot be used: {why.replace('flipflow resume RUN', command)}")
    return Measured(None, summary, request.name, _value(request, summary))


def _command(request: Request, *words: str) -> list[str]:
    at_level = ["--level", request.loaded.level] if request.loaded.level else []
    sets = [word for setting in request.overrides for word in ("--set", setting)]
    return ["flipflow", *words, *at_level, *sets]


def _lines(
    request: Request, measured: Measured, plan: ChancePlan, tolerance: float, study: StoredStudy | None
) -> Iterator[Any]:
    """Yield what is measured, wanted and chosen, the commands, and what is not known."""
    basis, value = plan.basis, measured.value
    unit = "points" if unit_at(request.name) == "%" else unit_at(request.name)
    assert value.half_width is not None, "a basis has an interval"
    where = "a pilot" if measured.folder is None else str(measured.folder)
    wide = "" if basis.width_m is None else f", slice of {1e3 * basis.width_m:.0f} mm"
    yield (
        f"{request.name} {value.value:.4g} ± {value.half_width:.2g} ({unit}, 95 %) by {where}: "
        f"{basis.counted_s:.3g} s counted after {basis.settling_s:.3g} s{wide}"
    )
    yield f"wanted: ± {tolerance:.3g} {unit}, {100 * tolerance / abs(value.value):.3g} % of the value"
    if measured.fixed > 0:
        yield f"of which ± {measured.fixed:.2g} {unit} are the error of the continued curve, and stay"
    if plan.within:
        head, rows = HEAD, [*_rows(plan)]
        if not any(one.way.numerics.sets for one in plan.within):
            head, rows = head[:1] + head[2:], [each[:1] + each[2:] for each in rows]
        yield console_table("ways to it", head, rows, left=("settings",))
    if (chosen := plan.choice) is not None:
        yield from _chosen(request, measured, chosen, unit)
    else:
        yield from _remedies(request, measured, plan, unit)
    yield from _unknown(measured, plan, study, request)


HEAD = ["way", "settings", "runs", "duration / s", "width / mm", "chance", "processor", "wall"]


def _kind(priced: Priced) -> str:
    way = priced.way
    if way.goes_on:
        return "go on with the run"
    if way.runs > 1:
        return "several seeds"
    ratio = way.width_ratio
    return "a new run" if abs(ratio - 1) < 1e-6 else "a wider slice" if ratio > 1 else "a narrower slice"


def _rows(plan: ChancePlan) -> Iterator[list[str]]:
    """Yield the cells of the cheapest way of each kind."""
    shown: set[tuple[str, str]] = set()
    for priced in plan.within:
        way = priced.way
        kind = _kind(priced), way.numerics.label
        if kind in shown:
            continue
        shown.add(kind)
        width = "" if way.width_m is None else f"{1e3 * way.width_m:.0f}"
        price, wall = in_words(priced.price_s), in_words(priced.wall_s)
        yield [
            *kind,
            str(way.runs),
            f"{priced.duration_s:.4g}",
            width,
            f"± {priced.half_width:.2g}",
            price,
            wall,
        ]


def _chosen(request: Request, measured: Measured, chosen: Priced, unit: str) -> Iterator[str]:
    way, bound = chosen.way, chosen.way.numerics.at_most
    numeric = "not known" if bound is None else f"at most {bound:.2g} {unit}"
    yield f"{_kind(chosen)}: chance ± {chosen.half_width:.2g} {unit}, numerics {numeric}"
    yield f"price: {in_words(chosen.price_s)} of processor time, {in_words(chosen.wall_s)} of wall time"
    yield from _commands(request, measured, chosen)
    if way.runs > 1:
        yield "the mean of its rows is the answer, and its half width theirs over the root of their number"


def _commands(request: Request, measured: Measured, chosen: Priced) -> Iterator[str]:
    """Yield the command of a way."""
    way, lasts = chosen.way, f"duration_s={chosen.duration_s:.6g}"
    if way.goes_on:
        yield shlex.join(["flipflow", "resume", str(measured.folder), "--set", lasts])
        return
    case = request.loaded.case
    sets = [*way.numerics.sets, lasts]
    if way.width_m is not None and (case.slice is None or abs(case.slice.width_m - way.width_m) > 1e-9):
        sets.append(f"slice.width_m={way.width_m:.6g}")
    words = [word for setting in sets for word in ("--set", setting)]
    if way.runs == 1:
        yield shlex.join([*_command(request, "run", str(request.case)), *words])
        return
    rows = (("blocks", case.bed.blocks), ("feeds", case.bed.feeds))
    own = {f"bed.{kind}.{name}.seed": row.seed for kind, table in rows for name, row in table.items()}
    for key, seed in own.items():
        words += ["--vary", f"{key}={','.join(str(seed + number) for number in range(1, way.runs + 1))}"]
    together = ["--plan", "list"] if len(own) > 1 else []
    ending = ["--result", request.name, "--jobs", str(min(way.runs, way.cores))]
    yield shlex.join([*_command(request, "study", "sweep", str(request.case)), *words, *together, *ending])


def _remedies(request: Request, measured: Measured, plan: ChancePlan, unit: str) -> Iterator[str]:
    """Yield what would be feasible."""
    limit = f"that does not fit into {in_words(plan.budget_s)}"
    if not plan.within:
        known = [one.at_most for one in plan.numerics if one.at_most is not None]
        why = f"; of numerics alone the least bound is {min(known):.2g} {unit}" if known else ""
        limit = f"no way leads to ± {plan.tolerance:.3g} {unit}{why}"
    yield f"{limit}; what would:"
    if plan.within:
        quickest = min(plan.within, key=lambda one: one.wall_s)
        yield f"  more time: {in_words(quickest.wall_s)} on {plan.cores} cores is the least; --budget"
    if (best := plan.best) is None:
        yield "  nothing: not even the shortest run that settles fits into that time"
        return
    yield f"  a wider tolerance: ± {best.half_width:.2g} {unit} by chance in {in_words(best.wall_s)}:"
    for line in _commands(request, measured, best):
        yield f"  {line}"


def _unknown(
    measured: Measured, plan: ChancePlan, study: StoredStudy | None, request: Request
) -> Iterator[str]:
    """Yield what the plan does not know."""
    tail = (1 - CONFIDENCE) / 2
    low, high = ((COSINES / float(chdtri(COSINES, share))) ** 0.5 for share in (tail, 1 - tail))
    yield "not known:"
    yield (
        f"  the scatter itself: one run knows it within a factor of {low:.2g} to {high:.2g}, and so the half "
        "width to come; ask again with the longer run"
    )
    basis = plan.basis
    if basis.settling_s >= 0.49 * (basis.settling_s + basis.counted_s):
        yield "  how long the deck takes to settle: the run left out the most that it may, its first half"
    if all(one.at_most is None for one in plan.numerics):
        level = f" --level {request.loaded.level}" if request.loaded.level else ""
        first = f"flipflow study accuracy {request.case}{level} --seeds 3"
        told = "the study has no bound for it" if study is not None else "there is no study"
        yield f"  the error of numerics (interval, mesh, step), which no longer run reduces: {told}: {first}"
    elif study is not None and (changes := study.changes(Case(request.loaded))):
        yield f"  numerics: the study is of the case before changes in {', '.join(changes)}"
    yield "  the error of the model, and how far a slice of another width screens alike"
