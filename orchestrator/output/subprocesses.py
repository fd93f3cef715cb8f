"""Processes that run parts of this program.

They import the same modules as this process, and nothing from the folder in which they start, where a
case may have put any file.
"""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]


LAUNCHERS = ("OMPI_", "ORTE_", "PMI_", "PMIX_")
"""The prefixes of the environment variables that tell a process its rank under mpirun."""


WITH_PARENT = ("setpriv", "--pdeathsig", "KILL")
"""The words before a command that is killed when the process that started it dies (Debian's util-linux)."""


_RUNNING: set[subprocess.Popen[str]] = set()


def python(
    *words: str, alone: bool = False, capture_output: bool = False, timeout: float | None = None, **more: Any
) -> subprocess.CompletedProcess[str]:
    """Run ``python WORDS`` to its end, with the arguments ``more`` of subprocess.Popen.

    With ``alone``, the program runs as a single process even if this process is a rank under mpirun.  The
    program is killed if this process dies, and if this call is interrupted or takes longer than ``timeout``
    seconds, which raises subprocess.TimeoutExpired.
    """
    paths = [str(ROOT), *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    own = {"PYTHONPATH": os.pathsep.join(paths)}
    env = os.environ | own | more.pop("env", {})
    if alone:
        env = {name: value for name, value in env.items() if not name.startswith(LAUNCHERS)}
    if capture_output:
        more |= {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}
    command = [*WITH_PARENT, sys.executable, "-P", *words]
    with subprocess.Popen(command, env=env, text=True, **more) as process:
        _RUNNING.add(process)
        try:
            written = process.communicate(timeout=timeout)
        except BaseException:
            process.kill()
            raise
        finally:
            _RUNNING.discard(process)
    return subprocess.CompletedProcess(command, process.returncode, *written)


def stop_all() -> None:
    """Ask all programs that run now to stop, those that other threads wait for, too."""
    for process in tuple(_RUNNING):
        process.terminate()
