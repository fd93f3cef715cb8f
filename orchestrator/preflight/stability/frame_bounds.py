"""Bounds from panels on frames that they push."""

from __future__ import annotations

import math
from collections.abc import Iterator

from orchestrator.case.tables.case import Case
from orchestrator.preflight.stability.bound import Bound
from orchestrator.preflight.stability.frame_limits import (
    AHEAD,
    LARGEST_MASS,
    carried_share,
    extrapolated_clamps_s,
    late_reaction_s,
)
from orchestrator.preflight.stability.frame_modes import FrameMatrices

SOURCE = "docs/theory/stability.md, "


def panels_on_frames(case: Case, frames: FrameMatrices) -> Iterator[Bound]:
    """Springs and masses that frames carry, where motion and force are handed over."""
    scheme = case.coupling.scheme
    if not (case.exchange.panel_reaction and case.exchange.frame_motion):
        return
    if scheme in LARGEST_MASS:
        yield _carried_mass(scheme, frames)
    if scheme in AHEAD:
        limit_s = extrapolated_clamps_s(frames.mass, frames.panels_N_per_m)
        why = "frames alone on the panels as springs"
        yield Bound("extrapolated clamps", limit_s, SOURCE + "extrapolated clamps", why)
    if scheme == "serial-staggered":
        _, shapes = frames.modes()
        limit_s = late_reaction_s(shapes, frames.panels_N_per_m, frames.damping_N_s_per_m)
        why = "bushings' damping over panels' stiffness, in the mode where it is least"
        yield Bound("late reaction", limit_s, SOURCE + "late reaction", why)


def _carried_mass(scheme: str, frames: FrameMatrices) -> Bound:
    share, limit = carried_share(frames.mass, frames.carried), LARGEST_MASS[scheme]
    why = f"panels' mass on the frames is up to {share:.2g} of their own; the limit is {limit:.2g}"
    limit_s = math.inf if share < limit else 0.0
    return Bound("carried mass", limit_s, SOURCE + "carried mass", why)
