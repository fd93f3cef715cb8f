"""Drawings of panels: the closed outlines of a DXF file, in metres.

Polylines, circles, ellipses and splines are outlines where they are closed, and so are chains of lines, arcs
and other open curves.  Blocks count as what stands in them.  ezdxf reads the files.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence
from copy import deepcopy
from functools import lru_cache
from itertools import islice
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.deck.stl import UnreadableSurface, find_file
from orchestrator.case.deck.surface_file import UNITS_M
from orchestrator.case.file.errors import CaseError, CaseProblem, Key, did_you_mean
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.deck import DrawnApertures
from orchestrator.ports import Array
from orchestrator.ports.drawn_openings import Drawing, area_m2, as_outline, faults

CURVES = ("LWPOLYLINE", "POLYLINE", "CIRCLE", "ELLIPSE", "SPLINE", "LINE", "ARC")
NOTES = (
    *("TEXT", "MTEXT", "ATTDEF", "DIMENSION", "LEADER", "MULTILEADER", "HATCH", "POINT", "VIEWPORT", "IMAGE"),
)
"""Kinds that are no outlines and may stand in any drawing."""
LARGEST_BYTES = 50_000_000
MOST_CURVES = 100_000
MOST_OPENINGS = 20_000
GAP_M = 1e-5  # between the ends of curves that are one point
FLAT_M = 1e-6  # height of what counts as flat
FINEST = 64  # pieces of a curve whose area counts as exact
KEPT = 0.98  # of an opening's area, by the corners of its curves
RECTANGLE = 0.999  # of its box that the outline of a panel covers
METRES = {1: 0.0254, 2: 0.3048, 4: 1e-3, 5: 1e-2, 6: 1.0, 10: 0.9144, 13: 1e-6, 14: 0.1}
"""Values of $INSUNITS, in m."""


class UnreadableDrawing(Exception):
    """An error about a drawing; the message says what and where it is."""


def read_drawings(case: Case, folder: Path) -> Case:
    """Return the case with what stands in the drawings of its panels and decks; ``folder`` is the case's.

    Raises CaseError with a problem for each drawing that cannot be read.
    """
    screen, problems = case.screen, []
    read: dict[str, dict[str, Any]] = {"panels": {**screen.panels}, "decks": {**screen.decks}}
    for kind, rows in read.items():
        for name, row in rows.items():
            if isinstance(row.apertures, DrawnApertures):
                try:
                    apertures = row.apertures.with_drawing(read_drawing(row.apertures, folder))
                    rows[name] = row.model_copy(update={"apertures": apertures})
                except UnreadableDrawing as error:
                    key: Key = ("screen", kind, name, "apertures", "file")
                    problems.append(CaseProblem(key, f'"{row.apertures.file}" {error}', kind="file"))
    if problems:
        raise CaseError(problems)
    return case.model_copy(update={"screen": screen.model_copy(update=read)})


def fill_in_sheets(table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """Return a case's table with the lengths and widths of panels that only their drawings give.

    What cannot be read is left to the check of the tables, and to ``read_drawings``.
    """
    filled = dict(table)
    for kind in ("panels", "decks"):
        screen = filled.get("screen")
        rows = screen.get(kind) if isinstance(screen, Mapping) else None
        for name, row in rows.items() if isinstance(rows, Mapping) else ():
            if not isinstance(row, Mapping) or {"length_m", "width_m"} <= row.keys():
                continue
            try:
                drawing = read_drawing(DrawnApertures.model_validate(row.get("apertures")), folder)
                length_m, width_m = drawing.sheet_m or (None, None)
                sheet_m = {"length_m": length_m - 2 * row.get("clamp_m", 0.0), "width_m": width_m}
            except (UnreadableDrawing, ValueError, TypeError):
                continue
            filled = deepcopy(filled)
            filled["screen"][kind][name] = sheet_m | filled["screen"][kind][name]
    return filled


def read_drawing(table: DrawnApertures, folder: Path) -> Drawing:
    """Return what stands in the file that a table names.  Raises UnreadableDrawing."""
    try:
        file = find_file(folder, table.file)
    except UnreadableSurface as error:
        raise UnreadableDrawing(f"is refused: {error}") from None
    about = file.stat()
    if about.st_size > LARGEST_BYTES:
        raise UnreadableDrawing(f"is larger than {LARGEST_BYTES} bytes")
    state = (about.st_mtime_ns, about.st_size)
    return _read(file.resolve(), state, table.unit, table.layers, table.rotation_deg)


@lru_cache(maxsize=16)
def _read(
    file: Path, _state: tuple[int, int], unit: str | None, layers: tuple[str, ...], rotation_deg: int
) -> Drawing:
    """Read a file once, as long as its ``_state``, the time and size of its last change, stays."""
    curves, told_m, ignored = _curves(file, layers)
    unit_m = UNITS_M[unit] if unit else told_m
    if unit_m is None:
        raise UnreadableDrawing(f"does not say its unit ($INSUNITS): give unit, one of {', '.join(UNITS_M)}")
    quarters = rotation_deg // 90
    turn = np.linalg.matrix_power(np.array([[0, 1], [-1, 0]]), quarters)
    outlines = [unit_m * _polygon(ring) @ turn for ring in _rings(curves, unit_m)]
    outlines = [at if area_m2(at) > 0 else at[::-1] for at in outlines]
    sheet_m, low_m, openings = _sheet(outlines)
    if not openings:
        raise UnreadableDrawing("has no openings: no closed outlines besides that of the panel")
    if len(openings) > MOST_OPENINGS:
        raise UnreadableDrawing(f"has {len(openings)} openings, more than {MOST_OPENINGS}")
    for fault in faults(openings):
        raise UnreadableDrawing(f"cannot be cut out: {fault}")
    return Drawing(tuple(as_outline(at - low_m) for at in openings), sheet_m, ignored)


def _curves(file: Path, layers: tuple[str, ...]) -> tuple[list[Any], float | None, str]:
    """Return the curves of a file's layers as paths of ezdxf, the file's unit in m, and what else it has.

    Raises UnreadableDrawing.
    """
    # these imports take long, and few cases have drawings
    from ezdxf.filemanagement import readfile
    from ezdxf.path import make_path

    try:
        drawing = readfile(file)
        shown = [*islice(_shown(drawing.modelspace()), MOST_CURVES + 1)]
        kinds = Counter(entity.dxftype() for _, entity in shown if entity.dxftype() not in CURVES)
        curves = [(layer, entity) for layer, entity in shown if entity.dxftype() in CURVES]
        paths = [(layer, make_path(entity)) for layer, entity in curves if _is_wanted(layer, layers)]
    except Exception as error:  # whatever a damaged file makes of the library
        said = f": {error.strerror}" if isinstance(error, OSError) and error.strerror else ""
        raise UnreadableDrawing(f"is damaged, or no DXF file{said}: export it again") from None
    if len(shown) > MOST_CURVES:
        raise UnreadableDrawing(f"has more than {MOST_CURVES} curves and notes")
    present = sorted({layer for layer, _ in curves})
    for layer in layers:
        if layer.casefold() not in map(str.casefold, present):
            raise UnreadableDrawing(f'has no curves on a layer "{layer}": {did_you_mean(layer, present)}')
    if len(present) > 1 and not layers:
        names = ", ".join(f'"{layer}"' for layer in present)
        raise UnreadableDrawing(f"has curves on the layers {names}: name those with outlines by layers")
    for kind in kinds.keys() - set(NOTES):
        raise UnreadableDrawing(f"has {kinds[kind]} of the kind {kind}: turn them into polylines")
    ignored = ", ".join(f"{count} {kind}" for kind, count in sorted(kinds.items()))
    return [path for _, path in paths if len(path)], METRES.get(drawing.units), ignored


def _is_wanted(layer: str, layers: tuple[str, ...]) -> bool:
    return not layers or layer.casefold() in map(str.casefold, layers)


def _shown(entities: Iterable[Any], above: str = "0") -> Iterator[tuple[str, Any]]:
    """Yield layer and entity of all that stands in a drawing, blocks taken apart.

    What is on layer 0 of a block is on the layer of the block.
    """
    for entity in entities:
        layer = above if entity.dxf.layer == "0" else entity.dxf.layer
        if entity.dxftype() != "INSERT":
            yield layer, entity
            continue
        for copy in entity.multi_insert() if entity.mcount > 1 else [entity]:
            yield from _shown(copy.virtual_entities(), layer)


def _rings(curves: Sequence[Any], unit_m: float) -> Iterator[list[Any]]:
    """Yield the curves of each closed outline, one after the other.  Raises UnreadableDrawing."""
    from ezdxf.edgeminer import Deposit, find_all_simple_chains, is_loop, make_edge

    gap = GAP_M / unit_m
    if any(abs(place.z) > FLAT_M / unit_m for curve in curves for place in curve.control_vertices()):
        raise UnreadableDrawing("is not flat: its curves have heights; project them onto z = 0")
    closed = [curve.start.distance(curve.end) <= gap for curve in curves]
    yield from ([curve] for curve, is_ring in zip(curves, closed, strict=True) if is_ring)
    edges = [
        make_edge(curve.start, curve.end, payload=curve)
        for curve, is_ring in zip(curves, closed, strict=True)
        if not is_ring
    ]
    chains = find_all_simple_chains(Deposit(edges, gap_tol=gap)) if edges else []
    loose = [chain for chain in chains if len(chain) < 2 or not is_loop(chain, gap_tol=gap)]
    if loose:
        x_mm, y_mm = (1e3 * unit_m * value for value in (loose[0][0].start.x, loose[0][0].start.y))
        more = f", and {len(loose) - 1} more" if len(loose) > 1 else ""
        what = f"has curves that close no outline, from ({x_mm:.4g}, {y_mm:.4g}) mm on{more}"
        raise UnreadableDrawing(f"{what}: join or remove them")
    for chain in sorted(map(_from_first, chains), key=lambda chain: chain[0].id):
        yield [edge.payload.reversed() if edge.is_reverse else edge.payload for edge in chain]


def _from_first(chain: Sequence[Any]) -> list[Any]:
    """Return the edges of a loop from the first one of the file on, in its direction."""
    first = min(range(len(chain)), key=lambda number: chain[number].id)
    chain = [*chain[first:], *chain[:first]]
    return chain if not chain[0].is_reverse else [edge.reversed() for edge in (chain[0], *chain[:0:-1])]


def _polygon(ring: Sequence[Any]) -> Array:
    """Return the corners (n, 2) of a closed outline, in units of the drawing.

    Curves are cut into the fewest equal pieces that keep 98 % of the area.  Raises UnreadableDrawing for an
    outline without area.
    """
    whole = abs(area_m2(_corners(ring, FINEST)))
    if whole == 0.0:
        x, y = ring[0].start.x, ring[0].start.y
        raise UnreadableDrawing(f"has an outline without area at ({x:.4g}, {y:.4g})")
    pieces = 1
    while abs(abs(area_m2(corners := _corners(ring, pieces))) - whole) > (1 - KEPT) * whole:
        pieces += 1
    return corners


def _corners(ring: Sequence[Any], pieces: int) -> Array:
    """Return the corners (n, 2) of an outline whose curves have so many pieces, each corner once."""
    places = [place for curve in ring for place in curve.flattening(1e99, segments=pieces)]
    corners = np.array([(place.x, place.y) for place in places])
    far = np.linalg.norm(corners - np.roll(corners, 1, axis=0), axis=1)
    kept = corners[far > 1e-9 * np.ptp(corners, axis=0).max()]
    sides = np.roll(kept, -1, axis=0) - kept
    before = np.roll(sides, 1, axis=0)
    turned = sides[:, 0] * before[:, 1] - sides[:, 1] * before[:, 0]
    straight = np.abs(turned) <= 1e-9 * np.linalg.norm(sides, axis=1) * np.linalg.norm(before, axis=1)
    return np.asarray(kept[~straight])


def _sheet(outlines: list[Array]) -> tuple[tuple[float, float] | None, Array, list[Array]]:
    """Return the sides of the panel's outline and its lowest corner, or else the origin, and the openings.

    The panel's outline is the one around all others.  Raises UnreadableDrawing if it is no rectangle.
    """
    if len(outlines) < 2:
        return None, np.zeros(2), outlines
    boxes = np.array([[at.min(axis=0), at.max(axis=0)] for at in outlines])
    around = (boxes[:, 0] <= boxes[:, 0].min(axis=0)) & (boxes[:, 1] >= boxes[:, 1].max(axis=0))
    widest = np.flatnonzero(around.all(axis=1))
    if len(widest) != 1:
        return None, np.zeros(2), outlines
    outline = outlines[widest[0]]
    low_m, high_m = boxes[widest[0]]
    length_m, width_m = high_m - low_m
    if area_m2(outline) < RECTANGLE * length_m * width_m:
        what = f"covers {area_m2(outline) / (length_m * width_m):.1%} of its box"
        raise UnreadableDrawing(
            f"has an outline around all others that is not a rectangle along its axes, but {what}: panels are"
        )
    openings = [at for number, at in enumerate(outlines) if number != widest[0]]
    return (float(length_m), float(width_m)), low_m, openings
