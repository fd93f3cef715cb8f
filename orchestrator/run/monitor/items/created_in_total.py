"""Energy that the coupling created or destroyed since the start, by the ledger."""

from __future__ import annotations

from collections.abc import Iterator

from orchestrator.coupling.ledger import created_shares
from orchestrator.run.monitor.item import MonitorItem, Observation, OutputTime


class CreatedInTotal(MonitorItem):
    """The share created of what went through each interface since t = 0 or was lost there."""

    name = "created_in_total"
    limit_key = "largest_created_in_total"
    message = (
        "the coupling has created or destroyed energy ({where}): {value:.2g} of all that went "
        "through or was lost there"
    )

    def observe_output(self, output: OutputTime) -> Iterator[Observation]:
        shares = created_shares(output.terms_J, self.subject.work.exchanged_J())
        for interface, share in shares.items():
            yield Observation(abs(share), interface)
