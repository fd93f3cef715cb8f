"""The commands' common part: a study's file, its folder, its runs, and all that is written of it."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from rich.table import Table

from orchestrator.studies.design.campaign import SAME, Campaign
from orchestrator.studies.design.findings import Findings
from orchestrator.studies.design.page import answers, borders, doubts, write_study_page
from orchestrator.studies.design.pictures import draw_all
from orchestrator.studies.design.runs import Runs
from orchestrator.studies.design.study_file import Study, StudyError
from orchestrator.studies.design.table_data import read_published, read_table
from orchestrator.studies.design.tables import term_name, write_recommended, write_tables
from orchestrator.studies.design.trials import Journal, Outcome
from orchestrator.studies.points import CaseStudy, Crew, Point
from orchestrator.workbench import CaseProblem, FolderUnusable, StudyFolder
from orchestrator.workbench.vocabulary import Array, console_table, in_words, read_toml

RUNS = "runs"  # folder of the runs, in the study's folder


class DesignStudy:
    """A study with its folder."""

    def __init__(self, study: Study, crew: Crew, out: Path | None) -> None:
        self.study = study
        self.folder = StudyFolder(out or Path("runs") / study.name).admit()
        self._check_folder()
        self._case = CaseStudy(
            study.path(study.file.case), study.file.level or None, (), self.folder / RUNS, crew
        )
        self.runs = Runs(study, self._case)
        self.campaign = Campaign(study, self.runs, Journal(self.folder / RUNS))

    def _check_folder(self) -> None:
        """Raise FolderUnusable where the folder has a study of another case or table."""
        stored, file = self.folder / "study.toml", self.study.file
        if stored.exists() and not stored.samefile(self.study.source):
            before = read_toml(stored)
            source = str(before.get("case") or before.get("table"))
            if (self.folder / source).resolve().name != self.study.path(file.case or file.table).name:
                what = f"is the folder of a study of {source}; give another one with --out"
                raise FolderUnusable(f"{self.folder}: {what}")

    def check(self) -> None:
        """Check that there is a case to run, that published tables can be read, and every corner as a case.

        Raises StudyError or CaseError with what is wrong.
        """
        if self.study.file.table:
            hint = "flipflow study fit takes it"
            raise StudyError([CaseProblem(("table",), "the data of a table cannot be run", hint)])
        read_published(self.study)
        self.runs.check()

    def run(self, search: bool) -> Iterator[str]:
        """Check the study, run the centre, the plan and, with ``search``, the search and the
        confirming runs; yield a line for each.

        Raises StudyError as :meth:`check`, and where the centre does not have a response.
        """
        self.check()
        with StudyFolder(self.folder).lock():
            for outcome in self.campaign.run(search):
                self._check_first(outcome)
                yield self._line(outcome, search)

    def planned_points(self) -> list[Point]:
        """Check the study, write down the trials of the centre and the plan, and return their runs.

        Raises StudyError as :meth:`check`.
        """
        self.check()
        with StudyFolder(self.folder).lock():
            return self.runs.points(self.campaign.store_planned())

    def _check_first(self, outcome: Outcome) -> None:
        """Raise StudyError where the centre lacks a response: all other runs would, too."""
        missing = [name for name in self.study.file.responses if name not in outcome.responses]
        if outcome.trial.stage == "centre" and (missing or not outcome.is_data):
            folder = self.folder / RUNS / outcome.trial.name
            what = f"the run of the centre ({folder}) does not tell {', '.join(missing)}"
            if not outcome.is_data:
                what = f"the run of the centre ({folder}) gives no data: {outcome.why}"
            hint = "look at its report; nothing else was run"
            raise StudyError([CaseProblem(("responses",), what, hint)])

    def _line(self, outcome: Outcome, search: bool) -> str:
        """Return what is said when a run has ended, with the time left after the stored ones."""
        said = ", ".join(f"{name} {each.value:.4g}" for name, each in outcome.responses.items())
        line = f"{outcome.trial.name} {outcome.trial.stage}: {said or outcome.status}"
        if best := self.campaign.best_so_far():
            line += f"; best so far {best}"
        if outcome.not_steady:
            line += f"; not steady: {outcome.not_steady}"
        if outcome.why:
            line += f"; no data: {outcome.why}"
        return line + (self._time_left(search) if outcome.trial.number >= self.campaign.stored else "")

    def _time_left(self, search: bool) -> str:
        """Return the predicted time to the end: of the runs to come, but not more than the hours allow."""
        each_s, hours = self.campaign.mean_wall_s(), self.study.file.hours
        left = self.campaign.trials_left(search) - self.campaign.beyond_hours(each_s)
        left_s = left * each_s / self.runs.side_by_side
        if not left_s:
            return ""
        if hours is not None and left_s > (budget_s := max(0.0, 3600.0 * hours - self.campaign.spent_s())):
            return f"; {in_words(budget_s)} of the {hours:g} h left"
        return f"; {'1 more run' if left == 1 else f'{left} more runs'}, {in_words(left_s)}"

    def load_finished(self) -> None:
        """Take the outcomes of the table, or of the runs that have ended; nothing is run.

        Raises StudyError where the table or a published one cannot be read.
        """
        read_published(self.study)
        if self.study.file.table:
            self.campaign.outcomes = read_table(self.study)
        else:
            self.campaign.outcomes = self.runs.finished(self.campaign.read_trials())

    def check_data(self) -> None:
        """Raise FolderUnusable where there are no data at all."""
        if not len(self.campaign.data().x):
            raise FolderUnusable(self._why_no_data())

    def _why_no_data(self) -> str:
        outcomes = self.campaign.outcomes
        if outcomes:
            return f"{self.folder}: none of {len(outcomes)} runs is data; the first: {outcomes[0].why}"
        return f"{self.folder}: there are no data yet; flipflow study design makes the first runs"

    def _check_ranges(self, x: Array) -> None:
        """Raise StudyError where none of the settings ``x``, (n, factors), coded, lies within the ranges."""
        outside = np.abs(x) > 1.0 + SAME
        if outside.any(axis=1).all():
            number = int(outside.sum(axis=0).argmax())
            name, values = list(self.study.file.factors)[number], self.study.space.actual(x)[:, number]
            what = f"no data within all ranges: {name} is {values.min():g} to {values.max():g} there"
            key = ("factors", name, "range")
            raise StudyError([CaseProblem(key, what, "compare the units, or widen the range")])

    def write(self) -> Iterator[str | Table | Path]:
        """Write tables, pictures and the page from the outcomes; yield what is said and the files.

        Raises FolderUnusable where there are no data at all, and StudyError where all lie out of the ranges.
        """
        self.check_data()
        findings = Findings(self.campaign)
        self._check_ranges(findings.data.x)
        yield from write_tables(findings, self.folder)
        if self.study.file.case:
            yield from write_recommended(findings, self.runs.centre, self.folder)
        pictures = draw_all(findings, self.folder)
        yield from pictures.values()
        yield write_study_page(findings, pictures, self.folder)
        yield from fit_tables(findings)
        yield from answers(findings)
        yield from doubts(findings)
        yield from borders(findings)


def fit_tables(findings: Findings) -> Iterator[str | Table]:
    """Yield the quality of the surrogates and the quadratic surfaces, for the terminal."""
    head = ["surrogate", *(f"{name}: {what}" for name in findings.responses for what in ("Q2", "in 95 %"))]
    rows = []
    for each in findings.surrogates:
        cells = [
            text
            for q2, share in zip(each.explained, each.coverage, strict=True)
            for text in (f"{q2:.3f}", f"{100 * share:.0f} %")
        ]
        rows.append([each.name, *(cells or [each.why_not, *[""] * (len(head) - 2)])])
    yield console_table("predicting each run from all other settings", head, rows, left=head[1:2])
    for name, surface in findings.quadratic.items():
        quality = surface.quality()
        yield (
            f"quadratic surface of {name}: R2 {quality['r2']:.6f}, adjusted {quality['r2_adjusted']:.6f}, "
            f"predicted {quality['r2_predicted']:.6f}, standard error {quality['standard_error']:.6g}"
        )
        factors = list(findings.campaign.study.file.factors)
        lines = [
            [
                term_name(row["term"], factors),
                f"{row['coefficient']:.6g}",
                f"{row['f']:.5g}",
                f"{row['p']:.3g}",
            ]
            for row in surface.anova()
        ]
        if (lack := surface.lack_of_fit()) is not None:
            lines.append(["lack of fit", "", f"{lack['f']:.5g}", f"{lack['p']:.3g}"])
        yield console_table("", ["term", "coefficient", "F", "p"], lines)
