"""The natural modes of the free frames on their bushings and panels, each named by its shape.

The panels count with the mean stiffness of a cycle at the estimated stroke, because a panel that is
slack for half of each cycle pulls in the other half only.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from orchestrator.case.deck.panels import axes
from orchestrator.case.tables.quantities import GROUND
from orchestrator.ports import Array, linear_frames
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.shaking import carry_panels, free_frames

SHAPES = ("motion along the deck", "motion across", "motion normal to the deck", "roll", "pitch", "yaw")
"""The coordinates of a frame in deck axes: translations along x, y and z, then rotations about them."""
NEAR = 0.15  # A mode this close to an excitation, as a share of it, is resonant or soon may be.
TAKES_PART = 0.1  # of the larger amplitude: a frame that moves less is not named


@dataclass(frozen=True)
class FrameMode:
    """A natural mode of the free frames.

    ``displacement`` (frames, 3) and ``rotation`` (frames, 3) are real amplitudes in deck axes, in m and
    rad to a common scale, of the centres of mass of ``frames``.  ``energy`` (frames, 6) has the shares
    of the kinetic energy by frame and coordinate, ``damping_ratio`` the share of the critical damping, and
    ``panels_share`` the share of the panels in the stiffness.
    """

    frequency_Hz: float
    damping_ratio: float
    frames: tuple[str, ...]
    displacement: Array
    rotation: Array
    energy: Array
    panels_share: float

    @property
    def shape(self) -> str:
        """The coordinate with most of the kinetic energy, the frame that has most of it, and its partner."""
        coordinate = int(np.argmax(self.energy.sum(axis=0)))
        moved = np.hstack([self.displacement, self.rotation])[:, coordinate]
        leader = int(np.argmax(self.energy[:, coordinate]))
        text = f"{SHAPES[coordinate]} of {name_frame(self.frames[leader])}"
        others = [(number, share / moved[leader]) for number, share in enumerate(moved) if number != leader]
        for sense, word in ((1, "with"), (-1, "against")):
            names = [self.frames[n] for n, ratio in others if sense * ratio > TAKES_PART]
            if names:
                text += f" {word} {' and '.join(map(name_frame, names))}"
        return text

    @property
    def in_words(self) -> str:
        """The shape and the frequency, for example "pitch of the driven frame, 12.4 Hz"."""
        return f"{self.shape}, {self.frequency_Hz:.3g} Hz"


def name_frame(name: str) -> str:
    """Return a frame's name with an article, for sentences."""
    if name == GROUND:
        return "the ground"
    return name if "frame" in name else f"the {name} frame"


def frame_modes(scene: Scene) -> tuple[FrameMode, ...]:
    """Return the modes of a scene, from the lowest frequency up; empty if no frame is free.

    Frames translate and rotate.  They only translate where the case gives a free frame no inertia.
    Frequencies and shapes are those without damping, and the damping ratio is that of the shape.
    """
    import scipy.linalg

    plan = scene.plan
    names = free_frames(plan)
    if not names:
        return ()
    bodies = [body for body in plan.bodies if body.name in names]
    rotates = all(np.linalg.det(body.inertia_kg_m2) > 0 for body in bodies)
    coordinates = linear_frames.SPACE if rotates else linear_frames.TRANSLATIONS
    moving = linear_frames.numbers(plan, tuple(names))
    machine = linear_frames.linearise(carry_panels(plan, scene.springs), coordinates, moving)
    of_bushings = linear_frames.linearise(plan, coordinates, moving).stiffness
    square, shapes = scipy.linalg.eigh(machine.stiffness, machine.mass)
    turn = axes(scene.case)
    modes = []
    for square_per_s2, column in zip(square.tolist(), shapes.T, strict=True):
        shape = column.reshape(len(names), -1, 3)
        rate_rad_per_s = math.sqrt(max(square_per_s2, 0.0))
        damping = float(column @ machine.damping @ column)
        mode = FrameMode(
            frequency_Hz=rate_rad_per_s / (2 * math.pi),
            damping_ratio=damping / (2 * rate_rad_per_s) if rate_rad_per_s > 0 else 0.0,
            frames=tuple(names),
            displacement=shape[:, 0] @ turn,
            rotation=shape[:, 1] @ turn if rotates else np.zeros((len(names), 3)),
            energy=_energy_shares(shape, machine.mass, turn),
            panels_share=1 - float(column @ of_bushings @ column) / square_per_s2
            if square_per_s2 > 0
            else 0.0,
        )
        modes.append(mode)
    return tuple(modes)


def modes_near(scene: Scene, speed_rad_per_s: float) -> list[FrameMode]:
    """Return the modes of the frames that are near a speed of excitation."""
    excited_Hz = speed_rad_per_s / (2 * math.pi)
    return [mode for mode in frame_modes(scene) if abs(mode.frequency_Hz - excited_Hz) <= NEAR * excited_Hz]


def _energy_shares(shape: Array, mass: Array, turn: Array) -> Array:
    """Return the shares (frames, 6) of the kinetic energy of a shape (frames, 1 or 2, 3) in world axes.

    Masses and moments about the deck axes count alone; products of inertia are left out of the shares.
    """
    own = np.einsum("fkifkj->fkij", mass.reshape(shape.shape * 2))
    kinetic = np.einsum("ia,fkij,ja->fka", turn, own, turn) * (shape @ turn) ** 2
    energy = np.zeros((len(shape), 6))
    energy[:, : shape[0].size] = kinetic.reshape(len(shape), -1)
    return np.asarray(energy / energy.sum())
