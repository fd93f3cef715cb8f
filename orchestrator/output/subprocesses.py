"""This program in processes of its own, which import what it imports: nothing from the folder that
they are started in, where a case may have laid anything."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[2]


LAUNCHERS = ("OMPI_", "ORTE_", "PMI_", "PMIX_")
"""Beginnings of the variables by which a process knows that it is one of several under mpirun."""


def python(*words: str, alone: bool = False, **more: Any) -> subprocess.CompletedProcess[str]:
    """Run ``python WORDS`` to its end; ``more`` as for subprocess.run.  ``alone``: as a program of one
    process, also where this one is a rank under mpirun."""
    paths = [str(ROOT), *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    own = {"PYTHONPATH": os.pathsep.join(paths)}
    env = os.environ | own | more.pop("env", {})
    if alone:
        env = {name: value for name, value in env.items() if not name.startswith(LAUNCHERS)}
    return subprocess.run([sys.executable, "-P", *words], env=env, text=True, check=False, **more)
