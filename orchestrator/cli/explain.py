"""What ``flipflow explain`` prints: a table of effects, and what follows from it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from rich import box
from rich.console import Console
from rich.table import Table

from orchestrator.case.scalars import SCALARS
from orchestrator.preflight.judge import JudgedCase
from orchestrator.preflight.judgement.catalogue import Judged, find_dispensable, with_dependents
from orchestrator.preflight.judgement.pair import Pair
from orchestrator.preflight.judgement.weighing import weigh_effects, with_doubt
from orchestrator.preflight.scene.effect import PARTS, describe_verdict
from orchestrator.preflight.stability.report import AUTO
from orchestrator.studies.pairs import TriedEffects

if TYPE_CHECKING:
    from orchestrator.studies.accuracy.plan import Stored

NARROW = 130  # too narrow for all columns
WIDTH = 196  # of the table where no terminal sets one
COLUMNS = ("effect", "here", "number", "value", "threshold", "auto", "verdict", "change / cost")
SHORT = ("effect", "here", "value", "auto")
NOTHING = {"particles": "no particles: nothing to decide", "panels": "no panels: nothing to decide"}


def print_explanation(
    loaded: JudgedCase,
    study: Stored | None = None,
    tried: TriedEffects | None = None,
    asked: Sequence[str] = (),
) -> None:
    """Prints the verdicts on all effects of a case whose tables have no problems.

    What a ``study`` of accuracy measured of it, or what runs that were ``tried`` say of the results
    ``asked`` for, takes the place of estimates.
    """
    console = Console(highlight=False, markup=False)
    if not console.is_terminal:
        console.width = WIDTH
    judged = judge_effects(loaded) if tried is None else judge_effects(loaded, tried.pairs, asked)
    if study is not None:
        judged = {name: _measured(one, study) for name, one in judged.items()}
    level = f"level {loaded.level}" if loaded.level else "no level"
    console.print(f"{loaded.name}, {level}: {loaded.case.title}", soft_wrap=True)
    narrow = console.width < NARROW
    console.print(effects_table(judged, COLUMNS[:-1] if narrow else COLUMNS))
    if narrow:
        console.print(f"(in {NARROW} columns, or in a file, also keys and costs)", soft_wrap=True)
    for line in () if tried is None else trial_lines(tried, asked):
        console.print(line, soft_wrap=True)
    for line in summary_lines(loaded, list(judged.values())):
        console.print(line, soft_wrap=True)


def _measured(one: Judged, study: Stored) -> Judged:
    from orchestrator.studies.accuracy.plan import measured_verdict

    return replace(one, verdict=measured_verdict(one.effect, one.verdict, study))


def judge_effects(
    loaded: JudgedCase, pairs: Mapping[str, Pair] | None = None, asked: Sequence[str] = ()
) -> dict[str, Judged]:
    """Judges the effects of the case as it describes itself, part by part.

    ``pairs`` of runs decide for the results ``asked`` for; by default those that the case has.
    """
    if pairs is None:
        pairs, asked = loaded.choice.pairs, loaded.choice.asked or (*SCALARS,)

    def here(one: Judged) -> Judged:
        return with_doubt(replace(one, present=one.present and one.effect not in loaded.left_out))

    return {name: here(one) for name, one in weigh_effects(loaded.described, pairs, asked).items()}


def effects_table(judged: Mapping[str, Judged], columns: tuple[str, ...]) -> Table:
    """Returns a table with a row for each effect, part by part."""
    rows_table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for column in columns:
        rows_table.add_column(column, no_wrap=column in SHORT, overflow="fold")
    going = with_dependents(find_dispensable(judged.values()), "")
    for part in PARTS:
        rows = [one for one in judged.values() if one.part == part]
        rows_table.add_row(f"[{part}]", *[""] * 5, "" if rows else NOTHING.get(part, ""))
        for one in rows:
            rows_table.add_row(*_row(one, going)[: len(columns)])
        rows_table.add_section()
    return rows_table


def trial_lines(tried: TriedEffects, asked: Sequence[str]) -> Iterator[str]:
    """Yields what was run, what could not be, and for what the budget did not last."""
    done = [name for name, pair in tried.pairs.items() if not pair.refused]
    spent = f"{tried.spent_s:.0f} s of processor time"
    yield f"for {', '.join(asked)}: {len(done)} effects tried out or remembered, {spent}"
    refused: dict[str, list[str]] = {}
    for name, pair in tried.pairs.items():
        if pair.refused:
            refused.setdefault(pair.refused, []).append(name)
        elif not pair.changes(asked):
            yield f"  {name}: the runs have none of these results"
    for why, names in refused.items():
        yield f"  no runs for {', '.join(names)}: {why}"
    if tried.omitted:
        yield f"  not tried, as --budget was used: {', '.join(tried.omitted)}"


def _row(one: Judged, going: Collection[str]) -> tuple[str, ...]:
    verdict = one.verdict
    return (
        one.effect,
        "yes" if one.present else "no",
        verdict.number,
        verdict.value_in_words,
        verdict.threshold,
        _by_auto(one, going),
        f"{describe_verdict(verdict.matters)}: {verdict.why}",
        "\n".join(text for text in (one.key, verdict.cost) if text),
    )


def _by_auto(one: Judged, going: Collection[str]) -> str:
    """Returns what ``effects = "auto"`` does with an effect."""
    if one.lacking:
        return "warns"
    if not one.present:
        return "-"
    return "leaves out" if one.effect in going else "keeps"


def summary_lines(loaded: JudgedCase, verdicts: list[Judged]) -> Iterator[str]:
    """Yields what the case lacks, and what it could do without."""
    lacking = [one for one in verdicts if one.lacking]
    spare = [one for one in verdicts if one.spare]
    yield ("matters, and the case does not have it:" if lacking else "nothing that matters is lacking")
    yield from (f"  {one.effect}: {one.verdict.why}; {one.key}" for one in lacking)
    yield "may be left out, and the case has it:" if spare else "nothing could be left out"
    yield from (f"  {one.effect}: {one.verdict.why}; {one.key}; it costs {one.verdict.cost}" for one in spare)
    if loaded.case.coupling.scheme == AUTO:  # which one it is takes the solvers to say
        yield "coupling.scheme: the program's choice, which flipflow check names, with the reason"
    yield "formulas, sources, and how crude each estimate is: docs/theory/effects.md"
