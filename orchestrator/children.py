"""This program in processes of its own, which import what it imports: nothing from the folder that
they are started in, where a case may have laid anything."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]


def python(*words: str, **more: Any) -> subprocess.CompletedProcess[str]:
    """``python WORDS`` run to its end; ``more`` as for subprocess.run."""
    paths = [str(ROOT), *filter(None, os.environ.get("PYTHONPATH", "").split(os.pathsep))]
    own = {"PYTHONPATH": os.pathsep.join(paths)}
    env = os.environ | own | more.pop("env", {})
    return subprocess.run([sys.executable, "-P", *words], env=env, text=True, check=False, **more)
