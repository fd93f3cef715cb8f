#!/usr/bin/env python3
"""The command that applies mutants to a checkout, one at a time, and runs the tests that should catch them.

    python -m tools.mutants TREE PATCHES TESTS.toml [--only 03,07] [--clean | --no-clean] [--out results.json]

TREE     a git checkout of flipflow without changes, set up by docker/setup.sh (it has .venv)
PATCHES  a folder with NN.patch, unified diffs against TREE
TESTS    a TOML file:  [03]  mistake = "..."  place = "..."  tests = ["tests/a.py", "tests/b.py::test_c"]

First, all named tests are run once without any mutant (--no-clean leaves this out, --clean does
nothing else).  Then, for each mutant, the command applies its patch, builds if it changes C++, runs
its tests, and takes the patch back.  At the end the clean sources are compiled again.  Every test is
run by ``pytest -n 0 --maxfail=N``; the wrapper (--wrapper) stands before every command that computes.

Exit code 0: every tried mutant is caught, and all its tests pass without it.
"""

from __future__ import annotations

import argparse
import json
import os
import shlex
import subprocess
import sys
import tempfile
import time
import tomllib
import xml.etree.ElementTree as ElementTree
from pathlib import Path
from typing import Any

COMPILED = (".cpp", ".h", ".hpp", ".cc", "CMakeLists.txt")
LIMIT_S = 900


def main() -> int:
    """Run the tests without and with the mutants, print the table, and return the exit code."""
    options = arguments()
    tree, wanted = options.tree.resolve(), tomllib.loads(options.tests.read_text())
    if options.only:
        wanted = {number: wanted[number] for number in options.only.split(",")}
    runner = Runner(tree, shlex.split(options.wrapper), options.maxfail)
    runner.check_clean()
    runner.build()
    results: dict[str, Any] = {"commit": runner.git("rev-parse", "HEAD").strip(), "mutants": {}}
    if not options.no_clean:
        tests = sorted({test for one in wanted.values() for test in one["tests"]})
        # a whole file includes its single tests
        tests = [t for t in tests if "::" not in t or t.split("::")[0] not in tests]
        results["clean"] = runner.run_tests(tests, maxfail=0)
        print(f"without mutants: {describe(results['clean'])}", flush=True)
    if not options.clean:
        for number, one in wanted.items():
            patch = (options.patches / f"{number}.patch").resolve()
            results["mutants"][number] = one | runner.mutant(patch, one["tests"])
            print(f"{number} {one['mistake']}: {describe(results['mutants'][number])}", flush=True)
        runner.build()
    if options.out:
        options.out.write_text(json.dumps(results, indent=1))
    print(table(results))
    return 0 if all_caught(results) else 1


def arguments() -> argparse.Namespace:
    """Return the options of the command line."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("tree", type=Path)
    parser.add_argument("patches", type=Path)
    parser.add_argument("tests", type=Path)
    parser.add_argument("--only", help="numbers, with commas")
    parser.add_argument("--clean", action="store_true", help="only without mutants")
    parser.add_argument("--no-clean", action="store_true", help="not without mutants")
    parser.add_argument("--maxfail", type=int, default=1, help="stop after so many failures (1)")
    parser.add_argument("--out", type=Path, help="all results, as JSON")
    parser.add_argument("--wrapper", default="", help="stands before every command that computes")
    return parser.parse_args()


class Runner:
    """A runner of git, builds and tests in a checkout."""

    def __init__(self, tree: Path, wrapper: list[str], maxfail: int) -> None:
        self.tree, self.wrapper, self.maxfail = tree, wrapper, maxfail

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

    def run_tests(self, tests: list[str], maxfail: int) -> dict[str, Any]:
        """Run tests, and return their outcomes, seconds and exit code.

        The seconds are the time with waiting for the wrapper, and pytest's own time.  Exit code 124 means
        that the time was out.
        """
        with tempfile.TemporaryDirectory(prefix="mutant_") as folder:
            report = Path(folder) / "report.xml"
            started = time.monotonic()
            words = ["env", "-u", "PYTHONUNBUFFERED", "TERM=dumb", ".venv/bin/python", "-m", "pytest"]
            words += ["-n", "0", "-q", "-p", "no:cacheprovider", "--tb=line", f"--maxfail={maxfail}"]
            done = self.compute(*words, f"--junit-xml={report}", "-o", "junit_family=xunit1", *tests)
            seconds = time.monotonic() - started
            outcomes, own_s = read(report) if report.exists() else ({}, 0.0)
        failed = [name for name, outcome in outcomes.items() if outcome["kind"] in ("failure", "error")]
        return {
            "exit": done.returncode,
            "tests_run": len(outcomes),
            "failed": failed,
            "why": [outcomes[name]["why"] for name in failed],
            "passed": [name for name, outcome in outcomes.items() if outcome["kind"] == "passed"],
            "skipped": [name for name, outcome in outcomes.items() if outcome["kind"] == "skipped"],
            "seconds": round(seconds, 1),
            "computing_s": round(own_s, 1),
            "tail": "" if done.returncode in (0, 1) else (done.stdout + done.stderr)[-2000:],
        }

    def mutant(self, patch: Path, tests: list[str]) -> dict[str, Any]:
        """Apply a mutant, run its tests, take it back, and return the outcomes of the tests."""
        changed = [line[6:].strip() for line in patch.read_text().splitlines() if line.startswith("+++ b/")]
        compiled = any(name.endswith(COMPILED) for name in changed)
        self.git("apply", "--check", str(patch))
        self.git("apply", str(patch))
        try:
            self.remove_bytecode(changed)
            if compiled:
                self.build()
            return self.run_tests(tests, self.maxfail)
        finally:
            self.git("apply", "-R", str(patch))
            self.remove_bytecode(changed)
            self.check_clean()
            if compiled:
                self.build()

    def remove_bytecode(self, changed: list[str]) -> None:
        """Remove the bytecode of changed files.

        Python compares second and size of a source, so that it may miss a quick change.
        """
        for name in changed:
            file = self.tree / name
            for cached in file.parent.glob(f"__pycache__/{file.stem}.*.pyc"):
                cached.unlink()


def read(report: Path) -> tuple[dict[str, dict[str, Any]], float]:
    """Return the outcomes by test, and pytest's own time in s, from a report in XML."""
    outcomes: dict[str, dict[str, Any]] = {}
    tree = ElementTree.parse(report)
    own_s = sum(float(suite.get("time", 0)) for suite in tree.iter("testsuite"))
    for case in tree.iter("testcase"):
        kind, why = "passed", ""
        for child in case:
            if child.tag in ("failure", "error", "skipped"):
                kind, why = child.tag, (child.get("message") or "").splitlines()[0:1]
                why = why[0][:200] if why else ""
        place = case.get("file") or case.get("classname", "")
        name = f"{place}::{case.get('name')}"
        if name in outcomes and outcomes[name]["kind"] != "passed":
            continue
        outcomes[name] = {"kind": kind, "why": why}
    return outcomes, own_s


def describe(one: dict[str, Any]) -> str:
    """Return the outcome of a run of tests in words."""
    what = f"{one['tests_run']} tests, {one['computing_s']} s, exit {one['exit']}"
    return what + (f", failed: {'; '.join(one['failed'])}" if one["failed"] else "") + one["tail"]


def verdict(results: dict[str, Any], one: dict[str, Any]) -> str:
    """Return the verdict on a mutant: it is caught if a test fails that passes without it."""
    passing = set(results["clean"]["passed"]) if "clean" in results else None
    if not one["failed"]:
        return "NOT CAUGHT" if one["exit"] == 0 else f"NO ANSWER (exit {one['exit']})"
    if passing is not None and not set(one["failed"]) & passing:
        return "caught only by tests that do not pass without it"
    return "caught" if passing is not None else "caught (clean state not run)"


def all_caught(results: dict[str, Any]) -> bool:
    """Return whether all mutants are caught, and all tests pass without them."""
    clean = results.get("clean", {"exit": 0})
    mutants = results["mutants"].values()
    return clean["exit"] == 0 and all(verdict(results, one).startswith("caught") for one in mutants)


def table(results: dict[str, Any]) -> str:
    """Return the table of verdicts in Markdown."""
    lines = [f"at {results['commit']}"]
    if "clean" in results:
        lines.append(f"without mutants: {describe(results['clean'])}")
    lines += [
        "",
        "| no. | mistake | place | verdict | first failing tests | s |",
        "|---|---|---|---|---|---|",
    ]
    for number, one in results["mutants"].items():
        failed = "<br>".join(one["failed"]) or "none"
        cells = [number, one["mistake"], one["place"], verdict(results, one), failed, one["computing_s"]]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
