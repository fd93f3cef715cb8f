"""The command that counts the tests which compare wording alone, folder by folder, and lists them.

    python -m tools.wording [FOLDER] [--list]

An assertion is about wording if it looks for a text with a space in another text (``"no run" in
output``), or compares, begins or ends with such a text, or matches a raised error with it. A test compares
wording alone if all that it asserts is of that kind. The key and the kind of a problem, numbers and the name
of an argument (``match="^force_N:"``) are no words. Assertions in functions that a test calls are not
followed.
"""

from __future__ import annotations

import argparse
import ast
import re
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import get_args

from orchestrator.case.file.errors import Kind

TESTS = Path(__file__).parents[1] / "tests"
KEY_AND_KIND = re.compile(rf"\S*: ({'|'.join(get_args(Kind))})")
STARTS = ("startswith", "endswith", "match", "search", "fullmatch", "count")


def main() -> None:
    """Print how many tests compare wording alone, folder by folder, and their names on demand."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("folder", type=Path, nargs="?", default=TESTS)
    parser.add_argument("--list", action="store_true", help="the names, too")
    options = parser.parse_args()
    count: Counter[str] = Counter()
    tests = 0
    for file in sorted(options.folder.rglob("test_*.py")):
        for function in functions(file):
            tests += 1
            if compares_wording_alone(function):
                count[str(file.parent.relative_to(options.folder))] += 1
                if options.list:
                    print(f"{file.relative_to(options.folder)}::{function.name}")
    for folder, number in sorted(count.items()):
        print(f"{number:5d}  {folder}")
    print(f"{count.total():5d}  of {tests} tests compare wording alone")


def functions(file: Path) -> Iterator[ast.FunctionDef]:
    """Yield the test functions of a file."""
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef) and node.name.startswith("test_"):
            yield node


def compares_wording_alone(function: ast.FunctionDef) -> bool:
    """Return whether a test asserts something, and nothing but wording."""
    kinds = [*_assertions(function)]
    return bool(kinds) and all(kinds)


def _assertions(function: ast.FunctionDef) -> Iterator[bool]:
    """Yield for each assertion of a function whether it is about wording."""
    loops = _words_of_loops(function)
    for node in ast.walk(function):
        if isinstance(node, ast.Assert):
            parts = node.test.values if isinstance(node.test, ast.BoolOp) else [node.test]
            yield from (_is_wording(part, loops) for part in parts)
        elif isinstance(node, ast.Call) and _name(node.func) == "raises":
            matched = (keyword.value for keyword in node.keywords if keyword.arg == "match")
            yield from (_is_text(word) or _name(word) in loops for word in matched)


def _words_of_loops(function: ast.FunctionDef) -> set[str]:
    """Return the names that loops and parameters of a test give to texts: ``for word in ("no run", ...)``."""
    names = set()
    for node in ast.walk(function):
        if not (isinstance(node, ast.For | ast.comprehension) and isinstance(node.target, ast.Name)):
            continue
        if isinstance(node.iter, ast.Tuple | ast.List) and any(map(_is_text, node.iter.elts)):
            names.add(node.target.id)
    for decorator in function.decorator_list:
        if isinstance(decorator, ast.Call) and _name(decorator.func) == "parametrize":
            names |= _texts_of_parameters(decorator)
    return names


def _texts_of_parameters(call: ast.Call) -> set[str]:
    """Return the names of parameters whose values are texts with spaces."""
    if len(call.args) < 2 or not isinstance(call.args[1], ast.List | ast.Tuple):
        return set()
    first = call.args[0]
    if isinstance(first, ast.Constant):
        names = [name.strip() for name in str(first.value).split(",")]
    else:
        names = [str(part.value) for part in getattr(first, "elts", []) if isinstance(part, ast.Constant)]
    texts = set()
    for row in call.args[1].elts:
        values = [row] if len(names) == 1 else getattr(row, "elts", [])
        texts |= {name for name, value in zip(names, values, strict=False) if _is_text(value)}
    return texts


def _is_wording(test: ast.expr, loops: set[str]) -> bool:
    if isinstance(test, ast.UnaryOp):
        return _is_wording(test.operand, loops)
    if isinstance(test, ast.Compare):
        return any(_is_text(part) or _name(part) in loops for part in (test.left, *test.comparators))
    if isinstance(test, ast.Call):
        if _name(test.func) in ("any", "all") and test.args:
            inner = test.args[0]
            return isinstance(inner, ast.GeneratorExp) and _is_wording(inner.elt, loops)
        return _name(test.func) in STARTS and any(
            _is_text(word) or _name(word) in loops for word in test.args
        )
    return False


def _is_text(node: ast.expr) -> bool:
    """Return whether an expression is a text of several words, or a list of them."""
    if isinstance(node, ast.List | ast.Tuple):
        return bool(node.elts) and all(map(_is_text, node.elts))
    if isinstance(node, ast.JoinedStr):
        return any(isinstance(part, ast.Constant) and " " in str(part.value) for part in node.values)
    if isinstance(node, ast.BinOp):
        return _is_text(node.left) or _is_text(node.right)
    if not (isinstance(node, ast.Constant) and isinstance(node.value, str)):
        return False
    return " " in node.value and not KEY_AND_KIND.fullmatch(node.value)


def _name(node: ast.expr) -> str:
    """Return the last name of an expression such as ``done.stderr``; "" of another one."""
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


if __name__ == "__main__":
    main()
