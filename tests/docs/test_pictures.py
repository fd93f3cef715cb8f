"""The pictures of the theory pages are those that docs/pictures draws."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
STORED = ROOT / "docs" / "images" / "theory"
HASH = re.compile(r"[\"#][a-z]*[0-9a-f]{10}\b")
NUMBER = re.compile(r"-?\d+\.?\d*(?:e-?\d+)?")


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("pictures")
    command = [sys.executable, ROOT / "docs" / "pictures" / "draw.py", "--out", folder]
    done = subprocess.run(command, capture_output=True, encoding="utf-8")
    assert done.returncode == 0, done.stderr
    return folder


def test_every_picture_is_stored_and_shown(drawn: Path) -> None:
    names = {file.name for file in drawn.iterdir()}
    assert names == {file.name for file in STORED.iterdir()}
    pages = "".join(page.read_text(encoding="utf-8") for page in (ROOT / "docs" / "theory").glob("*.md"))
    assert all(f"../images/theory/{name}" in pages for name in names)


@pytest.mark.parametrize("name", sorted(file.name for file in STORED.iterdir()))
def test_the_stored_picture_is_the_drawn_one(drawn: Path, name: str) -> None:
    """The pictures agree up to the last digits of numbers, which differ from processor to processor."""
    before, after = (HASH.sub("", (at / name).read_text(encoding="utf-8")) for at in (STORED, drawn))
    again = f"python docs/pictures/draw.py {Path(name).stem}"
    assert NUMBER.sub("#", before) == NUMBER.sub("#", after), again
    pairs = zip(NUMBER.findall(before), NUMBER.findall(after), strict=True)
    assert all(abs(float(number) - float(other)) < 0.01 for number, other in pairs), again


def test_every_theory_page_has_a_picture_and_sources() -> None:
    for page in (ROOT / "docs" / "theory").glob("*.md"):
        text = page.read_text(encoding="utf-8")
        assert re.search(r"^!\[.+\]\(\.\./images/.+\)$", text, re.M), page.name
        assert "\n## Sources\n" in text, page.name
        assert "\n## Validity\n" in text, page.name
