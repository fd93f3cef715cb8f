"""New levels of a case, made from another level and ``--set`` overlays."""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import tomli_w

from orchestrator.case.file.base import read_level
from orchestrator.case.file.deck_layout import lay_out_decks
from orchestrator.case.file.errors import CaseError, CaseProblem, show_value
from orchestrator.case.file.layers import Layers, is_outside, parse_override
from orchestrator.case.file.whole import write_text
from orchestrator.case.load import read_tables
from orchestrator.preflight.judge import JudgedCase
from orchestrator.preflight.judgement.catalogue import find_left_out_by_level

NAME = re.compile(r"[A-Za-z0-9][A-Za-z0-9_-]*")


def write_level(loaded: JudgedCase, name: str, sets: Sequence[str], about: str) -> Path:
    """Write the case's level with ``sets`` to ``levels/<name>.toml``, and return the file.

    The key ``without`` of the new level names all effects that it leaves out.  Raises CaseError if ``name``
    is none or the file exists, and OSError if it cannot be written.
    """
    if not NAME.fullmatch(name):
        what = f"{show_value(name)} is not a name of a level"
        raise CaseError(
            [CaseProblem((), what, "letters, digits, - and _", file="--write", kind="wrong-type")]
        )
    file = loaded.folder / "levels" / f"{name}.toml"
    if file.exists():
        raise CaseError([CaseProblem((), "exists already; nothing was written", file=str(file), kind="file")])
    if is_outside(file, loaded.folder):
        raise CaseError([CaseProblem((), "lies outside of the case's folder", file=str(file), kind="file")])
    text = level_text(loaded, sets, about)
    file.parent.mkdir(exist_ok=True)
    write_text(file, text)
    return file


def level_text(loaded: JudgedCase, sets: Sequence[str], about: str) -> str:
    """Return the content of a level file: the case's level with ``sets``, and what it leaves out named."""
    overlay = read_level(loaded.folder, loaded.level)[0] if loaded.level else {}
    overlay = {key: value for key, value in overlay.items() if key not in ("about", "without")}
    level = Layers(overlay, "--set")
    for override in sets:
        level.lay(parse_override(override), "--set")
    bare = loaded.origin.given
    whole = Layers(bare, "case.toml")
    whole.lay(level.merged, "--set")
    cases = (lay_out_decks(read_tables(table, loaded.folder)) for table in (bare, whole.merged))
    without = [*find_left_out_by_level(*cases)]
    head = {"about": about} | ({"without": without} if without else {})
    return tomli_w.dumps(head | level.merged)
