"""The build of the site: pages are staged beside each other, and MkDocs turns them into HTML."""

from __future__ import annotations

import re
import shutil
import tempfile
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import latex2mathml.converter
from mkdocs.commands.build import build
from mkdocs.config import load_config
from mkdocs.structure.pages import Page

from orchestrator.preflight.judge import load_judged
from orchestrator.views.drawings import SIDE, draw_view
from orchestrator.views.outline import outline

ROOT = Path(__file__).parents[2]
FRONT = ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md")
LINK = re.compile(r"\]\(([^)\s#]+)[^)\s]*\)")
FENCED = re.compile(r"^```.*?^```", re.M | re.S)
QUOTED_MATH = re.compile(r"\$`(.+?)`\$")  # a way to write an equation that hosts of repositories know
MATH = re.compile(r'<(span|div) class="arithmatex">\\([(\[])(.*?)\\[)\]]</\1>', re.S)
ENTITIES = {"&amp;": "&", "&lt;": "<", "&gt;": ">"}
API = "docs/python.md"
GALLERY = "docs/gallery.md"


def build_site(out: Path) -> Path:
    """Make the site in a folder, whatever was in it before, and return its first page.

    Raises mkdocs.exceptions.Abort if a page has a warning: a link or an anchor that leads nowhere, a page
    that is in no part of the navigation.
    """
    with tempfile.TemporaryDirectory(prefix="flipflow-site-") as folder:
        stage = Path(folder) / "pages"
        stage_pages(stage)
        config = load_config(
            str(ROOT / "tools/site/mkdocs.yml"),
            docs_dir=str(stage),
            site_dir=str(out.resolve()),
            nav=navigation(stage),
            strict=True,
        )
        config.plugins.run_event("startup", command="build", dirty=False)
        config.plugins._register_event("page_content", _equations_as_mathml)
        build(config)
        config.plugins.run_event("shutdown")
    return out / "index.html"


def stage_pages(stage: Path) -> None:
    """Copy all pages and what they link into the folder ``stage``, and write the gallery and the reference
    there.
    """
    pages = [ROOT / name for name in FRONT]
    pages += [*ROOT.glob("docs/**/*.md"), *ROOT.glob("cases/**/README.md")]
    (stage / "docs").mkdir(parents=True)
    shutil.copyfile(ROOT / "tools/site/equations.css", stage / "equations.css")
    for page in pages:
        text = page.read_text(encoding="utf-8")
        _copy(page, stage)
        (stage / page.relative_to(ROOT)).write_text(QUOTED_MATH.sub(r"$\1$", text), encoding="utf-8")
        for target in LINK.findall(FENCED.sub("", text)):
            linked = (page.parent / target).resolve()
            if linked.is_file() and linked.suffix != ".md":
                _copy(linked, stage)
    (stage / "LICENSE").rename(stage / "LICENSE.txt")  # a browser shows it, and the links say so
    _replace(stage / "README.md", "](LICENSE)", "](LICENSE.txt)")
    (stage / API).write_text("# Python package\n\n::: flipflow\n", encoding="utf-8")
    (stage / GALLERY).write_text("\n".join(_gallery(stage)), encoding="utf-8")


def navigation(stage: Path) -> list[Any]:
    """Return the navigation of the site: the parts of the documentation with all their pages."""

    def pages(pattern: str, first: str = "") -> list[str]:
        found = sorted(str(file.relative_to(stage)) for file in stage.glob(pattern))
        return sorted(found, key=lambda name: not (first and name.endswith(first)))

    manuals = [name for name in pages("docs/*.md") if name not in (GALLERY, API, "docs/README.md")]
    return [
        {"flipflow": ["README.md", "docs/README.md"]},
        {"How to": [*pages("docs/how-to/*.md"), "docs/examples/README.md"]},
        {"Cases": [{"Gallery": GALLERY}, *pages("cases/**/README.md")]},
        {"Manuals": [*manuals, {"Python package": API}]},
        {"Theory": pages("docs/theory/*.md")},
        {"Measured": pages("docs/measured/*.md", first="README.md")},
        {"Project": ["ARCHITECTURE.md", "CONTRIBUTING.md", "CHANGELOG.md"]},
    ]


def _gallery(stage: Path) -> Iterator[str]:
    """Yield the lines of a page that has the title and a picture of each case: the first of its own page, or
    else the side view, which is drawn into the folder ``stage``."""
    yield "# Gallery of cases\n"
    for page in sorted(ROOT.glob("cases/**/README.md")):
        case = page.parent
        title = tomllib.loads((case / "case.toml").read_text(encoding="utf-8")).get("title", case.name)
        name = str(case.relative_to(ROOT / "cases"))
        yield f"## [{name}](../cases/{name}/README.md)\n"
        yield f"{title}.\n"
        targets = LINK.findall(page.read_text(encoding="utf-8"))
        if pictures := [target for target in targets if target.endswith(".png")]:
            place = (case / pictures[0]).resolve().relative_to(ROOT)
        else:
            place = Path("docs/images/cases") / f"{name.replace('/', '-')}.png"
            _draw_side_view(case, stage / place)
        yield f"![{name}](../{place}){{ width=480 }}\n"


def _draw_side_view(case: Path, file: Path) -> None:
    file.parent.mkdir(parents=True, exist_ok=True)
    loaded = load_judged(case)
    draw_view(outline(loaded.case.whole_machine, loaded.folder), SIDE).savefig(file, dpi=100)


def _equations_as_mathml(html: str, page: Page, **_: Any) -> str:
    """Return a page whose equations are MathML, which browsers draw without a script or a network."""

    def convert(found: re.Match[str]) -> str:
        latex = found[3]
        for entity, letter in ENTITIES.items():
            latex = latex.replace(entity, letter)
        display = "block" if found[2] == "[" else "inline"
        return str(latex2mathml.converter.convert(latex, display=display))

    return MATH.sub(convert, html)


def _copy(file: Path, stage: Path) -> None:
    copy = stage / file.relative_to(ROOT)
    copy.parent.mkdir(parents=True, exist_ok=True)
    shutil.copyfile(file, copy)


def _replace(file: Path, before: str, after: str) -> None:
    file.write_text(file.read_text(encoding="utf-8").replace(before, after), encoding="utf-8")
