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
NOT_BARE_12 = "NOT ON A BARE DEBIAN 12"
NOTHING_ON_13 = "NOTHING RAN ON DEBIAN 13"


@pytest.mark.process
@pytest.mark.parametrize(
    ("twelve", "here", "thirteen", "code", "loud", "ran"),
    [
        (0, 0, 0, 0, (), ["bare.sh", THIRTEEN]),
        (0, 0, 1, 1, (), ["bare.sh", THIRTEEN]),
        (0, 0, 125, 125, (NOTHING_ON_13,), ["bare.sh", THIRTEEN]),
        (1, 0, 0, 1, (), ["bare.sh"]),  # a test failed there: that is the answer
        (125, 0, 0, 0, (NOT_BARE_12,), ["bare.sh", *DIRECTLY, THIRTEEN]),
        (125, 0, 125, 125, (NOT_BARE_12, NOTHING_ON_13), ["bare.sh", *DIRECTLY, THIRTEEN]),
        (125, 1, 125, 1, (NOT_BARE_12,), ["bare.sh", *DIRECTLY]),
    ],
)
def test_ci_runs_everything_once(
    tmp_path: Path, twelve: int, here: int, thirteen: int, code: int, loud: tuple[str, ...], ran: list[str]
) -> None:
    for program, does in (
        ("docker/bare.sh", f"echo bare.sh ${{@:1:2}}; [ $# = 0 ] && exit {twelve} || exit {thirteen}"),
        ("docker/setup.sh", "echo setup.sh"),
        (".venv/bin/flipflow", 'echo flipflow "$@"'),
        (".venv/bin/python", f'echo python "$@"; exit {here}'),
    ):
        file = tmp_path / program
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text(f"#!/usr/bin/env bash\n{does}\n")
        file.chmod(0o755)
    (tmp_path / ".ci").mkdir()
    shutil.copy(ROOT / ".ci/run", tmp_path / ".ci/run")
    done = subprocess.run(["bash", ".ci/run"], cwd=tmp_path, capture_output=True, encoding="utf-8")
    assert done.returncode == code
    assert tuple(words for words in (NOT_BARE_12, NOTHING_ON_13) if words in done.stderr) == loud
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
