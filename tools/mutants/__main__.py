"""The command that puts mistakes (mutants) into a checkout, one by one, and runs the tests that catch them.

    python -m tools.mutants TREE [--only feed-rate,bearing-life] [--clean] [--out results.json]
    python -m tools.mutants --check

TREE is a git checkout of flipflow without changes, set up by docker/setup.sh (it has .venv).  The files
``tools/mutants/*.toml`` list the mistakes:

    [feed-rate]
    mistake = "what is wrong"
    file = "orchestrator/case/bed/sources.py"
    old = "a text that the file has once"
    new = "the text in its place"
    tests = ["tests/particles/test_feed.py::test_the_rate"]

First, all tests are run once without a mistake.  Then the command replaces the text of each mistake, builds
if that changes C++, runs the tests of the mistake until the first one fails, and puts the text back.
``--wrapper`` stands before every command that computes.  ``--check`` says only which mistakes no longer fit:
their text is not there exactly once, or a test has another name now.

Exit code 0: every mistake is caught, and all tests pass without it (with --check: all mistakes fit).
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
import tomllib
import xml.etree.ElementTree as ElementTree
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

COMPILED = (".cpp", ".h")
LIMIT_S = 900
HERE = Path(__file__).parent
ROOT = HERE.parents[1]


@dataclass(frozen=True)
class Mutant:
    """A mistake: ``new`` stands in place of ``old`` in a file, and ``tests`` should notice it."""

    mistake: str
    file: str
    old: str
    new: str
    tests: tuple[str, ...]

    @property
    def is_compiled(self) -> bool:
        """Whether the file must be built."""
        return self.file.endswith(COMPILED)

    def misfits(self, tree: Path) -> Iterator[str]:
        """Yield a text for each reason why the mistake does not fit a checkout."""
        file = tree / self.file
        count = file.read_text(encoding="utf-8").count(self.old) if file.is_file() else 0
        if count != 1:
            yield f"{self.file} has {count} times: {self.old}"
        if not self.tests:
            yield "no tests"
        for test in self.tests:
            place, _, name = test.partition("::")
            if not (tree / place).exists():
                yield f"no file {place}"
            elif name and name.partition("[")[0] not in test_names(tree / place):
                yield f"{place} has no {name}"


def test_names(file: Path) -> set[str]:
    """Return the names of the functions in a file of tests."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    return {node.name for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)}


def listed(folder: Path = HERE) -> dict[str, Mutant]:
    """Return all mistakes by name, file by file.  Raises ValueError if a name comes twice."""
    mutants: dict[str, Mutant] = {}
    for file in sorted(folder.glob("*.toml")):
        table = tomllib.loads(file.read_text(encoding="utf-8"))
        if twice := mutants.keys() & table:
            raise ValueError(f"{file}: {', '.join(twice)} comes twice")
        mutants |= {name: Mutant(**row | {"tests": tuple(row["tests"])}) for name, row in table.items()}
    return mutants


def main() -> int:
    """Run the tests without and with the mistakes, print the table, and return the exit code."""
    options = arguments()
    mutants = listed()
    if options.only:
        mutants = {name: mutants[name] for name in options.only.split(",")}
    if options.check:
        lines = [f"{name}: {why}" for name, mutant in mutants.items() for why in mutant.misfits(ROOT)]
        print("\n".join(lines) or f"{len(mutants)} mistakes fit")
        return 1 if lines else 0
    runner = Runner(options.tree.resolve(), shlex.split(options.wrapper), options.processes)
    runner.check_clean()
    runner.build()
    results: dict[str, Any] = {"commit": runner.git("rev-parse", "HEAD").strip(), "mutants": {}}
    if not options.no_clean:
        results["clean"] = runner.run_tests(distinct(mutants), first_alone=False)
        print(f"without mistakes: {describe(results['clean'])}", flush=True)
    if not options.clean:
        for name, mutant in mutants.items():
            outcome = runner.outcome(mutant)
            results["mutants"][name] = outcome | {"mistake": mutant.mistake, "file": mutant.file}
            print(f"{name}: {verdict(results, outcome)}: {describe(outcome)}", flush=True)
        if any(mutant.is_compiled for mutant in mutants.values()):
            runner.build()
    if options.out:
        options.out.write_text(json.dumps(results, indent=1))
    print(table(results))
    return 0 if all_caught(results) else 1


def distinct(mutants: Mapping[str, Mutant]) -> list[str]:
    """Return the tests of all mistakes; a whole file includes its single tests."""
    tests = sorted({test for mutant in mutants.values() for test in mutant.tests})
    return [test for test in tests if "::" not in test or test.split("::")[0] not in tests]


def arguments() -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("tree", type=Path, nargs="?")
    parser.add_argument("--only", help="names, with commas")
    parser.add_argument("--check", action="store_true", help="only whether the mistakes fit this checkout")
    parser.add_argument("--clean", action="store_true", help="only without mistakes")
    parser.add_argument("--no-clean", action="store_true", help="not without mistakes")
    parser.add_argument("--processes", type=int, default=1, help="of pytest (1)")
    parser.add_argument("--out", type=Path, help="all results, as JSON")
    parser.add_argument("--wrapper", default="", help="stands before every command that computes")
    options = parser.parse_args()
    if options.tree is None and not options.check:
        parser.error("TREE is missing")
    return options


class Runner:
    """A runner of git, builds and tests in a checkout, with a number of pytest's processes."""

    def __init__(self, tree: Path, wrapper: list[str], processes: int) -> None:
        self.tree, self.wrapper, self.processes = tree, wrapper, processes

    def git(self, *words: str) -> str:
        """Return the output of a git command.  Raises SystemExit where it fails."""
        done = subprocess.run(["git", *words], cwd=self.tree, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"git {' '.join(words)}: {done.stderr}")
        return done.stdout

    def check_clean(self) -> None:
        """Raise SystemExit if the checkout has changes."""
        if changed := self.git("status", "--porcelain", "--untracked-files=no"):
            raise SystemExit(f"{self.tree} has changes:\n{changed}")

    def compute(self, *words: str) -> subprocess.CompletedProcess[str]:
        """Run a command behind the wrapper, with a limit of time."""
        return subprocess.run(
            [*self.wrapper, "timeout", str(LIMIT_S), *words],
            cwd=self.tree,
            env=os.environ | {"TERM": "dumb"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
        )

    def build(self) -> None:
        """Compile changed sources.  Raises RuntimeError where the build fails."""
        done = self.compute("bash", "docker/setup.sh")
        if done.returncode:
            raise RuntimeError(f"docker/setup.sh: {done.stdout}{done.stderr}")

    def run_tests(self, tests: list[str], first_alone: bool) -> dict[str, Any]:
        """Run tests, up to the first failure or all, and return their outcomes, seconds and exit code.

        Exit code 124 means that the time was out.
        """
        with tempfile.TemporaryDirectory(prefix="mutant_") as folder:
            report = Path(folder) / "report.xml"
            started = time.monotonic()
            words = ["env", "-u", "PYTHONUNBUFFERED", "TERM=dumb", ".venv/bin/python", "-m", "pytest"]
            words += ["-n", str(self.processes if self.processes > 1 else 0)]
            words += ["-q", "-p", "no:cacheprovider", "--tb=line", *(["-x"] if first_alone else [])]
            done = self.compute(*words, f"--junit-xml={report}", "-o", "junit_family=xunit1", *tests)
            seconds = time.monotonic() - started
            outcomes = read(report) if report.exists() else {}
        failed = [name for name, outcome in outcomes.items() if outcome["kind"] in ("failure", "error")]
        return {
            "exit": done.returncode,
            "tests_run": len(outcomes),
            "failed": failed,
            "why": [outcomes[name]["why"] for name in failed],
            "passed": [name for name, outcome in outcomes.items() if outcome["kind"] == "passed"],
            "seconds": round(seconds, 1),
            "tail": "" if done.returncode in (0, 1) else (done.stdout + done.stderr)[-2000:],
        }

    def outcome(self, mutant: Mutant) -> dict[str, Any]:
        """Make a mistake, run its tests, take it back, and return the outcomes of the tests."""
        if misfits := [*mutant.misfits(self.tree)]:
            raise SystemExit("\n".join(misfits))
        file = self.tree / mutant.file
        right = file.read_text(encoding="utf-8")
        file.write_text(right.replace(mutant.old, mutant.new), encoding="utf-8")
        try:
            self.remove_bytecode(file)
            if mutant.is_compiled:
                self.build()
            return self.run_tests([*mutant.tests], first_alone=True)
        finally:
            file.write_text(right, encoding="utf-8")
            self.remove_bytecode(file)
            self.check_clean()

    def remove_bytecode(self, file: Path) -> None:
        """Remove the bytecode of a changed file.

        Python compares second and size of a source, so that it may miss a quick change.
        """
        for cached in file.parent.glob(f"__pycache__/{file.stem}.*.pyc"):
            cached.unlink()


def read(report: Path) -> dict[str, dict[str, Any]]:
    """Return the outcomes by test from a report in XML."""
    outcomes: dict[str, dict[str, Any]] = {}
    for case in ElementTree.parse(report).iter("testcase"):
        kind, why = "passed", ""
        for child in case:
            if child.tag in ("failure", "error", "skipped"):
                kind, why = child.tag, (child.get("message") or "").partition("\n")[0][:200]
        place = case.get("file") or case.get("classname", "")
        name = f"{place}::{case.get('name')}"
        if name in outcomes and outcomes[name]["kind"] != "passed":
            continue
        outcomes[name] = {"kind": kind, "why": why}
    return outcomes


def describe(outcome: dict[str, Any]) -> str:
    """Return the outcome of a run of tests in words."""
    what = f"{outcome['tests_run']} tests, {outcome['seconds']} s, exit {outcome['exit']}"
    failed = f", failed: {'; '.join(outcome['failed'])}" if outcome["failed"] else ""
    return f"{what}{failed}{outcome['tail']}"


def verdict(results: dict[str, Any], outcome: dict[str, Any]) -> str:
    """Return the verdict on a mistake: it is caught if a test fails that passes without it."""
    passing = set(results["clean"]["passed"]) if "clean" in results else None
    if not outcome["failed"]:
        return "NOT CAUGHT" if outcome["exit"] == 0 else f"NO ANSWER (exit {outcome['exit']})"
    if passing is not None and not set(outcome["failed"]) & passing:
        return "caught only by tests that do not pass without it"
    return "caught" if passing is not None else "caught (not run without mistakes)"


def all_caught(results: dict[str, Any]) -> bool:
    """Return whether all mistakes are caught, and all tests pass without them."""
    clean = results.get("clean", {"exit": 0})
    outcomes = results["mutants"].values()
    return clean["exit"] == 0 and all(verdict(results, each).startswith("caught") for each in outcomes)


def table(results: dict[str, Any]) -> str:
    """Return the table of verdicts in Markdown."""
    lines = [f"at {results['commit']}"]
    if "clean" in results:
        lines.append(f"without mistakes: {describe(results['clean'])}")
    lines += ["", "| mistake | file | verdict | first failing test |", "|---|---|---|---|"]
    for outcome in results["mutants"].values():
        failed = f"`{outcome['failed'][0]}`" if outcome["failed"] else "none"
        lines.append(
            f"| {outcome['mistake']} | `{outcome['file']}` | {verdict(results, outcome)} | {failed} |"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
