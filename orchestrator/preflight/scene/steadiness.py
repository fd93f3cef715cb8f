"""What may make a machine move otherwise than the steady harmonic motion of a scene.

Numbers of effects look at one drive, steady, at one frequency.  Here are the reasons to doubt that, and the
strokes on the way up to the full speed.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from orchestrator.preflight.scene.frame_modes import NEAR, FrameMode, frame_modes, modes_near
from orchestrator.preflight.scene.scene import Scene, stroke_m
from orchestrator.preflight.scene.shaking import free_frames, solve_shakings

ORDERS = (1, 3)  # of parametric resonances; that of order 2 is at the mode itself
SPEEDS = 30  # number of speeds on the way up, besides those of the modes
LOWEST = 0.05  # of the full speed, on the way up


def doubt_of_steady_motion(scene: Scene) -> str:
    """Return why the frames may move otherwise than steadily and harmonically; "" if nothing says so."""
    exciters = scene.plan.exciters
    if len(exciters) > 1 and any(exciter.motor is not None for exciter in exciters):
        return "no gear couples the shafts, which find their own phases"
    for shaking in scene.shaken:
        if near := modes_near(scene, shaking.speed_rad_per_s):
            return f"near a mode small changes matter: {near[0].in_words}"
        if excited := _excited_by_panels(scene, shaking.speed_rad_per_s):
            return f"the panels' stiffness varies in each cycle and may excite {excited[0].in_words}"
    return ""


def _excited_by_panels(scene: Scene, speed_rad_per_s: float) -> list[FrameMode]:
    """Return the modes that panels which are taut for a part of each cycle may excite.

    A stiffness that varies with w excites modes at  n w / 2  if its depth e, over the mean stiffness of the
    mode, is large enough for the damping: (e / 4)^n > damping ratio.  A panel that pulls for half of a cycle
    varies by 4 / pi of its mean.  Bolotin, V. V., The Dynamic Stability of Elastic Systems, 1964, ch. 2.
    """
    if not any(abs(panel.tension_m) < panel.stroke_m for panel in scene.panels):
        return []
    excited_Hz = speed_rad_per_s / (2 * math.pi)
    return [
        mode
        for mode in frame_modes(scene)
        for order in ORDERS
        if abs(mode.frequency_Hz / (order * excited_Hz / 2) - 1) <= NEAR
        and (mode.panels_share / math.pi) ** order > mode.damping_ratio
    ]


def on_the_way_up(scene: Scene) -> Scene | None:
    """Return the scene with the largest stroke that each panel has at any speed up to the full one.

    The exciters pass all speeds together, so slowly that the motion at each becomes steady: an upper bound.
    Return None if no exciter moves a free frame.
    """
    plan, full_rad_per_s = scene.plan, scene.speed_rad_per_s
    if not plan.exciters or not free_frames(plan):
        return None
    modes = [2 * math.pi * mode.frequency_Hz / full_rad_per_s for mode in frame_modes(scene)]
    shares = [*np.linspace(LOWEST, 1.0, SPEEDS).tolist(), *(share for share in modes if LOWEST < share < 1)]
    strokes_m = np.zeros(len(scene.panels))
    for share in shares:
        slower = tuple(replace(row, speed_rad_per_s=share * row.speed_rad_per_s) for row in plan.exciters)
        shaken = solve_shakings(replace(plan, exciters=slower), scene.springs)
        strokes_m = np.maximum(strokes_m, [stroke_m(shaken, spring) for spring in scene.springs])
    panels = (
        replace(panel, stroke_m=float(size)) for panel, size in zip(scene.panels, strokes_m, strict=True)
    )
    return replace(scene, panels=tuple(panels))
