"""``flipflow study stability``: benchmarks (cases that are hard to couple) and the map of stability.

A benchmark is a case whose ``criteria.toml`` describes the events and their expected consequences.  The map
shows the stable combinations of coupling scheme, sync interval, and mass of the bed over the panel's mass.
It belongs to a case whose ``map.toml`` names the key that changes the mass of the bed.  For all schemes, sync
intervals are multiples of the largest safe interval of the plain scheme (particles-first) at that mass, from
the stability report, so that a row of the map shows the gain of a scheme.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated

import typer
from annotated_types import Len
from matplotlib.lines import Line2D
from pydantic import ValidationError

from orchestrator.case.file.errors import CaseError, CaseProblem, from_validation
from orchestrator.case.file.layers import read_toml
from orchestrator.case.tables.quantities import OneLine, Positive, Table
from orchestrator.coupling.ledger import share_created
from orchestrator.coupling.schemes import SCHEMES
from orchestrator.output.records.run_folder import study_folder
from orchestrator.preflight.scene.scene import bed_kg
from orchestrator.studies.criteria import FILE, interval_sets
from orchestrator.studies.options import StudyOutput, check_folder
from orchestrator.studies.points import CaseStudy, Crew, Point, run_points, summary_of
from orchestrator.studies.quantities import is_over, outcome
from orchestrator.studies.report import figure_parts, write_csv, write_page
from orchestrator.studies.verdicts import (
    CaseCriteria,
    CriterionResult,
    case_criteria,
    verdict_table,
    write_verdicts,
)
from orchestrator.views.style import save

MAP_FILE = "map.toml"
PLAIN = "particles-first"
QUIET = ("output.pictures=false",)
# by outcome: colour, mark and label; marks of different shapes serve readers who see no colours
SHOWN = {
    "stable": ("#2b7a4b", "o", "stable"),
    "warned": ("#d08a00", "^", "warned: over 1 % of the energy made or lost, or a mode that grows"),
    "stopped": ("#b3261e", "X", "stopped, with a reason"),
    "idle": ("#9aa4b0", "s", "idle: no particle met a panel"),
    "not run": ("#9aa4b0", "_", "not run"),
}


def command(
    crew: Crew,
    cases: Annotated[Path, typer.Argument(metavar="[FOLDER]", help="folder with the benchmarks")] = Path(
        "cases/hard"
    ),
    part: Annotated[str, typer.Option("--part", help="hard, map, or both with a comma between")] = "hard,map",
    base: Annotated[
        str, typer.Option("--map", help="the case of that folder whose map.toml is drawn")
    ] = "interval",
    out: Annotated[Path, typer.Option("--out", help="folder of the study")] = Path("runs/stability"),
) -> StudyOutput:
    """Run all hard cases, and draw the map of stability.

    Part "hard" makes every run of every case with criteria.toml and judges it by the criteria.  Part
    "map" runs one case over coupling schemes, sync intervals and masses of the bed; each run is
    stable, warned or stopped, or idle if no particle met a panel.  Called again, the command makes only
    the missing runs; a run that was stopped with a reason is not missing.  The folder gets hard.csv,
    hard.md, map.csv, stability-map.png and stability.html.

    Exit code 4: a criterion is not met, a known failure is met, or a run of the map is missing or idle;
    2: a case is wrong.
    """
    parts = {word.strip() for word in part.split(",")}
    if unknown := parts - {"hard", "map"}:
        raise CaseError(
            [CaseProblem((), f"no part {sorted(unknown)[0]}", "hard or map", "--part", kind="unknown-name")]
        )
    benchmarks = find_benchmarks(cases, out / "hard") if "hard" in parts else []
    spots = map_spots(cases / base, out / "map") if "map" in parts else []
    points = [*(p for each in benchmarks for p in each.points), *(spot.run for spot in spots)]
    with study_folder(out):
        yield from run_points(points, crew)
    results = {each.name: each.results() for each in benchmarks}
    every = [result for of_case in results.values() for result in of_case]
    picture = None
    if every:
        yield verdict_table("hard cases", every)
        yield from write_verdicts(every, out, "hard")
    if spots:
        picture = draw_map(spots, out / "stability-map.png")
        yield from (write_csv([spot.words for spot in spots], out / "map.csv"), picture)
    yield write_stability_page([(each, results[each.name]) for each in benchmarks], spots, picture, out)
    return all(each.is_good for each in every) and all(
        spot.outcome not in ("not run", "idle") for spot in spots
    )


def write_stability_page(
    cases: Sequence[tuple[CaseCriteria, Sequence[CriterionResult]]],
    spots: Sequence[Spot],
    picture: Path | None,
    folder: Path,
) -> Path:
    """Write ``stability.html``, and return the file."""
    verdicts = [result.verdict for _, results in cases for result in results]
    return write_page(
        "commands/stability.html",
        folder / "stability.html",
        cases=cases,
        map_file=picture,
        spots=[spot.words for spot in spots],
        counts={name: verdicts.count(name) for name in dict.fromkeys(verdicts)},
    )


def find_benchmarks(folder: Path, out: Path) -> list[CaseCriteria]:
    """Return every case of a folder with criteria, in the order of their numbers; nothing is run here.

    Raises CaseError if one of them is wrong or there is none, and FolderUnusable where its runs would go into
    a case's folder.
    """
    cases = [file.parent for file in sorted(folder.glob(f"*/{FILE}"))]
    for case in cases:
        check_folder(out / case.name, "stability")
    benchmarks = [benchmark(case, out) for case in cases]
    if not benchmarks:
        raise CaseError([CaseProblem((), f"has no case with {FILE}", file=str(folder), kind="file")])
    return sorted(benchmarks, key=lambda each: each.criteria.number or 0)


def benchmark(case: Path, out: Path) -> CaseCriteria:
    """Return a benchmark, at its default level, with the runs that it needs.  Raises CaseError."""
    return case_criteria(CaseStudy(case, None, QUIET, out / case.name), is_over)


class MapAxes(Table):
    """The content of ``map.toml``."""

    key: OneLine
    """The key that changes the mass of the bed."""
    values: Annotated[tuple[Positive, ...], Len(1)]
    """The values of the key."""
    multiples: Annotated[tuple[Positive, ...], Len(1)]
    """The sync intervals, in multiples of the plain scheme's largest safe interval."""
    sets: tuple[OneLine, ...] = ()
    """Overlays of every run, as ``--set`` takes them."""


@dataclass(frozen=True)
class Spot:
    """One run of the map.

    ``mass_ratio`` is the mass of the bed over the mass of the panels; ``multiple`` is the sync interval over
    the plain scheme's largest safe interval.
    """

    scheme: str
    mass_ratio: float
    multiple: float
    run: Point

    @property
    def outcome(self) -> str:
        """The outcome of the run; "idle" if no particle met a panel, so that nothing could be unstable."""
        state, summary = outcome(self.run.folder), summary_of(self.run.folder)
        met_J = summary.get("energy_exchanged_J", {}).get("particles-panel")
        return "idle" if state == "stable" and met_J == 0.0 else state

    @property
    def words(self) -> dict[str, str]:
        """The row of the map's table, in words.

        It has the created energy over all energy exchanged and lost, the number of intervals that an iterated
        scheme did not solve to its tolerance, and the reason of an early end.
        """
        summary = summary_of(self.run.folder)
        interval_s = self.run.loaded.case.coupling.sync_interval_s
        return {
            "scheme": self.scheme,
            "bed / panel": f"{self.mass_ratio:.3g}",
            "interval / safe": f"{self.multiple:.3g}",
            "sync_interval_s": f"{interval_s:.3g}",
            "outcome": self.outcome,
            "share created": f"{share_created(summary):+.1e}" if "energy_ledger_J" in summary else "",
            "intervals not solved": str((summary.get("iterations") or {}).get("unsolved", "")),
            "why it was stopped": str(summary.get("reason", "")),
        }


def map_spots(folder: Path, out: Path) -> list[Spot]:
    """Return every spot of the map; nothing is run here.  Raises CaseError."""
    try:
        wanted = MapAxes.model_validate(read_toml(folder / MAP_FILE, folder))
    except ValidationError as error:
        raise CaseError([*from_validation(error, MapAxes)]) from None
    study, spots = CaseStudy(folder, None, (*QUIET, *wanted.sets), out), []
    for value in wanted.values:
        mass = f"{wanted.key}={value!r}"
        case = study.check([mass]).case
        panels_kg = (
            (panel.count * panel.length_m * panel.width_m * panel.thickness_m)
            * case.materials[panel.material].density_kg_per_m3
            for panel in case.screen.panels.values()
        )
        mass_ratio = bed_kg(case) / sum(panels_kg)  # the panels between their clamps
        for multiple in wanted.multiples:
            interval = interval_sets(study, [mass, f"coupling.scheme={PLAIN}"], multiple)
            for scheme in SCHEMES:
                name = f"{scheme}-{mass_ratio:.3g}-{multiple:g}"
                run = study.point(name, [mass, f"coupling.scheme={scheme}", *interval])
                spots.append(Spot(scheme, mass_ratio, multiple, replace(run, ended=is_over)))
    return spots


def draw_map(spots: Sequence[Spot], file: Path) -> Path:
    """Draw the map with a part for each scheme: sync interval across, mass of the bed upward."""
    schemes = list(dict.fromkeys(spot.scheme for spot in spots))
    outcomes = [spot.outcome for spot in spots]
    multiples, ratios = (sorted({getattr(s, key) for s in spots}) for key in ("multiple", "mass_ratio"))
    drawn, parts = figure_parts(len(schemes), min(3, len(schemes)), 3.75, 3.3)
    for axis, scheme in zip(parts, schemes, strict=True):
        for spot, outcome_there in zip(spots, outcomes, strict=True):
            if spot.scheme == scheme:
                colour, mark, _ = SHOWN[outcome_there]
                axis.scatter(spot.multiple, spot.mass_ratio, c=colour, marker=mark, s=95, zorder=3)
        axis.axvline(1.0, color="#24406e", lw=1.0, ls="--", zorder=1)
        axis.set(xscale="log", yscale="log")
        axis.set_title(scheme, loc="left", fontsize=11)
        axis.set_xticks(multiples, [f"{x:g}" for x in multiples])
        axis.set_yticks(ratios, [f"{x:.2g}" for x in ratios])
        axis.minorticks_off()
        axis.margins(0.12)
        axis.grid(alpha=0.25)
    handles = [
        Line2D([], [], color=colour, marker=mark, ls="", ms=9, label=text)
        for name, (colour, mark, text) in SHOWN.items()
        if name in outcomes
    ]
    drawn.legend(handles=handles, loc="outside upper center", ncols=len(handles))
    drawn.supxlabel("sync interval / largest safe one of the plain scheme", fontsize=10)
    drawn.supylabel("mass of the bed / of the panel", fontsize=10)
    save(drawn, file)
    return file
