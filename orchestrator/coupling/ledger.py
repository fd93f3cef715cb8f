"""The books of a run: momentum and energy of every member and through every interface.

Energy: for each member  d(stored) + lost - supplied = received + defect.  In nature, the energies that two
members receive from each other add up to zero; in a staggered run the remainder is the energy that the
coupling created.  The defects and the created energy measure the run's quality.

Momentum: for each member  d(momentum) = outside impulse + impulse through its ports.  The impulse that a
member gives reaches the other member at once, or is in transit for one interval.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from orchestrator.coupling.metered import MeteredSolvers
from orchestrator.coupling.schemes.scheme import Pending
from orchestrator.ports import Account, Array

ROUNDED = 1e-6
"""The share of the summed impulses through all points that is added to a residual's scale: rounding of their
sum, a share of 1e-16, then appears as 1e-10 at most."""

LOSING = {"particles-panel": ("particles",), "panel-frames": ("panel", "frames")}
"""The members whose losses count in the scale for the energy created at an interface: particles lose energy
from the panels, and panels and frames lose energy from the machine's drive."""


def created_shares(terms_J: Mapping[str, float], exchanged_J: Mapping[str, float]) -> dict[str, float]:
    """Return the energy created at each interface of ``exchanged_J``, as a share.

    The share is relative to the energy that was exchanged there, and lost by the members that exchanged it,
    since t = 0.  ``terms_J``: as ``Ledger.energy_J`` returns them; ``exchanged_J``: as the monitor's
    ``ExchangedEnergy`` has it.  A share is negative where energy was destroyed, and 0 where nothing happened.
    """
    shares = {}
    for interface, exchanged in exchanged_J.items():
        scale_J = exchanged + _size_J(terms_J, *(f"lost.{member}." for member in LOSING[interface]))
        created_J = terms_J.get(f"created.{interface}", 0.0)
        shares[interface] = created_J / scale_J if scale_J > 0 else 0.0
    return shares


def share_created(summary: Mapping[str, Any]) -> float:
    """Return the share of a run's ``summary.json`` at the interface where most energy was created."""
    shares = created_shares(summary["energy_ledger_J"], summary.get("energy_exchanged_J", {}))
    return max(shares.values(), key=abs, default=0.0)


def defect_shares(summary: Mapping[str, Any]) -> dict[str, float]:
    """Return by member the share of energy that its own time steps made in a run of this ``summary.json``.

    A share is negative where energy was destroyed.  It is relative to the energy that went through the
    member's interfaces, was lost by it, supplied to it, or is stored otherwise than at t = 0: falling
    particles turn their height into speed, which appears in no other member's account.
    """
    terms_J, exchanged_J = summary["energy_ledger_J"], summary.get("energy_exchanged_J", {})
    shares = {}
    for member in ("frames", "panel", "particles"):
        scale_J = sum(value for name, value in exchanged_J.items() if member in name.split("-"))
        scale_J += _size_J(terms_J, *(f"{book}.{member}." for book in ("lost", "supplied", "stored")))
        made_J = terms_J.get(f"defect.{member}", 0.0)
        shares[member] = made_J / scale_J if scale_J > 0 else 0.0
    return shares


def _size_J(terms_J: Mapping[str, float], *beginnings: str) -> float:
    """Return the sum of the sizes of all terms whose names have the given beginning."""
    return sum(abs(value) for name, value in terms_J.items() if name.startswith(beginnings))


class Ledger:
    """The books, opened at t = 0 (after every member's ``initial``) and read at any sync point.

    Every ``account`` is collective under MPI, and so are ``energy_J`` and ``momentum_residual``.
    """

    def __init__(self, members: MeteredSolvers, pending: Pending) -> None:
        """Open the books; ``pending`` is the impulse that the scheme holds back at t = 0."""
        self._members, self._opening_pending = members, pending
        self._opening = self._accounts()

    def _accounts(self) -> dict[str, Account]:
        return {name: member.account() for name, member in self._members.by_name().items()}

    def energy_J(self) -> dict[str, float]:
        """Return every term by name: ``stored.<member>.<kind>`` as change since t = 0, ``lost.…``,
        ``supplied.…``, ``created.<interface>``, ``defect.<member>``."""
        terms: dict[str, float] = {}
        received: dict[str, dict[str, float]] = {}
        now = self._accounts()
        for member, account in now.items():
            opening = self._opening[member]
            received[member] = _change(account.received_J, opening.received_J)
            books = {
                "stored": _change(account.stored_J, opening.stored_J),
                "lost": _change(account.lost_J, opening.lost_J),
                "supplied": _change(account.supplied_J, opening.supplied_J),
            }
            for book, entries in books.items():
                terms |= {f"{book}.{member}.{kind}": value for kind, value in entries.items()}
            stored_J, lost_J, supplied_J = (sum(entries.values()) for entries in books.values())
            terms[f"defect.{member}"] = stored_J + lost_J - supplied_J - sum(received[member].values())
        blow_J = self._members.frames.blow_J
        if self._members.frames.seizes:
            terms["lost.frames.blow"] = blow_J
        terms["created.panel-frames"] = received["panel"]["clamps"] + received["frames"]["reaction"] + blow_J
        if "particles" in now:
            terms["created.particles-panel"] = received["particles"]["surface"] + received["panel"]["load"]
        return terms

    def book_blow(self) -> None:
        """Book the blow of frames that seize the panels: what is missing at the interface after the interval
        in which the frames first felt it, and at most half of their work on the panels.  Collective."""
        frames = self._members.frames
        if frames.seizes:
            work_J = self._opening["frames"].received_J["reaction"] - frames.account().received_J["reaction"]
            missing_J = frames.blow_J - self.energy_J()["created.panel-frames"]
            frames.blow_J = min(max(0.0, missing_J), max(0.0, work_J / 2))

    def momentum_residual(self, pending: Pending) -> dict[str, float]:
        """Return the relative residual by member and interface.

        It is |defect| over the sum of the sizes of the terms that should balance.  ``pending`` is the impulse
        that the scheme still holds back.

        The two clamps of a taut panel pull against each other.  If nothing else happens, the terms are the
        rounding errors of this pull.  A millionth of the summed impulses through the points is therefore
        added to the sizes.  Momenta of particles may cancel each other, too, as of two that meet head-on:
        those of all single particles count as sizes.
        """
        frames, panel, particles = self._members.frames, self._members.panel, self._members.particles
        received_N_s, given_N_s = panel.received.impulse_N_s, panel.given.impulse_N_s
        onto_frames_N_s = frames.received.impulse_N_s
        ports = {"frames": [onto_frames_N_s], "panel": [received_N_s, -given_N_s]}
        in_transit = pending.reaction_N_s - self._opening_pending.reaction_N_s
        crossing = {"panel-frames": [given_N_s, -onto_frames_N_s, -in_transit]}
        if particles is not None:
            from_particles_N_s = particles.given.impulse_N_s
            ports["particles"] = [-from_particles_N_s]
            in_transit = pending.load_N_s - self._opening_pending.load_N_s
            crossing["particles-panel"] = [from_particles_N_s, -received_N_s, -in_transit]
        residual = {name: _relative(terms, ROUNDED * panel.through_N_s) for name, terms in crossing.items()}
        for name, member in self._members.by_name().items():
            now, opening = member.account(), self._opening[name]
            outside = now.outside_impulse_N_s - opening.outside_impulse_N_s
            terms = [now.momentum_kg_m_per_s, -opening.momentum_kg_m_per_s, -outside]
            terms += [-impulse for impulse in ports[name]]
            residual[name] = _relative(
                terms, ROUNDED * member.through_N_s + opening.moved_N_s + now.moved_N_s
            )
        return residual

    def angular_momentum_residual(self, pending: Pending) -> dict[str, float]:
        """Return the relative residual of angular momentum about the world's origin.

        Members that report their angular momentum balance to rounding.  Interfaces keep the error that mean
        loads on mean places leave (docs/theory/coupling.md).
        """
        frames, panel = self._members.frames, self._members.panel
        in_transit = pending.reaction_N_m_s - self._opening_pending.reaction_N_m_s
        residual = {
            "panel-frames": _relative([panel.given.moment_N_m_s, -frames.received.moment_N_m_s, -in_transit])
        }
        for member, account in self._accounts().items():
            angular, opening = account.angular, self._opening[member].angular
            if angular is None or opening is None:
                continue
            outside = angular.outside_impulse_N_m_s - opening.outside_impulse_N_m_s
            received = {
                port: value - opening.received_N_m_s[port] for port, value in angular.received_N_m_s.items()
            }
            had, has = opening.momentum_kg_m2_per_s, angular.momentum_kg_m2_per_s
            terms = [has, -had, -outside, *(-impulse for impulse in received.values())]
            residual[member] = _relative(terms)
            if member == "particles":
                in_transit = pending.load_N_m_s - self._opening_pending.load_N_m_s
                terms = [-received["surface"], -panel.received.moment_N_m_s, -in_transit]
                residual["particles-panel"] = _relative(terms)
        return residual

    def figures(self, pending: Pending) -> dict[str, Any]:
        """Return the entries of ``summary.json``."""
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
    """Return the size of the sum over the sum of the sizes, to which ``least_size`` is added."""
    size = least_size + sum(float(np.linalg.norm(term)) for term in terms)
    return float(np.linalg.norm(np.sum(terms, axis=0))) / size if size > 0 else 0.0
