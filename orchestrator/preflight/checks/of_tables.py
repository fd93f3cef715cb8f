"""The rules that a case's tables alone must meet, before any file is read."""

from __future__ import annotations

from orchestrator.case.file.plausible import wrong_sizes
from orchestrator.preflight.checks import (
    adhesion,
    apertures,
    drives,
    machine,
    materials,
    names,
    recordings,
    steps,
    stops,
    surfaces,
)

OF_TABLES = (
    names.unknown_names,
    names.shared_names,
    materials.complete_materials,
    materials.complete_contacts,
    materials.worn_surfaces,
    materials.boxes_and_sizes,
    machine.frames_and_their_solver,
    drives.driven_frames,
    drives.start_of_drives,
    machine.bushings_and_exciters,
    machine.panels,
    apertures.openings,
    stops.stops,
    machine.panel_integrator,
    recordings.named_recording,
    machine.probes,
    surfaces.plates,
    adhesion.works_of_adhesion,
    wrong_sizes,
    steps.whole_times,
)
