"""The checks of a case: small functions, each with its own rule and test."""

from orchestrator.case.file.plausible import wrong_sizes
from orchestrator.preflight.checks import bed, machine, names, panels, steps, surfaces

TABLE_RULES = (
    names.unknown_names,
    names.shared_names,
    bed.complete_materials,
    bed.complete_contacts,
    bed.growing_impacts,
    bed.boxes_and_sizes,
    machine.frames_and_their_solver,
    machine.start_of_drives,
    machine.bushings_and_exciters,
    machine.stops_of_exciters,
    panels.panel_rows,
    panels.drawings,
    panels.openings,
    panels.rims,
    panels.stops,
    panels.panel_integrator,
    machine.probes,
    surfaces.plates,
    bed.works_of_adhesion,
    wrong_sizes,
    steps.whole_times,
)
"""The rules that a case's tables alone must meet, before any file is read."""
