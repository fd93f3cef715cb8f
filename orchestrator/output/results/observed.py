"""What a run tells of the numbers by which its effects were judged."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.loss_curve import moduli
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.frames import Exciter
from orchestrator.output.records.panel_lines import tension_N
from orchestrator.output.results.bed import averaged
from orchestrator.output.results.events import read
from orchestrator.output.results.run_reader import RunData, run_data
from orchestrator.output.results.sampling import rows_too_seldom
from orchestrator.ports import Array
from orchestrator.ports.plans import Hyperelastic
from orchestrator.preflight.judgement.account import Entry
from orchestrator.preflight.judgement.catalogue import EFFECTS, present
from orchestrator.preflight.scene.moved_panel import MovedPanel
from orchestrator.preflight.scene.scene import Scene, deck_m2, scene
from orchestrator.preflight.scene.seen import Bearing, Deepest, Products, Seen, Shape, Turned
from orchestrator.preflight.scene.shaking import PanelSpring, free_frames, shakings
from orchestrator.preflight.scene.turning import Part, clamps_m, out_of_plane, turned

FEWEST = 30  # particles of a product whose mean size is compared: the project's own choice


def bed_kg_per_m2(data: RunData) -> float | None:
    """Largest mass on the deck at an output time, per area of the panels."""
    area_m2 = deck_m2(data.case)
    group = next((name for name in ("profile", "bed") if name in data.history), None)
    if area_m2 == 0.0 or group is None:
        return None
    mass_kg = data.read(f"{group}/mass_kg")
    return float(np.nansum(mass_kg.reshape(len(mass_kg), -1), axis=1).max() / area_m2)


def transport_m_per_s(results: Mapping[str, Any]) -> float | None:
    """Speed of the bed along the deck."""
    bed = results.get("bed")
    speed_m_per_s = bed["velocity_m_per_s"]["value"] if bed else None
    return None if speed_m_per_s is None else max(0.0, float(speed_m_per_s))


def bearing(scene: Scene, data: RunData, start_s: float, end_s: float) -> Bearing | None:
    """Means over a window of the force on all panels together; None where nothing lies on them."""
    if "bed" not in data.history or not scene.panels:
        return None
    mass_kg = data.read("bed/mass_kg")[averaged(data.read("bed/time_s"), start_s, end_s)]
    if not len(mass_kg):
        return None
    normal_N = downhill_N = normal_weight = 0.0
    panels = single_panels(data.case)
    for panel in panels:
        rows = data.cycles(f"panel_cycles/{panel.name}", start_s, end_s)
        load_N = rows["sync_points"] @ rows["load_mean_N"] / rows["sync_points"].sum()
        at = panel.rectangle
        normal_N -= float(load_N @ at.normal)
        downhill_N += float(load_N @ at.along) * (-1.0 if at.along[2] > 0 else 1.0)
        normal_weight += float(abs(at.normal[2])) / len(panels)
    weight_N = float(mass_kg.mean()) * scene.gravity_m_per_s2 * normal_weight
    if not (normal_N > 0.0 and weight_N > 0.0):
        return None
    rubs = present(data.case, "sliding-friction")
    return Bearing(normal_N / weight_N, max(0.0, downhill_N / normal_N) if rubs else None)


def deepest(data: RunData) -> Deepest | None:
    """Of all steps; None if nothing ever touched."""
    if "overlaps" not in data.history:
        return None
    names = ("between_per_diameter", "surface_per_diameter", "surface_m")
    between, surface, surface_m = (float(data.read(f"overlaps/{n}").max()) for n in names)
    if between == surface == 0.0:
        return None
    return Deepest(per_diameter=max(between, surface), surface_m=surface_m)


def products(data: RunData) -> Products | None:
    """Mean diameters by mass of what left through each exit; None with fewer than two that many
    particles left through."""
    tables = read(data.history)
    if tables is None:
        return None
    _, removed, exits = tables
    found = {}
    for number, name in enumerate(exits.names):
        mine = removed.exit == number
        if mine.sum() >= FEWEST:
            found[name] = float(np.average(removed.diameter_m[mine], weights=removed.mass_kg[mine]))
    if len(found) < 2:
        return None
    fine, coarse = min(found, key=found.__getitem__), max(found, key=found.__getitem__)
    words = f"{found[coarse] * 1e3:.3g} mm through {coarse}, {found[fine] * 1e3:.3g} mm through {fine}"
    return Products(found[coarse] / found[fine], words)


def spring_N_per_m(time_s: Array, pull_N: Array, stretch_m: Array, speed_rad_per_s: float) -> float | None:
    """Stiffness of the spring with the first harmonic of a panel's pull (rows,) in phase with the
    stretch of its ends (rows,); None where nothing stretches it."""
    stretch_m = np.broadcast_to(stretch_m, pull_N.shape)  # one row where both ends stand still
    pull, stretch = (_harmonic(time_s, one, speed_rad_per_s) for one in (pull_N, stretch_m))
    if abs(stretch) < 1e-9:
        return None
    return max(0.0, float((pull / stretch).real))


def _harmonic(time_s: Array, values: Array, speed_rad_per_s: float) -> complex:
    """Complex amplitude at one speed, by least squares."""
    phase = speed_rad_per_s * time_s
    columns = np.column_stack([np.ones_like(phase), np.cos(phase), np.sin(phase)])
    _, cosine, sine = np.linalg.lstsq(columns, values, rcond=None)[0]
    return complex(cosine, -sine)


def loss_factor(panel: MovedPanel, time_s: Array, pull_N: Array) -> float | None:
    """Of the panel's material, weighted with the square of the pull's amplitude at each
    frequency: as if stiffness did not depend on it, with the energy stored there."""
    steps = np.diff(time_s)
    power_N2 = np.abs(np.fft.rfft(np.hanning(len(pull_N)) * (pull_N - pull_N.mean()))) ** 2
    speed_rad_per_s = 2 * math.pi * np.fft.rfftfreq(len(pull_N), float(steps.mean()))
    if power_N2[1:].sum() == 0.0:
        return None
    return float(np.average(_factors(panel.material, speed_rad_per_s[1:]), weights=power_N2[1:]))


def _factors(law: Hyperelastic, speed_rad_per_s: Array) -> Array:
    return moduli(law.branches, speed_rad_per_s)[1]


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


def checked(
    entries: Mapping[str, Entry], described: Case, folder: Path, results: Mapping[str, Any]
) -> dict[str, Entry]:
    """The entries with the verdicts that the run's own numbers give, where it has them.

    ``described``: the case with all that it describes; ``results``: those of the run in ``folder``.
    """
    with h5py.File(folder / "history.h5") as history:
        seen = seen_scene(scene(described), run_data(folder, history), results)
    found = dict(entries)
    for name, entry in entries.items():
        what = EFFECTS[name].checked_by
        if entry.before is not None and what and getattr(seen.seen, what) is not None:
            found[name] = replace(entry, after=EFFECTS[name].judge(seen))
    return found


def seen_scene(estimated: Scene, data: RunData, results: Mapping[str, Any]) -> Scene:
    """The scene with the numbers of the run: motion over the window of ``results``, bed over all
    of it.  Nothing is said of motion where the series do not show it."""
    bed = Seen(
        bed_kg_per_m2=bed_kg_per_m2(data),
        transport_m_per_s=transport_m_per_s(results),
        deepest=deepest(data),
        products=products(data),
        closed=not present(data.case, "apertures"),
    )
    window = results.get("motion")
    interval_s = data.case.coupling.sync_interval_s
    seldom = rows_too_seldom(data.series_s(), data.cycle_s, interval_s)
    if window is None or seldom or not estimated.speed_rad_per_s > 0:
        return replace(estimated, seen=bed)
    motion = SeenMotion(estimated, data, window["start_s"], window["end_s"])
    springs = motion.springs()
    seen = replace(
        bed,
        frames_throw=motion.frames_throw(),
        rotation=motion.outermost("frame-rotation", turned),
        sideways=motion.outermost("sideways-motion", out_of_plane),
        panels_N_per_m=sum(spring.stiffness_N_per_m for spring in springs) if springs else None,
        loss_factor=motion.loss_factor(),
        turned=motion.turned(),
        bearing=bearing(estimated, data, window["start_s"], window["end_s"]),
    )
    moved = replace(estimated, panels=motion.panels(), seen=seen)
    if not springs:
        return moved
    return replace(moved, springs=springs, shaken=shakings(moved.plan, springs))
