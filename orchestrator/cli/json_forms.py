"""The output of ``check``, ``explain`` and ``list`` for other programs (docs/json-output.md).

All numbers are in SI units, and names end with their unit.  The message of an error goes to standard
error, and the exit code tells its kind; ``check`` has the problems of a case as JSON, too.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import asdict
from pathlib import Path
from typing import Any

import typer

from orchestrator.figures.figure import to_json
from orchestrator.preflight.judge import JudgedCase
from orchestrator.preflight.judgement.catalogue import Judged

FORMAT = 1
"""Version of all these forms, their entry ``format_version``."""


def print_json(table: Mapping[str, Any]) -> None:
    """Print a table as JSON on standard output, with ``format_version`` first; numbers that are not finite
    become null, and characters that a terminal could obey are escaped."""
    text = json.dumps(to_json({"format_version": FORMAT, **table}), indent=2, ensure_ascii=False)
    typer.echo("".join(c if c.isprintable() or c == "\n" else json.dumps(c)[1:-1] for c in text))


def check_form(loaded: JudgedCase) -> dict[str, Any]:
    """Return what ``flipflow check`` says about a case without problems."""
    from orchestrator.case.deck.panels import single_panels
    from orchestrator.case.solver_plans import particle_step_s
    from orchestrator.case.tables.case import has_particles
    from orchestrator.ports.clock import steps_in
    from orchestrator.preflight.check import given_rates_kg_per_s, warnings
    from orchestrator.preflight.checks.steps import missing_solvers
    from orchestrator.preflight.cost import (
        THICK,
        THIN,
        particles_at_start,
        predicted_parts_s,
        rigid_triangles,
    )
    from orchestrator.preflight.mats.mats import mat_tables
    from orchestrator.preflight.scene.frame_motion import frame_motions
    from orchestrator.preflight.scene.scene import scene
    from orchestrator.preflight.sheet.sheet import sheet
    from orchestrator.preflight.stability.report import stability_report, with_scheme

    case = loaded.case
    stability = stability_report(case)
    costed, at_start = with_scheme(case, stability.scheme), particles_at_start(case)
    rigid = sum(rigid_triangles(case, loaded.folder))
    predicted_s = {bed: predicted_parts_s(costed, at_start, bed, rigid=rigid) for bed in (THIN, THICK)}
    return {
        "case": loaded.name,
        "level": loaded.level or None,
        "title": case.title,
        "solvers": {part: getattr(case, part).solver for part in ("frames", "panel", "particles")},
        "frames": [*case.screen.frames],
        "motion": [asdict(motion) for motion in frame_motions(scene(case))],
        "panels": [panel.name for panel in single_panels(case)],
        "mats": mat_tables(scene(case)),
        "sheet": [asdict(line) for line in sheet(scene(case.original), given_rates_kg_per_s(loaded))],
        "particles_at_start": at_start,
        "feeds_kg_per_s": {name: feed.rate_kg_per_s for name, feed in case.bed.feeds.items()},
        "duration_s": case.duration_s,
        "sync_interval_s": case.coupling.sync_interval_s,
        "sync_intervals": steps_in(case.duration_s, case.coupling.sync_interval_s),
        "particle_step_s": particle_step_s(case) if has_particles(case) else None,
        "predicted_processor_s": {
            "thin_bed": sum(predicted_s[THIN].values()),
            "thick_bed": sum(predicted_s[THICK].values()),
        },
        "left_out": loaded.left_out,
        "changed": list(loaded.changed),
        "stability": stability.as_json(),
        "warnings": [*warnings(loaded), *stability.warnings(), *missing_solvers(case)],
    }


def explain_form(loaded: JudgedCase, effects: Sequence[Judged]) -> dict[str, Any]:
    """Return what ``flipflow explain`` says about the effects of a case."""
    from orchestrator.preflight.judgement.catalogue import find_dispensable, with_dependents

    left_out = with_dependents(find_dispensable(effects), "")
    return {
        "case": loaded.name,
        "level": loaded.level or None,
        "title": loaded.case.title,
        "effects": {
            judged.effect: {
                "part": judged.part,
                "present": judged.present,
                "verdict": asdict(judged.verdict),
                "is_lacking": judged.is_lacking,
                "is_spare": judged.is_spare,
                "auto_leaves_out": judged.present and judged.effect in left_out,
                "key": judged.key,
            }
            for judged in effects
        },
    }


def cases_in(folder: Path) -> Iterator[dict[str, Any]]:
    """Yield the folder, title, base, levels and default level of each case in a folder, in order.

    The title of a case that cannot be read is None.
    """
    from orchestrator.case.file.base import level_names, read_chain
    from orchestrator.case.file.errors import CaseError
    from orchestrator.case.load import load

    for file in sorted(folder.glob("*/case.toml")):
        case: dict[str, Any] = {"folder": str(file.parent), "title": None, "base": None}
        case |= {"levels": [], "default_level": None}
        with suppress(CaseError):  # the title then says that it has problems
            case |= {"levels": level_names(file.parent), "base": read_chain(file)[0].base or None}
            loaded = load(file)
            case["title"] = loaded.case.title
            case["default_level"] = loaded.level.name if loaded.level is not None else None
        yield case
