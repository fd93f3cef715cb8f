"""``flipflow study paper``: a comparison of cases with the numbers of the papers that they come from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer

from orchestrator.case.file.base import CASE_FILE
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.file.whole import write_text
from orchestrator.output.records.run_folder import study_folder
from orchestrator.studies.commands.sweep import write_sweep
from orchestrator.studies.criteria import FILE, read_criteria
from orchestrator.studies.options import StudyOutput, check_folder
from orchestrator.studies.points import CaseStudy
from orchestrator.studies.report import markdown_table, write_csv, write_page
from orchestrator.studies.verdicts import CaseCriteria, CriterionResult, case_criteria, verdict_table

HEAD = ("number", "published", "experiment", "ours", "distance", "ours is", "band", "verdict")


def command(
    study: CaseStudy,
    dry: Annotated[
        bool, typer.Option("--dry", help="make no run, and judge the runs that are there")
    ] = False,
) -> StudyOutput:
    """Compare cases with the papers they come from: printed number, computed number, and distance.

    CASE is a case with criteria.toml, or a folder of cases: then all cases whose criteria.toml names a
    source are compared, each at the level that it names.  The criteria have the paper's numbers, their
    acceptance bands, and the runs that they need; finished runs are not made again.  A number that is
    fitted, published or assumed proves nothing and is marked so.  The folder gets paper.csv, paper.md
    and paper.html, and sweep.csv and sweep.png of every varied key.

    Exit code 4: a run failed, or a predicted number is out of its band.
    """
    papers = find_papers(study)
    if not dry:
        yield from study.run([point for paper, _ in papers for point in paper.points])
    results = [(paper, paper.results()) for paper, _ in papers]
    for paper, of_case in results:
        yield verdict_table(f"{paper.name}: {paper.criteria.source}", of_case)
    with study_folder(study.folder):
        for paper, folder in papers:
            for name, runs in paper.runs.items():
                if runs.vary and not dry:
                    yield from write_sweep(runs.vary, runs.points, folder / name)
        every = [result for _, of_case in results for result in of_case]
        yield write_csv([each.cells for each in every], study.folder / "paper.csv")
        yield from write_paper(results, study)
    return all(result.is_good for result in every)


def find_papers(study: CaseStudy) -> list[tuple[CaseCriteria, Path]]:
    """Return the criteria of a study's case, or of all cases of its folder that name a source.

    Each comes with the folder of its runs; nothing is run here.  Raises CaseError with the problems of all
    cases, or if there is no case to compare, and FolderUnusable where the runs would go into a case's folder.
    """
    if study.case.is_file() or (study.case / CASE_FILE).is_file():
        return [(of_case(study), study.folder)]
    papers, problems = [], []
    for file in sorted(study.case.glob(f"*/{FILE}")):
        case = file.parent
        try:
            if read_criteria(case).source:
                own = replace(study, case=case, out=study.folder / case.name)
                check_folder(own.folder, study.name)
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
    write_text(study.folder / "paper.md", "\n\n".join(part.rstrip() for part in text) + "\n")
    page = write_page(
        "commands/paper.html", study.folder / "paper.html", parts=parts, counts=counts(every), head=HEAD
    )
    return [study.folder / "paper.md", page]


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
