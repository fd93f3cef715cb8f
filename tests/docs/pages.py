"""Code that stands on a page of the documentation."""

from __future__ import annotations

import re
from pathlib import Path

DOCS = Path(__file__).parents[2] / "docs"


def code_on(page: str, language: str = "python") -> list[str]:
    """The blocks of code in a language, in their order."""
    text = (DOCS / page).read_text(encoding="utf-8")
    return re.findall(rf"^```{language}\n(.*?)^```$", text, flags=re.DOTALL | re.MULTILINE)


def installed(folder: Path, page: str, module: str) -> str:
    """Installs the first block of a page into a folder, as the page's entry point names it; returns
    the Python that lets a process find it."""
    ((group, entry),) = re.findall(
        r'entry-points\."(.*?)"\]\n(.*?)\n```', (DOCS / page).read_text(encoding="utf-8")
    )
    (folder / f"{module}.py").write_text(code_on(page)[0])
    about = folder / f"{module}-1.0.dist-info"
    about.mkdir()
    (about / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {module}\nVersion: 1.0\n")
    (about / "entry_points.txt").write_text(f"[{group}]\n{entry.replace(chr(34), '')}\n")
    return f"import sys; sys.path.insert(0, {str(folder)!r})"
