"""A comparison of cases with the numbers of the papers that they come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from orchestrator.studies.criteria import FILE, read_criteria
from orchestrator.studies.facts import Fact, predicted_facts
from orchestrator.studies.points import CaseStudy
from orchestrator.studies.recorded import read_rows
from orchestrator.studies.report import markdown_table
from orchestrator.studies.verdicts import (
    WORST_FIRST,
    CaseCriteria,
    CriterionResult,
    case_criteria,
    worst_first,
)
from orchestrator.workbench import CaseError, CaseProblem, StudyFolder
from orchestrator.workbench.vocabulary import did_you_mean

RECORDED = ("case", "criterion", "value", "half width", "unit")
FACT_HEAD = ("fact", "number", "published", "ours", "distance", "band", "verdict")
OPEN_HEAD = ("fact", "number", "published", "ours", "verdict")
RULES = (
    "A **fact** is one thing that a paper says. It counts once, with the verdict of the worst of our numbers "
    "for it. Misses come first.\n"
    "Intervals are 95 % confidence intervals of our runs; they do not contain what a case assumes.",
    "- *Met* and *NOT MET*: the number was **predicted**. No value of the case was chosen to meet it. "
    "The band is the source's own error.\n"
    "- *Sign only*: the sign of an effect is published, its size is not.\n"
    "- *Chance*: our interval holds zero and a part of the band, so that there may be no effect.\n"
    "- Only counted here: *as own theory*, beside a closed form of our own; *not compared*; *fitted*, "
    "*assumed* or *published*, and inside, which proves nothing.",
)
HEAD = ("number", "published", "experiment", "ours", "distance", "ours is", "band", "verdict")
COUNTED = ("as own theory", "fitted, inside", "assumed, inside", "published, inside", "not compared")
"""Verdicts of numbers that ``paper.csv`` and ``paper.html`` have, and ``paper.md`` only counts."""
INSIDE = ("sign only", "met")
"""Verdicts of facts that ``paper.md`` only names."""


def find_papers(study: CaseStudy) -> list[tuple[CaseCriteria, Path]]:
    """Return the criteria of a study's case, or of all cases of its folder that name a source.

    Each comes with the folder of its runs; nothing is run here.  Raises CaseError with the problems of all
    cases, or if there is no case to compare, and FolderUnusable where the runs would go into a case's folder.
    """
    if study.case.is_file() or (study.case / "case.toml").is_file():
        return [(of_case(study), study.folder)]
    papers, problems = [], []
    for file in sorted(study.case.glob(f"*/{FILE}")):
        case = file.parent
        try:
            if read_criteria(case).source:
                own = replace(study, case=case, out=study.folder / case.name)
                StudyFolder(own.folder).admit(study.name)
                papers.append((of_case(own), own.folder))
        except CaseError as error:
            problems += [replace(each, file=f"{case.name}: {each.file}") for each in error.problems]
    if problems:
        raise CaseError(problems)
    if not papers:
        what = f"is not a case, and has no case with a source in {FILE}"
        raise CaseError([CaseProblem((), what, "docs/criteria.md", str(study.case), kind="file")])
    return papers


def of_case(study: CaseStudy) -> CaseCriteria:
    """Return the criteria of a study's case, at the level of the study or of the criteria.

    Raises CaseError.
    """
    return case_criteria(replace(study, level=study.level or read_criteria(study.case).level or None))


def recorded_results(
    papers: Sequence[CaseCriteria], file: Path
) -> list[tuple[CaseCriteria, list[CriterionResult]]]:
    """Return the results of criteria whose numbers an earlier ``paper.csv`` has; nothing is run or read else.

    The file has the columns ``case``, ``criterion``, ``value``, ``half width`` and ``unit``, and may have
    ``note``, a remark that the page shows.  A criterion that it does not have gives no number.  Raises
    CaseError where a column is missing or a row is of no criterion, or in another unit.
    """
    every = read_rows(file, RECORDED, ("value", "half width"), "docs/criteria.md")
    rows = {(row["case"], row["criterion"]): row for row in every}
    known = {(paper.name, row.what): row for paper in papers for row in paper.criteria.criteria}
    names = {paper.name for paper in papers}
    problems = []
    for key, row in rows.items():
        if key[0] not in names:
            continue
        if key not in known:
            hint = did_you_mean(key[1], [what for case, what in known if case == key[0]])
            problems.append(CaseProblem((*key,), "is not a criterion", hint, str(file), kind="unknown-name"))
        elif row["unit"] != known[key].unit:
            what = f"is in {row['unit']}, and its criterion in {known[key].unit}"
            problems.append(CaseProblem((*key,), what, file=str(file), kind="unit"))
    if problems:
        raise CaseError(problems)
    results = []
    for paper in papers:
        found = []
        for criterion in paper.criteria.criteria:
            row = rows.get((paper.name, criterion.what), {})
            why = "no number" if row else "not recorded"
            value, width = (float(row[name]) if row.get(name) else None for name in ("value", "half width"))
            found.append(CriterionResult(paper.name, criterion, value, why, width, row.get("note") or ""))
        results.append((paper, found))
    return results


def write_paper(
    results: Sequence[tuple[CaseCriteria, Sequence[CriterionResult]]],
    study: CaseStudy,
    recorded: Path | None = None,
) -> list[Path]:
    """Write ``paper.md``, ``paper_facts.csv`` and ``paper.html``, and return the files.

    ``recorded`` is the file of the numbers if they were measured before.
    Facts come first, the misses among them before the rest.  ``paper.html`` has every number,
    ``paper_facts.csv`` those of facts, ``paper.md`` those that are out of their band or not known.
    """
    facts = predicted_facts(results)
    of_file = "" if recorded is None else f" --recorded {recorded}"
    counted = counts([fact.verdict for fact in facts], "facts")
    parts = [
        (
            paper,
            counts([each.verdict for each in of_case], "numbers"),
            [*dict.fromkeys(each.note for each in of_case if each.note)],
            [row(each) for each in worst_first(of_case)],
        )
        for paper, of_case in results
    ]
    of_facts = [cells for fact in facts for cells in fact_rows(fact)]
    of_a_fact = {id(each) for fact in facts for each in fact.results}
    rows = [dict(zip(FACT_HEAD, cells, strict=True)) for cells in of_facts]
    shown_facts = [[each[name] for name in OPEN_HEAD] for each in rows if each["verdict"] not in INSIDE]
    text = [
        "# Published numbers and ours",
        f"`flipflow study paper {study.case}{of_file}` makes this page. {counted}",
        *RULES,
        "## Facts",
        *([markdown_table(OPEN_HEAD, shown_facts)] if shown_facts else []),
        facts_inside(facts),
    ]
    text += ["## Cases", cases_by_source(results)]
    others = [each for _, of_case in results for each in of_case if id(each) not in of_a_fact]
    shown = [(each.case, *row(each)) for each in worst_first(others) if each.verdict not in COUNTED]
    text += ["## Other numbers out of their band", markdown_table(("case", *HEAD), shown)] if shown else []
    folder = StudyFolder(study.folder)
    table = folder.write_csv("paper_facts.csv", rows)
    file = folder.write_text("paper.md", "\n\n".join(part.rstrip() for part in text) + "\n")
    page = folder.write_page(
        "paper.html",
        "paper.html",
        parts=parts,
        counts=counted,
        head=HEAD,
        fact_head=FACT_HEAD,
        facts=of_facts,
    )
    return [file, table, page]


def cases_by_source(results: Sequence[tuple[CaseCriteria, Sequence[CriterionResult]]]) -> str:
    """Return the sources, each with its cases and what their numbers came to, and the remarks on cases."""
    by_source: dict[str, list[str]] = {}
    by_note: dict[str, list[str]] = {}
    for paper, of_case in results:
        level = f" (level {paper.level})" if paper.level else ""
        counted = counts([each.verdict for each in of_case], "numbers")
        by_source.setdefault(paper.criteria.source, []).append(f"  - {paper.name}{level}: {counted}")
        for note in dict.fromkeys(each.note for each in of_case if each.note):
            by_note.setdefault(note, []).append(paper.name)
    lines = ["\n".join([f"- {source}", *cases]) for source, cases in by_source.items()]
    notes = [f"{', '.join(names)}: {note}" for note, names in by_note.items()]
    return "\n\n".join(["\n".join(lines), *notes])


def facts_inside(facts: Sequence[Fact]) -> str:
    """Return the names of the facts that are met or whose sign is, and how many numbers of others are."""
    lines = []
    for verdict in reversed(INSIDE):
        names = ";\n  ".join(fact.name for fact in facts if fact.verdict == verdict)
        lines += [f"- **{verdict.capitalize()}**: {names}."] if names else []
    for fact in facts:
        inside = sum(each.verdict in INSIDE for each in fact.results)
        if inside and fact.verdict not in INSIDE:
            lines.append(f"- **{fact.name}**: {inside} of {len(fact.results)} numbers are met.")
    return "\n".join([*lines, "- **All numbers** of facts: [paper_facts.csv](paper_facts.csv)."])


def fact_rows(fact: Fact) -> list[tuple[str, ...]]:
    """Return the words of a fact for a table with the columns ``FACT_HEAD``: a row for each number that says
    something of the source.

    A reason of a band that several numbers have stands in the first row.
    """
    rows: list[tuple[str, ...]] = []
    reasons = {""}
    for each in fact.results:
        if each.verdict in COUNTED:
            continue
        what = "" if each.row.what == fact.name else f"{each.row.what}, "
        reason = "" if each.row.why in reasons else f" ({each.row.why})"
        rows.append(
            (
                fact.name,
                f"{what}{each.case}{reason}",
                each.reference_in_words,
                each.value_in_words,
                each.distance_in_words,
                each.band_in_words,
                each.verdict,
            )
        )
        reasons.add(each.row.why)
    return rows


def row(result: CriterionResult) -> tuple[str, ...]:
    """Return the words of one number for a table with the columns ``HEAD``."""
    criterion = result.row
    experiment = "" if criterion.experiment is None else f"{criterion.experiment:g} {criterion.unit}"
    why = f" ({criterion.why})" if criterion.why else ""
    return (
        criterion.what + why,
        result.reference_in_words,
        experiment.removesuffix(" 1"),
        result.value_in_words,
        result.distance_in_words,
        criterion.ours,
        result.band_in_words,
        result.verdict,
    )


def counts(verdicts: Sequence[str], of: str) -> str:
    """Return a sentence with the number of verdicts of each kind, the worst first."""
    counted = (f"{verdicts.count(name)} {name}" for name in WORST_FIRST if name in verdicts)
    return f"Of {len(verdicts)} {of}: {', '.join(counted)}."
