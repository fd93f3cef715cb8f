"""A page in a real browser: what it shows, says and asks for."""

from __future__ import annotations

import re
import shutil
import subprocess
from dataclasses import dataclass
from html.parser import HTMLParser
from pathlib import Path

NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome")
PROBE = """
<script>
const said = document.documentElement.dataset;
said.errors = "";
addEventListener("error", event => { said.errors += event.message; }, true);
addEventListener("load", () => {
  said.images = [...document.images].map(i => `${i.naturalWidth}x${i.naturalHeight}`).join(" ");
  const fetched = performance.getEntriesByType("resource").map(entry => entry.name);
  said.asked = fetched.filter(name => !name.startsWith("data:")).join(" ");
  said.overflow = document.documentElement.scrollWidth - document.documentElement.clientWidth;
});
</script>
"""


@dataclass(frozen=True)
class Seen:
    """``images`` sizes in pixels as decoded; ``asked`` addresses that were fetched; ``overflow``
    pixels by which the page is wider than the window; ``log`` what the browser's console said;
    ``tables`` the cells of each table."""

    images: list[tuple[int, int]]
    asked: list[str]
    errors: str
    overflow: int
    log: list[str]
    tables: list[list[str]]
    screenshot: Path


def browser() -> str | None:
    """Its path, if one is installed."""
    return next((path for name in NAMES if (path := shutil.which(name))), None)


def seen(page: Path, place: Path) -> Seen:
    """Opens the page, with a script that notes what happens, in a window of a laptop's width."""
    copy, picture = place / "seen.html", place / "seen.png"
    copy.write_text(page.read_text().replace("<head>", "<head>" + PROBE, 1))
    dom = _run("--dump-dom", "--enable-logging=stderr", f"file://{copy}")
    _run(f"--screenshot={picture}", "--window-size=1280,5000", f"file://{page}")
    data = {key: _attribute(dom.stdout, key) for key in ("images", "asked", "errors", "overflow")}
    cells = Cells()
    cells.feed(dom.stdout)
    return Seen(
        [(int(w), int(h)) for w, h in re.findall(r"(\d+)x(\d+)", data["images"])],
        data["asked"].split(),
        data["errors"],
        int(data["overflow"]),
        [line for line in dom.stderr.splitlines() if ":CONSOLE" in line],
        cells.tables,
        picture,
    )


def _run(*words: str) -> subprocess.CompletedProcess[str]:
    path = browser()
    assert path is not None
    options = ("--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars")
    options += ("--virtual-time-budget=4000", "--window-size=1280,900")
    done = subprocess.run(
        [path, *options, *words], capture_output=True, encoding="utf-8", timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return done


def _attribute(dom: str, name: str) -> str:
    match = re.search(rf'<html[^>]* data-{name}="([^"]*)"', dom)
    return match.group(1) if match else ""


class Cells(HTMLParser):
    """Text of the cells of every table."""

    def __init__(self) -> None:
        super().__init__()
        self.tables: list[list[str]] = []
        self._inside = False

    def handle_starttag(self, tag: str, attrs: object) -> None:
        if tag == "table":
            self.tables.append([])
        if tag in ("td", "th"):
            self._inside = True
            self.tables[-1].append("")

    def handle_endtag(self, tag: str) -> None:
        if tag in ("td", "th"):
            self._inside = False

    def handle_data(self, data: str) -> None:
        if self._inside:
            self.tables[-1][-1] += data.strip()
