"""What a panel's solver needs to know."""

from __future__ import annotations

from dataclasses import dataclass

from orchestrator.ports import Array
from orchestrator.ports.geometry import AperturePattern, Rectangle
from orchestrator.ports.recording import Playback


@dataclass(frozen=True)
class HyperelasticPlan:
    """Two-parameter Mooney-Rivlin  W = C10 (I1 - 3) + C01 (I2 - 3) + K/2 (J - 1)^2  with the
    isochoric invariants, and Maxwell branches for damping: each a pair (ratio of the branch's
    modulus to the elastic one, relaxation time in s)."""

    density_kg_per_m3: float
    c10_Pa: float
    c01_Pa: float
    bulk_modulus_Pa: float
    branches: tuple[tuple[float, float], ...] = ()

    @property
    def shear_modulus_Pa(self) -> float:
        return 2.0 * (self.c10_Pa + self.c01_Pa)

    @property
    def youngs_modulus_Pa(self) -> float:
        """At small strain, incompressible."""
        return 3.0 * self.shear_modulus_Pa


@dataclass(frozen=True)
class StopPlan:
    """The flat top of a beam under the free length of a panel from ``from_m`` to ``to_m``, carried
    by ``frame``, ``gap_m`` below the panel as it is mounted straight.  The layer on it has the
    stiffness ``stiffness_Pa_per_m`` and the damping ``damping_Pa_s_per_m``: pressure per depth, per speed.
    """

    name: str
    frame: str
    from_m: float
    to_m: float
    gap_m: float
    stiffness_Pa_per_m: float
    damping_Pa_s_per_m: float


@dataclass(frozen=True)
class PanelPlan:
    """One panel: geometry, material, and how finely to solve it.

    ``frames`` names the frames that hold the first and the second clamp.  ``cells`` along the
    free length and across; ``step_s`` the largest step (0: the solver's own limit with margin).
    ``apertures``: its openings, if any; only particles see each of them.  ``playback``: the
    recorded motion that it follows, where its shape is prescribed.  ``stops``: beams that it can
    come to lie on (``orchestrator/coupling/stopped_panel.py``, no matter of the solver).
    """

    name: str
    rectangle: Rectangle
    frames: tuple[str, str]
    thickness_m: float
    material: HyperelasticPlan
    gravity_m_per_s2: Array
    cells: tuple[int, int]
    step_s: float
    integrator: str
    sync_interval_s: float
    apertures: AperturePattern | None = None
    playback: Playback | None = None
    stops: tuple[StopPlan, ...] = ()

    @property
    def mass_kg(self) -> float:
        """Mass of the whole panel: its free length without openings, and the parts in the clamps."""
        at = self.rectangle
        share = self.apertures.material_share(at) if self.apertures is not None else 1.0
        area_m2 = at.width_m * (share * at.length_m + 2.0 * at.clamp_m)
        return area_m2 * self.thickness_m * self.material.density_kg_per_m3


@dataclass(frozen=True)
class MeshSize:
    """How large a panel's mesh is, before it is made: cells with material, nodes (each with three
    unknowns), memory with the factorised stiffness (good to a factor of two), and the mass of the
    lightest node that particles can touch."""

    cells: int
    nodes: int
    memory_GiB: float
    lightest_kg: float


LARGEST_MESHES_GIB = 64.0
"""What the panels' meshes may take in all: a large workstation's memory."""
