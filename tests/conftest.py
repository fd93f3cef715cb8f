"""What holds for all tests in one process.

PyVista brings its own VTK, and Debian's DOLFINx loads another one.  The process dies where PyVista
is the second of them.  A run has it first, since its case is checked before solvers are opened;
tests come in any order.
"""

import pyvista  # noqa: F401
