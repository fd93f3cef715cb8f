"""Openings of any outline: where they repeat, what passes them, and whether they are apart."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from orchestrator.ports import Array, Indices

Outline = tuple[tuple[float, float], ...]
SAME = 1e-6  # of the largest opening: places and outlines that differ by less are the same
SIZES = 256  # steps of the table of what passes, whose area is linear between them: 1e-4 of an opening
INSCRIBED = 1e-5  # of an opening's size: what the radius of its largest sphere may lack


@dataclass(frozen=True)
class Drawing:
    """What stands in a drawing of a panel.

    ``outlines_m`` has the corners (x, y) of each opening, anticlockwise, from the lowest corner of the
    panel's outline, or else from the origin of the drawing.  ``sheet_m`` has the sides of that outline,
    clamped strips included; None without it.  ``ignored`` says what else the file has.
    """

    outlines_m: tuple[Outline, ...]
    sheet_m: tuple[float, float] | None
    ignored: str = ""


@dataclass(frozen=True)
class DrawnOpenings:
    """Openings in a rectangular panel, in its material coordinates.

    ``outlines_m`` has the corners (s, y) of each opening, anticlockwise, and ``panel_m`` the free length and
    the width of the panel.  No opening touches another one or itself (``faults``).
    """

    outlines_m: tuple[Outline, ...]
    panel_m: tuple[float, float]

    def __len__(self) -> int:
        return len(self.outlines_m)

    @cached_property
    def corners_m(self) -> tuple[Array, ...]:
        """The outlines as arrays (corners, 2)."""
        return tuple(np.array(outline) for outline in self.outlines_m)

    @cached_property
    def boxes_m(self) -> Array:
        """The lowest and highest (s, y) of each opening, (openings, 2, 2)."""
        return np.array([[corners.min(axis=0), corners.max(axis=0)] for corners in self.corners_m])

    @property
    def centres_m(self) -> Array:
        """The middles (openings, 2) of the boxes around the openings."""
        return np.asarray(self.boxes_m.mean(axis=1))

    @cached_property
    def areas_m2(self) -> Array:
        """The area (openings,) of each opening."""
        return np.array([area_m2(corners) for corners in self.corners_m])

    @cached_property
    def land_m(self) -> float:
        """The least distance between two openings; infinite for a single one."""
        from shapely import STRtree

        if len(self) == 1:
            return math.inf
        _, apart_m = STRtree(self._polygons).query_nearest(
            self._polygons, exclusive=True, return_distance=True
        )
        return float(apart_m.min())

    @cached_property
    def repeats_m(self) -> tuple[float, float]:
        """The least distances along and across after which the openings repeat; 0 where they do not."""
        along_m, across_m = (self._least_repeat_m(axis) for axis in (0, 1))
        return along_m, across_m

    @cached_property
    def period_m(self) -> tuple[float, float]:
        """The distances along and across after which the openings repeat themselves.

        In a direction in which they do not, it is the length of the whole region.
        """
        along_m, across_m = (self.repeats_m[axis] or float(np.ptp(self.region_m[:, axis])) for axis in (0, 1))
        return along_m, across_m

    @cached_property
    def region_m(self) -> Array:
        """The lowest and highest (s, y) of the perforated region, (2, 2).

        Where openings repeat, it consists of whole pitches, of which one holds a row.  Elsewhere it goes half
        the least land beyond them.
        """
        low_m, high_m = self.boxes_m[:, 0].min(axis=0), self.boxes_m[:, 1].max(axis=0)
        size_m = high_m - low_m + self.land_m
        for axis in (0, 1):
            if pitch_m := self.repeats_m[axis]:
                pitch_m /= len(self._rows_m(pitch_m)) if axis == 0 else 1
                size_m[axis] = np.ceil((high_m - low_m)[axis] / pitch_m - SAME) * pitch_m
        middle_m = (low_m + high_m) / 2
        return np.clip([middle_m - size_m / 2, middle_m + size_m / 2], 0.0, self.panel_m)

    @property
    def pitch_m(self) -> tuple[float, float]:
        """The mean distances of openings along and across.

        Where no rows repeat, lands are taken as equally wide in both directions.
        """
        cell_m2 = math.prod(self.period_m) / len(self._in_period)
        if period_m := self.repeats_m[0]:
            along_m = period_m / len(self._rows_m(period_m))
            return along_m, cell_m2 / along_m
        length_m, width_m = self.mean_sides_m
        half_m = (length_m + width_m) / 2
        land_m = math.sqrt(max(half_m**2 + cell_m2 - length_m * width_m, 0.0)) - half_m
        return length_m + land_m, width_m + land_m

    @property
    def mean_sides_m(self) -> tuple[float, float]:
        """The mean sides of the boxes around the openings, along and across."""
        length_m, width_m = np.ptp(self.boxes_m, axis=1).mean(axis=0)
        return float(length_m), float(width_m)

    @property
    def openings_in_period(self) -> int:
        """The number of openings that are no copies of another one a period apart."""
        return len(self._in_period)

    @property
    def solid_share(self) -> float:
        """The material's share of the area of a period."""
        return float(1.0 - self.areas_m2[self._in_period].sum() / math.prod(self.period_m))

    @property
    def cell_m(self) -> list[Array]:
        """The outlines (corners, 2) of all openings that reach into a period, from its lowest corner."""
        period_m = np.array(self.period_m)
        at_m = [self.corners_m[number] - self.region_m[0] for number in self._in_period]
        copies = [at + period_m * image for at in at_m for image in np.ndindex(3, 3)]
        copies = [copy - period_m for copy in copies]
        return [copy for copy in copies if ((copy.max(axis=0) > 0) & (copy.min(axis=0) < period_m)).all()]

    @cached_property
    def spheres_m(self) -> tuple[float, float]:
        """The diameters of the largest spheres that pass the narrowest and the widest opening."""
        return float(self._spheres_m.min()), float(self._spheres_m.max())

    def passed_share(self, size_m: float) -> float:
        """Return the share of the period's area at which the center of a sphere falls through untouched."""
        return float(np.interp(size_m, *self._passed, right=0.0))

    def grown(self, outwards_m: float) -> DrawnOpenings:
        """Return the openings with all sides moved outwards, or inwards by a negative distance."""
        moved = (corners + outwards_m * outwards(corners) for corners in self.corners_m)
        return DrawnOpenings(tuple(as_outline(corners) for corners in moved), self.panel_m)

    @cached_property
    def _polygons(self) -> Any:
        import shapely  # takes long to import, and few cases have drawings

        return np.array([shapely.Polygon(corners) for corners in self.corners_m])

    @cached_property
    def _in_period(self) -> Indices:
        """The numbers of openings of which all others are copies, a period apart."""
        first_m = self.centres_m.min(axis=0) - SAME * self._largest_m
        beyond_m = np.array([first_m[axis] + (self.repeats_m[axis] or math.inf) for axis in (0, 1)])
        return np.flatnonzero(((self.centres_m >= first_m) & (self.centres_m < beyond_m)).all(axis=1))

    def _rows_m(self, period_m: float) -> Array:
        """Return the places along of the rows in a period."""
        s_m = np.sort(self.centres_m[:, 0])
        within_m = s_m[s_m < s_m[0] + period_m - SAME * self._largest_m]
        return np.asarray(within_m[np.append(True, np.diff(within_m) > SAME * self._largest_m)])

    @property
    def _largest_m(self) -> float:
        return float(np.ptp(self.boxes_m, axis=1).max())

    @cached_property
    def _described_m(self) -> Array:
        """The middle of each opening, and lengths that are equal for copies: (openings, 10).

        The latter are the sides of its box, the place of its centroid in it, and its second moments.
        """
        largest_m = self._largest_m
        about = zip(self.corners_m, self.centres_m, strict=True)
        moments = np.array([_moments((corners - centre) / largest_m) for corners, centre in about])
        return np.column_stack([self.centres_m, np.ptp(self.boxes_m, axis=1), largest_m * moments])

    def _least_repeat_m(self, axis: int) -> float:
        """Return the first distance to a copy of the lowest opening after which all openings repeat.

        Each has a copy before or behind it, and both where the region goes on.
        """
        from scipy.spatial import cKDTree  # takes long to import, and few cases have drawings

        slack_m = SAME * self._largest_m
        places_m = self._described_m
        tree, along = cKDTree(places_m), places_m[:, axis]
        first = int(np.argmin(along))
        rest = np.delete(places_m, axis, axis=1)
        in_line = np.abs(rest - rest[first]).max(axis=1) < slack_m
        for candidate_m in np.sort(along[in_line] - along[first])[1:]:
            step_m = candidate_m * np.eye(places_m.shape[1])[axis]
            copied = []
            for way, wanted in (
                (step_m, along + candidate_m <= along.max() + slack_m),
                (-step_m, along - candidate_m >= along.min() - slack_m),
            ):
                copied.append(tree.query(places_m + way)[0] < slack_m)
                if not copied[-1][wanted].all():
                    break
            else:
                if (copied[0] | copied[1]).all():
                    return float(candidate_m)
        return 0.0

    @cached_property
    def _spheres_m(self) -> Array:
        """The diameter (openings,) of the largest sphere that passes each opening, of those in a period."""
        import shapely  # takes long to import, and few cases have drawings

        polygons, size_m = self._polygons[self._in_period], np.sqrt(self.areas_m2[self._in_period])
        return np.asarray(2 * shapely.length(shapely.maximum_inscribed_circle(polygons, INSCRIBED * size_m)))

    @cached_property
    def _passed(self) -> tuple[Array, Array]:
        """The sizes of spheres, and the share of the period's area at which their centers fall through."""
        import shapely

        polygons = self._polygons[self._in_period]
        sizes_m = np.linspace(0.0, self.spheres_m[1], SIZES + 1)
        free_m2 = [shapely.area(shapely.buffer(polygons, -size_m / 2)).sum() for size_m in sizes_m]
        return sizes_m, np.array(free_m2) / math.prod(self.period_m)


def as_outline(corners_m: Array) -> Outline:
    """Return corners (n, 2) as tuples, which can be compared and remembered."""
    return tuple((float(s), float(y)) for s, y in corners_m)


def area_m2(corners_m: Array) -> float:
    """Return the area of a polygon (n, 2); it is positive for anticlockwise corners."""
    after = np.roll(corners_m, -1, axis=0)
    return float((corners_m[:, 0] * after[:, 1] - corners_m[:, 1] * after[:, 0]).sum() / 2)


def _moments(corners: Array) -> Array:
    """Return the area, the first and the second moments (6,) of an anticlockwise polygon (n, 2)."""
    (x, y), (after_x, after_y) = corners.T, np.roll(corners, -1, axis=0).T
    twice = x * after_y - after_x * y
    return np.array(
        [
            twice.sum() / 2,
            ((x + after_x) * twice).sum() / 6,
            ((y + after_y) * twice).sum() / 6,
            ((x * x + x * after_x + after_x**2) * twice).sum() / 12,
            ((y * y + y * after_y + after_y**2) * twice).sum() / 12,
            ((x * (2 * y + after_y) + after_x * (y + 2 * after_y)) * twice).sum() / 24,
        ]
    )


def outwards(corners_m: Array) -> Array:
    """Return the way (n, 2) of each corner of an anticlockwise polygon while its sides move outwards by 1."""
    sides = np.roll(corners_m, -1, axis=0) - corners_m
    after = np.column_stack([sides[:, 1], -sides[:, 0]]) / np.linalg.norm(sides, axis=1)[:, None]
    before = np.roll(after, 1, axis=0)
    return np.asarray((after + before) / (1.0 + (after * before).sum(axis=1))[:, None])


def faults(outlines_m: Sequence[Array]) -> Iterator[str]:
    """Yield a sentence for the first outline (n, 2) that crosses itself, and for the first two that meet."""
    import shapely

    polygons = np.array([shapely.Polygon(corners) for corners in outlines_m])
    crossed = np.flatnonzero(~shapely.is_valid(polygons))
    if len(crossed):
        yield f"the outline {_place(outlines_m[crossed[0]])} crosses or touches itself{_more(len(crossed))}"
        return
    first, second = shapely.STRtree(polygons).query(polygons, predicate="intersects")
    met = np.flatnonzero(first < second)
    if len(met):
        one, two = (outlines_m[number[met[0]]] for number in (first, second))
        yield f"the outlines {_place(one)} and {_place(two)} overlap, touch or are one twice{_more(len(met))}"


def _place(corners_m: Array) -> str:
    """Return where an outline is, in words."""
    s_mm, y_mm = 1e3 * (corners_m.min(axis=0) + corners_m.max(axis=0)) / 2
    return f"at ({s_mm:.4g}, {y_mm:.4g}) mm"


def _more(count: int) -> str:
    return f", and {count - 1} more" if count > 1 else ""
