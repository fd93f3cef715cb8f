"""The contact damper against the panel's lightest nodes: a limit of the sync interval.

Between two sync points the particles see a surface that drifts freely.  A damper g on a node of
effective mass m then changes the node's velocity by the factor 1 - g H / m per interval, which
grows without bound for H > 2 m / g.  Derived for this program: docs/theory/coupling.md.
"""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from orchestrator.bed.contact_times import contact_moduli, impact_speed_m_s, reduced_modulus_Pa
from orchestrator.bed.size_distribution import classes
from orchestrator.casefile.case import Case
from orchestrator.casefile.contents import has_particles
from orchestrator.geometry import Apertures
from orchestrator.ports import Array
from orchestrator.tables.screen import Panel


def light_nodes(case: Case) -> Iterator[str]:
    """A warning with numbers for a sheet whose surface points rest on nodes that are too light."""
    if case.panel.solver != "sheet" or not has_particles(case):
        return
    for name, panel in case.screen.panels.items():
        limit_s = 2 * lightest_node_kg(case, panel) / strongest_damper_N_s_m(case, panel.material)
        if case.coupling.sync_interval_s > limit_s:
            yield (
                f"coupling.sync_interval_s = {case.coupling.sync_interval_s:.3g} s: a particle's "
                f"contact damping on the lightest nodes of panel {name} allows {limit_s:.2g} s. "
                "Take that, fewer panel.cells, or panel.surface_cells whose corners stay away "
                "from the corners of panel.cells"
            )


def lightest_node_kg(case: Case, panel: Panel) -> float:
    """Effective mass 1 / sum(N^2 / m) of the surface's points, the free edges left out.

    N: shape functions, m: masses of the sheet's quadratic cells, lumped at their
    Gauss-Lobatto points (1/6, 2/3, 1/6 in each direction; corners belong to two cells).
    Openings have corners everywhere, so some stand on the lightest nodes, the cells' corners.
    """
    density = case.materials[panel.material].density_kg_m3
    sides_m = (panel.length_m, panel.width_m)
    cells, surface = case.panel.cells, case.panel.surface_cells
    cell_m2 = math.prod(side_m / n for side_m, n in zip(sides_m, cells, strict=True))
    solid, lightest = 1.0, np.empty(0)
    if panel.apertures:
        solid, lightest = Apertures(**dict(panel.apertures)).solid_share, np.zeros(1)
    mobility = [
        _mobility(np.append(np.arange(1, m) * n / m, lightest)).max(initial=0.75)
        for n, m in zip(cells, surface, strict=True)
    ]
    return float(solid * density * panel.thickness_m * cell_m2 / math.prod(mobility))


def _mobility(cells_from_edge: Array) -> Array:
    """Sum of N^2 / weight at places counted in cells, along one direction."""
    x = 2 * (cells_from_edge % 1.0) - 1
    one, middle, two = x * (x - 1) / 2, 1 - x * x, x * (x + 1) / 2
    mobility: Array = 3 * (one**2 + two**2) + 1.5 * middle**2
    return mobility


def strongest_damper_N_s_m(case: Case, panel_material: str) -> float:
    """Of all particles on a panel at the deepest overlap of an impact:
    2 sqrt(5/6) beta sqrt(2 E* sqrt(R d) m), beta = -ln e / sqrt(ln^2 e + pi^2)
    (Tsuji, Tanaka and Ishida, Powder Technology 71, 1992, 239-250,
    doi 10.1016/0032-5910(92)88030-L, in the form of LIGGGHTS's model hertz)."""
    cap, speed = case.particles.largest_youngs_modulus_Pa, impact_speed_m_s(case)
    panel = contact_moduli(case.materials[panel_material], cap)
    found = [1e-12]
    for name, diameter_m in _largest_m(case).items():
        grain = case.materials[name]
        mass_kg, radius_m = math.pi / 6 * diameter_m**3 * grain.density_kg_m3, diameter_m / 2
        reduced_Pa = reduced_modulus_Pa(contact_moduli(grain, cap), panel)
        depth_m = (15 * mass_kg * speed**2 / (16 * math.sqrt(radius_m) * reduced_Pa)) ** 0.4
        stiffness_N_m = 2 * reduced_Pa * math.sqrt(radius_m * depth_m)
        log_e = math.log(_restitution(case, name, panel_material))
        beta = -log_e / math.hypot(log_e, math.pi)
        found.append(2 * math.sqrt(5 / 6) * beta * math.sqrt(stiffness_N_m * mass_kg))
    return max(found)


def _largest_m(case: Case) -> dict[str, float]:
    bed = case.bed
    sizes = [(row.material, row.diameter_m) for row in bed.particles.values()]
    sizes += [(source.material, row.largest_m) for source in bed.sources for row in classes(source)]
    largest: dict[str, float] = {}
    for name, diameter_m in sizes:
        largest[name] = max(diameter_m, largest.get(name, 0.0))
    return largest


def _restitution(case: Case, one: str, two: str) -> float:
    pairs = {frozenset(row.between): row.restitution for row in case.contacts}
    return pairs[frozenset((one, two))]
