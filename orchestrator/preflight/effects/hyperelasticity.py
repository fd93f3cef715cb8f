"""Mooney-Rivlin's stress of the panels at large strain.

It is compared with the stress of the linear law when the panel is most taut.
"""

from __future__ import annotations

from orchestrator.preflight.scene.effect import Effect, Verdict, compare
from orchestrator.preflight.scene.moved_panel import mooney_ratio
from orchestrator.preflight.scene.scene import Scene, elastic_solvers


def judge(scene: Scene) -> Verdict:
    """Judge Mooney-Rivlin's stress over the linear one in the panel that is stretched most."""
    panel = max(scene.panels, key=lambda panel: panel.strain)
    return compare(
        "Mooney-Rivlin / linear stress - 1",
        abs(mooney_ratio(panel.material, panel.strain) - 1),
        f"the tautest panel is stretched by {panel.strain:.2%}",
        threshold="0.1 (a tenth of the force)",
        cost=elastic_solvers(),
    )


EFFECT = Effect(part="panels", judge=judge, needs=("panel-deformation",), checked_by="frames_throw")
