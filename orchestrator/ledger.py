"""The books of a run: momentum and energy of every member and through every interface.

Energy: for each member  d(stored) + lost - supplied = received + defect.  What two members
received from each other adds up to zero in nature; in a staggered run the remainder is what the
coupling created.  Both the defects and the created energy are the run's own figures of quality.

Momentum: for each member  d(momentum) = outside impulse + impulse through its ports, and what
one member gave the other received (or it is in transit, one interval late).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from orchestrator.coupling import Pending
from orchestrator.metered import MeteredFrames, MeteredPanel, MeteredParticles
from orchestrator.ports import Account, Array


@dataclass(frozen=True)
class Members:
    """The metered members; ``particles`` is None where the case has none."""

    frames: MeteredFrames
    panel: MeteredPanel
    particles: MeteredParticles | None


class Ledger:
    """Opened at t = 0 (after every member's ``initial``), read at any sync point.

    ``account``s are collective under MPI, so are ``energy_J`` and ``momentum_residual``.
    """

    def __init__(self, members: Members, pending: Pending) -> None:
        """``pending``: what the scheme holds back at t = 0."""
        self._members = members
        self._opening = self._accounts()
        self._opening_pending = pending

    def _accounts(self) -> dict[str, Account]:
        members = self._members
        accounts = {"frames": members.frames.account(), "panel": members.panel.account()}
        if members.particles is not None:
            accounts["particles"] = members.particles.account()
        return accounts

    def energy_J(self) -> dict[str, float]:
        """Every term by name: ``stored.<member>.<kind>`` as change since t = 0, ``lost.…``,
        ``supplied.…``, ``created.<interface>``, ``defect.<member>``."""
        terms: dict[str, float] = {}
        now = self._accounts()
        received: dict[str, dict[str, float]] = {}
        for member, account in now.items():
            opening = self._opening[member]
            stored = _change(account.stored_J, opening.stored_J)
            lost = _change(account.lost_J, opening.lost_J)
            supplied = _change(account.supplied_J, opening.supplied_J)
            received[member] = _change(account.received_J, opening.received_J)
            for book, entries in (("stored", stored), ("lost", lost), ("supplied", supplied)):
                terms |= {f"{book}.{member}.{kind}": value for kind, value in entries.items()}
            terms[f"defect.{member}"] = (
                sum(stored.values())
                + sum(lost.values())
                - sum(supplied.values())
                - sum(received[member].values())
            )
        terms["created.panel-frames"] = received["panel"]["clamps"] + received["frames"]["reaction"]
        if "particles" in now:
            terms["created.particles-panel"] = (
                received["particles"]["surface"] + received["panel"]["load"]
            )
        return terms

    def momentum_residual(self, pending: Pending) -> dict[str, float]:
        """Relative residual by member and interface: |defect| over the sum of the sizes of the
        terms that should balance.  ``pending`` is what the scheme still holds back."""
        members, now = self._members, self._accounts()
        frames, panel, particles = members.frames, members.panel, members.particles
        through: dict[str, list[Array]] = {
            "frames": [frames.received_N_s],
            "panel": [panel.received_N_s, -panel.given_N_s],
        }
        held = pending.reaction_N_s - self._opening_pending.reaction_N_s
        crossing = {"panel-frames": [panel.given_N_s, -frames.received_N_s, -held]}
        if particles is not None:
            through["particles"] = [-particles.given_N_s]
            held = pending.load_N_s - self._opening_pending.load_N_s
            crossing["particles-panel"] = [particles.given_N_s, -panel.received_N_s, -held]
        residual = {interface: _relative(terms) for interface, terms in crossing.items()}
        for member, impulses in through.items():
            opening = self._opening[member]
            outside = now[member].outside_impulse_N_s - opening.outside_impulse_N_s
            change = now[member].momentum_kg_m_s - opening.momentum_kg_m_s
            residual[member] = _relative([change, -outside, *(-i for i in impulses)])
        return residual

    def figures(self, pending: Pending) -> dict[str, Any]:
        """For ``summary.json``."""
        residuals = self.momentum_residual(pending)
        return {
            "momentum_residual_relative": max(residuals.values()),
            "momentum_residuals": residuals,
            "energy_ledger_J": self.energy_J(),
        }


def _change(now: Mapping[str, float], opening: Mapping[str, float]) -> dict[str, float]:
    return {kind: value - opening.get(kind, 0.0) for kind, value in now.items()}


def _relative(terms: list[Array]) -> float:
    """Size of the sum over the sum of the sizes."""
    size = sum(float(np.linalg.norm(term)) for term in terms)
    return float(np.linalg.norm(np.sum(terms, axis=0))) / size if size > 0 else 0.0
