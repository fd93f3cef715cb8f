"""The picture of a rigid surface from a file: from above, from the side, from the end and obliquely."""

from __future__ import annotations

from typing import Any

import numpy as np
from matplotlib.collections import LineCollection, PolyCollection

from orchestrator.case.deck.heal import Healed
from orchestrator.ports import Array
from orchestrator.ports.geometry import area_vectors_m2, distinct_edges
from orchestrator.views.style import WIDE, figure

OBLIQUE = np.array([0.45, -1.0, 0.6])
"""The direction of the oblique view, towards the eye."""
VIEWS = (
    ("from above", np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]), ("x / m", "y / m")),
    ("obliquely", None, ("", "")),
    ("from the side", np.array([[1.0, 0.0, 0.0], [0.0, 0.0, 1.0]]), ("x / m", "z / m")),
    ("from the end", np.array([[0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]), ("y / m", "z / m")),
)
DARK, BRIGHT = np.array([0.45, 0.5, 0.56]), np.array([0.86, 0.89, 0.92])
OPEN = "#c1443c"


def draw_surface(healed: Healed, title: str) -> Any:
    """Return a figure of a surface in four views, with its open edges in red."""
    fig, axes = figure(2, 2, width=WIDE, height=0.7 * WIDE)
    corners_m = healed.position_m[healed.triangles]
    edges, _, sharing = distinct_edges(healed.triangles)
    open_m = healed.position_m[edges[sharing == 1]]
    for plot, (name, rows, labels) in zip(axes.flat, VIEWS, strict=True):
        right_up = _oblique_rows() if rows is None else rows
        toward = np.cross(*right_up)
        order = np.argsort(corners_m.mean(axis=1) @ toward)  # the nearest last
        seen_m = corners_m[order] @ right_up.T
        faces = PolyCollection([*seen_m], facecolors=_shades(corners_m[order], toward))
        faces.set_edgecolor("face")
        faces.set_linewidth(0.1)
        plot.add_collection(faces)
        plot.add_collection(LineCollection(open_m @ right_up.T, colors=OPEN, linewidths=0.8))
        plot.autoscale_view()
        plot.set_aspect("equal")
        plot.set(title=name, xlabel=labels[0], ylabel=labels[1])
        if rows is None:
            plot.set_axis_off()
    fig.suptitle(f"{title}; open edges are red" if len(open_m) else title)
    return fig


def _oblique_rows() -> Array:
    """Return the directions to the right and upwards (2, 3) of the oblique view."""
    toward = OBLIQUE / np.linalg.norm(OBLIQUE)
    right = np.cross([0.0, 0.0, 1.0], toward)
    right /= np.linalg.norm(right)
    return np.array([right, np.cross(toward, right)])


def _shades(corners_m: Array, toward: Array) -> Array:
    """Return colours (n, 3) of triangles (n, 3, 3), the brighter the more they face the eye."""
    area_m2 = area_vectors_m2(corners_m)
    facing = np.abs(area_m2 @ toward) / np.linalg.norm(area_m2, axis=1)
    return np.asarray(DARK + facing[:, None] * (BRIGHT - DARK))
