"""The draft of a paper keeps the journal's rules, cites what its list has, and counts facts as measured."""

from __future__ import annotations

import re

from tests.docs.pages import DOCS

PAPER = (DOCS.parent / "paper/paper.md").read_text(encoding="utf-8")
LIST = (DOCS.parent / "paper/paper.bib").read_text(encoding="utf-8")
SECTIONS = [
    "Summary",
    "Statement of need",
    "State of the field",
    "Software design",
    "Research impact statement",
    "AI usage disclosure",
    "Acknowledgements",
    "References",
]
"""By "JOSS Paper Format" of the Journal of Open Source Software, read in November 2026."""
WORDS = range(750, 1751)


def test_it_has_the_sections_and_the_length() -> None:
    assert re.findall(r"^# (.+)$", PAPER, re.M) == SECTIONS
    body = re.sub(r"<!--.*?-->", "", PAPER.split("\n---\n", 1)[1], flags=re.S)
    assert len(body.split()) in WORDS


def test_it_cites_what_its_list_has() -> None:
    assert set(re.findall(r"@(\w+\d{4})", PAPER)) == set(re.findall(r"^@\w+\{(\w+),", LIST, re.M))
    assert len(re.findall(r"^  doi +=", LIST, re.M)) == len(re.findall(r"^@", LIST, re.M))


def test_it_counts_facts_as_the_measured_page_does() -> None:
    measured = (DOCS / "measured/papers.md").read_text(encoding="utf-8")
    facts, missed = re.search(r"Of (\d+) facts: (\d+) NOT MET", measured).groups()  # type: ignore[union-attr]
    assert f"Of {facts} facts, {missed} are not met." in " ".join(PAPER.split())
