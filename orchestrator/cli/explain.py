"""The output of ``flipflow explain``: a table of effects, and the conclusions from it."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from rich import box
from rich.table import Table

from orchestrator.case import solvers
from orchestrator.cli.console import TextConsole
from orchestrator.cli.json_forms import explain_form, print_json
from orchestrator.figures.short_names import SHORT_NAMES
from orchestrator.preflight.judge import JudgedCase
from orchestrator.preflight.judgement.catalogue import Judged, find_dispensable, with_dependents
from orchestrator.preflight.judgement.pair import Pair
from orchestrator.preflight.judgement.weighing import weigh_effects, with_doubt
from orchestrator.preflight.scene.effect import PARTS, TENTH, Verdict, describe_verdict
from orchestrator.preflight.stability.report import AUTO
from orchestrator.run.trials.pairs import TriedEffects

if TYPE_CHECKING:
    from orchestrator.studies.accuracy.stored import StoredStudy

NARROW = 130  # width of the console below which not all columns fit
WIDTH = 196  # width of the table if no terminal sets one
COLUMNS = ("effect", "here", "number", "value", "threshold", "auto", "verdict", "change / cost")
SHORT = ("effect", "here", "value", "auto")
NOTHING = {"particles": "no particles: nothing to decide", "panels": "no panels: nothing to decide"}


def print_explanation(
    loaded: JudgedCase,
    study: StoredStudy | None = None,
    tried: TriedEffects | None = None,
    asked: Sequence[str] = (),
    as_json: bool = False,
) -> None:
    """Print the verdicts on all effects of a case without problems in its tables.

    The measurements of a ``study`` of accuracy replace estimates, unless the case has changed since.  So do
    the runs that were ``tried``, with their changes of the results ``asked`` for.
    """
    changes: list[str] = []
    if study is not None:
        from orchestrator.workbench import Case  # it takes a second, and few have a study

        changes = study.changes(Case(loaded))
    effects = _judge_with_measurements(loaded, None if changes else study, tried, asked)
    if as_json:
        print_json(explain_form(loaded, [*effects.values()]))
        return
    console = TextConsole(highlight=False, markup=False)
    if not console.is_terminal:
        console.width = WIDTH
    level = f"level {loaded.level}" if loaded.level else "no level"
    console.print(f"{loaded.name}, {level}: {loaded.case.title}", soft_wrap=True)
    narrow = console.width < NARROW
    console.print(effects_table(effects, COLUMNS[:-1] if narrow else COLUMNS))
    if narrow:
        console.print(f"(in {NARROW} columns, or in a file, also keys and costs)", soft_wrap=True)
    lines = [] if tried is None else [*trial_lines(tried, asked)]
    if study is not None and changes:
        lines.append(f"not used: {study.file}, which is of the case before changes in {', '.join(changes)}")
    for line in (*lines, *summary_lines(loaded, [*effects.values()])):
        console.print(line, soft_wrap=True)


def _judge_with_measurements(
    loaded: JudgedCase, study: StoredStudy | None, tried: TriedEffects | None, asked: Sequence[str]
) -> dict[str, Judged]:
    effects = judge_effects(loaded) if tried is None else judge_effects(loaded, tried.pairs, asked)
    if study is not None:
        for name, judged in effects.items():
            effects[name] = replace(judged, verdict=measured_verdict(name, judged.verdict, study))
    return effects


def measured_verdict(effect: str, verdict: Verdict, study: StoredStudy) -> Verdict:
    """Return the verdict on an effect, with the measured error and cost of the model that leaves it out.

    Without a run of such a model the verdict is returned unchanged, and so it is where chance leaves open
    whether the error is above the threshold.
    """
    from orchestrator.studies.accuracy.combinations import DECISIVE  # it takes time, and few ask for it

    model = _model_without(effect, study.table.get("models", []))
    decisive = {name: model["error"][name] for name in DECISIVE if name in model["error"]} if model else {}
    if model is None or not decisive:
        return verdict
    widths = model.get("half_width", {})
    known = {name: widths.get(name) or 0.0 for name in decisive}
    surely = any(value - known[name] > TENTH for name, value in decisive.items())
    if not surely and any(value + known[name] > TENTH for name, value in decisive.items()):
        return verdict
    errors = ", ".join(f"{name} {100 * value:.3g} %" for name, value in decisive.items())
    if any(widths.get(name, 0.0) is None for name in decisive):
        errors += "; how much of it is chance is not known"
    return replace(
        verdict,
        number=f"largest error of {model['label']}",
        value=max(decisive.values()),
        threshold=f"0.1 (measured against {model['reference']})",
        matters=surely,
        why=f"measured: {errors}",
        cost=f"{model['reference_processor_s']:.3g} s instead of {model['processor_s']:.3g} s of processor",
    )


def _model_without(effect: str, models: Sequence[dict[str, Any]]) -> dict[str, Any] | None:
    """Return the measured model that leaves an effect out, or None where there is none.

    It is the case's own model if that leaves the effect out, or else the finest such model.  For the effect
    "contact-stiffness" it has softer contacts, for "single-particles" coarser particles.
    """
    wanted = {"contact-stiffness": ("stiffness", ""), "single-particles": ("number", "")}
    ports: tuple[solvers.Port, ...] = ("panel", "frames")
    for port in ports:
        if name := solvers.name_without(port, effect):
            wanted[effect] = (port, name)
    if effect not in wanted:
        return None
    fitting = [
        m for m in models if (m["axis"], m["variant"]) == wanted[effect] and m["label"] != m["reference"]
    ]
    return next((model for model in fitting if not model["sets"]), fitting[-1] if fitting else None)


def judge_effects(
    loaded: JudgedCase, pairs: Mapping[str, Pair] | None = None, asked: Sequence[str] = ()
) -> dict[str, Judged]:
    """Return the judgements of the effects of a case, with all that it describes, part by part.

    ``pairs`` of runs decide for the results ``asked`` for.  By default, the remembered pairs decide.
    """
    if pairs is None:
        pairs, asked = loaded.choice.pairs, loaded.choice.asked or (*SHORT_NAMES,)
    effects = weigh_effects(loaded.described, pairs, asked)
    return {
        name: with_doubt(replace(judged, present=judged.present and name not in loaded.left_out))
        for name, judged in effects.items()
    }


def effects_table(effects: Mapping[str, Judged], columns: tuple[str, ...]) -> Table:
    """Return a table with a row for each effect, part by part."""
    table = Table(box=box.SIMPLE_HEAD, pad_edge=False)
    for column in columns:
        table.add_column(column, no_wrap=column in SHORT, overflow="fold")
    left_out = with_dependents(find_dispensable(effects.values()), "")
    for part in PARTS:
        rows = [judged for judged in effects.values() if judged.part == part]
        table.add_row(f"[{part}]", *[""] * 5, "" if rows else NOTHING.get(part, ""))
        for judged in rows:
            verdict = judged.verdict
            row = (
                judged.effect,
                "yes" if judged.present else "no",
                verdict.number,
                verdict.value_in_words,
                verdict.threshold,
                _by_auto(judged, left_out),
                f"{describe_verdict(verdict.matters)}: {verdict.why}",
                "\n".join(text for text in (judged.key, verdict.cost) if text),
            )
            table.add_row(*row[: len(columns)])
        table.add_section()
    return table


def _by_auto(judged: Judged, left_out: Collection[str]) -> str:
    """Return the word for what ``effects = "auto"`` does with an effect."""
    if judged.is_lacking:
        return "warns"
    if not judged.present:
        return "-"
    return "leaves out" if judged.effect in left_out else "keeps"


def trial_lines(tried: TriedEffects, asked: Sequence[str]) -> Iterator[str]:
    """Yield lines about the effects that were tried, those without runs, and those beyond the budget."""
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


def summary_lines(loaded: JudgedCase, verdicts: list[Judged]) -> Iterator[str]:
    """Yield lines about the effects that the case lacks, and those without which it could do."""
    lacking = [
        f"  {row.effect}: {'; '.join(filter(None, (row.verdict.why, row.key)))}"
        for row in verdicts
        if row.is_lacking
    ]
    spare = [
        f"  {row.effect}: {row.verdict.why}; {row.key}; cost: {row.verdict.cost}"
        for row in verdicts
        if row.is_spare
    ]
    yield "matters, and the case does not have it:" if lacking else "nothing that matters is lacking"
    yield from lacking
    yield "may be left out, and the case has it:" if spare else "nothing could be left out"
    yield from spare
    if loaded.case.coupling.scheme == AUTO:  # only solvers can tell which scheme it is
        yield "coupling.scheme: the program's choice, which flipflow check names, with the reason"
    yield "formulas, sources, and how crude each estimate is: docs/theory/effects.md"
