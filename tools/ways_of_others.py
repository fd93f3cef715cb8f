"""What other ways of coupling cost, and how far they are off: ``python -m tools.ways_of_others [WORD ...]``.

The tool makes the runs of docs/measured/ways_of_others.csv that flipflow can make, those whose row has each
WORD, and writes their rows; rows of other programs stay as they are.  Cost is the processor time of the loop
for each simulated second; the start has importing, opening, results and all else that a run does once.
Errors are relative, against the row "reference" of the same scene; ``error_of`` says whether model or mesh
differ from the reference's, too.
"""

from __future__ import annotations

import csv
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import typer

import flipflow
from orchestrator.output.records.summary import processor_by_part_s
from tests.runs.outside import ROOT

TABLE = ROOT / "docs" / "measured" / "ways_of_others.csv"
COLUMNS = (
    *("way", "scene", "settings", "processor_s_per_s", "start_s", "quantity", "value", "unit"),
    *("error", "error_of", "status", "source"),
)
STATUS = {"done": "done", "doubtful": "doubtful"}  # every other run was stopped
MODEL = ("panel.solver=strip", "panel.solver=solid", "panel.cells=")
ONCE = ("start", "rest")  # parts of a run's processor time that do not grow with the simulated time
PEAK = "probes.middle.peak_m"

BALL, STRIP = "ball on a panel", "480 spheres on a strip"
ORDER = ("reference", "flipflow", "conventional order", "the paper's way", "Kratos")
SCENES: dict[str, tuple[str, ...]] = {
    BALL: (
        *("cases/ball-on-panel", "duration_s=0.004", "output.interval_s=0.004", "output.pictures=false"),
        *("bed.particles.ball.position_m=[0.152,0.1,0.0101]",),
        *("bed.particles.ball.velocity_m_per_s=[0,0,-1.2528]",),
    ),
    STRIP: ("tools/bench/scenes/strip-drop", "level=thrown", "output.pictures=false"),
}
"""The case of each scene, and the overlays that all of its runs have."""
UNWATCHED = ("monitor.created_energy=warn", "monitor.growing_modes=warn")  # nobody shortens an interval


@dataclass(frozen=True)
class Way:
    """A way of coupling in a scene: its name, its settings in words, and the overlays that it has."""

    way: str
    scene: str
    settings: str
    sets: tuple[str, ...]

    @property
    def command(self) -> str:
        """The command that makes the run."""
        case, *shared = SCENES[self.scene]
        level = [each.removeprefix("level=") for each in shared if each.startswith("level=")]
        sets = [each for each in (*shared, *self.sets) if not each.startswith("level=")]
        words = [f"flipflow run {case}", *(f"--level {each}" for each in level)]
        return " ".join([*words, *(f"--set {each}" for each in sets)])

    def measure(self) -> dict[str, str]:
        """Make the run, and return its row without the error."""
        case, level, sets = parse(self.command)
        summary: Mapping[str, Any] = {"status": "failed"}
        with tempfile.TemporaryDirectory(prefix="flipflow-ways-") as scratch:
            try:
                summary = flipflow.load(case, level, sets).run(Path(scratch) / "run").summary
            except flipflow.RunFailed as failed:
                summary = failed.run.summary if failed.run else summary
        row = {"way": self.way, "scene": self.scene, "settings": self.settings, "source": self.command}
        differs = any(each.startswith(MODEL) for each in self.sets)
        row["error_of"] = "model and numerics" if differs else "numerics"
        row |= {"status": STATUS.get(summary["status"], "stopped"), "quantity": PEAK, "unit": "mm"}
        if "wall_by_part_s" in summary:
            by_part_s = processor_by_part_s(summary)
            once_s = sum(by_part_s.get(part, 0.0) for part in ONCE)
            rate = (sum(by_part_s.values()) - once_s) / summary["simulated_s"]
            row |= {"processor_s_per_s": f"{float(f'{rate:.3g}'):g}", "start_s": f"{once_s:.2g}"}
        if row["status"] != "stopped":
            row["value"] = f"{1e3 * summary['probes']['middle']['peak_m']:.5f}"
        return row


def parse(command: str) -> tuple[Path, str | None, tuple[str, ...]]:
    """Return folder, level and overlays of a case from the command that runs it."""
    words = command.split()
    given = list(zip(words[3::2], words[4::2], strict=True))
    level = next((value for option, value in given if option == "--level"), None)
    return ROOT / words[2], level, tuple(value for option, value in given if option == "--set")


def ways() -> Iterator[Way]:
    """Yield every way in which flipflow runs the scenes."""

    def coupled(scheme: str, interval_s: str, *more: str) -> tuple[str, ...]:
        return (f"coupling.scheme={scheme}", f"coupling.sync_interval_s={interval_s}", *more)

    def steps(each: str) -> tuple[str, ...]:
        return f"particles.step_s={each}", f"panel.step_s={each}", "panel.integrator=explicit"

    finest = {BALL: "1e-6", STRIP: "2e-6"}
    intervals = {BALL: ("2e-5", "4e-5", "8e-5", "1.6e-4"), STRIP: ("2e-5", "5e-5", "1e-4", "2e-4")}
    for scene in SCENES:
        step = finest[scene]
        yield Way(
            "reference", scene, f"sheet, all at {step} s", coupled("particles-first", step, *steps(step))
        )
        for interval_s in intervals[scene]:
            yield Way("flipflow", scene, f"exchange {interval_s} s", coupled("auto", interval_s))
        for interval_s in intervals[scene]:
            sets = coupled("serial-staggered", interval_s, *UNWATCHED)
            yield Way("conventional order", scene, f"exchange {interval_s} s", sets)
        for model in ("sheet", "solid"):
            sets = coupled("particles-first", "8e-7", *steps("8e-7"), f"panel.solver={model}")
            yield Way("the paper's way", scene, f"{model}, all at 8e-7 s", sets)
    implicit = coupled("auto", "2e-5", "panel.solver=solid", "panel.integrator=implicit")
    strip = coupled("auto", "2e-5", "panel.solver=strip", "panel.cells=[22,1]")
    yield Way("flipflow", BALL, "strip of 22 cells, exchange 2e-5 s", strip)
    yield Way("flipflow", BALL, "solid, implicit, exchange 2e-5 s", implicit)
    fine = coupled("auto", "5e-5", "panel.cells=[66,10]", "panel.surface_cells=[66,10]")
    yield Way("flipflow", STRIP, "66 x 10 cells, exchange 5e-5 s", fine)
    strip = coupled("auto", "5e-5", "panel.solver=strip", "panel.cells=[66,1]")
    yield Way("flipflow", STRIP, "strip of 66 cells, exchange 5e-5 s", strip)


def read() -> list[dict[str, str]]:
    """Return the rows of the table."""
    if not TABLE.exists():
        return []
    with TABLE.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def write(rows: Sequence[Mapping[str, str]]) -> None:
    """Write the rows, with the error of each against the reference of its scene."""
    exact = {row["scene"]: float(row["value"]) for row in rows if row["way"] == "reference" and row["value"]}
    with TABLE.open("w", encoding="utf-8", newline="") as file:
        table = csv.DictWriter(file, COLUMNS, restval="", lineterminator="\n")
        table.writeheader()
        for row in sorted(rows, key=lambda row: ([*SCENES].index(row["scene"]), ORDER.index(row["way"]))):
            known = exact.get(row["scene"]) if row.get("value") and row["way"] != "reference" else None
            error = abs(float(row["value"]) / known - 1) if known else None
            table.writerow({**row, "error": "" if error is None else f"{error:.2g}"})


def main(words: Annotated[list[str] | None, typer.Argument()] = None) -> None:
    """Make the runs whose way, scene and settings have all words, and write the table after each."""
    for each in ways():
        if all(word in f"{each.way}, {each.scene}, {each.settings}" for word in words or ()):
            row = each.measure()
            key = row["way"], row["scene"], row["settings"]
            rows = {(old["way"], old["scene"], old["settings"]): old for old in read()}
            write([*(rows | {key: row}).values()])


if __name__ == "__main__":
    typer.run(main)
