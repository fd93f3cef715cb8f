"""The command ``new``: it asks for what is not given, and writes the proposed case."""

from __future__ import annotations

import re
import shlex
import shutil
import sys
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from orchestrator.cli.console import CONSOLE, ERRORS, reported_errors

if TYPE_CHECKING:
    from orchestrator.case.file.errors import CaseProblem
    from orchestrator.cli.proposal.proposal import Proposal

OPTION = re.compile(r"--([a-z]+(?:-[a-z]+)*)")
NAME = re.compile(r"[A-Za-z0-9_][A-Za-z0-9_.-]{0,59}")


def new(
    context: typer.Context,
    folder: Annotated[Path, typer.Argument(metavar="NAME", help="new folder of the case")],
    template: Annotated[
        str | None, typer.Option(help="flip-flow, banana, crank-link or test-rig [default: flip-flow]")
    ] = None,
    width: Annotated[str | None, typer.Option(help='width of the deck, such as "2 m"')] = None,
    panels: Annotated[str | None, typer.Option(help="number of panels along the deck")] = None,
    length: Annotated[
        str | None, typer.Option(help="length of the whole deck [default: as the stroke wants it]")
    ] = None,
    slope: Annotated[
        str | None, typer.Option(help='slope, such as "20 deg", or slopes: "30 deg, 20 deg, 12 deg"')
    ] = None,
    opening: Annotated[str | None, typer.Option(help='width of the openings, such as "12 mm"')] = None,
    opening_length: Annotated[
        str | None, typer.Option(help="length of the openings [default: square]")
    ] = None,
    material: Annotated[str | None, typer.Option(help="material that is screened")] = None,
    shape: Annotated[
        str | None,
        typer.Option(
            help="shape of its grains: round, rounded, angular or flaky [default: as it usually has]"
        ),
    ] = None,
    moisture: Annotated[str | None, typer.Option(help="dry, moist, wet or sticky")] = None,
    throughput: Annotated[str | None, typer.Option(help='mass rate of the feed, such as "50 t/h"')] = None,
    feed: Annotated[
        str | None,
        typer.Option(
            help='sizes of the feed, such as "0-30 mm", or the file of a sieve analysis '
            "[default: 0 to 2.5 openings]"
        ),
    ] = None,
    cut: Annotated[
        str | None, typer.Option(help="size from which on a grain is coarse [default: that of the openings]")
    ] = None,
    speed: Annotated[str | None, typer.Option(help='speed of the shaft, such as "750 rpm"')] = None,
    stroke: Annotated[
        str | None,
        typer.Option(help='amplitude of the frames against each other along the deck, such as "6 mm"'),
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="take defaults, and ask nothing")] = False,
) -> None:
    """Begin a machine of your own: write a commented case that can be checked and run at once.

    Masses, unbalance and bushings follow from stroke and speed, and their distance from resonance is
    printed.  In a terminal it asks for what is not given.  Nothing is overwritten.
    """
    from orchestrator.case.file.errors import CaseProblem
    from orchestrator.cli.proposal.propose import find_refusals, propose
    from orchestrator.cli.proposal.wishes import QUESTIONS, ImpossibleWishes, find_wrong_answers, read_wishes

    options = ((name, context.params[name.replace("-", "_")]) for name in QUESTIONS)
    answers = {name: text for name, text in options if text is not None}
    with reported_errors(), _said_when_interrupted():
        problems = [*_wrong_folder(folder), *find_wrong_answers(template, answers)]
        if can_ask() and not yes and not problems:
            template, answers = _ask(template, answers)
            while refusals := find_refusals(template, answers):
                answers = _ask_again(template, answers, refusals)
            CONSOLE.print(f"the same without questions: {_command(folder, template, answers)}")
        taken = [] if yes or can_ask() else [*_defaults_taken(template, answers)]
        template = template or "flip-flow"
        if problems := [*_wrong_folder(folder), *find_refusals(template, answers)]:
            raise ImpossibleWishes(problems)
        proposal = propose(read_wishes(template, answers), str(folder))
        try:
            write_files(proposal.files, folder)
        except OSError as error:
            what = f"{folder} cannot be written: {error.strerror}"
            raise ImpossibleWishes([CaseProblem((), what, file="NAME", kind="file")]) from None
    if taken:
        CONSOLE.print(f"no terminal to ask in; taken: {shlex.join(taken)}")
    _report(proposal, folder)


@contextmanager
def _said_when_interrupted() -> Iterator[None]:
    """Say in a line that nothing is written when Ctrl-C, or the end of the input, ends the questions."""
    try:
        yield
    except (KeyboardInterrupt, typer.Abort):
        ERRORS.print("\ninterrupted: nothing is written")
        raise KeyboardInterrupt from None


def _defaults_taken(template: str | None, answers: Mapping[str, str]) -> Iterator[str]:
    """Yield the words of the options that are left to their defaults; options without a default are left
    out."""
    from orchestrator.cli.proposal.wishes import TEMPLATES, default_answer

    chosen = template or "flip-flow"
    if template is None:
        yield from ("--template", chosen)
    for name in TEMPLATES[chosen].asks if chosen in TEMPLATES else ():
        if not answers.get(name, "").strip() and (default := default_answer(chosen, name, answers)):
            yield from (f"--{name}", default)


def _wrong_folder(folder: Path) -> Iterator[CaseProblem]:
    """Yield a problem if a case cannot be written into a new folder of this name."""
    from orchestrator.case.file.errors import CaseProblem

    if not NAME.fullmatch(folder.name):
        hint = "letters, digits, _, - and dots make a name, at most 60"
        yield CaseProblem(
            (), f"{str(folder)!r} is not a name of a folder", hint, file="NAME", kind="wrong-type"
        )
    elif folder.exists() or folder.is_symlink():
        yield CaseProblem((), f"{folder} exists already", "take another name", file="NAME", kind="file")
    elif not (above := next(place for place in folder.absolute().parents if place.exists())).is_dir():
        yield CaseProblem((), f"{above} is not a folder", "take another place", file="NAME", kind="file")


def can_ask() -> bool:
    """Return whether somebody can answer questions."""
    return sys.stdin.isatty()


def _ask_again(template: str, answers: Mapping[str, str], refusals: Sequence[CaseProblem]) -> dict[str, str]:
    """Print why answers describe no possible machine, ask again for those that are named; return all answers.

    A refusal names its own option first and then those that may help.
    """
    named = set()
    for refusal in refusals:
        CONSOLE.print(str(refusal), markup=False)
        named |= set(OPTION.findall(str(refusal)))
    kept = {name: text for name, text in answers.items() if name not in named}
    return _ask(template, kept, offered=answers)[1]


def _ask(
    template: str | None, given: Mapping[str, str], offered: Mapping[str, str] | None = None
) -> tuple[str, dict[str, str]]:
    """Ask in the terminal for the template and for each wish that is not given; return all answers.

    The answers ``offered`` go before the template's defaults.  A wrong answer is explained, and the question
    is asked again.
    """
    from orchestrator.case.file.errors import CaseError
    from orchestrator.cli.proposal.wishes import (
        QUESTIONS,
        TEMPLATES,
        default_answer,
        read_answer,
        read_template,
    )

    def checked_template(text: str) -> str:
        try:
            read_template(text)
        except CaseError as error:
            raise typer.BadParameter(error.problems[0].what_helps) from None
        return text

    if template is None:
        for name, row in TEMPLATES.items():
            CONSOLE.print(f"  {name:<12}{row.about}")
        template = typer.prompt("Which kind of machine?", default="flip-flow", value_proc=checked_template)
    read_template(template)
    answers = dict(given)
    for name in TEMPLATES[template].asks:
        if name in answers:
            continue

        def checked(text: str, name: str = name) -> str:
            try:
                read_answer(name, text)
            except CaseError as error:
                raise typer.BadParameter("; ".join(row.what_helps for row in error.problems)) from None
            return text

        default = (offered or {}).get(name) or default_answer(template, name, answers)
        answers[name] = typer.prompt(
            QUESTIONS[name].sentence, default=default, show_default=bool(default), value_proc=checked
        )
    return template, answers


def _command(folder: Path, template: str, answers: Mapping[str, str]) -> str:
    given = {"template": template} | {name: text.strip() for name, text in answers.items()}
    words = [word for name, text in given.items() if text for word in (f"--{name}", text)]
    return shlex.join(["flipflow", "new", str(folder), *words, "--yes"])


def write_files(files: Mapping[str, str], folder: Path) -> None:
    """Write the files of a case into a new folder, which appears when all are written."""
    unfinished = folder.with_name(f".{folder.name}.unfinished")
    try:
        for name, text in files.items():
            file = unfinished / name
            file.parent.mkdir(parents=True, exist_ok=True)
            file.write_text(text, encoding="utf-8")
        unfinished.rename(folder)
    finally:
        shutil.rmtree(unfinished, ignore_errors=True)


def _report(proposal: Proposal, folder: Path) -> None:
    """Print what is proposed, and the next commands."""
    from orchestrator.preflight.cost import in_words

    CONSOLE.print(f"{folder.name}: {proposal.wishes.title}")
    for line in proposal.remarks:
        CONSOLE.print(f"  {line}")
    CONSOLE.print(f"written: {folder} with {', '.join(proposal.files)}")
    path = shlex.quote(str(folder))
    CONSOLE.print(f"next:  flipflow check {path}")
    CONSOLE.print(f"       flipflow run {path}    # level draft, about {in_words(proposal.run_s['draft'])}")
