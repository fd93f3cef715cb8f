"""A comparison of cases with the numbers of the papers that they come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from orchestrator.studies.criteria import FILE, read_criteria
from orchestrator.studies.points import CaseStudy
from orchestrator.studies.report import markdown_table
from orchestrator.studies.verdicts import CaseCriteria, CriterionResult, case_criteria
from orchestrator.workbench import CaseError, CaseProblem, StudyFolder

HEAD = ("number", "published", "experiment", "ours", "distance", "ours is", "band", "verdict")


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
        what = f"is no case, and has no case with a source in {FILE}"
        raise CaseError([CaseProblem((), what, "docs/criteria.md", str(study.case), kind="file")])
    return papers


def of_case(study: CaseStudy) -> CaseCriteria:
    """Return the criteria of a study's case, at the level of the study or of the criteria.

    Raises CaseError.
    """
    return case_criteria(replace(study, level=study.level or read_criteria(study.case).level or None))


def write_paper(
    results: Sequence[tuple[CaseCriteria, Sequence[CriterionResult]]], study: CaseStudy
) -> list[Path]:
    """Write ``paper.md`` and ``paper.html``: every published number beside ours, and return both files."""
    every = [result for _, of_case in results for result in of_case]
    parts = [(paper, counts(of_case), [row(result) for result in of_case]) for paper, of_case in results]
    text = [
        "# Published numbers and ours",
        f"`flipflow study paper {study.case}` makes this page. {counts(every)}",
        "*Met* and *NOT MET* are verdicts on numbers that were **predicted**: no value of the case was "
        "chosen to meet them. A number that is *fitted*, *published* or *assumed* proves nothing. "
        "*As own theory* compares with a closed form of our own, not with a measurement. *Chance* stands for "
        "an effect that the paper's own data do not tell from chance. Intervals are 95 % confidence "
        "intervals of our runs; they do not contain what a case assumes.",
    ]
    for paper, counted, rows in parts:
        level = f", level {paper.level}" if paper.level else ""
        text += [f"## {paper.name}{level}", f"{paper.criteria.source}. {counted}"]
        text.append(markdown_table(HEAD, rows))
    folder = StudyFolder(study.folder)
    file = folder.write_text("paper.md", "\n\n".join(part.rstrip() for part in text) + "\n")
    page = folder.write_page("paper.html", "paper.html", parts=parts, counts=counts(every), head=HEAD)
    return [file, page]


def row(result: CriterionResult) -> tuple[str, ...]:
    """Return the words of one number for a table with the columns ``HEAD``."""
    criterion = result.row
    known = (criterion.reference, criterion.experiment)
    published = ("" if value is None else f"{value:g} {criterion.unit}".removesuffix(" 1") for value in known)
    why = f" ({criterion.why})" if criterion.why else ""
    return (
        criterion.what + why,
        *published,
        result.value_in_words,
        result.distance_in_words,
        criterion.ours,
        result.band_in_words,
        result.verdict,
    )


def counts(results: Sequence[CriterionResult]) -> str:
    """Return a sentence with the number of results of each verdict."""
    verdicts = [result.verdict for result in results]
    counted = (f"{verdicts.count(name)} {name}" for name in dict.fromkeys(verdicts))
    return f"Of {len(verdicts)} numbers: {', '.join(counted)}."
