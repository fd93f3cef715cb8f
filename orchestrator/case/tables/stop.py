"""``[screen.panels.<name>.stops.<name>]`` and ``[screen.decks.<name>.stops.<name>]``."""

from __future__ import annotations

from orchestrator.case.tables.quantities import NotNegative, Positive, Share, Table


class Stop(Table):
    """The flat top of a beam below a panel, which the panel may come to lie on: the cross beam's
    own flange beside its clamp, or a bar in between (docs/theory/panel_stops.md)."""

    frame: str | None = None
    """The frame that carries it, or "ground"; without, the one that holds the nearer clamp."""
    from_m: NotNegative
    """Where it begins, along the free length from the first clamp's inner edge."""
    to_m: Positive
    """Where it ends."""
    gap_m: Positive
    """How far it lies below the panel as it is mounted straight between its clamps."""
    stiffness_Pa_per_m: Positive | None = None
    """Pressure on its layer of rubber over the depth pressed in; without, a tenth of the panel's
    mass per area over the sync interval squared, ten times less than the most allowed."""
    damping_ratio: Share = 0.2
    """Damping of the panel's mass on the layer over the critical one."""
