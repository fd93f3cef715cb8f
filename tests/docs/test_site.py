"""The documentation becomes a site without a warning, and its pages need no network."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import flipflow
from tools.site import __main__ as site

ROOT = Path(__file__).parents[2]
LOADED = re.compile(r'<(?:script[^>]*?src|img[^>]*?src|link[^>]*?href)="([^"]+)"')


@pytest.mark.process
@pytest.mark.slow
def test_the_site_is_made_without_a_warning(tmp_path: Path) -> None:
    command = [sys.executable, "-m", "tools.site", str(tmp_path / "site")]
    done = subprocess.run(command, capture_output=True, encoding="utf-8", cwd=ROOT)
    assert done.returncode == 0, done.stdout + done.stderr
    pages = {str(page.relative_to(tmp_path / "site")): page for page in (tmp_path / "site").rglob("*.html")}
    assert {"index.html", "docs/gallery.html", "docs/python.html", "docs/theory/coupling.html"} <= set(pages)
    for name, page in pages.items():
        text = page.read_text(encoding="utf-8")
        assert "\\(" not in re.sub(r"<(pre|code|script).*?</\1>", "", text, flags=re.S), (
            f"{name}: an equation is left"
        )
        for target in LOADED.findall(text):
            assert not re.match(r"(https?:)?//", target), f"{name} loads {target}"
    assert "<math" in pages["docs/theory/coupling.html"].read_text(encoding="utf-8")
    gallery = pages["docs/gallery.html"].read_text(encoding="utf-8")
    cases = len([*ROOT.glob("cases/**/README.md")])
    assert len(re.findall(r"<h2 ", gallery)) == len(re.findall(r"<img ", gallery)) == cases > 30
    reference = pages["docs/python.html"].read_text(encoding="utf-8")
    for name in (*flipflow.__all__, "Case.change", "Run.history"):
        assert f'id="flipflow.{name}"' in reference, f"the reference lacks {name}"


def test_the_command_takes_a_folder_and_explains_itself(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    made: list[Path] = []
    monkeypatch.setattr(site, "build_site", lambda out: made.append(out) or out / "index.html")
    for words in (["--help"], ["--out", "there"]):
        with pytest.raises(SystemExit):
            site.main(words)
    assert "python -m tools.site" in capsys.readouterr().out
    assert made == []
    site.main([])
    site.main([str(tmp_path)])
    assert made == [site.OUT, tmp_path]
