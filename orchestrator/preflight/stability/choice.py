"""``coupling.scheme = "auto"``: the scheme that a case's stability card calls for."""

from __future__ import annotations

import math
from dataclasses import replace

from orchestrator.case.file.contents import has_particles
from orchestrator.case.tables.case import Case
from orchestrator.preflight.stability.bound import Card
from orchestrator.preflight.stability.card import card

PLAIN, STRONGER, AUTO = "particles-first", "robin", "auto"


def settled_card(case: Case) -> Card:
    """The card of a case without problems.  Where that leaves its scheme to the program: the plain
    one's where the sync interval is within what it is sure to be stable at, or where nothing is
    stronger there; else ``robin``'s."""
    if case.coupling.scheme != AUTO:
        return card(case)
    plain = card(with_scheme(case, PLAIN))
    if plain.interval_s <= plain.safe_s:
        why = f"the sync interval is within its safe one, {_limit(plain)}"
        return replace(plain, why=why)
    beyond = f"the sync interval of {plain.interval_s:.3g} s is above {PLAIN}'s {_limit(plain)}"
    if not has_particles(case):
        return replace(plain, why=f"{beyond}, and without particles {STRONGER} is no other")
    stronger = card(with_scheme(case, STRONGER))
    if stronger.safe_s > plain.safe_s:
        return replace(stronger, why=f"{beyond}; {STRONGER}'s is {_limit(stronger)}")
    return replace(plain, why=f"{beyond}, and {STRONGER}'s is no longer: {_limit(stronger)}")


def settled(case: Case) -> Case:
    """The case with a scheme of its own, or with the one that is taken for it."""
    return with_scheme(case, settled_card(case).scheme) if case.coupling.scheme == AUTO else case


def with_scheme(case: Case, name: str) -> Case:
    coupling = case.coupling.model_copy(update={"scheme": name})
    return case.model_copy(update={"coupling": coupling})


def _limit(found: Card) -> str:
    if found.stable is None or math.isinf(found.safe_s):
        return "unlimited"
    return f"{found.safe_s:.2g} s ({found.stable.name})"
