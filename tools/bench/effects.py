"""The cost of each effect of a case, and a check that an effect costs nothing once it is left out.

For each effect, up to three machines advance in turn, block by block, in one process, so that a computer
whose speed drifts slows all of them: the unchanged case, the case without the effect by ``effects``, and the
case with data that do not describe the effect.  Their ratios are ratios of CPU time, block against block.
"""

from __future__ import annotations

import tempfile
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.table import Table

from orchestrator.case.tables.case import Case
from orchestrator.preflight.judge import JudgedCase, load_judged
from orchestrator.preflight.judgement.catalogue import EFFECTS, can_leave_out, has_effect, with_dependents
from tools.bench.coupling import Runner, median_ratio
from tools.bench.loaded import loaded_by

BLOCK = 20
PARTS = ("particles", "panel", "frames", "mapping")
COEFFICIENTS = {
    "adhesion": "work_of_adhesion_J_per_m2",
    "rolling-friction": "rolling_friction",
    "wear": "specific_wear_m3_per_N_m",
}


@dataclass(frozen=True)
class TimedCase:
    """The case that is timed, as the command line describes it."""

    case: Path
    level: str | None
    overrides: tuple[str, ...]

    def load(self, *more: str) -> JudgedCase:
        """Return the case with more overlays."""
        return load_judged(self.case, self.level, [*self.overrides, *more])

    def loads(self, *more: str) -> frozenset[str]:
        """Return the adapters and large packages that the case loads with more overlays."""
        return loaded_by(self.case, self.level or "", [*self.overrides, *more])


def that_can_go(timed: TimedCase) -> list[str]:
    """Return the names of the case's effects that can be left out."""
    case = timed.load().case
    return [name for name in EFFECTS if has_effect(case, name) and can_leave_out(case, name)]


def bench(timed: TimedCase, intervals: int, effects: Collection[str]) -> Table:
    """Time ``intervals`` sync intervals of each machine, and return the table.

    Raises SolverMissing and SolverFailed.
    """
    case = timed.load().case
    here = [name for name in EFFECTS if has_effect(case, name)]
    table = Table(title=f"{timed.case.name}: ms per sync interval", title_justify="left")
    for column in ("", "all", *PARTS, "against the case", "undescribed / left out"):
        table.add_column(column, justify="left" if not column else "right", no_wrap=True)
    table.add_column("not loaded")
    whole, everything = _time([timed.load()], intervals)[0], timed.loads()
    table.add_row("the case", *whole.row(), "", "", "")
    for name in effects:
        others = [one for one in here if one not in with_dependents([name], "")]
        named = f"effects={others}"
        undescribed = list(sets(undescribing(case, name)))
        cases = [timed.load(), timed.load(named)]
        cases += [timed.load(*undescribed)] if undescribed else []
        full, without, *nothing = _time(cases, intervals)
        saved = sorted(everything - timed.loads(named))
        pair = ratio(nothing[0], without) if nothing else "the same data"
        table.add_row(f"without {name}", *without.row(), ratio(without, full), pair, " ".join(saved))
    return table


def undescribing(case: Case, effect: str) -> dict[str, Any]:
    """Return the keys that remove an effect from the data, where its overlay chooses another law."""
    coefficient = COEFFICIENTS.get(effect)
    if coefficient is None:
        return {}
    return {"contacts": {str(n): {coefficient: 0.0} for n in range(len(case.contacts))}}


@dataclass(frozen=True)
class Timed:
    """The CPU time of each block in s, and the wall time per sync interval in s, in all and by part."""

    blocks_s: tuple[float, ...]
    all_s: float
    parts_s: Mapping[str, float]

    def row(self) -> list[str]:
        """Return the wall times per sync interval in ms, in all and by part, in words."""
        return [f"{1e3 * one:.3f}" for one in (self.all_s, *map(self._part, PARTS))]

    def _part(self, part: str) -> float:
        return self.parts_s.get(part, 0.0)


def _time(cases: Sequence[JudgedCase], intervals: int) -> list[Timed]:
    """Run the machines of the cases in turn, and return their times without the first block."""
    with tempfile.TemporaryDirectory(prefix="flipflow-bench-") as scratch:
        runners = [Runner(case, Path(scratch) / str(number)) for number, case in enumerate(cases)]
        for number in range(1 + max(2, intervals // BLOCK)):
            for runner in runners:
                runner.block(BLOCK)
                if number == 0:
                    runner.forget()
        for runner in runners:
            runner.close()
    return [_of(runner) for runner in runners]


def _of(runner: Runner) -> Timed:
    done = BLOCK * len(runner.blocks_s)
    parts_s = {part: wall_s / done for part, wall_s in runner.stopwatch.wall_s.items()}
    return Timed(tuple(runner.blocks_s), runner.wall_s / done, parts_s)


def ratio(one: Timed, other: Timed) -> str:
    """Return the median and the quartiles of the blocks' ratios of CPU time, in words."""
    return median_ratio(one.blocks_s, other.blocks_s)


def sets(overlay: Mapping[str, Any], path: str = "") -> Iterator[str]:
    """Yield the numbers of an overlay as ``--set`` takes them."""
    for key, value in overlay.items():
        if isinstance(value, Mapping):
            yield from sets(value, f"{path}{key}.")
        else:
            yield f"{path}{key}={value}"
