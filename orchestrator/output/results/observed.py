"""The values that a run gives to the numbers by which its effects were judged.

The motion of frames and the strokes of panels are first harmonics (``harmonics.py``) over the window of the
results' motion.  The shapes of panels are extremes over all sync points in this window.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.loss_curve import moduli
from orchestrator.case.solver_plans import exciters
from orchestrator.case.tables.case import Case
from orchestrator.figures.results import Results
from orchestrator.output.cycles import count_whole_cycles
from orchestrator.output.records.panel_lines import panel_pull_N
from orchestrator.output.results.events import read_events
from orchestrator.output.results.harmonics import Phasors, first_harmonic
from orchestrator.output.results.run_reader import RunReader
from orchestrator.output.results.sampling import rows_too_seldom
from orchestrator.ports import Array
from orchestrator.ports.unbalance import Unbalance
from orchestrator.preflight.judgement.account import Entry
from orchestrator.preflight.judgement.catalogue import EFFECTS, has_effect
from orchestrator.preflight.scene.clamp_motion import clamp_arms_m
from orchestrator.preflight.scene.moved_panel import MovedPanel
from orchestrator.preflight.scene.observed import Bearing, Deepest, ExciterLoad, Observed, Products, Shape
from orchestrator.preflight.scene.scene import Scene, deck_m2, scene
from orchestrator.preflight.scene.shaking import PanelSpring, free_frames, solve_shakings

FEWEST = 30  # particles of a product whose mean size is compared (a choice of this project)
STILL_M = 1e-9  # a smaller stretch counts as none


def check_effects_by_run(
    entries: Mapping[str, Entry], described: Case, folder: Path, results: Results
) -> dict[str, Entry]:
    """Return the entries, with verdicts from the run's own numbers where the run has them.

    ``described`` is the case with all effects that it describes, and ``results`` are the results of the
    run in ``folder``.
    """
    with RunReader(folder) as run:
        observed = observed_scene(scene(described), run, results)
    table = dict(entries)
    for name, entry in entries.items():
        what = EFFECTS[name].checked_by
        if entry.before is not None and what and getattr(observed.observed, what) is not None:
            table[name] = replace(entry, after=EFFECTS[name].judge(observed))
    return table


def observed_scene(estimated: Scene, run: RunReader, results: Results) -> Scene:
    """Return the scene with the numbers of the run.

    They are the motion over the window of ``results``, and the bed over the whole run.  The motion is left
    out if the rows of the series are too few to show it, or the window has no whole cycle.
    """
    bed = Observed(
        bed_kg_per_m2=bed_kg_per_m2(run),
        transport_m_per_s=transport_m_per_s(results),
        deepest=deepest_contacts(run),
        products=products(run),
        closed=not has_effect(run.case, "apertures"),
    )
    window = results.motion
    seldom = rows_too_seldom(run.series_s(), run.cycle_s, run.case.coupling.sync_interval_s)
    if window is None or seldom or not estimated.speed_rad_per_s > 0:
        return replace(estimated, observed=bed)
    if not count_whole_cycles(window.end_s - window.start_s, 2 * np.pi / estimated.speed_rad_per_s):
        return replace(estimated, observed=bed)
    motion = ObservedMotion(estimated, run, window.start_s, window.end_s)
    springs = motion.springs()
    whole = replace(
        bed,
        frames_throw=motion.frames_throw(),
        rotation=motion.rotation(),
        panels_N_per_m=sum(spring.stiffness_N_per_m for spring in springs) if springs else None,
        loss_factor=motion.loss_factor(),
        exciter_load=motion.exciter_load(),
        bearing=bearing(estimated, run, window.start_s, window.end_s),
    )
    moved = replace(estimated, panels=motion.panels(), observed=whole)
    if not springs:
        return moved
    return replace(moved, springs=springs, shaken=solve_shakings(moved.plan, springs))


def bed_kg_per_m2(run: RunReader) -> float | None:
    """Return the largest mass on the deck at an output time per area of the panels, or None without a bed."""
    area_m2 = deck_m2(run.case)
    group = next((name for name in ("profile", "bed") if run.has(name)), None)
    if area_m2 == 0.0 or group is None:
        return None
    mass_kg = run.read(f"{group}/mass_kg")
    return float(np.nansum(mass_kg.reshape(len(mass_kg), -1), axis=1).max() / area_m2)


def transport_m_per_s(results: Results) -> float | None:
    """Return the speed of the bed along the deck (at least 0), or None if the results have none."""
    speed_m_per_s = results.bed.velocity_m_per_s.value if results.bed else None
    return None if speed_m_per_s is None else max(0.0, float(speed_m_per_s))


def bearing(scene: Scene, run: RunReader, start_s: float, end_s: float) -> Bearing | None:
    """Return how the panels bear the bed, from mean forces over a window; None if nothing lies on them."""
    if not run.has("bed") or not scene.panels:
        return None
    mass_kg = run.read_between("bed", "mass_kg", start_s, end_s)
    if not len(mass_kg):
        return None
    normal_N = downhill_N = normal_weight = 0.0
    panels = single_panels(run.case)
    for panel in panels:
        rows = run.read_cycles(f"panel_cycles/{panel.name}", start_s, end_s)
        load_N = rows["sync_points"] @ rows["load_mean_N"] / rows["sync_points"].sum()
        at = panel.rectangle
        normal_N -= float(load_N @ at.normal)
        downhill_N += float(load_N @ at.along) * (-1.0 if at.along[2] > 0 else 1.0)
        normal_weight += float(abs(at.normal[2])) / len(panels)
    weight_N = float(mass_kg.mean()) * scene.gravity_m_per_s2 * normal_weight
    if not (normal_N > 0.0 and weight_N > 0.0):
        return None
    rubs = has_effect(run.case, "sliding-friction")
    return Bearing(normal_N / weight_N, max(0.0, downhill_N / normal_N) if rubs else None)


def deepest_contacts(run: RunReader) -> Deepest | None:
    """Return the deepest contacts of all steps, or None if nothing ever touched."""
    if not run.has("overlaps"):
        return None
    names = ("between_per_diameter", "surface_per_diameter", "surface_m")
    between, surface, surface_m = (float(run.read(f"overlaps/{n}").max()) for n in names)
    if between == surface == 0.0:
        return None
    return Deepest(per_diameter=max(between, surface), surface_m=surface_m)


def products(run: RunReader) -> Products | None:
    """Return the ratio of the coarsest to the finest product, by the mean sizes of the exits by mass.

    Return None if fewer than two exits have at least ``FEWEST`` particles.
    """
    tables = read_events(run.history)
    if tables is None:
        return None
    _, removed, exits = tables
    mean_m = {}
    for number, name in enumerate(exits.names):
        mine = removed.exit == number
        if mine.sum() >= FEWEST:
            mean_m[name] = float(np.average(removed.sieve_size_m[mine], weights=removed.mass_kg[mine]))
    if len(mean_m) < 2:
        return None
    fine, coarse = min(mean_m, key=mean_m.__getitem__), max(mean_m, key=mean_m.__getitem__)
    words = f"{mean_m[coarse] * 1e3:.3g} mm through {coarse}, {mean_m[fine] * 1e3:.3g} mm through {fine}"
    return Products(mean_m[coarse] / mean_m[fine], words)


class ObservedMotion:
    """The motion in a window of whole cycles, by its first harmonic at the speed of the scene, or at that of
    the shaft where a motor turns it."""

    def __init__(self, scene: Scene, run: RunReader, start_s: float, end_s: float) -> None:
        self._scene, self._run, self._window_s = scene, run, (start_s, end_s)
        lag = run.turn_s(start_s, end_s) / run.cycle_s
        self._cycle_s = lag * 2 * np.pi / scene.speed_rad_per_s
        self._bodies = {body.name: body for body in scene.plan.bodies}
        self._bend = has_effect(run.case, "panel-deformation")
        self.phasor = cache(self._read_phasor)

    def _read_phasor(self, frame: str, name: str = "displacement_m") -> Phasors:
        """Return the phasor (3,) of a frame's motion, in world axes."""
        time_s, values = (self._run.read(f"frames/{frame}/{column}") for column in ("time_s", name))
        return first_harmonic(time_s, values, self._cycle_s, *self._window_s).phasor

    def frames_throw(self) -> float:
        """Return w^2 a / g for the centre of mass with the largest amplitude a normal to the deck."""
        normal = self._run.deck_axes[:, 2]
        largest_m = max((abs(self.phasor(name) @ normal) for name in self._bodies), default=0.0)
        return float((2 * np.pi / self._cycle_s) ** 2 * largest_m / self._scene.gravity_m_per_s2)

    def panels(self) -> tuple[MovedPanel, ...]:
        """Return the panels with their strokes, and with their shapes where they bend."""
        pairs = zip(self._scene.panels, self._scene.springs, strict=True)
        return tuple(
            replace(
                panel,
                stroke_m=float(abs(self._stretch_m(spring))),
                shape=self._shape(panel) if self._bend else None,
            )
            for panel, spring in pairs
        )

    def springs(self) -> tuple[PanelSpring, ...]:
        """Return the panels' springs with stiffnesses from their pull and stretch.

        Return no springs if the panels do not bend, or if one of them is not stretched.
        """
        springs = []
        for panel, spring in zip(self._scene.panels, self._scene.springs, strict=True):
            stretch_m = self._stretch_m(spring)
            if not self._bend or abs(stretch_m) < STILL_M:
                return ()
            time_s, pull_N = self._pull(panel)
            pull = first_harmonic(time_s, pull_N[:, None], self._cycle_s, *self._window_s).phasor[0]
            springs.append(replace(spring, stiffness_N_per_m=spring_N_per_m(pull, stretch_m)))
        return tuple(springs)

    def loss_factor(self) -> float | None:
        """Return the largest loss factor of a panel's material at the frequencies of its pull, or None."""
        factors = [loss_factor(panel, *self._pull(panel)) for panel in self._scene.panels if self._bend]
        return max((factor for factor in factors if factor is not None), default=None)

    def exciter_load(self) -> ExciterLoad | None:
        """Return the mean power of the exciters in the window, and their largest mean torque in a revolution.

        Return None without exciters, with a motor, whose lag would be part of the power, or with too few
        output times.
        """
        shafts = exciters(self._run.case)
        path = "energy/supplied.frames.exciter_J"
        if not shafts or not self._run.has(path) or any(shaft.motor for shaft in shafts):
            return None
        time_s, given_J = self._run.read("energy/time_s"), self._run.read(path)
        start_s, end_s = self._window_s
        inside = (time_s >= start_s - 1e-12) & (time_s <= end_s + 1e-12)
        slowest = min(shafts, key=lambda shaft: shaft.speed_rad_per_s)
        turned_rad = Unbalance(slowest).turning(time_s)[0] - slowest.phase_rad
        before_rad = turned_rad - 2 * np.pi
        before_J = np.interp(before_rad, turned_rad, given_J)
        torque_N_m = (given_J - before_J)[before_rad >= 0] / (2 * np.pi)
        if inside.sum() < 2 or not len(torque_N_m):
            return None
        spent_J, over_s = np.ptp(given_J[inside]), np.ptp(time_s[inside])
        return ExciterLoad(float(spent_J / over_s), float(torque_N_m.max()))

    def rotation(self) -> tuple[float, str] | None:
        """Return the largest motion of a clamp by rotation over its frame's translation, and its place.

        Return None if the case leaves out rotations, or if nothing moves.
        """
        ratios = []
        for name in free_frames(self._scene.plan) if has_effect(self._run.case, "frame-rotation") else ():
            moved_m = self.phasor(name)
            if size_m := np.linalg.norm(moved_m):
                arms_m = clamp_arms_m(self._scene, name)
                at_clamps_m = np.cross(self.phasor(name, "rotation_rad"), arms_m)
                ratios.append((float(np.linalg.norm(at_clamps_m, axis=-1).max() / size_m), name))
        if not ratios:
            return None
        ratio, name = max(ratios)
        return ratio, f"at the outermost clamp of {name}"

    def _pull(self, panel: MovedPanel) -> tuple[Array, Array]:
        """Return the times (rows,) and the pull (rows,) of a panel in the window."""
        time_s, first_N, second_N = (
            self._run.read_between(f"forces/{panel.panel.name}", column, *self._window_s)
            for column in ("time_s", "first_clamp_N", "second_clamp_N")
        )
        return time_s, panel_pull_N(first_N, second_N, panel.panel.rectangle.along)

    def _stretch_m(self, spring: PanelSpring) -> complex:
        """Return the phasor of the second end's motion against the first end, along the panel."""
        first_m, second_m = map(self._place_phasor, spring.frames, spring.ends_m)
        return complex((second_m - first_m) @ spring.along)

    def _place_phasor(self, frame: str, place_m: Array) -> Phasors:
        """Return the phasor (3,) of a place on a frame that rotates little; it is zero for the ground."""
        if frame not in self._bodies:
            return np.zeros(3, complex)
        arm_m = place_m - self._bodies[frame].center_of_mass_m
        return self.phasor(frame) + np.cross(self.phasor(frame, "rotation_rad"), arm_m)

    def _shape(self, panel: MovedPanel) -> Shape:
        """Return a panel's shape from every sync point of the cycles in the window."""
        rows = self._run.read_cycles(f"panel_cycles/{panel.panel.name}", *self._window_s)
        return Shape(
            sag_m=float(rows["sag_most_m"].max()),
            travel_m=float(rows["middle_most_m"].max() - rows["middle_least_m"].min()),
            strain=max(0.0, float(rows["stretch_most"].max())),
        )


def spring_N_per_m(pull_N: complex, stretch_m: complex) -> float:
    """Return the stiffness of a panel: its pull in phase with the stretch of its ends, over this stretch.

    ``pull_N`` and ``stretch_m`` are phasors.
    """
    return max(0.0, float((pull_N / stretch_m).real))


def loss_factor(panel: MovedPanel, time_s: Array, pull_N: Array) -> float | None:
    """Return the loss factor of the panel's material at the frequencies of its pull, or None without any.

    The weight of a frequency is the squared amplitude of the pull.  If the stiffness is the same at all
    frequencies, this is the energy stored at the frequency.
    """
    steps_s = np.diff(time_s)
    power_N2 = np.abs(np.fft.rfft(np.hanning(len(pull_N)) * (pull_N - pull_N.mean()))) ** 2
    speed_rad_per_s = 2 * np.pi * np.fft.rfftfreq(len(pull_N), float(steps_s.mean()))
    if power_N2[1:].sum() == 0.0:
        return None
    factors = moduli(panel.material.branches, speed_rad_per_s[1:])[1]
    return float(np.average(factors, weights=power_N2[1:]))
