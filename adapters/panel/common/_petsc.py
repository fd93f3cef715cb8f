"""PETSc without option files.  To be imported before anything that imports PETSc, which would take
options, and libraries to load, from ``.petscrc`` in the folder that the program is started in."""

from __future__ import annotations

import petsc4py

petsc4py.init(["flipflow", "-skip_petscrc"])
