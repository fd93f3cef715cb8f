"""A mat as a chain of rigid-jointed links, written for the tests alone: none of the program's mechanics.

Links of mass points with springs along them and springs at the joints, which act on true angles; each spring
has Maxwell elements beside it.  Semi-implicit Euler steps.  Everything is for one metre of width, in the
plane of the length (x) and the normal (z).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, sosfiltfilt

from orchestrator.ports import Array

LINKS, STEP_S, ROW_S = 24, 2e-5, 4e-4


@dataclass(frozen=True)
class Mat:
    """A mat for each metre of width, and how its second clamp moves along it against the first.

    The motion grows over ``run_up_turns`` turns as half a cosine.
    """

    length_m: float
    span_m: float
    mass_kg_per_m2: float
    stretching_N_per_m: float
    bending_N_m: float
    branches: tuple[tuple[float, float], ...]
    clamp_angle_deg: float
    stroke_m: float
    speed_rad_per_s: float
    run_up_turns: float


@dataclass(frozen=True)
class Turns:
    """The farthest height of the middle and the largest acceleration below 500 Hz in each turn."""

    farthest_m: Array
    peak_g: Array


def flip(mats: list[Mat], turns: int, left_out: int) -> list[Turns]:
    """Return the turns after the first ``left_out`` of each mat.

    All mats have the same free length, speed and branches.
    """
    count, links = len(mats), LINKS

    def each(name: str) -> Array:
        return np.array([getattr(mat, name) for mat in mats])[:, None]

    length_m, speed = mats[0].length_m, mats[0].speed_rad_per_s
    link_m, turn_s = length_m / links, 2 * math.pi / speed
    rate_N, joint_N_m = each("stretching_N_per_m"), each("bending_N_m") / link_m
    joint_N_m = joint_N_m * np.concatenate([[2.0], np.ones(links - 1), [2.0]])
    angle_rad = np.radians(each("clamp_angle_deg"))
    node_kg = each("mass_kg_per_m2") * link_m
    at_rest = np.linspace(0, 1, links + 1)
    place_m = np.zeros((count, links + 1, 2))
    place_m[:, :, 0] = at_rest * each("span_m")
    slack_m = np.maximum(length_m - each("span_m"), 1e-5)
    place_m[:, :, 1] = -2 / np.pi * np.sqrt(slack_m * length_m) * np.sin(np.pi * at_rest) ** 2
    speed_m_per_s = np.zeros_like(place_m)
    gains = [ratio for ratio, _ in mats[0].branches]
    decays = [1 / (1 + STEP_S / time_s) for _, time_s in mats[0].branches]
    pulls, moments = ([np.zeros((count, n)) for _ in gains] for n in (links, links + 1))
    strain_before, bent_before = None, None
    still_s, each_row = 0.5, round(ROW_S / STEP_S)
    steps = round((still_s + turns * turn_s) / STEP_S)
    rows = []
    for step in range(steps):
        link = np.diff(place_m, axis=1)
        long_m = np.hypot(link[:, :, 0], link[:, :, 1])
        turn = np.arctan2(link[:, :, 1], link[:, :, 0])
        strain = long_m / link_m - 1
        bent = np.diff(np.concatenate([-angle_rad, turn, angle_rad], axis=1), axis=1)
        pull_N, moment_N_m = rate_N * strain, joint_N_m * bent
        if strain_before is not None:
            for number, (gain, decay) in enumerate(zip(gains, decays, strict=True)):
                pulls[number] = decay * (pulls[number] + gain * rate_N * (strain - strain_before))
                moments[number] = decay * (moments[number] + gain * joint_N_m * (bent - bent_before))
                pull_N = pull_N + pulls[number]
                moment_N_m = moment_N_m + moments[number]
        strain_before, bent_before = strain, bent
        shear_N = np.diff(moment_N_m, axis=1) / long_m
        along = link / long_m[:, :, None]
        upright = np.stack([-along[:, :, 1], along[:, :, 0]], axis=2)
        on_link_N = pull_N[:, :, None] * along - shear_N[:, :, None] * upright
        force_N = np.zeros_like(place_m)
        force_N[:, :-1] += on_link_N
        force_N[:, 1:] -= on_link_N
        force_N[:, :, 1] -= 9.81 * node_kg
        speed_m_per_s += STEP_S * force_N / node_kg[:, :, None]
        moving_s = (step + 1) * STEP_S - still_s
        if moving_s < 0:  # it comes to rest
            speed_m_per_s *= 1 - 30 * STEP_S
        grown = (1 - np.cos(math.pi * np.clip(moving_s / (each("run_up_turns") * turn_s), 0.0, 1.0))) / 2
        speed_m_per_s[:, [0, -1]] = 0.0
        place_m += STEP_S * speed_m_per_s
        place_m[:, -1, 0] = (each("span_m") + each("stroke_m") * grown * math.cos(speed * moving_s))[:, 0]
        if moving_s >= 0 and (step + 1) % each_row == 0:
            middle_m_per_s = speed_m_per_s[:, links // 2].copy()
            rows.append((moving_s, place_m[:, links // 2, 1].copy(), middle_m_per_s))
    time_s = np.array([row[0] for row in rows])
    height_m, velocity_m_per_s = (np.array([row[k] for row in rows]) for k in (1, 2))
    band = butter(4, 500.0, fs=1 / ROW_S, output="sos")
    size_g = np.linalg.norm(sosfiltfilt(band, np.gradient(velocity_m_per_s, ROW_S, axis=0), axis=0), axis=2)
    number = np.floor(time_s / turn_s).astype(int)
    turns_of_chains = []
    for mat in range(count):
        parts = [number == turn for turn in range(left_out, turns)]
        far = [height_m[part, mat][np.abs(height_m[part, mat]).argmax()] for part in parts]
        peak = [size_g[part, mat].max() / 9.81 for part in parts]
        turns_of_chains.append(Turns(np.array(far), np.array(peak)))
    return turns_of_chains
