"""Contacts that cannot carry what meets in them."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.case.file.contents import has_particles
from orchestrator.case.tables.case import Case
from orchestrator.ports.particle_records import LARGEST_CARRIED_OVERLAP
from orchestrator.preflight.scene.scene import scene
from orchestrator.preflight.scene.softness import softness


def too_soft(case: Case) -> Iterator[str]:
    """Warns of contacts in which particles are expected to sink deeper than contact laws hold."""
    if not has_particles(case):
        return
    found = softness(scene(case))
    if found.overlap > LARGEST_CARRIED_OVERLAP:
        said = found.in_words(found.overlap, LARGEST_CARRIED_OVERLAP, found.where)
        yield (
            f"particles are expected to sink into what they meet by {found.overlap:.2g} of a "
            f"radius ({said}): beyond {LARGEST_CARRIED_OVERLAP:g} no contact law holds, at 1 they "
            "go through panels; raise particles.largest_youngs_modulus_Pa"
        )
