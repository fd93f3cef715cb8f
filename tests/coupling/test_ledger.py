"""The books of a run: what is in transit when they are opened and when they are read."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import cast

import numpy as np
import pytest

from orchestrator.coupling.ledger import Ledger
from orchestrator.coupling.metered import Meter, MeteredFrames, MeteredPanel, MeteredParticles, MeteredSolvers
from orchestrator.coupling.schemes.scheme import Pending
from orchestrator.ports import Account, Array


def along_x(size: float) -> Array:
    return np.array([size, 0.0, 0.0])


@dataclass
class Member:
    """Part of a metered member that the ledger reads."""

    momentum: float = 0.0
    outside: float = 0.0
    stored_J: float = 0.0
    lost_J: float = 0.0
    supplied_J: float = 0.0
    work_J: dict[str, float] = field(default_factory=dict)
    received: Meter = field(default_factory=Meter)
    given: Meter = field(default_factory=Meter)
    through_N_s: float = 0.0
    moved_N_s: float = 0.0
    seizes: bool = False
    blow_J: float = 0.0

    def account(self) -> Account:
        return Account(
            along_x(self.momentum),
            along_x(self.outside),
            {"kept": self.stored_J},
            {"lost": self.lost_J},
            {"fed": self.supplied_J},
            dict(self.work_J),
            moved_N_s=self.moved_N_s,
        )


def metered(impulse_N_s: float) -> Meter:
    """An impulse along x through the world's origin that was handed over."""
    return Meter(np.array([impulse_N_s, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0]))


def members() -> tuple[Member, Member, Member]:
    """Frames, panel and particles, with something in every book."""
    frames = Member(1.0, 2.0, 3.0, 4.0, 5.0, {"reaction": 6.0})
    panel = Member(7.0, 8.0, 9.0, 10.0, 11.0, {"load": 12.0, "clamps": 13.0})
    return frames, panel, Member(14.0, 15.0, 16.0, 17.0, 18.0, {"surface": 19.0})


def opened(frames: Member, panel: Member, particles: Member, pending: Pending) -> Ledger:
    solvers = MeteredSolvers(
        cast(MeteredFrames, frames), cast(MeteredPanel, panel), cast(MeteredParticles, particles)
    )
    return Ledger(solvers, pending)


def pending(load: float, reaction: float) -> Pending:
    """Impulses along x through the world's origin, so that they have no moment about it."""
    return Pending(along_x(load), along_x(reaction), along_x(0.0), along_x(0.0))


def test_what_was_in_transit_at_the_start_counts() -> None:
    """A scheme that hands over late holds back the panels' weight at t = 0.  The particles give
    30, of which 4 are in transit now and 1 was at the start: the panel received 27.  It gives 50,
    of which 9 and 2 are: the frames received 43."""
    frames, panel, particles = members()
    ledger = opened(frames, panel, particles, pending(1.0, 2.0))
    particles.given, particles.momentum = metered(30.0), particles.momentum - 30.0
    panel.received, panel.given = metered(27.0), metered(50.0)
    panel.momentum += 27.0 - 50.0
    frames.received, frames.momentum = metered(43.0), frames.momentum + 43.0
    residuals = ledger.momentum_residual(pending(4.0, 9.0))
    assert residuals == dict.fromkeys(residuals, 0.0)
    assert set(residuals) == {"frames", "panel", "particles", "panel-frames", "particles-panel"}
    off = ledger.momentum_residual(pending(4.0, 8.0))
    assert off["panel-frames"] == pytest.approx(1.0 / (50.0 + 43.0 + 6.0))
    assert off["particles-panel"] == 0.0
    off = ledger.momentum_residual(pending(3.0, 9.0))
    assert off["particles-panel"] == pytest.approx(1.0 / (30.0 + 27.0 + 2.0))


def test_the_impulse_from_outside_belongs_to_its_member() -> None:
    """The panel had 7 and has 12, of which 4 came from outside."""
    frames, panel, particles = members()
    ledger = opened(frames, panel, particles, pending(0.0, 0.0))
    panel.momentum, panel.outside = panel.momentum + 5.0, panel.outside + 4.0
    residuals = ledger.momentum_residual(pending(0.0, 0.0))
    assert residuals["panel"] == pytest.approx(1.0 / (7.0 + 12.0 + 4.0))
    assert residuals["frames"] == residuals["particles"] == 0.0


def test_momenta_that_cancel_each_other_are_sizes_of_the_balance() -> None:
    """The sums of two balls that met head-on, with 3 N s each, hold only rounding."""
    frames, panel, particles = members()
    particles.momentum = particles.outside = 0.0
    particles.moved_N_s = 2.0
    ledger = opened(frames, panel, particles, pending(0.0, 0.0))
    for moved_N_s in (4.0, 0.0):  # or they stick to each other and stand
        particles.momentum, particles.moved_N_s = 6e-16, moved_N_s
        residual = ledger.momentum_residual(pending(0.0, 0.0))["particles"]
        assert residual == pytest.approx(6e-16 / (2.0 + moved_N_s), rel=1e-6)


def test_energy_is_counted_from_the_opening_on() -> None:
    """Each term by hand: what is defect of a member, and what the coupling created."""
    frames, panel, particles = members()
    ledger = opened(frames, panel, particles, pending(0.0, 0.0))
    assert not any(ledger.energy_J().values())
    panel.stored_J, panel.lost_J, panel.supplied_J = 9.0 + 3.0, 10.0 + 2.0, 11.0 + 1.0
    panel.work_J = {"load": 12.0 + 0.5, "clamps": 13.0 - 0.25}
    particles.work_J = {"surface": 19.0 - 0.375}
    frames.work_J = {"reaction": 6.0 + 0.3125}
    terms = ledger.energy_J()
    assert terms["stored.panel.kept"] == 3.0
    assert terms["lost.panel.lost"] == 2.0
    assert terms["supplied.panel.fed"] == 1.0
    assert terms["defect.panel"] == 3.0 + 2.0 - 1.0 - 0.25
    assert terms["defect.frames"] == -0.3125
    assert terms["defect.particles"] == 0.375
    assert terms["created.particles-panel"] == 0.5 - 0.375
    assert terms["created.panel-frames"] == -0.25 + 0.3125
