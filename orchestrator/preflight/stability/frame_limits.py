"""The longest stable sync interval for panels on frames, scheme by scheme.

Matrices over the free frames' coordinates: M of the frames alone, K of the panels as massless
springs, all modes' shapes X of the whole machine.  Derivations: docs/theory/stability.md.
"""

from __future__ import annotations

import math

import numpy as np
from scipy.linalg import eigh

from orchestrator.ports import Array

AHEAD = ("particles-first", "robin", "aitken", "quasi-newton")  # schemes that extrapolate the clamps
LARGEST_MASS = dict.fromkeys(AHEAD, 1 / 3) | {"serial-staggered": 0.95}
"""Mass that a frame carries stiffly over its own mass, r, above which its acceleration, fed
back through the panels' inertia, grows at any interval.  ``AHEAD`` schemes extrapolate it,
z^2 + 2 r z - r = 0; serial-staggered returns it, z = -r: stable below 1, less a margin for
bushings (measured: 0.99 where they swing by a quarter of a radian in an interval).  Causin, P.,
Gerbeau, J.-F. and Nobile, F., Computer Methods in Applied Mechanics and Engineering 194, 2005,
4506-4527, doi 10.1016/j.cma.2004.12.005, on loads from more mass than they act on."""


def extrapolated_clamps_s(mass: Array, panels_N_per_m: Array) -> float:
    """``AHEAD`` schemes: clamps extrapolated with the last acceleration, on springs.  Stable for
    w H < 1, w the highest frequency of the frames on the panels alone; damped below."""
    highest = float(eigh(panels_N_per_m, mass, eigvals_only=True)[-1])
    return 1 / math.sqrt(highest) if highest > 0 else math.inf


def late_reaction_s(shapes: Array, panels_N_per_m: Array, damping_N_s_per_m: Array) -> float:
    """serial-staggered: the panels' force comes an interval late, which is the damping -K H.  Of
    every mode X (a column), the machine's own damping must be larger: H < X C X / X K X."""
    driven = np.einsum("im,ij,jm->m", shapes, panels_N_per_m, shapes)
    damped = np.einsum("im,ij,jm->m", shapes, damping_N_s_per_m, shapes)
    felt = driven > 1e-9 * driven.max(initial=0.0)
    return float(np.min(damped[felt] / driven[felt], initial=math.inf))


def carried_share(mass: Array, carried: Array) -> float:
    """The largest ratio of carried mass to the frames' own, over all their motions."""
    return float(eigh(carried, mass, eigvals_only=True)[-1])
