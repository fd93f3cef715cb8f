"""The README's commands on a bare machine, as in CI; here, and loudly, if none can be made."""

from __future__ import annotations

import os
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest

ROOT = Path(__file__).parents[1]
DIRECTLY = ["setup.sh", "flipflow run cases/quickstart", "setup.sh", "python -m pytest"]
THIRTEEN = "bare.sh --debian 13"


@pytest.mark.process
@pytest.mark.parametrize(
    ("bare", "thirteen", "code", "loud", "ran"),
    [
        (0, 0, 0, False, ["bare.sh", THIRTEEN]),
        (0, 1, 1, False, ["bare.sh", THIRTEEN]),
        (0, 125, 125, False, ["bare.sh", THIRTEEN]),  # no Debian 13 is a failure
        (1, 0, 1, False, ["bare.sh"]),  # a test failed there: that is the answer
        (125, 0, 0, True, ["bare.sh", *DIRECTLY, THIRTEEN]),
    ],
)
def test_ci_runs_everything_once(
    tmp_path: Path, bare: int, thirteen: int, code: int, loud: bool, ran: list[str]
) -> None:
    for program, does in (
        ("docker/bare.sh", f"echo bare.sh ${{@:1:2}}; [ $# = 0 ] && exit {bare} || exit {thirteen}"),
        ("docker/setup.sh", "echo setup.sh"),
        (".venv/bin/flipflow", 'echo flipflow "$@"'),
        (".venv/bin/python", 'echo python "$@"'),
    ):
        file = tmp_path / program
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"#!/usr/bin/env bash\n{does}\n")
        file.chmod(0o755)
    (tmp_path / ".ci").mkdir()
    shutil.copy(ROOT / ".ci/run", tmp_path / ".ci/run")
    done = subprocess.run(["bash", ".ci/run"], cwd=tmp_path, capture_output=True, encoding="utf-8")
    assert done.returncode == code
    assert ("NOT ON A BARE MACHINE" in done.stderr) == loud
    assert done.stdout.splitlines() == ran


@pytest.mark.process
def test_a_bare_machine_is_for_root() -> None:
    """The script says so, makes nothing, and its exit code is none of a command."""
    nobody = ["setpriv", "--reuid=65534", "--regid=65534", "--clear-groups"]
    if os.geteuid() == 0 and shutil.which(nobody[0]) is None:
        pytest.skip("no setpriv to be somebody else with")
    with TemporaryDirectory() as place:  # which nobody may read
        Path(place).chmod(0o755)
        shutil.copytree(ROOT / "docker", Path(place) / "docker")
        shutil.copy(ROOT / "README.md", place)
        command = ["bash", f"{place}/docker/bare.sh"]
        words = [*nobody, *command] if os.geteuid() == 0 else command
        done = subprocess.run(words, capture_output=True, encoding="utf-8", cwd="/")
    assert done.returncode == 125
    assert done.stderr == "bare.sh: cannot make a bare Debian 12 here: that needs root\n"


@pytest.mark.process
def test_a_debian_that_is_not_known_is_refused() -> None:
    words = ["bash", str(ROOT / "docker/bare.sh"), "--debian", "11", "true"]
    done = subprocess.run(words, capture_output=True, encoding="utf-8")
    assert (done.returncode, done.stderr) == (2, "bare.sh: --debian takes 12 or 13, not '11'\n")


def test_the_readme_s_two_commands_are_found() -> None:
    lines = (ROOT / "README.md").read_text().splitlines()
    commands = [line for line in lines if line.startswith("bash docker/setup.sh && ")]
    assert [line.split("&& ")[1] for line in commands] == [
        ".venv/bin/flipflow run cases/quickstart",
        ".venv/bin/python -m pytest",
    ]
