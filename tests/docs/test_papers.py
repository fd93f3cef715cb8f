"""docs/measured/papers.md is the page that the command makes of the recorded numbers."""

from __future__ import annotations

from pathlib import Path

import pytest

from orchestrator.cli.studies.paper import command
from orchestrator.studies.points import CaseStudy

ROOT = Path(__file__).parents[2]


@pytest.mark.slow
def test_the_page_is_that_of_the_recorded_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Every criterion has a recorded number."""
    monkeypatch.chdir(ROOT)
    study = CaseStudy(Path("cases"), out=tmp_path / "papers")
    assert [*command(study, recorded=Path("docs/measured/papers.csv"))]
    written = (study.folder / "paper.md").read_text(encoding="utf-8")
    assert written == (ROOT / "docs/measured/papers.md").read_text(encoding="utf-8")
    assert "not recorded" not in written
    facts = (study.folder / "paper_facts.csv").read_text(encoding="utf-8")
    assert facts == (ROOT / "docs/measured/paper_facts.csv").read_text(encoding="utf-8")
