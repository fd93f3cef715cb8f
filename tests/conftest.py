"""Settings of all tests in one process, and of those that they start.

PyVista brings its own VTK, and Debian's DOLFINx loads another one.  The process dies where PyVista
is the second of them.  A run has it first, since its case is checked before solvers are opened;
tests come in any order.

Examples that are drawn are the same ones every time, so that a change is judged by what it
changes; new ones are looked for by ``pytest tests/case --hypothesis-profile=long``.

The reference solvers of ``tests/reference`` can be named in a case.

Compiled modules are kept even where the environment says otherwise: hundreds of processes are started,
and each would compile the program anew.
"""

import os
import sys

import pyvista  # noqa: F401
from hypothesis import settings

from tests import reference

settings.register_profile("same", derandomize=True)
settings.load_profile("same")
reference.install()
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False
