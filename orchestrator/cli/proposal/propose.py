"""From wishes to the proposal of a case: the layout, the machine that reaches the stroke, and the levels.

The stroke is that of the preflight scene (orchestrator/preflight/scene), computed from the proposed case
itself: frames on damped bushings, with panels as springs.  The closed form of two masses gives the first
machine, and a few rounds correct its unbalance and its bushings.
"""

from __future__ import annotations

import math
import shlex
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from orchestrator.case.deck.panels import TRANSPORT_M_PER_S
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.materials.library import slug
from orchestrator.cli.proposal import levels, limits
from orchestrator.cli.proposal.case_files import fill_templates, toml_answer
from orchestrator.cli.proposal.deck_size import with_enough_panels
from orchestrator.cli.proposal.layout import CHUTE_SLOPE_DEG, CLAMP_M, Layout, lay_out
from orchestrator.cli.proposal.machine import ISOLATION, RATIO, RUN_UP_CYCLES, Machine, propose_machine
from orchestrator.cli.proposal.mounting import Choice, choose_mounting, no_hanging_mats
from orchestrator.cli.proposal.proposal import Proposal, mean_stroke_m, panels_N_per_m
from orchestrator.cli.proposal.remarks import remarks
from orchestrator.cli.proposal.wishes import TEMPLATES, ImpossibleWishes, Wishes, read_wishes
from orchestrator.ports.plans import SolverFailed, SolverMissing
from orchestrator.preflight.check import find_problems, warnings
from orchestrator.preflight.cost import THIN, in_words
from orchestrator.preflight.effects import air_drag
from orchestrator.preflight.judge import JudgedCase, load_judged
from orchestrator.preflight.scene.scene import scene
from orchestrator.preflight.stability.report import stability_report

PANEL_MATERIAL = "polyurethane 90 Shore A"
ROUNDS = 12
CLOSE = 1e-4  # largest relative error of the scene's stroke
RIG_CYCLES = 12
LEVELS = ("draft", "study")


@dataclass
class _Draft:
    """A case in a temporary folder, whose files are written again after each change of ``values``."""

    folder: Path
    layout: Layout
    values: dict[str, Any] = field(default_factory=dict)

    def write(self, *files: str) -> None:
        """Fill the templates of these files."""
        template = TEMPLATES[self.layout.wishes.template]
        for file, text in fill_templates(template.files, self.values, files).items():
            path = self.folder / file
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text, encoding="utf-8")

    def read(self) -> dict[str, str]:
        """Return the texts of all files by their paths."""
        files = sorted(file for file in self.folder.rglob("*") if file.is_file())
        return {file.relative_to(self.folder).as_posix(): file.read_text(encoding="utf-8") for file in files}

    def judge(self, level: str) -> JudgedCase:
        """Return the case at a level.  Raises CaseError with the problems that its tables reveal."""
        return load_judged(self.folder, level)


def find_refusals(template: str, answers: Mapping[str, str]) -> list[CaseProblem]:
    """Return each reason, as far as it is known without a case, why answers describe no possible machine."""
    try:
        return [*limits.find_impossible(with_enough_panels(read_wishes(template, answers)))]
    except ImpossibleWishes as error:
        return list(error.problems)


def propose(wishes: Wishes, folder: str) -> Proposal:
    """Return the proposal of a case for a new ``folder``, whose path stands in the commands of its README.

    Raises ImpossibleWishes with every reason why no such machine can be, and CaseError if the proposed
    case has problems that the wishes did not reveal.
    """
    wishes = with_enough_panels(wishes)
    if problems := [*limits.find_impossible(wishes)]:
        raise ImpossibleWishes(problems)
    layout = lay_out(wishes)
    with TemporaryDirectory() as temporary:
        name = Path(folder).name
        case = _Draft(Path(temporary) / name, layout, _first_values(layout, name))
        if wishes.feed_file:
            case.folder.mkdir(parents=True)
            (case.folder / "feed.csv").write_text(wishes.feed_file, encoding="utf-8")
        chosen = _mount(case)
        layout = case.layout
        machine = _tune(case) if wishes.is_free else None
        _with_safe_interval(case, "study", levels.study(layout))
        _add_air(case)
        draft = _choose_draft(case)
        judged = {level: case.judge(level) for level in LEVELS}
        if problems := [problem for loaded in judged.values() for problem in find_problems(loaded)]:
            raise CaseError(problems)
        run_s = {level: levels.predicted_s(row.case) for level, row in judged.items()}
        moved = scene(judged["draft"].case.whole_machine)
        proposal = Proposal(wishes, layout, machine, moved, draft, run_s, chosen, case.values["air"])
        stability = stability_report(judged["draft"].case)
        warned = [*warnings(judged["draft"]), *stability.warnings()]
        proposal = replace(proposal, remarks=tuple(remarks(proposal, warned)))
        case.values |= {
            "folder": shlex.quote(folder),
            "remarks": proposal.remarks,
            "draft_time": in_words(run_s["draft"]),
            "study_time": in_words(run_s["study"]),
        }
        case.write("README.md")
        return replace(proposal, files=case.read())


def _first_values(layout: Layout, name: str) -> dict[str, Any]:
    """Return the values of the templates, without a machine and levels."""
    wishes = layout.wishes
    cycle_s = 2 * math.pi / wishes.speed_rad_per_s
    speeds_m_per_s = (THIN, TRANSPORT_M_PER_S)
    return {
        "name": name,
        "wishes": wishes,
        "given": {key: toml_answer(text) for key, text in wishes.answers.items()},
        "feed": slug(wishes.material),
        "panel_material": PANEL_MATERIAL,
        "layout": layout,
        "title": wishes.title,
        "words": ", ".join(f"{name} {text}" for name, text in wishes.answers.items()),
        "machine": None,
        "air": "",
        "is_heavy": False,
        "study": levels.study(layout),
        "coarse_cells": levels.cells(layout, levels.COARSE_CELLS),
        "fine_cells": levels.cells(layout, levels.FINE_CELLS),
        "isolation_share": ISOLATION,
        "ratio": RATIO,
        "run_up_s": round(RUN_UP_CYCLES * cycle_s, 3),
        "center_m": (layout.length_m / 2, wishes.width_m / 2, 0.0),
        "clamp_m": CLAMP_M,
        "chute_slope_deg": CHUTE_SLOPE_DEG,
        "speeds_m_per_s": speeds_m_per_s,
        "bed_kg_per_m2": [wishes.throughput_kg_per_s / (wishes.width_m * v) for v in speeds_m_per_s],
        "watched": sorted({1, (wishes.panels + 1) // 2, wishes.panels}),
        "rig_cycles": RIG_CYCLES,
        "rig_domain_m": ((-0.2, -0.2, -0.4), (layout.panel_m + 0.2, wishes.width_m + 0.2, 0.4)),
    }


def _mount(case: _Draft) -> Choice | None:
    """Mount the mats so that they hang down in every turn, and return what was chosen.

    Return None where that cannot be tried, and for a rig, which is there to try others.  Raises
    ImpossibleWishes if no mat hangs at the wanted stroke and speed.
    """
    wishes = case.layout.wishes
    if wishes.is_free:
        _tune(case)
    else:
        case.values["draft"] = next(levels.drafts(case.layout))
        case.write("case.toml", "levels/draft.toml")
    moved = scene(case.judge("draft").case.whole_machine)
    try:
        chosen = choose_mounting(moved)
        if chosen is None and wishes.has_material:
            raise ImpossibleWishes([*no_hanging_mats(wishes, moved)])
    except (SolverFailed, SolverMissing):
        return None
    if chosen is not None:
        case.layout = replace(case.layout, mounting=chosen.mounting)
        case.values |= _first_values(case.layout, case.folder.name)
    return chosen


def _tune(case: _Draft) -> Machine:
    """Return the machine with which the scene of the case has the wanted stroke.

    The panels' stiffness depends on the stroke, and the closed form has no damping; both are taken from the
    scene of the machine of the round before.  Raises ImpossibleWishes if the panels are too stiff.
    """
    layout = case.layout
    case.values |= {"draft": next(levels.drafts(layout)), "panels_N_per_m": 0.0}
    held_N_per_m, panels_kg, correction = 0.0, 0.0, 1.0
    for _ in range(ROUNDS):
        if problems := [*limits.too_stiff_panels(layout, held_N_per_m)]:
            raise ImpossibleWishes(problems)
        machine = propose_machine(layout, held_N_per_m, panels_kg, correction)
        case.values |= {"machine": machine, "is_heavy": machine.is_heavy, "panels_N_per_m": held_N_per_m}
        case.write("case.toml", "levels/draft.toml")
        moved = scene(case.judge("draft").case.whole_machine)
        stroke_m = mean_stroke_m(moved)
        if abs(stroke_m / layout.wishes.stroke_m - 1) < CLOSE:
            break
        correction *= layout.wishes.stroke_m / stroke_m
        held_N_per_m = panels_N_per_m(moved)
        panels_kg = sum(spring.mass_kg for spring in moved.springs)
    return machine


def _add_air(case: _Draft) -> None:
    """Give the case air where its drag matters to the finest grains that the study computes."""
    if not case.layout.wishes.has_material:
        return
    verdict = air_drag.judge(scene(case.judge("study").case.whole_machine))
    if verdict.matters:
        case.values["air"] = verdict.why
        case.write("case.toml")


def _choose_draft(case: _Draft) -> levels.Level:
    """Return the best draft whose predicted time is short enough, or the cheapest."""
    for draft in levels.drafts(case.layout):
        safe = _with_safe_interval(case, "draft", draft)
        if levels.predicted_s(case.judge("draft").case) < levels.DRAFT_S:
            break
    return safe


def _with_safe_interval(case: _Draft, name: str, level: levels.Level) -> levels.Level:
    """Return the level with a sync interval that is stable and accurate by the preflight's own bounds.

    The bounds depend on the scheme, which the program chooses by the interval; a few rounds find both.
    """
    for _ in range(ROUNDS):
        case.values[name] = level
        case.write("case.toml", f"levels/{name}.toml")
        report = stability_report(case.judge(name).case)
        bounds_s = [bound.interval_s for bound in (report.stability_bound, report.accuracy_bound) if bound]
        if not bounds_s or level.interval_s <= min(bounds_s):
            break
        level = level.with_interval(levels.WITHIN * min(bounds_s))
    return level
