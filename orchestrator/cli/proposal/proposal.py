"""The proposal of a case: its files, and what was estimated of its machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from statistics import fmean

from orchestrator.case.deck.panels import axes
from orchestrator.cli.proposal.layout import Layout
from orchestrator.cli.proposal.levels import Level
from orchestrator.cli.proposal.machine import Machine
from orchestrator.cli.proposal.mounting import Choice
from orchestrator.cli.proposal.wishes import Wishes
from orchestrator.preflight.scene.scene import Scene


@dataclass(frozen=True)
class Proposal:
    """A proposed case: the texts of its files by their paths, and the scene of its machine.

    ``machine`` is None where drives prescribe the motion, and ``mounting`` where none could be tried.
    ``air`` says why the air matters to the feed; it is empty where it does not.
    ``run_s`` has the predicted processor time of a run at each level, and ``remarks`` has sentences about
    what is proposed and what is doubtful in it.
    """

    wishes: Wishes
    layout: Layout
    machine: Machine | None
    scene: Scene
    draft: Level
    run_s: Mapping[str, float]
    mounting: Choice | None = None
    air: str = ""
    remarks: tuple[str, ...] = ()
    files: Mapping[str, str] = field(default_factory=dict)


def panels_N_per_m(moved: Scene) -> float:
    """Return the stiffness of all panels along the deck, as springs."""
    along = axes(moved.case)[:, 0]
    return float(sum(spring.stiffness_N_per_m * (spring.along @ along) ** 2 for spring in moved.springs))


def mean_stroke_m(moved: Scene) -> float:
    """Return the mean amplitude of the panels' ends against each other, each along its panel."""
    return fmean(panel.stroke_m for panel in moved.panels)
