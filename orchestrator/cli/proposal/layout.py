"""The layout of a proposed deck: panels, openings, walls, chute, exits and domain, in deck axes.

Lengths follow from a few rules, which the comments in the new case repeat: panels are so long that the
stroke stretches them by ``USUAL_STRAIN``, and all that surrounds the deck keeps clear of sagging panels
and of the largest particles.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from orchestrator.case.file.deck_layout import beams
from orchestrator.case.tables.deck import Deck
from orchestrator.case.tables.quantities import Box, Vector
from orchestrator.cli.proposal.wishes import Wishes
from orchestrator.ports import Array
from orchestrator.ports.geometry import AperturePattern
from orchestrator.preflight.scene.moved_panel import sine_arch_m

USUAL_STRAIN = 0.02  # of a panel at full stroke; published screens stretch theirs by 0.02 to 0.025
USUAL_PANELS_M = (0.30, 0.45)  # of panels whose length is not given; FFS0827 has the first
CLAMP_M, BEAM_GAP_M = 0.018, 0.002
AROUND_M = 2 * CLAMP_M + BEAM_GAP_M  # from panel to panel
LAND = 0.4  # of an opening's width, between neighbouring openings
THINNEST_LAND_M = 0.003
FINEST_COMPUTED = 0.25
"""Finest diameter that any level computes, over the smaller side of the openings."""
CHUTE_SLOPE_DEG = 45.0
FALL_M, FLIGHT_M, THROW_M = 0.5, 3.5, 2.5
"""What is so far beyond the deck's end has left it at any height; the box ends so far behind and above it."""


@dataclass(frozen=True)
class Mounting:
    """How the mats are mounted between cross beams; ``slack_m`` is their free length less the clamps'
    distance."""

    thickness_m: float = 0.005
    clamp_angle_deg: float = 0.0
    slack_m: float = 0.0

    @property
    def lift_m(self) -> float:
        """The height of the clamps' outer edges over their inner ones."""
        return CLAMP_M * math.sin(math.radians(self.clamp_angle_deg))


@dataclass(frozen=True)
class Plate:
    """A rigid plate: a corner and the two edges that start there."""

    corner_m: Vector
    edges_m: tuple[Vector, Vector]


@dataclass(frozen=True)
class Exit:
    """A box that removes one product."""

    name: str
    product: str
    box_m: Box


@dataclass(frozen=True)
class Layout:
    """The places of all parts.  ``beams_m`` (panels + 1, 3) has the middles of the cross beams' tops.

    The clamps of a panel are ``panel_m`` apart.
    """

    wishes: Wishes
    inclination_deg: float
    slopes_deg: tuple[float, ...]
    panels_per_slope: tuple[int, ...]
    panel_m: float
    pitch_m: float
    corner_m: Vector
    beams_m: Array
    openings: AperturePattern
    mounting: Mounting = field(default_factory=Mounting)

    @property
    def free_m(self) -> float:
        """The free length of a panel, unstretched."""
        return round(self.panel_m + self.mounting.slack_m, 6)

    @property
    def stretch(self) -> float:
        """The strain of a panel when its clamps are farthest apart."""
        return (self.wishes.stroke_m - self.mounting.slack_m) / self.free_m

    @property
    def length_m(self) -> float:
        """The length of the deck, from the first cross beam to the last."""
        return self.wishes.panels * self.pitch_m

    @property
    def end_m(self) -> Array:
        """The middle of the last cross beam's top (3,)."""
        return np.asarray(self.beams_m[-1])

    @property
    def sag_m(self) -> float:
        """The height of a panel's arch at the end of the stroke at which it is slack."""
        return sine_arch_m(self.free_m, self.wishes.stroke_m + self.mounting.slack_m)

    @property
    def finest_m(self) -> float:
        """The smallest diameter of the feed that any level computes."""
        return max(self.wishes.feed_m[0][0], FINEST_COMPUTED * self.wishes.smaller_m)

    @property
    def largest_m(self) -> float:
        """The largest diameter of the feed."""
        return self.wishes.feed_m[-1][0]

    @property
    def side_height_m(self) -> float:
        """The height of the side plates."""
        return round_up(max(0.3, 8 * self.largest_m), 0.05)

    @property
    def side_depth_m(self) -> float:
        """The depth of the side plates below the line of the panels, below the deepest sag."""
        return round_up(1.3 * self.sag_m, 0.01)

    @property
    def side_gap_m(self) -> float:
        """The gap between panels and side plates, through which no particle fits."""
        return min(0.005, self.finest_m / 3)

    @property
    def clearance_m(self) -> float:
        """The distance of the exits below the panels."""
        return round_up(max(0.08, 2.0 * self.sag_m), 0.01)

    @property
    def chute_drop_m(self) -> float:
        """The height of the chute's end above the first cross beam."""
        return round_up(max(0.06, 2 * self.largest_m), 0.01)

    @property
    def chute_length_m(self) -> float:
        """The length of the chute."""
        return round_up(max(0.4, 10 * self.largest_m), 0.05)

    def above_chute_m(self, share: float) -> tuple[float, float]:
        """Return x and z of the chute's point at a share of its length from its lower end."""
        down = math.radians(CHUTE_SLOPE_DEG - self.inclination_deg)
        x_m, _, z_m = self.corner_m
        up_m = share * self.chute_length_m
        end_m = z_m + self.mounting.lift_m + self.chute_drop_m
        return x_m - up_m * math.cos(down), end_m + up_m * math.sin(down)

    @property
    def feed_box_m(self) -> Box:
        """The box above the chute in which the feed appears."""
        from_m, low_m = self.above_chute_m(0.75)
        to_m, _ = self.above_chute_m(0.1)
        side_m = min(0.02, self.wishes.width_m / 10)
        height_m = max(0.1, 4 * self.largest_m)
        low_m += 0.6 * self.largest_m
        return (from_m, side_m, low_m), (to_m, self.wishes.width_m - side_m, low_m + height_m)

    @property
    def back(self) -> Plate:
        """The plate that closes the gap between the first cross beam and the chute's end."""
        x_m, y_m, z_m = self.corner_m
        height_m = self.side_depth_m + self.chute_drop_m + self.mounting.lift_m
        return Plate((x_m + 5e-4, y_m, z_m - self.side_depth_m), (self._across, (0.0, 0.0, height_m)))

    @property
    def hood(self) -> Plate:
        """The plate across the chute's upper end, which keeps material from jumping off."""
        x_m, z_m = self.above_chute_m(0.88)
        low_m, high_m = z_m - 0.1, self.feed_box_m[1][2] + 0.2
        return Plate((x_m, 0.0, low_m), (self._across, (0.0, 0.0, high_m - low_m)))

    @property
    def divider(self) -> Plate:
        """The plate below the last cross beam that keeps undersize and oversize apart."""
        x_m, _, z_m = map(float, self.end_m)
        return Plate((x_m, 0.0, z_m - 0.6), (self._across, (0.0, 0.0, 0.58)))

    @property
    def exits(self) -> tuple[Exit, ...]:
        """A section of the undersize below each panel, and the oversize behind the end.

        A grain that is thrown far beyond the end is oversize at once, wherever it would come down.
        """
        sections = []
        outside_m = (self.corner_m[0] - 1.0, -0.5, self.wishes.width_m + 0.5)
        for number, (start_m, end_m) in enumerate(pairwise(self.beams_m)):
            top_m = min(start_m[2], end_m[2]) - self.clearance_m
            from_m = start_m[0] if number else outside_m[0]
            low, high = (from_m, outside_m[1], top_m - 0.6), (end_m[0], outside_m[2], top_m)
            sections.append(Exit(f"section-{number + 1}", "undersize", (_floats(low), _floats(high))))
        x_m, _, z_m = self.end_m
        low = (x_m + 0.001, outside_m[1], z_m - self.clearance_m - 0.6)
        high = (x_m + FALL_M, outside_m[2], z_m - 0.04)
        beyond = (x_m + FALL_M, *low[1:]), (x_m + FLIGHT_M, outside_m[2], z_m + THROW_M)
        return (
            *sections,
            Exit("discharge", "oversize", (_floats(low), _floats(high))),
            Exit("discharge-thrown", "oversize", (_floats(beyond[0]), _floats(beyond[1]))),
        )

    @property
    def domain_m(self) -> Box:
        """A box in world axes around all that particles may reach."""
        turn = math.radians(self.inclination_deg)
        corners_m = np.array([corner for row in self.exits for corner in row.box_m])
        above_m = np.add(self.hood.corner_m, (0.0, 0.0, 1.5))
        x_m, _, z_m = np.vstack([corners_m, above_m, self.beams_m]).T
        along_m = x_m * math.cos(turn) + z_m * math.sin(turn)
        up_m = z_m * math.cos(turn) - x_m * math.sin(turn)
        low = (along_m.min() - 0.3, -0.6, up_m.min() - 0.1)
        high = (along_m.max() + 0.3, self.wishes.width_m + 0.6, up_m.max() + 0.5)
        return _floats(low, 2), _floats(high, 2)

    @property
    def _across(self) -> Vector:
        return 0.0, self.wishes.width_m, 0.0


def panel_length_m(wishes: Wishes) -> float:
    """Return the free length of a panel, which is not positive if the deck is too short for its clamps."""
    if wishes.length_m is None:
        shortest_m, longest_m = USUAL_PANELS_M
        return min(max(shortest_m, round_up(wishes.stroke_m / USUAL_STRAIN, 0.01)), longest_m)
    return wishes.length_m / wishes.panels - AROUND_M


def lay_out(wishes: Wishes) -> Layout:
    """Return the layout of a deck for the wishes, whose panels must have a positive length."""
    panel_m = panel_length_m(wishes)
    slopes_deg = wishes.slopes_deg
    panels_per_slope = tuple(len(part) for part in np.array_split(range(wishes.panels), len(slopes_deg)))
    inclination_deg = round(float(np.average(slopes_deg, weights=panels_per_slope)), 2)
    if len(slopes_deg) == 1:
        slopes_deg, panels_per_slope = (), ()
    deck = Deck(
        material="",
        frames=("driving", "driven"),
        corner_m=(0.0, 0.0, 0.0),
        panels=wishes.panels,
        pitch_m=panel_m + AROUND_M,
        length_m=panel_m,
        width_m=wishes.width_m,
        thickness_m=Mounting().thickness_m,
        slopes_deg=slopes_deg,
        panels_per_slope=panels_per_slope,
    )
    beams_m = beams(deck, inclination_deg)
    corner_m = (0.0, 0.0, round(-float(beams_m[:, 2].mean()), 3))
    return Layout(
        wishes=wishes,
        inclination_deg=inclination_deg,
        slopes_deg=slopes_deg,
        panels_per_slope=panels_per_slope,
        panel_m=panel_m,
        pitch_m=panel_m + AROUND_M,
        corner_m=corner_m,
        beams_m=beams_m + corner_m,
        openings=openings_of(wishes),
    )


def openings_of(wishes: Wishes) -> AperturePattern:
    """Return the pattern of the openings, with round pitches."""
    land_m = max(LAND * wishes.opening_m, THINNEST_LAND_M)
    return AperturePattern(
        shape="rectangle",
        length_m=wishes.opening_length_m,
        width_m=wishes.opening_m,
        pitch_along_m=round_up(wishes.opening_length_m + land_m, 5e-4),
        pitch_across_m=round_up(wishes.opening_m + land_m, 5e-4),
        margin_along_m=0.03,
        margin_across_m=0.03,
    )


def round_up(value: float, step: float) -> float:
    """Return the smallest multiple of ``step`` that is not below a value."""
    return round(math.ceil(value / step - 1e-9) * step, 9)


def _floats(vector: tuple[float, float, float], digits: int = 6) -> Vector:
    x, y, z = (round(float(number), digits) for number in vector)
    return x, y, z
