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


def python(*words: str, alone: bool = False, **more: Any) -> subprocess.CompletedProcess[str]:
    """Run ``python WORDS`` to its end, with the arguments ``more`` of subprocess.run.

    With ``alone``, the program runs as a single process even if this process is a rank under mpirun.
    """
    paths = [str(ROOT), *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    own = {"PYTHONPATH": os.pathsep.join(paths)}
    env = os.environ | own | more.pop("env", {})
    if alone:
        env = {name: value for name, value in env.items() if not name.startswith(LAUNCHERS)}
    return subprocess.run([sys.executable, "-P", *words], env=env, text=True, check=False, **more)
