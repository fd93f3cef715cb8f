"""Checks of a case before anything starts: small functions, each with its own rule and test."""

from orchestrator.case.file.plausible import wrong_sizes
from orchestrator.preflight.checks import machine, materials, names, panels, recordings, steps, surfaces

TABLE_RULES = (
    names.unknown_names,
    names.shared_names,
    materials.complete_materials,
    materials.complete_contacts,
    materials.worn_surfaces,
    materials.boxes_and_sizes,
    machine.frames_and_their_solver,
    machine.driven_frames,
    machine.start_of_drives,
    machine.bushings_and_exciters,
    panels.panel_rows,
    panels.openings,
    panels.stops,
    panels.panel_integrator,
    recordings.named_recording,
    machine.probes,
    surfaces.plates,
    materials.works_of_adhesion,
    wrong_sizes,
    steps.whole_times,
)
"""The rules that a case's tables alone must meet, before any file is read."""
