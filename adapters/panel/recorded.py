"""A panel of prescribed shape: carried by its clamps, with its recorded shape on top.

    place = N clamps + shape(angle of the machine)

with N bilinear between the clamps (``orchestrator.ports.recording``).  The shape is cubic Hermite in time
between its samples and cubic between its grid's points, so the surface is C1 in both; it grows from rest
while the machine runs up.  No load changes it.

The panel has its mass.  The force that moves it, f = load + m (gravity - mean acceleration) at each point,
goes to the clamps by the lever rule N^T, so linear momentum is exact.  The recorded pull of one clamp on the
other comes on top: equal and opposite.  The forces that keep the shape do work; it is supplied.  Limits and
measurements: docs/theory/panel_recorded.md.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from adapters.panel.common.carried import CarriedSurface
from adapters.panel.common.grid import locate
from orchestrator.ports import Account, Array, HermitePath, Interpolation, Motion, Mount
from orchestrator.ports.adapters import PanelAdapter
from orchestrator.ports.plans import Cost, PanelPlan, PanelsWork
from orchestrator.ports.recording import Playback, RecordedGrid, both_ways, hats

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def build(plan: PanelPlan) -> RecordedPanel:
    """Open a panel that plays back the plan's recording.  Raises ValueError for a plan without one."""
    if plan.playback is None:
        raise ValueError(f"panel {plan.name}: nothing is recorded of it")
    return RecordedPanel(plan, plan.playback)


class RecordedPanel(CarriedSurface):
    """A ``MeshedPanel`` that plays back a recording.

    Its surface points are the points of the recorded grid.  Its clamp points are the corners of the clamps,
    row by row: y = 0 before y = width."""

    STATE = (*CarriedSurface.STATE, "_supplied_J")

    def __init__(self, plan: PanelPlan, playback: Playback) -> None:
        rectangle, self._grid = plan.rectangle, playback.recording.grid
        self._player = Player(playback)
        self._axes = np.stack([rectangle.along, rectangle.across, rectangle.normal])
        corners_m = self._grid.corners_m(rectangle)
        ends = rectangle.end(corners_m).astype(int)
        # the pull acts at the inner edges, half at each side of the panel
        inner = np.isin(corners_m[:, 0], (0.0, rectangle.length_m))
        self._pulled = np.where(inner, np.where(ends == 0, 0.5, -0.5), 0.0)[:, None]
        self._edges_m, self._supplied_J = (0.0, rectangle.length_m), 0.0
        share = plan.apertures.material_share(rectangle) if plan.apertures else 1.0
        per_area = plan.material.density_kg_per_m3 * plan.thickness_m
        super().__init__(
            f"panel {plan.name}",
            Mount(rectangle.mounted(corners_m), tuple(plan.frames[end] for end in ends)),
            self._grid.mass_kg(rectangle, per_area, share),
            plan.gravity_m_per_s2,
            self._grid.carried(rectangle),
        )

    def account(self) -> Account:
        return replace(super().account(), supplied_J={"recording": self._supplied_J})

    def interpolation(self, coordinates_m: Array) -> Interpolation:
        """Return shape functions, cubic between the grid's points and linear under the clamps."""
        from scipy.sparse import csr_array

        def values(at_m: Array) -> csr_array:
            return csr_array(interpolation_matrices(self._grid, self._edges_m, at_m)[0])

        def slopes(at_m: Array) -> tuple[csr_array, csr_array]:
            _, along, across = interpolation_matrices(self._grid, self._edges_m, at_m)
            return csr_array(along), csr_array(across)

        return Interpolation.of(coordinates_m, values, slopes)

    def _place(self, clamps: Motion, time_s: float) -> Motion:
        shape_m, rate_m_per_s = self._player.shape(time_s)
        flat = super()._place(clamps, time_s)
        return Motion(
            flat.position_m + shape_m @ self._axes, flat.velocity_m_per_s + rate_m_per_s @ self._axes
        )

    def _pull_N(self, time_s: float) -> Array:
        return np.asarray(self._pulled * (self._player.pull_N(time_s) @ self._axes))

    def _clamps_work_J(
        self, clamps: Motion, surface: Motion, load_N: Array, through_N: Array, reaction_N: Array
    ) -> float:
        """Return the work of the clamps in J: mean forces times the displacements of the clamps.

        The work of the forces that keep the shape, which also feeds the pull and moves the panel against its
        clamps, is booked.
        """
        ends_m = clamps.position_m - self._clamps.position_m
        shaped_m = surface.position_m - self._surface.position_m - self._carried @ ends_m
        pulled_N = reaction_N - self._transposed @ through_N
        self._supplied_J += float(np.sum(pulled_N * ends_m) - np.sum(through_N * shaped_m))
        return -float(np.sum(reaction_N * ends_m))


class Player:
    """The recording at any time, in the panel's axes."""

    def __init__(self, playback: Playback) -> None:
        self._playback, self._recording = playback, playback.recording
        self._samples = len(playback.recording.shape_m)
        self._step_rad = 2 * math.pi * playback.recording.cycles / self._samples

    def shape(self, time_s: float) -> tuple[Array, Array]:
        """Return the shape in m and its velocity in m/s, (points, 3) each."""
        recording, speed = self._recording, self._playback.speed_rad_per_s
        first, second, fraction = self._neighbors(time_s)
        before = Motion(recording.shape_m[first], recording.rate_m[first])
        after = Motion(recording.shape_m[second], recording.rate_m[second])
        now = HermitePath(before, after, self._step_rad).at(fraction)
        share, rate_1_s = self._run_up(time_s)
        away_m = now.position_m - recording.rest_m
        velocity_m_per_s = rate_1_s * away_m + share * speed * now.velocity_m_per_s
        return recording.rest_m + share * away_m, velocity_m_per_s

    def pull_N(self, time_s: float) -> Array:
        """Return the force (3,) on the first clamp."""
        recording, share = self._recording, self._run_up(time_s)[0]
        first, second, fraction = self._neighbors(time_s)
        now = (1 - fraction) * recording.pull_N[first] + fraction * recording.pull_N[second]
        return np.asarray(recording.rest_pull_N + share * (now - recording.rest_pull_N))

    def _neighbors(self, time_s: float) -> tuple[int, int, float]:
        """Return the samples before and after a time, and its place between them."""
        angle = self._playback.speed_rad_per_s * (time_s - self._playback.zero_s) / self._step_rad
        first = math.floor(angle)
        return first % self._samples, (first + 1) % self._samples, angle - first

    def _run_up(self, time_s: float) -> tuple[float, float]:
        """Return the share of the motion while it grows, (1 - cos) / 2, and its rate."""
        run_up_s = self._playback.run_up_s
        share = min(max((time_s - self._playback.start_s) / run_up_s, 0.0), 1.0)
        turn = math.pi * share
        return (1 - math.cos(turn)) / 2, math.pi / (2 * run_up_s) * math.sin(turn)


def interpolation_matrices(
    grid: RecordedGrid, edges_m: tuple[float, float], coordinates_m: Array
) -> tuple[Array, Array, Array]:
    """Return H (n, points), rows of which sum to one, and its derivatives with respect to s and y.  Raises
    ValueError for coordinates off the grid."""
    s, y = coordinates_m.T
    rows, columns = grid.rows_m, grid.columns_m
    slack_m = 1e-9 * (rows[-1] - rows[0])
    locate(rows, s, slack_m)
    along, slope = hats(s, rows), np.zeros((len(s), len(rows)))
    free_rows = (rows >= edges_m[0]) & (rows <= edges_m[1])
    free = (s > edges_m[0]) & (s < edges_m[1]) if not free_rows.all() else np.full(len(s), True)
    for under, link in ((s <= edges_m[0], slice(0, 2)), (s >= edges_m[1], slice(-2, None))):
        slope[under, link] = np.array([-1.0, 1.0]) / np.ptp(rows[link])
    at = np.ix_(free, free_rows)
    along[at], slope[at] = cubic_shapes(s[free], rows[free_rows], slack_m)
    across, slope_across = cubic_shapes(y, columns, slack_m)
    return both_ways(along, across), both_ways(slope, across), both_ways(along, slope_across)


def cubic_shapes(places: Array, nodes: Array, slack_m: float) -> tuple[Array, Array]:
    """Return cubic Hermite shape functions (places, nodes) and their derivatives.

    Their slopes are central differences through the nodes (at the ends one-sided).  They are C1, and exact
    for parabolas.  Raises ValueError for places that are outside by more than ``slack_m``.
    """
    slopes = np.gradient(np.eye(len(nodes)), nodes, axis=0, edge_order=2 if len(nodes) > 2 else 1)
    cell, share = locate(nodes, places, slack_m)
    t, length = np.clip(share, 0.0, 1.0)[:, None], (nodes[cell + 1] - nodes[cell])[:, None]
    first, second = np.eye(len(nodes))[cell], np.eye(len(nodes))[cell + 1]
    value = (1 + 2 * t) * (1 - t) ** 2 * first + t**2 * (3 - 2 * t) * second
    value += length * (t * (1 - t) ** 2 * slopes[cell] + t**2 * (t - 1) * slopes[cell + 1])
    rate = 6 * t * (1 - t) / length * (second - first)
    rate += (1 - t) * (1 - 3 * t) * slopes[cell] + t * (3 * t - 2) * slopes[cell + 1]
    return np.asarray(value), np.asarray(rate)


def cost(work: PanelsWork) -> Cost:
    """Return the time of a call of each panel in each interval."""
    return Cost(0.02 * work.panels, 1.5e-4 * work.panels * work.runs)


ADAPTER = PanelAdapter(
    about="the shape of an earlier run, played back",
    build=build,
    cost=cost,
    leaves_out={
        "particle-load": "no load bends the panels; it goes on to the frames",
        "panel-response": "panels play back a shape, whatever moves them",
    },
    yields=False,
    plays_back=True,
)
