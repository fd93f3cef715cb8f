"""The documents name what is there: links and their headings, files and folders, pages named in code."""

from __future__ import annotations

import re
from collections.abc import Iterator
from fnmatch import fnmatch
from functools import cache
from pathlib import Path

import pytest

from orchestrator.output.records.snapshots import STATE

ROOT = Path(__file__).parents[2]
FOLDERS = "orchestrator|adapters|tests|cases|docs|docker|meshes"
PATH = re.compile(rf"`((?:{FOLDERS})/[\w./*<>\[\]-]+)`")
SOURCE = re.compile(r"`([\w/*-]+\.(?:py|cpp|h))`")
FENCED = re.compile(r"^```.*?^```", re.M | re.S)


@cache
def written(*patterns: str) -> list[Path]:
    """The files of the project that match, without what is installed, built or computed."""
    places = [ROOT, *(ROOT / folder for folder in FOLDERS.split("|"))]
    files = [file for place in places[1:] for pattern in patterns for file in place.rglob(pattern)]
    return sorted([*files, *(file for pattern in patterns for file in ROOT.glob(pattern))])


PAGES = [page for page in written("*.md") if page.parent.name != "cli"]  # parts of docs/case-format.md


@cache
def anchors(page: Path) -> set[str]:
    """The anchors that GitHub gives to the headings of a page."""
    names = set()
    for line in FENCED.sub("", page.read_text(encoding="utf-8")).splitlines():
        if line.startswith("#"):
            title = re.sub(r"[`*$]", "", line.lstrip("#").strip()).lower()
            names.add(re.sub(r"[^\w\- ]", "", title).replace(" ", "-"))
    return names


def links(page: Path) -> Iterator[str]:
    for target in re.findall(r"\]\(([^)\s]+)\)", FENCED.sub("", page.read_text(encoding="utf-8"))):
        if not re.match(r"[a-z]+:", target):
            yield target


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(ROOT)) for page in PAGES])
def test_links_lead_somewhere(page: Path) -> None:
    for target in links(page):
        name, _, anchor = target.partition("#")
        file = (page.parent / name).resolve() if name else page
        assert file.exists(), target
        if anchor:
            assert anchor in anchors(file), target


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(ROOT)) for page in PAGES])
def test_files_that_are_named_are_there(page: Path) -> None:
    if page.parent.name == "how-to":
        return  # some are the reader's, yet to be written
    for path in PATH.findall(page.read_text(encoding="utf-8")):
        if "<" not in path:
            assert list(ROOT.glob(path.rstrip("/."))), path


@pytest.mark.parametrize("page", PAGES, ids=[str(page.relative_to(ROOT)) for page in PAGES])
def test_sources_that_are_named_without_their_folder_are_there(page: Path) -> None:
    """The sources are named as ``shaking.py``, or ``exudyn/shaft.py``; a run's folder has one of its own."""
    if page.parent.name == "how-to":
        return  # the files of an example are the reader's
    files = [f"/{file.relative_to(ROOT)}" for file in written("*.py", "*.cpp", "*.h")]
    files.append(f"/{STATE}")
    for name in SOURCE.findall(page.read_text(encoding="utf-8")):
        assert any(fnmatch(file, f"*/{name}") for file in files), name


def test_the_architecture_names_rooms_and_calls_that_are_there() -> None:
    page = (ROOT / "ARCHITECTURE.md").read_text(encoding="utf-8")
    rooms = "cli|run|studies|output|coupling|preflight|case|ports"
    for path in re.findall(rf"`((?:{rooms})/[\w./]+)`", page):
        assert (ROOT / "orchestrator" / path).exists(), path
    for path, call in re.findall(r"^\| \w+ \| `([\w/.]+)`, `(\w+)` \|", page, re.M):
        text = (ROOT / "orchestrator" / path).read_text(encoding="utf-8")
        assert re.search(rf"^(?:def|class) {call}\b", text, re.M), f"{path}: {call}"


def test_pages_that_code_names_are_there() -> None:
    missing = []
    for file in written("*.py", "*.toml", "*.cpp", "*.h", "*.html", "*.sh"):
        for page in re.findall(r"\bdocs/[\w./-]+\.md\b", file.read_text(encoding="utf-8")):
            if not (ROOT / page).is_file():
                missing.append(f"{file.relative_to(ROOT)}: {page}")
    assert not missing
