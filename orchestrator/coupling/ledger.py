"""The books of a run: momentum and energy of every member and through every interface.

Energy: for each member  d(stored) + lost - supplied = received + defect.  What two members
received from each other adds up to zero in nature; in a staggered run the remainder is what the
coupling created.  Both the defects and the created energy are the run's own figures of quality.

Momentum: for each member  d(momentum) = outside impulse + impulse through its ports, and what
one member gave the other received (or it is in transit, one interval late).
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from orchestrator.coupling.metered import MeteredSolvers
from orchestrator.coupling.schemes.scheme import Pending
from orchestrator.ports import Account, Array

ROUNDED = 1e-6
"""Of the impulse through all points, in sizes: beside it, rounding of their sum (1e-16 of it) is
1e-10 at most."""

LOSING = {"particles-panel": ("particles",), "panel-frames": ("panel", "frames")}
"""MeteredSolvers whose losses are a scale for what is created at an interface: particles lose what the
panels gave them, panels and frames what drives the machine."""


def created_shares(terms_J: Mapping[str, float], exchanged_J: Mapping[str, float]) -> dict[str, float]:
    """Energy created at each interface of ``exchanged_J``, over all that was exchanged there and
    lost by those that exchanged it, since t = 0.

    ``terms_J``: as ``Ledger.energy_J`` has them; ``exchanged_J``: as ``watching.Exchange``.
    Negative where energy was destroyed; 0 where nothing happened.
    """
    shares = {}
    for interface, exchanged in exchanged_J.items():
        lost = tuple(f"lost.{member}." for member in LOSING[interface])
        scale_J = exchanged + sum(abs(v) for name, v in terms_J.items() if name.startswith(lost))
        created_J = terms_J.get(f"created.{interface}", 0.0)
        shares[interface] = created_J / scale_J if scale_J > 0 else 0.0
    return shares


def share_created(summary: Mapping[str, Any]) -> float:
    """Of a run's ``summary.json``: that of the interface where most was created.  Runs of older
    versions do not say what was exchanged; theirs is told by what was lost alone."""
    nothing = dict.fromkeys(LOSING, 0.0)
    exchanged_J = summary.get("energy_exchanged_J", nothing)
    shares = created_shares(summary["energy_ledger_J"], exchanged_J)
    return max(shares.values(), key=abs, default=0.0)


def defect_shares(summary: Mapping[str, Any]) -> dict[str, float]:
    """Of a run's ``summary.json``: energy that each member's own time steps made (negative:
    destroyed), over what went through its interfaces, was lost by it, supplied to it, or is stored
    otherwise than at t = 0: particles that fall turn their height into speed, and nobody else
    knows."""
    terms_J, exchanged_J = summary["energy_ledger_J"], summary.get("energy_exchanged_J", {})
    shares = {}
    for member in ("frames", "panel", "particles"):
        scale_J = sum(value for name, value in exchanged_J.items() if member in name.split("-"))
        own = tuple(f"{book}.{member}." for book in ("lost", "supplied", "stored"))
        scale_J += sum(abs(v) for name, v in terms_J.items() if name.startswith(own))
        made_J = terms_J.get(f"defect.{member}", 0.0)
        shares[member] = made_J / scale_J if scale_J > 0 else 0.0
    return shares


class Ledger:
    """Opened at t = 0 (after every member's ``initial``), read at any sync point.

    ``account``s are collective under MPI, so are ``energy_J`` and ``momentum_residual``.
    """

    def __init__(self, members: MeteredSolvers, pending: Pending) -> None:
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
            terms["created.particles-panel"] = received["particles"]["surface"] + received["panel"]["load"]
        return terms

    def momentum_residual(self, pending: Pending) -> dict[str, float]:
        """Relative residual by member and interface: |defect| over the sum of the sizes of the
        terms that should balance.  ``pending`` is what the scheme still holds back.

        The two clamps of a taut panel pull against each other; where nothing else happens, the
        terms are what rounding leaves of that.  A millionth of the impulse that went through the
        points (the sum of its sizes) is therefore added to the sizes.
        """
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
        through_N_s = {
            "frames": frames.through_N_s,
            "panel": panel.through_N_s,
            "particles": 0.0 if particles is None else particles.through_N_s,
        }
        residual = {
            interface: _relative(terms, ROUNDED * through_N_s["panel"])
            for interface, terms in crossing.items()
        }
        for member, impulses in through.items():
            opening = self._opening[member]
            outside = now[member].outside_impulse_N_s - opening.outside_impulse_N_s
            had, has = opening.momentum_kg_m_per_s, now[member].momentum_kg_m_per_s
            size_N_s = ROUNDED * through_N_s[member]
            terms = [has, -had, -outside, *(-i for i in impulses)]
            residual[member] = _relative(terms, size_N_s)
        return residual

    def angular_momentum_residual(self, pending: Pending) -> dict[str, float]:
        """The same about the world's origin: of members that tell their angular momentum, to
        rounding; of interfaces what mean loads on mean places leave (docs/theory/coupling.md)."""
        members, now = self._members, self._accounts()
        frames, panel, particles = members.frames, members.panel, members.particles
        held = pending.reaction_N_m_s - self._opening_pending.reaction_N_m_s
        residual = {"panel-frames": _relative([panel.given_N_m_s, -frames.received_N_m_s, -held])}
        for member, account in now.items():
            opening = self._opening[member].angular
            if account.angular is None or opening is None:
                continue
            angular = account.angular
            outside = angular.outside_impulse_N_m_s - opening.outside_impulse_N_m_s
            received = {
                port: value - opening.received_N_m_s[port] for port, value in angular.received_N_m_s.items()
            }
            had, has = opening.momentum_kg_m2_per_s, angular.momentum_kg_m2_per_s
            terms = [has, -had, -outside, *(-one for one in received.values())]
            residual[member] = _relative(terms)
            if member == "particles" and particles is not None:
                held = pending.load_N_m_s - self._opening_pending.load_N_m_s
                terms = [-received["surface"], -panel.received_N_m_s, -held]
                residual["particles-panel"] = _relative(terms)
        return residual

    def figures(self, pending: Pending) -> dict[str, Any]:
        """For ``summary.json``."""
        residuals = self.momentum_residual(pending)
        return {
            "momentum_residual_relative": max(residuals.values()),
            "momentum_residuals": residuals,
            "angular_momentum_residuals": self.angular_momentum_residual(pending),
            "energy_ledger_J": self.energy_J(),
        }


def _change(now: Mapping[str, float], opening: Mapping[str, float]) -> dict[str, float]:
    return {kind: value - opening.get(kind, 0.0) for kind, value in now.items()}


def _relative(terms: list[Array], least_size: float = 0.0) -> float:
    """Size of the sum over the sum of the sizes, ``least_size`` among them."""
    size = least_size + sum(float(np.linalg.norm(term)) for term in terms)
    return float(np.linalg.norm(np.sum(terms, axis=0))) / size if size > 0 else 0.0
