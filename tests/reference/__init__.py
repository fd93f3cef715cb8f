"""Reference solvers of the tests, which come into a case as those of an installed package do.

``flipflow_reference-1.0.dist-info`` names them by entry points.  Python finds it once this folder is
on the path; ``tests/conftest.py`` puts it there, for this process and for those that tests start.
"""

from __future__ import annotations

import os
import sys
from pathlib import Path

FOLDER = Path(__file__).parent
PLACES = (FOLDER.parents[1], FOLDER)  # of the package ``tests``, and of what names the solvers


def install() -> None:
    """Put the reference solvers on the path of this process and of its children."""
    for place in map(str, PLACES):
        if place not in sys.path:
            sys.path.append(place)
    before = os.environ.get("PYTHONPATH", "").split(os.pathsep)
    added = [str(place) for place in PLACES if str(place) not in before]
    os.environ["PYTHONPATH"] = os.pathsep.join(filter(None, [*added, *before]))
