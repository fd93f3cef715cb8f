"""Side walls and a back wall around a deck, as an STL file: ``cases/quickstart/walls.stl``.

    python -m meshes.side_walls cases/quickstart/walls.stl -0.019 0.657 0.0 0.2 -0.06 0.16

Six triangles in deck axes: two walls along the deck and one across its upper end; the lower end
is open.  Normals point to the bed.
"""

from __future__ import annotations

import sys
from pathlib import Path

import meshio
import numpy as np


def side_walls(x_m: tuple[float, float], y_m: tuple[float, float], z_m: tuple[float, float]) -> meshio.Mesh:
    """A mesh of 8 points and 6 triangles between the given limits."""
    points = np.array([(x, y, z) for x in x_m for y in y_m for z in z_m])
    triangles = np.array([(0, 1, 5), (0, 5, 4), (2, 7, 3), (2, 6, 7), (0, 3, 1), (0, 2, 3)], dtype=np.int64)
    return meshio.Mesh(points, [("triangle", triangles)])


def main(words: list[str]) -> None:
    """Write the file that the command line names."""
    file, (a, b, c, d, e, f) = Path(words[0]), map(float, words[1:])
    meshio.stl.write(file, side_walls((a, b), (c, d), (e, f)))


if __name__ == "__main__":
    main(sys.argv[1:])
