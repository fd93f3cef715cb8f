"""Cases of this project, spoilt: what a user, a program or an attacker may do to
a case's folder."""

from __future__ import annotations

import copy
import datetime
import math
import shutil
import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import tomli_w
from hypothesis import strategies as st

ROOT = Path(__file__).parents[2]
SEEDS = sorted((file.parents[1].name, file.stem) for file in (ROOT / "cases").glob("*/levels/*.toml"))
DRAFTS = [seed for seed in SEEDS if seed[1] == "draft"]
NASTY = [
    "",
    " ",
    "\x00",
    "\x1b[2J\x1b]0;owned\x07",
    "line\nshell touch written",
    "${x}$(touch written)`touch written`",
    "'\";|&<>",
    "<script>alert(1)</script>",
    "{{ 7 * 7 }}",
    "[bold]rich[/bold]",
    "%s%n{0}",
    "../../../etc/passwd",
    "/etc/passwd",
    "e\u0301\u0327\u202egnp.exe\u200f",
    "ground",
    "0",
    "x" * 300,
    "\U0001f4a5" * 100_000,
    "$\\frac{1}{$",
]
NUMBERS = [
    0, -0.0, 1, -1, 3, 1e-300, 5e-324, 1e-12, 1e-9, 1e6, 1e15, 1e300, 1.7976931348623157e308,
    math.inf, -math.inf, math.nan, 2**31, 2**63 - 1, -(2**63), 10**30, 10**400,
]  # fmt: skip
OTHERS = [True, False, [], [[]], {}, {"": {}}, [{}], [1, "a"], datetime.date(2026, 1, 1)]
FACTORS = [
    1e3, 1e-3, 1e6, 1e-6, 1e9, 1e-9, 100.0, 0.01, 9.80665, 180 / math.pi, math.pi / 180,
    2 * math.pi / 60, 60 / (2 * math.pi), -1.0, 0.5, 2.0, 10.0, 0.1,
]  # fmt: skip
VALUES = st.one_of(
    st.sampled_from([*NUMBERS, *OTHERS, *NASTY]),
    st.integers(-(2**70), 2**70),
    st.floats(),
    st.text(st.characters(exclude_categories=["Cs"]), max_size=20),
)
Path_ = tuple[str | int, ...]


def places(value: Any, here: Path_ = ()) -> list[Path_]:
    """All keys and elements, the whole first."""
    inner: Any = ()
    if isinstance(value, dict):
        inner = value.items()
    elif isinstance(value, list):
        inner = enumerate(value)
    return [here, *(place for key, child in inner for place in places(child, (*here, key)))]


def at(table: Any, place: Path_) -> Any:
    for key in place:
        table = table[key]
    return table


def spoilt(table: dict[str, Any], draw: Callable[[Any], Any]) -> dict[str, Any]:
    """A copy with something at one place changed."""
    table = copy.deepcopy(table)
    place = draw(st.sampled_from(places(table)[1:]))
    holder, key = at(table, place[:-1]), place[-1]
    kind = draw(st.sampled_from(["scale", "scale", "value", "value", "take", "add", "move"]))
    if kind == "scale":
        holder[key] = scaled(holder[key], draw(st.sampled_from(FACTORS)))
    elif kind == "value":
        holder[key] = draw(VALUES)
    elif kind == "take":
        del holder[key]
    elif kind == "add" and isinstance(holder, dict):
        name = draw(st.sampled_from(NASTY) | st.sampled_from([f"{key}s", f"{key}-2", "x"]))
        holder[name] = copy.deepcopy(holder[key])
    else:
        other = draw(st.sampled_from(places(table)[1:]))
        holder[key] = copy.deepcopy(at(table, other))
    return table


def scaled(value: Any, factor: float) -> Any:
    """Every number in it."""
    if isinstance(value, dict):
        return {key: scaled(part, factor) for key, part in value.items()}
    if isinstance(value, list):
        return [scaled(part, factor) for part in value]
    if isinstance(value, int | float) and not isinstance(value, bool):
        return value * factor
    return value


@st.composite
def spoilt_tables(draw: Any, seeds: list[tuple[str, str]]) -> tuple[str, str, bytes, bytes]:
    """Case, level, and the bytes of their files, with up to three keys changed."""
    case, level = draw(st.sampled_from(seeds))
    folder = ROOT / "cases" / case
    tables = [
        tomllib.loads(file.read_text(encoding="utf-8"))
        for file in (folder / "case.toml", folder / "levels" / f"{level}.toml")
    ]
    for _ in range(draw(st.integers(1, 3))):
        number = draw(st.sampled_from([0, 0, 1]))
        if tables[number]:
            tables[number] = spoilt(tables[number], draw)
    case_bytes, level_bytes = (tomli_w.dumps(table).encode() for table in tables)
    return case, level, case_bytes, level_bytes


@st.composite
def spoilt_bytes(draw: Any, given: bytes) -> bytes:
    """A text cut off, with something put in or taken out."""
    start, end = sorted(draw(st.tuples(*[st.integers(0, len(given))] * 2)))
    put_in = draw(
        st.sampled_from([b"", b"\0", b"\xff\xfe", b"\xef\xbb\xbf", b"[" * 3000, b"9" * 5000, b"a." * 5000])
        | st.binary(max_size=20)
    )
    kind = draw(st.sampled_from(["cut", "put", "take"]))
    if kind == "cut":
        return given[:start] + put_in
    return given[:start] + put_in + given[start if kind == "put" else end :]


def lay_out(place: Path, case: str, level: str, case_toml: bytes, level_toml: bytes) -> Path:
    """The folder ``place/case`` with what was drawn, and the case's own other files."""
    folder = place / "case"
    shutil.rmtree(folder, ignore_errors=True)
    (folder / "levels").mkdir(parents=True)
    (folder / "case.toml").write_bytes(case_toml)
    (folder / "levels" / f"{level}.toml").write_bytes(level_toml)
    for file in (ROOT / "cases" / case).glob("*.stl"):
        shutil.copy(file, folder)
    return folder
