#!/usr/bin/env python3
"""Applies mutants to a checkout one by one, runs the tests that should catch each, takes it back.

    run.py TREE PATCHES TESTS.toml [--only 03,07] [--clean | --no-clean] [--out results.json]

TREE     a git checkout of flipflow without changes, set up by docker/setup.sh (it has .venv)
PATCHES  a folder with NN.patch, unified diffs against TREE
TESTS    a TOML file:  [03]  mistake = "..."  place = "..."  tests = ["tests/a.py", "tests/b.py::test_c"]

First all tests named are run without any mutant (once; --no-clean leaves that out, --clean does
nothing else).  Then for each mutant: git apply, build where it changes C++, tests, git apply -R.
At the end what was compiled is compiled again from the clean sources.  Every test is run by
``pytest -n 0 --maxfail=N``; all that computes goes through the wrapper (--wrapper).

Exit code 0: every mutant that was tried is caught, and all its tests pass without it.
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
    asked = arguments()
    tree, wanted = asked.tree.resolve(), tomllib.loads(asked.tests.read_text())
    if asked.only:
        wanted = {number: wanted[number] for number in asked.only.split(",")}
    runner = Runner(tree, shlex.split(asked.wrapper), asked.maxfail)
    runner.must_be_clean()
    runner.build()
    found: dict[str, Any] = {"commit": runner.git("rev-parse", "HEAD").strip(), "mutants": {}}
    if not asked.no_clean:
        tests = sorted({test for one in wanted.values() for test in one["tests"]})
        # a file named whole has its single tests in it already
        tests = [t for t in tests if "::" not in t or t.split("::")[0] not in tests]
        found["clean"] = runner.tested(tests, maxfail=0)
        print(f"without mutants: {said(found['clean'])}", flush=True)
    if not asked.clean:
        for number, one in wanted.items():
            patch = (asked.patches / f"{number}.patch").resolve()
            found["mutants"][number] = one | runner.mutant(patch, one["tests"])
            print(f"{number} {one['mistake']}: {said(found['mutants'][number])}", flush=True)
        runner.build()
    if asked.out:
        asked.out.write_text(json.dumps(found, indent=1))
    print(table(found))
    return 0 if well(found) else 1


def arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("tree", type=Path)
    parser.add_argument("patches", type=Path)
    parser.add_argument("tests", type=Path)
    parser.add_argument("--only", help="numbers, with commas")
    parser.add_argument("--clean", action="store_true", help="only without mutants")
    parser.add_argument("--no-clean", action="store_true", help="not without mutants")
    parser.add_argument("--maxfail", type=int, default=1, help="stop after so many failures (1)")
    parser.add_argument("--out", type=Path, help="all that was found, as JSON")
    parser.add_argument("--wrapper", default="", help="stands before every command that computes")
    return parser.parse_args()


class Runner:
    def __init__(self, tree: Path, wrapper: list[str], maxfail: int) -> None:
        self.tree, self.wrapper, self.maxfail = tree, wrapper, maxfail

    def git(self, *words: str) -> str:
        done = subprocess.run(["git", *words], cwd=self.tree, capture_output=True, text=True)
        if done.returncode:
            raise SystemExit(f"git {' '.join(words)}: {done.stderr}")
        return done.stdout

    def must_be_clean(self) -> None:
        if changed := self.git("status", "--porcelain", "--untracked-files=no"):
            raise SystemExit(f"{self.tree} has changes:\n{changed}")

    def computed(self, *words: str) -> subprocess.CompletedProcess[str]:
        return subprocess.run(
            [*self.wrapper, "timeout", str(LIMIT_S), *words],
            cwd=self.tree,
            env=os.environ | {"TERM": "dumb"},
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
        )

    def build(self) -> None:
        """Compiles what has changed; nothing where nothing has."""
        done = self.computed("bash", "docker/setup.sh")
        if done.returncode:
            raise RuntimeError(f"docker/setup.sh: {done.stdout}{done.stderr}")

    def tested(self, tests: list[str], maxfail: int) -> dict[str, Any]:
        """Outcomes by test, seconds (those with waiting for the wrapper, and pytest's own), and pytest's
        exit code (124: out of time)."""
        with tempfile.TemporaryDirectory(prefix="mutant_") as folder:
            report = Path(folder) / "report.xml"
            started = time.monotonic()
            words = ["env", "-u", "PYTHONUNBUFFERED", "TERM=dumb", ".venv/bin/python", "-m", "pytest"]
            words += ["-n", "0", "-q", "-p", "no:cacheprovider", "--tb=line", f"--maxfail={maxfail}"]
            done = self.computed(*words, f"--junit-xml={report}", "-o", "junit_family=xunit1", *tests)
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
        changed = [line[6:].strip() for line in patch.read_text().splitlines() if line.startswith("+++ b/")]
        compiled = any(name.endswith(COMPILED) for name in changed)
        self.git("apply", "--check", str(patch))
        self.git("apply", str(patch))
        try:
            self.forget(changed)
            if compiled:
                self.build()
            return self.tested(tests, self.maxfail)
        finally:
            self.git("apply", "-R", str(patch))
            self.forget(changed)
            self.must_be_clean()
            if compiled:
                self.build()

    def forget(self, changed: list[str]) -> None:
        """Bytecode goes by the second and the size of its source: a quick change may escape it."""
        for name in changed:
            file = self.tree / name
            for cached in file.parent.glob(f"__pycache__/{file.stem}.*.pyc"):
                cached.unlink()


def read(report: Path) -> tuple[dict[str, dict[str, Any]], float]:
    """Outcomes by test, and pytest's own seconds."""
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


def said(one: dict[str, Any]) -> str:
    what = f"{one['tests_run']} tests, {one['computing_s']} s, exit {one['exit']}"
    return what + (f", failed: {'; '.join(one['failed'])}" if one["failed"] else "") + one["tail"]


def verdict(found: dict[str, Any], one: dict[str, Any]) -> str:
    """Caught where a test fails that passes without the mutant."""
    passing = set(found["clean"]["passed"]) if "clean" in found else None
    if not one["failed"]:
        return "NOT CAUGHT" if one["exit"] == 0 else f"NO ANSWER (exit {one['exit']})"
    if passing is not None and not set(one["failed"]) & passing:
        return "caught only by tests that do not pass without it"
    return "caught" if passing is not None else "caught (clean state not run)"


def well(found: dict[str, Any]) -> bool:
    clean = found.get("clean", {"exit": 0})
    mutants = found["mutants"].values()
    return clean["exit"] == 0 and all(verdict(found, one).startswith("caught") for one in mutants)


def table(found: dict[str, Any]) -> str:
    lines = [f"at {found['commit']}"]
    if "clean" in found:
        lines.append(f"without mutants: {said(found['clean'])}")
    lines += [
        "",
        "| no. | mistake | place | verdict | first failing tests | s |",
        "|---|---|---|---|---|---|",
    ]
    for number, one in found["mutants"].items():
        failed = "<br>".join(one["failed"]) or "none"
        cells = [number, one["mistake"], one["place"], verdict(found, one), failed, one["computing_s"]]
        lines.append("| " + " | ".join(map(str, cells)) + " |")
    return "\n".join(lines)


if __name__ == "__main__":
    sys.exit(main())
