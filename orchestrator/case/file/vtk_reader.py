"""A program that reads the points of a VTK file with their arrays, and writes them as .npz.

    python -m orchestrator.case.file.vtk_reader FILE OUT

VTK may crash, hang, or take all memory for a damaged file.  So it runs in this process, with limits.
``names`` of the result has the names of the arrays ``arr_0``, ``arr_1`` and so on, of which the first has
the points.  Exit code: 0 if the file is whole.
"""

from __future__ import annotations

import resource
import sys
import warnings

import numpy as np

MEMORY_BYTES = 8_000_000_000
CPU_S = 120


def main() -> None:
    """Read the file that the command line names."""
    import pyvista
    from vtkmodules.vtkCommonCore import vtkOutputWindow, vtkStringOutputWindow

    resource.setrlimit(resource.RLIMIT_AS, (MEMORY_BYTES, MEMORY_BYTES))
    resource.setrlimit(resource.RLIMIT_CPU, (CPU_S, CPU_S))
    warnings.simplefilter("ignore")
    name, out = sys.argv[1:]
    told = vtkStringOutputWindow()
    vtkOutputWindow.SetInstance(told)  # VTK says of a damaged file that it is one, and reads on
    mesh = pyvista.read(name)
    arrays = {"Points": mesh.points, **{name: mesh.point_data[name] for name in mesh.point_data}}
    if told.GetOutput().strip():
        raise SystemExit(2)
    np.savez(out, *(np.asarray(array) for array in arrays.values()), names=np.array([*arrays]))


if __name__ == "__main__":
    main()
