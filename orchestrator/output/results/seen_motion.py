"""What a run tells of its motion: strokes and shapes of panels, frames, and the clamps' forces."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from orchestrator.case.tables.frames import Exciter
from orchestrator.output.records.panel_lines import tension_N
from orchestrator.output.results.run_data import RunData
from orchestrator.output.results.seen_forces import loss_factor, spring_N_per_m
from orchestrator.ports import Array
from orchestrator.preflight.judgement.catalogue import present
from orchestrator.preflight.scene.moved_panel import MovedPanel
from orchestrator.preflight.scene.scene import Scene
from orchestrator.preflight.scene.seen import Shape, Turned
from orchestrator.preflight.scene.shaking import PanelSpring, free_frames
from orchestrator.preflight.scene.turning import Part, clamps_m


class SeenMotion:
    """Amplitudes are half the ranges over a window of time, whatever their harmonics."""

    def __init__(self, scene: Scene, data: RunData, start_s: float, end_s: float) -> None:
        self._scene, self._data, self._window_s = scene, data, (start_s, end_s)

    def frames_throw(self) -> float:
        """w^2 a / g of the centre of mass that moves most normal to the deck."""
        normal = self._data.deck_axes[:, 2]
        names = [body.name for body in self._scene.plan.bodies]
        largest_m = max((float(_half_range(self._moved(n) @ normal)) for n in names), default=0.0)
        return self._scene.speed_rad_per_s**2 * largest_m / self._scene.gravity_m_per_s2

    def panels(self) -> tuple[MovedPanel, ...]:
        bend = present(self._data.case, "panel-deformation")
        return tuple(
            replace(panel, stroke_m=self._stroke_m(spring), shape=self._shape(panel) if bend else None)
            for panel, spring in zip(self._scene.panels, self._scene.springs, strict=True)
        )

    def springs(self) -> tuple[PanelSpring, ...]:
        """The panels' as their pull and stretch have them; empty where they do not bend, or
        nothing stretches one."""
        if not present(self._data.case, "panel-deformation"):
            return ()
        speed = self._scene.speed_rad_per_s
        found = []
        for panel, spring in zip(self._scene.panels, self._scene.springs, strict=True):
            stiffness_N_per_m = spring_N_per_m(*self._pull(panel), self._stretch_m(spring), speed)
            if stiffness_N_per_m is None:
                return ()
            found.append(replace(spring, stiffness_N_per_m=stiffness_N_per_m))
        return tuple(found)

    def loss_factor(self) -> float | None:
        if not present(self._data.case, "panel-deformation"):
            return None
        found = [loss_factor(panel, *self._pull(panel)) for panel in self._scene.panels]
        return max((one for one in found if one is not None), default=None)

    def turned(self) -> Turned | None:
        """Power of the exciters in the window, and their largest torque before it, revolution by
        revolution; None where none turns at its own speed: a motor's lag would be in it."""
        exciters = list(self._data.case.screen.exciters.values())
        path = "energy/supplied.frames.exciter_J"
        if path not in self._data.history or any(one.motor for one in exciters):
            return None
        time_s, given_J = self._data.read("energy/time_s"), self._data.read(path)
        inside = self._inside(time_s)
        slowest = min(exciters, key=lambda one: one.speed_rad_per_s)
        turned_rad = angle_rad(time_s, slowest)
        before_rad = turned_rad - 2 * np.pi
        before_J = np.interp(before_rad, turned_rad, given_J)
        torque_N_m = (given_J - before_J)[before_rad >= 0] / (2 * np.pi)
        if inside.sum() < 2 or not len(torque_N_m):
            return None
        spent_J, over_s = np.ptp(given_J[inside]), np.ptp(time_s[inside])
        return Turned(float(spent_J / over_s), float(torque_N_m.max()))

    def _pull(self, panel: MovedPanel) -> tuple[Array, Array]:
        """Times (rows,) and pull (rows,) of a panel."""
        group, along = f"forces/{panel.panel.name}", panel.panel.rectangle.along
        inside = self._inside(self._data.read(f"{group}/time_s"))
        first_N, second_N = (self._data.read(f"{group}/{n}_clamp_N") for n in ("first", "second"))
        time_s = self._data.read(f"{group}/time_s")[inside]
        return time_s, tension_N(first_N[inside], second_N[inside], along)

    def outermost(self, effect: str, part: Part) -> tuple[float, str] | None:
        """A part of the displacement at a frame's outermost clamp over the translation of its
        centre of mass, of the frame for which it is largest; None where the solver leaves out the
        effect, or nothing moves."""
        free = [name for name in free_frames(self._scene.plan) if self._translation_m(name) > 0]
        if not free or not present(self._data.case, effect):
            return None
        ratio, name = max((self._part_m(name, part) / self._translation_m(name), name) for name in free)
        return ratio, f"at the outermost clamp of {name}"

    def _part_m(self, frame: str, part: Part) -> float:
        body = next(one for one in self._scene.plan.bodies if one.name == frame)
        arms_m = clamps_m(self._scene, frame) - body.center_of_mass_m
        moved_m, turned_rad = self._moved(frame), self._read(frame, "rotation_rad")
        at_clamps_m = _half_range(part(moved_m[:, None], turned_rad[:, None], arms_m))
        return float(np.linalg.norm(at_clamps_m, axis=-1).max())

    def _translation_m(self, frame: str) -> float:
        return float(np.linalg.norm(_half_range(self._moved(frame))))

    def _stroke_m(self, spring: PanelSpring) -> float:
        """Of the panel's second end against the first, along it."""
        return float(_half_range(self._stretch_m(spring)))

    def _stretch_m(self, spring: PanelSpring) -> Array:
        """(rows,) the same, since t = 0."""
        ends = zip(spring.frames, spring.ends_m, (-1.0, 1.0), strict=True)
        moved = [sign * self._carried(frame, place_m) for frame, place_m, sign in ends]
        return np.asarray(sum(moved) @ spring.along)

    def _carried(self, frame: str, place_m: Array) -> Array:
        """(rows, 3) displacement of a place on a frame that turns little; the ground stands."""
        bodies = [body for body in self._scene.plan.bodies if body.name == frame]
        if not bodies:
            return np.zeros((1, 3))
        arm_m = place_m - bodies[0].center_of_mass_m
        return self._moved(frame) + np.cross(self._read(frame, "rotation_rad"), arm_m)

    def _shape(self, panel: MovedPanel) -> Shape:
        """From every sync point of the cycles in the window."""
        rows = self._data.cycles(f"panel_cycles/{panel.panel.name}", *self._window_s)
        return Shape(
            sag_m=float(rows["sag_most_m"].max()),
            travel_m=float(rows["middle_most_m"].max() - rows["middle_least_m"].min()),
            strain=max(0.0, float(rows["stretch_most"].max())),
        )

    def _moved(self, frame: str) -> Array:
        return self._read(frame, "displacement_m")

    def _read(self, frame: str, name: str) -> Array:
        """Rows in the window."""
        inside = self._inside(self._data.read(f"frames/{frame}/time_s"))
        return np.asarray(self._data.read(f"frames/{frame}/{name}")[inside])

    def _inside(self, time_s: Array) -> Array:
        start_s, end_s = self._window_s
        return np.asarray((time_s >= start_s - 1e-12) & (time_s <= end_s + 1e-12))


def angle_rad(time_s: Array, exciter: Exciter) -> Array:
    """Of a shaft that runs up as prescribed: its speed rises with half a cosine."""
    since_s = np.maximum(time_s - exciter.start_s, 0.0)
    run_up_s = exciter.run_up_s
    rising_s = np.minimum(since_s, run_up_s)
    lag_s = run_up_s / np.pi * np.sin(np.pi * rising_s / run_up_s) if run_up_s else 0.0
    turning_s = (rising_s - lag_s) / 2 + (since_s - rising_s)
    return np.asarray(exciter.speed_rad_per_s * turning_s)


def _half_range(rows: Array) -> Array:
    return np.asarray(np.ptp(rows, axis=0) / 2)
