"""Particles by LIGGGHTS 3.8.0 (DEM: C. Kloss et al., Prog. Comput. Fluid Dyn. 12 (2012) 140-152,
doi 10.1504/PCFD.2012.047457), in this process and without files."""

from __future__ import annotations

from adapters.particles.liggghts.particles import Liggghts
from orchestrator.ports.plans import ParticlesPlan


def build(plan: ParticlesPlan) -> Liggghts:
    """Start LIGGGHTS with the plan's particles on the surface at t = 0.

    Raises SolverFailed if LIGGGHTS refuses the input.  In a parallel run an error can stop a single
    rank; the caller must then abort the communicator.
    """
    return Liggghts(plan)
