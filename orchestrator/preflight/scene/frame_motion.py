"""The steady motion of each frame in the numbers of a screen: stroke, acceleration, throw and speed."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from orchestrator.case.deck.panels import axes
from orchestrator.ports import Array
from orchestrator.ports.physics import STANDARD_GRAVITY_M_PER_S2
from orchestrator.preflight.scene.frame_modes import modes_near
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import Shaking, free_frames, solve_shakings

SLIGHT = 1e-3  # of a frame's acceleration: a speed with less of it is not named
ROUND = 0.8  # Smaller over larger axis of a frame's ellipse from which on its stroke has no direction.
MUCH_LOSS = 1.0  # loss factor with which bushings answer a mode hardly more than other speeds


@dataclass(frozen=True)
class FrameMotion:
    """The steady motion of a frame's centre of mass, summed over all speeds.

    ``stroke_m`` is the amplitude along the largest axis of its ellipse.  ``acceleration_g`` and ``throw_g``,
    its part normal to the deck, are peaks over standard gravity.  ``near_mode`` says whether a mode of the
    frames is so near to a speed that the linear estimate is uncertain.  ``angle_deg`` is the angle of the
    stroke to the deck at the speed of the largest acceleration, positive where the frame moves down the deck
    and up from it; it is None of a motion that is nearly a circle, and without motion.
    """

    frame: str
    stroke_m: float
    acceleration_g: float
    throw_g: float
    speeds_rad_per_s: tuple[float, ...]
    near_mode: bool
    angle_deg: float | None = None

    @property
    def in_words(self) -> str:
        """The frame and its numbers in one line, for example "driving: stroke 3.39 mm (amplitude), ..."."""
        return f"{self.frame}: {self.numbers_in_words}"

    @property
    def numbers_in_words(self) -> str:
        """The numbers in one line, for example "stroke 3.39 mm (amplitude), 84 deg to the deck, ..."."""
        if not self.speeds_rad_per_s:
            return "nothing shakes it"
        speeds = " and ".join(speed_in_words(speed) for speed in self.speeds_rad_per_s)
        uncertain = "; uncertain, near a mode" if self.near_mode else ""
        way = "nearly a circle" if self.angle_deg is None else f"{self.angle_deg:.0f} deg to the deck"
        return (
            f"stroke {1e3 * self.stroke_m:.3g} mm (amplitude), {way}, {self.acceleration_g:.3g} g, "
            f"throw {self.throw_g:.3g} g, at {speeds}{uncertain}"
        )


def speed_in_words(speed_rad_per_s: float) -> str:
    """Return a speed in three units, for example "78.5 rad/s = 750 rpm = 12.5 Hz"."""
    turns_Hz = speed_rad_per_s / (2 * math.pi)
    return f"{speed_rad_per_s:.4g} rad/s = {60 * turns_Hz:.4g} rpm = {turns_Hz:.3g} Hz"


def motion_lines(scene: Scene) -> Iterator[str]:
    """Yield a line for each frame with its estimated steady motion."""
    for motion in frame_motions(scene):
        yield f"frame {motion.in_words}"


def frame_motions(scene: Scene, loss_factor: float | None = None) -> tuple[FrameMotion, ...]:
    """Return the steady motion of each frame by the linear model of frames on bushings and panels.

    Frames turn, too, where the case gives all free frames an inertia.  Free frames stand still if the case's
    solver moves no frame by forces.  ``loss_factor`` replaces the damping of all bushings.
    """
    free = free_frames(scene.plan)
    shaken, _ = spatial_shakings(scene, loss_factor)
    deck = axes(scene.case)
    normal = deck[:, 2]
    near = {row.speed_rad_per_s for row in scene.shaken if modes_near(scene, row.speed_rad_per_s)}
    still = () if scene.case.frames.adapter.moved_by_forces else free
    motions = []
    for body in scene.plan.bodies:
        moving = () if body.name in still else shaken
        rows = [(row.speed_rad_per_s, row.amplitude_m[body.name]) for row in moving]
        peaks_g = [speed**2 * largest_m(moved_m) / STANDARD_GRAVITY_M_PER_S2 for speed, moved_m in rows]
        thrown_g = [speed**2 * abs(moved_m @ normal) / STANDARD_GRAVITY_M_PER_S2 for speed, moved_m in rows]
        speeds = [
            speed for (speed, _), peak_g in zip(rows, peaks_g, strict=True) if peak_g > SLIGHT * sum(peaks_g)
        ]
        motions.append(
            FrameMotion(
                body.name,
                sum(largest_m(moved_m) for _, moved_m in rows),
                sum(peaks_g),
                float(sum(thrown_g)),
                tuple(speeds),
                body.name in free and not near.isdisjoint(speeds),
                _angle_deg(rows[int(np.argmax(peaks_g))][1] @ deck) if speeds else None,
            )
        )
    return tuple(motions)


def spatial_shakings(scene: Scene, loss_factor: float | None = None) -> tuple[tuple[Shaking, ...], int]:
    """Return the steady motion of the frames at each speed, and the number of coordinates of each frame, 6
    where all free frames have an inertia, else 3.

    ``loss_factor`` replaces the damping of all bushings.
    """
    free = free_frames(scene.plan)
    turns = all(np.linalg.det(body.inertia_kg_m2) > 0 for body in scene.plan.bodies if body.name in free)
    freedoms = 6 if turns else 3
    return solve_shakings(scene.plan, scene.springs, loss_factor, freedoms), freedoms


def _angle_deg(amplitude_m: Array) -> float | None:
    """Return the angle to the deck, from -90 to 90, of the largest axis of the ellipse of a complex amplitude
    (3,) in deck axes; None for nearly a circle."""
    parts = np.array([amplitude_m.real, amplitude_m.imag])[:, [0, 2]]
    _, sizes, ways = np.linalg.svd(parts)
    if sizes[1] > ROUND * sizes[0]:
        return None
    along, normal = ways[0]
    angle_deg = math.degrees(math.atan2(normal, along))
    return angle_deg - 180 * round(angle_deg / 180)


def least_motions(scene: Scene) -> tuple[FrameMotion, ...]:
    """Return the motions that do not hang on a mode: those with much loss, where an own speed is near one."""
    motions = frame_motions(scene)
    return frame_motions(scene, MUCH_LOSS) if any(motion.near_mode for motion in motions) else motions


def largest_m(amplitude_m: Array) -> float:
    """Return the largest semi-axis of the ellipse  Re(amplitude exp(i w t))  of a complex amplitude (3,)."""
    parts = np.array([amplitude_m.real, amplitude_m.imag])
    return float(np.linalg.svd(parts, compute_uv=False)[0])
