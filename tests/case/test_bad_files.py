"""Files of a case that are none, or somebody else's, or far too large; and words that would do
harm where they are shown."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from orchestrator.case.file.errors import LONGEST, MOST, CaseError
from orchestrator.preflight.check import find_problems
from orchestrator.preflight.judge import load_judged
from tests.cases import CASE, LEVEL, case_folder, complaints, only_complaint


def refusal(folder: Path, level: str | None = None) -> str:
    with pytest.raises(CaseError) as refused:
        load_judged(folder, level)
    return str(refused.value)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"title = \xff", "case.toml: is not a text file in UTF-8"),
        (b'title = "\0"', "case.toml: is not TOML: "),
        (b"x = 1\n" * 2, "case.toml: is not TOML: Cannot overwrite"),
        (b"seed = " + b"9" * 5000, "case.toml: is not TOML: Exceeds the limit"),
        (b"x = " + b"[" * 5000, "case.toml: is nested too deeply"),
        (b"x = " + b"{a=" * 5000, "case.toml: is nested too deeply"),
        (b"screen.frames" + b".a" * 5000 + b" = 1", "case.toml: is nested too deeply"),
        (b"#" * 1_000_001, "case.toml: is larger than 1000000 bytes"),
    ],
    ids=["bytes", "NUL", "twice", "digits", "lists", "tables", "dots", "large"],
)
def test_what_is_no_case(tmp_path: Path, content: bytes, message: str) -> None:
    case_folder(tmp_path)
    (tmp_path / "case.toml").write_bytes(content)
    assert message in refusal(tmp_path)
    assert len(refusal(tmp_path).splitlines()) == 2


@pytest.mark.parametrize(
    ("line", "hint"),
    [
        ("thickness_m = 0,004", "write a decimal point: 0.004"),
        ("thickness_m = -1,5e-3", "write a decimal point: 1.5"),
        ("along = [0,05, 0.0, 1.0]", "write a decimal point: 0.05"),
        ("drive = {run_up_s = 0,16}", "write a decimal point: 0.16"),
        ("thickness_m = 1,234.5", ""),
        ("count = 1, pitch_m = 0.3", ""),
        (
            "material = \u201cPU\u201d",
            "the character there is a left double quotation mark; write a plain one",
        ),
        ("thickness_m\u00a0= 0.004", "the character there is a no-break space; write a plain one"),
        ("tension_m = \u22120.003", "the character there is a minus sign; write a plain one"),
        ("material = PU", ""),
    ],
)
def test_what_is_no_toml_is_told_with_its_place_and_a_remedy(tmp_path: Path, line: str, hint: str) -> None:
    case_folder(tmp_path, f"# 1,5 mm\n{line}\n{CASE}")
    with pytest.raises(CaseError) as raised:
        load_judged(tmp_path)
    (problem,) = raised.value.problems
    assert "(at line 2, column " in problem.what
    assert (problem.kind, problem.hint) == ("file", hint)


def test_a_case_too_large_with_its_defaults(tmp_path: Path) -> None:
    """Results and resumed runs read the case from the run's folder, where defaults make it larger."""
    balls = "".join(
        f'[bed.particles.ball-{number}]\nmaterial = "coal"\nsieve_size_m = 9e-5\n'
        f"position_m = [0, {number * 1e-4:g}, 0.5]\n"
        for number in range(8000)
    )
    assert len(balls) < 1_000_000
    case_folder(tmp_path, CASE + balls)
    (problem,) = find_problems(load_judged(tmp_path))
    assert "bytes with all defaults, and a file may have 1000000" in problem.what
    assert problem.hint == "write many particles into a file of their own: bed.table"


def test_a_byte_order_mark_is_no_mistake(tmp_path: Path) -> None:
    case_folder(tmp_path, "\ufeff" + CASE.replace("\n", "\r\n"))
    assert load_judged(tmp_path).case == load_judged(case_folder(tmp_path / "plain")).case


def test_a_level_that_is_no_file(tmp_path: Path) -> None:
    case_folder(tmp_path)
    (tmp_path / "levels/folder.toml").mkdir()
    os.mkfifo(tmp_path / "levels/pipe.toml")  # reading it would wait for ever
    (tmp_path / "levels/null.toml").symlink_to("/dev/zero")
    (tmp_path / "levels/loop.toml").symlink_to("loop.toml")
    (tmp_path / "levels/lost.toml").symlink_to("nowhere.toml")
    for level in ("folder", "pipe", "null", "loop", "lost"):
        with pytest.raises(CaseError) as refused:
            load_judged(tmp_path, level)
        (problem,) = refused.value.problems
        assert (problem.file, problem.kind) == (str(tmp_path / f"levels/{level}.toml"), "file")


def test_a_level_of_somebody_else(tmp_path: Path) -> None:
    folder = case_folder(tmp_path / "case", own=LEVEL)
    (tmp_path / "secret.toml").write_text("[panel]\nsolver = 'strip'")
    (folder / "levels/link.toml").symlink_to("../../secret.toml")
    (folder / "levels/own-link.toml").symlink_to("own.toml")
    assert "link.toml: is a link to a file outside of the case's folder" in refusal(folder, "link")
    assert load_judged(folder, "own-link").case.panel.solver == "strip"
    for level in ("../../secret", "/etc/passwd", "x" * 5000, "nul\0", ""):
        with pytest.raises(CaseError, match="no level") if level else pytest.raises(CaseError):
            load_judged(folder, level or "none")


def test_a_case_may_be_reached_by_a_link(tmp_path: Path) -> None:
    (tmp_path / "link").symlink_to(case_folder(tmp_path / "case", draft=LEVEL))
    (tmp_path / "file.toml").symlink_to("case/case.toml")
    for path in (tmp_path / "link", tmp_path / "file.toml"):
        assert load_judged(path, "draft").folder == tmp_path / "case"


@pytest.mark.parametrize("word", ["\x1b]0;owned\x07", "\x00", "\u202egpj.exe", "a\nb", "\ud800"])
def test_messages_have_nothing_that_a_terminal_obeys(tmp_path: Path, word: str) -> None:
    spoilt = [f"probes.p.frame='''{word}'''", f"{word}=1", f"probes.{word}.particle=1"]
    for override in [*spoilt, f"screen.panels.deck.{word}=2"]:
        messages = complaints(tmp_path, override)
        assert messages
        assert all(complaint.isprintable() for complaint in messages)
        assert all(complaint.isprintable() for complaint in refusal_lines(tmp_path, override))


def refusal_lines(folder: Path, override: str) -> list[str]:
    try:
        load_judged(folder, None, [override])
    except CaseError as error:
        return str(error).splitlines()
    return []


def test_a_title_is_one_line_that_can_be_shown(tmp_path: Path) -> None:
    for title in ("\\u001b[2J", "two\\nlines", "\\u202e"):
        complaint = only_complaint(tmp_path, f'title="{title}"')
        assert complaint.startswith("--set title: ")
        assert complaint.endswith("has characters that cannot be shown")
    assert "at most 200 characters" in only_complaint(tmp_path, f"title='{'x' * 201}'")
    for title in ("Übergröße 篩い分け", "e\u0301 <b>&amp; $x$ [bold]", "غربال"):
        assert complaints(tmp_path, f"title='{title}'") == []


def test_names_are_short_enough_for_files(tmp_path: Path) -> None:
    assert complaints(tmp_path, f"probes.{'x' * 60}.particle=1") == []
    assert "at most 60" in only_complaint(tmp_path, f"probes.{'x' * 61}.particle=1")


def test_a_hundred_thousand_mistakes_are_not_all_said(tmp_path: Path) -> None:
    case_folder(tmp_path, CASE + "".join(f"[x{number}]\n" for number in range(50_000)))
    lines = refusal(tmp_path).splitlines()
    assert len(lines) == MOST + 2
    assert all(len(line) <= LONGEST + 2 for line in lines)
    assert lines[-1].endswith(" more")


@pytest.mark.parametrize("value", ["0x" + "f" * 900_000, "'" + "\U0001f4a5" * 200_000 + "'"])
def test_huge_values_are_said_in_short(tmp_path: Path, value: str) -> None:
    for key in ("duration_s", "coupling.scheme", "bed.blocks.x.seed", "title", "panel.cells"):
        (tmp_path / key).mkdir(exist_ok=True)
        case_folder(tmp_path / key, f"{key} = {value}\n" + CASE)
        message = refusal(tmp_path / key)
        assert key in message
        assert len(message) < 3 * LONGEST
