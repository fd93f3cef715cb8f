"""Clumps: shapes from a list of overlapping spheres, with volume, centre, inertia and sieve size computed."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import cache
from itertools import combinations, pairwise

import numpy as np

from orchestrator.ports.grains import Shape
from orchestrator.ports.interface_records import Array

TOUCHING = 1e-9
"""Share of the sum of two radii up to which spheres that are this far apart still touch."""
NODES = 16
"""Gauss points of each piece between two heights at which the outline of a cross-section changes its kind,
and of each arc: integrals are exact to about 1e-10 with them."""
SAME_MOMENT = 1e-9
"""Share of the largest moment of inertia below which products of inertia are rounding."""
DIGITS = 12
"""Digits behind the point to which the numbers of a shape are told: what rounding does differently on two
machines is finer."""
STARTS = 64
"""Number of the best of ``ATTITUDES`` random attitudes from which the sieve size is minimised."""
ATTITUDES = 4096


def clump(name: str, about: str, spheres: Sequence[Sequence[float]]) -> Shape:
    """Return the shape that spheres of place and radius (x, y, z, r) make together, in any unit of length.

    It is a solid of one density: what several spheres have in common counts once.  The shape has the sieve
    size 1, its centre of mass in the origin and principal axes, the largest moment of inertia first.  Where
    the given axes are principal ones, they are only put into that order.

    Raises ValueError for a list that makes no grain: without spheres, with numbers that are not finite, radii
    that are not positive, or spheres that do not hang together.
    """
    given = _checked(spheres)
    if len(given) == 1:
        return Shape(name, about, ((0.0, 0.0, 0.0, 0.5),), math.pi / 6, (math.pi / 60,) * 3)
    scale = float(given[:, 3].max())
    unit = given / scale
    volume, centre, second = moments(unit)
    unit = unit - np.array([*centre, 0.0])
    inertia = np.trace(second) * np.eye(3) - second
    axes = _principal_axes(inertia)
    unit[:, :3] = unit[:, :3] @ axes
    size = sieve_size(unit)
    own = [tuple(row) for row in _rounded(unit / size).tolist()]
    across, between, along = _rounded(np.diag(axes.T @ inertia @ axes) / size**5).tolist()
    return Shape(name, about, tuple(own), float(_rounded(volume / size**3)), (across, between, along))


def divided(shape: Shape, parts: int) -> Shape:
    """Return a shape with finer dents, whose spheres are those of ``divided_spheres``.

    Outline and sieve size are the same; the depth of dents goes with the square of their length.
    """
    if parts == 1 or len(shape.spheres) == 1:
        return shape
    return clump(shape.name, shape.about, divided_spheres(shape.spheres, parts))


def divided_spheres(
    spheres: Sequence[tuple[float, float, float, float]], parts: int
) -> list[tuple[float, ...]]:
    """Return the spheres (x, y, z, r) of a shape, with the way between each two that overlap or touch divided
    into ``parts`` by others, and triangles of such spheres filled as finely.

    Each sphere that is put in lies in the hull of two or three others: place and radius are in proportion.
    """
    own = np.array(spheres)
    apart = np.linalg.norm(own[:, None, :3] - own[None, :, :3], axis=2)
    meets = apart <= np.add.outer(own[:, 3], own[:, 3]) * (1.0 + TOUCHING)
    every = [*own]
    for count in (2, 3):
        shares = [share for share in _compositions(parts, count) if min(share) > 0]
        for corners in combinations(range(len(own)), count):
            if all(meets[pair] for pair in combinations(corners, 2)):
                every += [np.array(share) / parts @ own[list(corners)] for share in shares]
    single = np.array([row for k, row in enumerate(every) if not _is_among(row, every[:k])])
    return [tuple(row) for row in single[_not_within_another(single)].tolist()]


def _is_among(sphere: Array, others: Sequence[Array]) -> bool:
    return bool(others) and bool((np.abs(np.array(others) - sphere).max(axis=1) <= TOUCHING).any())


def _compositions(total: int, count: int) -> Iterator[tuple[int, ...]]:
    """Yield all ways to write a whole number as a sum of so many."""
    if count == 1:
        yield (total,)
        return
    for first in range(total + 1):
        yield from ((first, *rest) for rest in _compositions(total - first, count - 1))


def moments(spheres: Array) -> tuple[float, Array, Array]:
    """Return the volume of a union of spheres (n, 4), its centre (3,) and the integral (3, 3) of x x^T about
    that centre.

    Cross-sections are unions of discs, whose integrals are those along the arcs of their outline (Green's
    theorem).  Their sum over the height is Gauss's, piece by piece between the heights at which a disc or a
    corner of the outline appears or disappears; sines of the height take the roots out of the ends of pieces.
    """
    origin = spheres[:, :3].mean(axis=0)
    placed = spheres - np.array([*origin, 0.0])
    node, weight = _gauss(NODES)
    total = np.zeros(10)  # of 1, x, y, z, xx, yy, zz, xy, xz, yz
    for low, high in _pieces(placed):
        half, middle = (high - low) / 2.0, (high + low) / 2.0
        for at, share in zip(node, weight, strict=True):
            z = middle + half * math.sin(math.pi / 2.0 * at)
            thickness = share * half * math.pi / 2.0 * math.cos(math.pi / 2.0 * at)
            area, x, y, xx, yy, xy = _disc_union(placed, z)
            here = (area, x, y, z * area, xx, yy, z * z * area, xy, z * x, z * y)
            total += thickness * np.array(here)
    volume = float(total[0])
    centre = total[1:4] / volume
    xx, yy, zz, xy, xz, yz = total[4:]
    second = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) - volume * np.outer(centre, centre)
    return volume, origin + centre, second


def sieve_size(spheres: Array) -> float:
    """Return the side of the smallest square opening that a body of spheres (n, 4) passes.

    The opening is thin and rigid, and the body goes through it along the opening's normal, without turning
    on its way, in the attitude that suits it best.  So the sieve size is the side of the smallest square that
    holds the body's shadow, over all directions of light: the least of max(w(u), w(v)) over all pairs of unit
    vectors u, v at a right angle, where w is the body's width along a direction.  A bent body that turns on
    its way may get through a smaller one.

    The least is found by sequential quadratic programming (D. Kraft, DFVLR-FB 88-28, 1988, in SciPy's
    ``minimize``) from the best of many attitudes, which are the same in every call.
    """
    from scipy.optimize import minimize
    from scipy.spatial.transform import Rotation

    if len(spheres) == 1:
        return 2.0 * float(spheres[0, 3])
    outer = _on_the_hull(spheres)
    place, radius = outer[:, :3], outer[:, 3]
    i, j = np.triu_indices(len(outer), 1)
    between, both = place[i] - place[j], radius[i] + radius[j]
    thickest = 2.0 * float(radius.max())

    def sides(turn: Array) -> Array:
        """Return the widths (..., 2) along both sides of the square, whose axes are turned by ``turn``."""
        return np.asarray(np.maximum((np.abs(turn[..., :2, :] @ between.T) + both).max(axis=-1), thickest))

    attitudes = Rotation.random(ATTITUDES, random_state=0).as_matrix()
    attitudes[:3] = np.eye(3), np.roll(np.eye(3), 1, axis=0), np.roll(np.eye(3), 2, axis=0)
    found = sides(attitudes).max(axis=1)
    least = float(found.min())
    for start in attitudes[np.argsort(found, kind="stable")[:STARTS]]:

        def room(unknown: Array, start: Array = start) -> Array:
            turn = Rotation.from_rotvec(unknown[:3]).as_matrix() @ start
            along = turn[:2] @ between.T
            return np.concatenate([(unknown[3] - both - along).ravel(), (unknown[3] - both + along).ravel()])

        begin = np.array([0.0, 0.0, 0.0, sides(start).max()])
        done = minimize(
            lambda unknown: unknown[3],
            begin,
            jac=lambda _: np.array([0.0, 0.0, 0.0, 1.0]),
            bounds=[(-math.pi, math.pi)] * 3 + [(thickest, None)],
            constraints={"type": "ineq", "fun": room},
            method="SLSQP",
            options={"ftol": 1e-13, "maxiter": 200},
        )
        turn = Rotation.from_rotvec(done.x[:3]).as_matrix() @ start
        least = min(least, float(sides(turn).max()))  # of the attitude itself, whatever the method says of it
        if least <= thickest:
            break
    return least


def _rounded(values: Array | float) -> Array:
    return np.asarray(np.round(values, DIGITS) + 0.0)  # no minus zero


def _checked(spheres: Sequence[Sequence[float]]) -> Array:
    """Return the spheres (n, 4) that count: those within another one do not."""
    rows = [list(row) for row in spheres]
    if not rows:
        raise ValueError("a shape needs one sphere at least")
    if any(len(row) != 4 for row in rows):
        raise ValueError("a sphere is four numbers: x, y, z, radius")
    given = np.array(rows, dtype=float)
    if not np.isfinite(given).all() or (given[:, 3] <= 0.0).any():
        raise ValueError("places must be finite, and radii positive")
    given = given[_not_within_another(given)]
    distance = np.linalg.norm(given[:, None, :3] - given[None, :, :3], axis=2)
    reach = np.add.outer(given[:, 3], given[:, 3])
    reached, edge = {0}, [0]
    while edge:
        near = np.flatnonzero(distance[edge[0]] <= reach[edge.pop(0)] * (1.0 + TOUCHING))
        edge += [int(k) for k in near if k not in reached]
        reached.update(map(int, near))
    if len(reached) < len(given):
        lost = min(set(range(len(given))) - reached)
        x, y, z, r = given[lost]
        raise ValueError(
            f"the spheres do not hang together: that at ({x:g}, {y:g}, {z:g}) of radius {r:g} touches none "
            "that hangs on the first"
        )
    return given


def _not_within_another(spheres: Array) -> list[int]:
    kept: list[int] = []
    for k in np.argsort(-spheres[:, 3], kind="stable"):
        inside = [
            np.linalg.norm(spheres[k, :3] - spheres[j, :3]) + spheres[k, 3] <= spheres[j, 3] for j in kept
        ]
        if not any(inside):
            kept.append(int(k))
    return sorted(kept)


def _principal_axes(inertia: Array) -> Array:
    """Return the principal axes as columns (3, 3), a right-handed system, the largest moment first."""
    off = inertia - np.diag(np.diag(inertia))
    if np.abs(off).max() <= SAME_MOMENT * np.trace(inertia):
        moment, axes = np.diag(inertia), np.eye(3)
    else:
        moment, axes = np.linalg.eigh(inertia)
    # moments that are equal to rounding keep their order
    order = np.argsort(-np.round(moment / np.trace(inertia), 9), kind="stable")
    axes = axes[:, order]
    return np.asarray(axes * np.array([1.0, 1.0, np.linalg.det(axes)]))


def _on_the_hull(spheres: Array) -> Array:
    """Return the spheres that may bound a width, without those in the hull of two others."""
    kept = list(range(len(spheres)))
    for k in range(len(spheres)):
        others = [j for j in kept if j != k]
        if any(_between(spheres[k], spheres[a], spheres[b]) for a, b in combinations(others, 2)):
            kept.remove(k)
    return spheres[kept]


def _between(one: Array, a: Array, b: Array) -> bool:
    """Return whether a sphere lies within the cone of two others: one from a to b of its place has its
    radius."""
    along = b[:3] - a[:3]
    length2 = float(along @ along)
    if length2 == 0.0:
        return False
    share = float((one[:3] - a[:3]) @ along) / length2
    share = min(max(share, 0.0), 1.0)
    away = np.linalg.norm(one[:3] - a[:3] - share * along)
    return bool(away + one[3] <= (1.0 - share) * a[3] + share * b[3] + 1e-12 * (a[3] + b[3]))


def _pieces(spheres: Array) -> Iterator[tuple[float, float]]:
    """Yield the pieces of the height between which the outline of cross-sections changes its kind."""
    heights = sorted({height for height in _kinks(spheres)})
    for low, high in pairwise(heights):
        if high - low > 1e-13:
            yield low, high


def _kinks(spheres: Array) -> Iterator[float]:
    """Yield the heights of poles, of the ends of the circles in which two spheres meet, and of the points at
    which three do, where they are on the surface of the union."""

    def on_surface(point: Array, but: tuple[int, ...]) -> bool:
        inside = np.linalg.norm(spheres[:, :3] - point, axis=1) < spheres[:, 3] * (1.0 - 1e-12)
        inside[list(but)] = False
        return not inside.any()

    for k, (x, y, z, r) in enumerate(spheres):
        for pole in (z - r, z + r):
            if on_surface(np.array([x, y, pole]), (k,)):
                yield float(pole)
    circles: dict[tuple[int, int], tuple[Array, Array, float]] = {}
    for i, j in combinations(range(len(spheres)), 2):
        apart = spheres[j, :3] - spheres[i, :3]
        distance = float(np.linalg.norm(apart))
        if not abs(spheres[i, 3] - spheres[j, 3]) < distance < spheres[i, 3] + spheres[j, 3]:
            continue
        normal = apart / distance
        offset = (distance**2 + spheres[i, 3] ** 2 - spheres[j, 3] ** 2) / (2.0 * distance)
        circle_radius = math.sqrt(max(spheres[i, 3] ** 2 - offset**2, 0.0))
        centre = spheres[i, :3] + offset * normal
        circles[i, j] = centre, normal, circle_radius
        uphill = np.array([0.0, 0.0, 1.0]) - normal[2] * normal
        steep = float(np.linalg.norm(uphill))
        for end in (-1.0, 1.0):
            way = uphill / steep if steep > 1e-12 else np.zeros(3)
            point = centre + end * circle_radius * way
            if steep <= 1e-12 or on_surface(point, (i, j)):
                yield float(point[2])
    for (i, j), (centre, normal, circle_radius) in circles.items():
        for k in range(j + 1, len(spheres)):
            apart = spheres[k, :3] - centre
            height = float(apart @ normal)
            in_plane = apart - height * normal
            distance = float(np.linalg.norm(in_plane))
            other2 = spheres[k, 3] ** 2 - height**2
            if other2 <= 0.0:
                continue
            other = math.sqrt(other2)
            if not abs(circle_radius - other) < distance < circle_radius + other:
                continue
            offset = (distance**2 + circle_radius**2 - other2) / (2.0 * distance)
            rise = math.sqrt(max(circle_radius**2 - offset**2, 0.0))
            toward = in_plane / distance
            for end in (-1.0, 1.0):
                point = centre + offset * toward + end * rise * np.cross(normal, toward)
                if on_surface(point, (i, j, k)):
                    yield float(point[2])


@cache
def _gauss(points: int) -> tuple[Array, Array]:
    """Return the places in [-1, 1] and the weights of Gauss's formula."""
    node, weight = np.polynomial.legendre.leggauss(points)  # type: ignore[no-untyped-call]
    return node, weight


def _disc_union(spheres: Array, z: float) -> tuple[float, float, float, float, float, float]:
    """Return the integrals of 1, x, y, x^2, y^2 and x y over the cross-section at a height."""
    squared = spheres[:, 3] ** 2 - (z - spheres[:, 2]) ** 2
    cut = squared > 0.0
    x0, y0, radius = spheres[cut, 0], spheres[cut, 1], np.sqrt(squared[cut])
    node, weight = _gauss(2 * NODES)
    area = mx = my = mxx = myy = mxy = 0.0
    for k in range(len(radius)):
        for begin, end in _free_arcs(x0, y0, radius, k):
            angle = (begin + end) / 2.0 + (end - begin) / 2.0 * node
            length = weight * (end - begin) / 2.0
            cosine, sine = np.cos(angle), np.sin(angle)
            x, y = x0[k] + radius[k] * cosine, y0[k] + radius[k] * sine
            dx, dy = -radius[k] * sine * length, radius[k] * cosine * length
            area += float(x @ dy - y @ dx) / 2.0
            mx += float((x * x) @ dy) / 2.0
            my -= float((y * y) @ dx) / 2.0
            mxx += float((x**3) @ dy) / 3.0
            myy -= float((y**3) @ dx) / 3.0
            mxy += float((x * x * y) @ dy) / 2.0
    return area, mx, my, mxx, myy, mxy


def _free_arcs(x0: Array, y0: Array, radius: Array, k: int) -> list[tuple[float, float]]:
    """Return the arcs, from angle to angle, of a circle that are in no other disc; of two equal discs the
    first has the outline."""
    covered: list[tuple[float, float]] = []
    for j in range(len(radius)):
        if j == k:
            continue
        dx, dy = x0[j] - x0[k], y0[j] - y0[k]
        distance = math.hypot(dx, dy)
        if distance >= radius[k] + radius[j] or distance + radius[j] < radius[k]:
            continue
        if distance + radius[k] <= radius[j]:
            if distance > 0.0 or radius[k] < radius[j] or j < k:
                return []
            continue
        cosine = (distance**2 + radius[k] ** 2 - radius[j] ** 2) / (2.0 * distance * radius[k])
        half = math.acos(min(max(cosine, -1.0), 1.0))
        begin = (math.atan2(dy, dx) - half) % (2.0 * math.pi)
        end = begin + 2.0 * half
        covered.append((begin, min(end, 2.0 * math.pi)))
        if end > 2.0 * math.pi:
            covered.append((0.0, end - 2.0 * math.pi))
    free: list[tuple[float, float]] = []
    reached = 0.0
    for begin, end in sorted(covered):
        if begin > reached:
            free.append((reached, begin))
        reached = max(reached, end)
    if reached < 2.0 * math.pi:
        free.append((reached, 2.0 * math.pi))
    return free
