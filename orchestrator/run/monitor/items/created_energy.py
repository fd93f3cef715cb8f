"""Energy that the coupling created or destroyed in the last intervals."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.run.monitor.item import MonitorItem, Observation


class CreatedEnergy(MonitorItem):
    """The share created of what went through each interface in some twenty intervals."""

    name = "created_energy"
    limit_key = "largest_created_share"
    message = (
        "the coupling creates or destroys energy between {where}: {value:.2g} of what went through "
        "in the last intervals"
    )

    def observe(self) -> Iterator[Observation]:
        for where, work in self.subject.work.works.items():
            yield Observation(work.balance.recently(), where)
