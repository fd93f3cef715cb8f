"""The repair of triangulations as programs write them: doubles, triangles without area, mixed orientation.

Particles touch a rigid surface from both sides.  So neither the orientation of its triangles nor three sheets
at an edge change a contact; they are put in order or counted, and never refused.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.sparse import coo_array
from scipy.sparse.csgraph import breadth_first_order, connected_components
from scipy.spatial import cKDTree

from orchestrator.case.deck.stl import Facets, UnreadableSurface
from orchestrator.ports import Array, Indices
from orchestrator.ports.geometry import area_vectors_m2, distinct_edges

Mask = npt.NDArray[np.bool_]
SAME_PLACE = 1e-7  # distance of corners over the surface's extent: the rounding of numbers of 32 bits
THIN = 1e-6  # height of a triangle over the surface's extent: below, its normal is that of rounding


@dataclass(frozen=True)
class Healed:
    """A surface that can be used: each corner (n, 3) once, and triangles (m, 3) of corners' numbers.

    ``healed`` says what was changed, ``left`` what is unusual and stays, ``open_edges`` how many edges belong
    to one triangle alone, and ``volume_m3`` what a closed surface encloses; it is NaN for an open one.
    """

    position_m: Array
    triangles: Indices
    healed: tuple[str, ...]
    left: tuple[str, ...]
    open_edges: int
    volume_m3: float

    @property
    def line(self) -> str:
        """All that was changed and all that is unusual, in one line; empty for a clean surface."""
        return ", ".join(self.healed + self.left)


def heal(facets: Facets) -> Healed:
    """Return a surface without doubles and triangles without area, whose neighbours are oriented alike.

    Closed parts get normals outwards.  Raises UnreadableSurface if no triangle is left.
    """
    extent_m = float(np.ptp(facets.position_m, axis=0).max())
    joined, position_m, number = _joined(facets.position_m, SAME_PLACE * extent_m)
    triangles = number[facets.triangles]
    corners_m = position_m[triangles]
    edges_m = np.linalg.norm(corners_m - np.roll(corners_m, 1, axis=1), axis=2)
    double_area_m2 = 2 * np.linalg.norm(area_vectors_m2(corners_m), axis=1)
    flat = double_area_m2 <= THIN * extent_m * edges_m.max(axis=1)
    if flat.all():
        raise UnreadableSurface("has no triangle with an area")
    against = int((np.einsum("ij,ij->i", area_vectors_m2(corners_m), facets.normal) < 0)[~flat].sum())
    triangles = triangles[~flat]
    _, first = np.unique(np.sort(triangles, axis=1), axis=0, return_index=True)
    doubles = len(triangles) - len(first)
    triangles = triangles[np.sort(first)]
    triangles, turned = _oriented(position_m, triangles)
    _, _, sharing = distinct_edges(triangles)
    open_edges, crowded = int((sharing == 1).sum()), int((sharing > 2).sum())
    used, compact = np.unique(triangles, return_inverse=True)
    position_m, triangles = position_m[used], compact.reshape(-1, 3).astype(np.int64)
    healed = (
        (joined, "corners joined to one that is as near as rounding"),
        (int(flat.sum()), "triangles without area removed"),
        (doubles, "double triangles removed"),
        (turned, "triangles turned over"),
        (against, "normals in the file contradict the corners, which count"),
    )
    return Healed(
        position_m,
        triangles,
        tuple(f"{count} {what}" for count, what in healed if count),
        (f"{crowded} edges have three or more triangles",) if crowded else (),
        open_edges,
        float("nan") if open_edges else _volume_m3(position_m[triangles]),
    )


def _joined(position_m: Array, distance_m: float) -> tuple[int, Array, Indices]:
    """Return how many corners (n, 3) are joined to another, those that stay, and new numbers (n,)."""
    pairs = cKDTree(position_m).query_pairs(distance_m, output_type="ndarray")
    number = np.arange(len(position_m))
    if len(pairs):
        _, label = connected_components(_graph(pairs, len(position_m)), directed=False)
        _, first, number = np.unique(label, return_index=True, return_inverse=True)
        order = np.argsort(first)  # Corners keep their order.
        position_m, number = position_m[first[order]], np.argsort(order)[number]
    return len(number) - len(position_m), position_m, number


def _graph(pairs: Indices, size: int) -> coo_array:
    return coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(size, size)).tocsr()


def _oriented(position_m: Array, triangles: Indices) -> tuple[Indices, int]:
    """Return triangles (m, 3) of which neighbours are oriented alike, and how many were turned over.

    In each connected part, fewer than half are turned over, or those that make a closed part's normals point
    outwards.  A part that has but one side stays as it is.
    """
    edges = triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)  # as these run through them
    _, number, sharing = distinct_edges(triangles)
    in_turn = np.argsort(number, kind="stable")
    begin = np.concatenate([[0], np.cumsum(sharing)[:-1]])[sharing == 2]
    one, two = in_turn[begin], in_turn[begin + 1]
    alike = (edges[one] == edges[two]).all(axis=1)  # Neighbours that agree run through an edge contrarily.
    pairs = np.stack([one // 3, two // 3], axis=1)
    parts, part = connected_components(_graph(pairs, len(triangles)), directed=False)
    is_open = np.zeros(parts, dtype=np.bool_)
    is_open[part[np.flatnonzero(sharing[number] != 2) // 3]] = True
    turn = np.zeros(len(triangles), dtype=np.bool_)
    for wrong in np.unique(part[pairs[alike, 0]]):
        _turn_part(turn, np.flatnonzero(part == wrong), pairs, alike, part[pairs[:, 0]] == wrong)
    signed = np.where(turn, -1.0, 1.0) * np.linalg.det(position_m[triangles] - position_m.mean(axis=0))
    inwards = (np.bincount(part, signed, parts) < 0) & ~is_open
    turn ^= inwards[part]
    triangles = np.where(turn[:, None], triangles[:, [0, 2, 1]], triangles)
    return triangles, int(turn.sum())


def _turn_part(turn: Mask, members: Indices, pairs: Indices, alike: Mask, inside: Mask) -> None:
    """Set in ``turn`` which ``members`` of one connected part have to be turned over."""
    local = np.full(len(turn), -1)
    local[members] = np.arange(len(members))
    near, differ = local[pairs[inside]], alike[inside]
    graph = _graph(near, len(members))
    order, before = breadth_first_order(graph + graph.T, 0, directed=False)
    key = np.sort(near, axis=1) @ [len(members), 1]
    kept = np.argsort(key, kind="stable")
    rows = np.sort(np.stack([order[1:], before[order[1:]]], axis=1), axis=1) @ [len(members), 1]
    step = differ[kept[np.searchsorted(key[kept], rows)]]
    turned = np.zeros(len(members), dtype=np.bool_)
    for child, other in zip(order[1:], step, strict=True):
        turned[child] = turned[before[child]] ^ other
    if (turned[near[:, 0]] ^ turned[near[:, 1]] != differ).any():
        return  # A band with one side, as that of Moebius, has no orientation.
    turn[members] = turned if turned.sum() * 2 <= len(members) else ~turned


def _volume_m3(corners_m: Array) -> float:
    """Return the volume that closed triangles (m, 3, 3) enclose, by the divergence theorem."""
    return abs(float(np.linalg.det(corners_m - corners_m.reshape(-1, 3).mean(axis=0)).sum())) / 6
