"""Published facts: what several numbers of ours are held against, counted once."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from orchestrator.studies.verdicts import WORST_FIRST, CaseCriteria, CriterionResult, worst_first

DOI = re.compile(r"10\.\d{4,9}/\S*\w")


@dataclass(frozen=True)
class Fact:
    """A published fact with every predicted number that is held against it, worst first."""

    name: str
    results: tuple[CriterionResult, ...]

    @property
    def verdict(self) -> str:
        """The worst verdict of its numbers."""
        return self.results[0].verdict


def predicted_facts(results: Sequence[tuple[CaseCriteria, Sequence[CriterionResult]]]) -> list[Fact]:
    """Return the facts that our numbers predict, the worst first.

    Numbers without a band, and numbers that are fitted, published or assumed, judge no fact.
    """
    found: dict[tuple[str, str], list[CriterionResult]] = {}
    for paper, of_case in results:
        doi = DOI.search(paper.criteria.source)
        source = doi.group() if doi else paper.criteria.source
        for each in of_case:
            if each.row.ours == "predicted" and each.row.limits is not None:
                found.setdefault((source, each.row.fact or each.row.what), []).append(each)
    facts = [Fact(name, tuple(worst_first(of_fact))) for (_, name), of_fact in found.items()]
    return sorted(facts, key=lambda fact: WORST_FIRST.index(fact.verdict))
