"""Workers that make the points of a study, with Dask: on this machine, or wherever a Dask scheduler
has workers.

Each piece of work starts a process of its own, so that workers are threads.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any

PER_RUN_MIB = 1000  # of memory: a run with sheets and tens of thousands of particles takes less


@dataclass(frozen=True)
class Crew:
    """``workers`` at a time on this machine, or those of the ``scheduler`` at an address, which
    must see the same files under the same names."""

    workers: int = 1
    scheduler: str = ""

    def each(self, work: Iterable[Callable[[], str]]) -> Iterator[str]:
        """Yields what each piece of work returns, in the order in which they end.  A piece is taken
        from ``work`` only when a worker is free, so that it may depend on what ended before.
        Interrupted, no more pieces are begun."""
        waiting = iter(work)
        if self.workers == 1 and not self.scheduler:
            yield from (piece() for piece in waiting)
            return
        first = next(waiting, None)
        if first is None:
            return
        from distributed import as_completed

        with self._client() as client:
            running = as_completed([client.submit(first, pure=False)])
            self._fill(client, running, waiting)
            for future in running:
                yield future.result()
                self._fill(client, running, waiting)

    def _fill(self, client: Any, running: Any, waiting: Iterator[Callable[[], str]]) -> None:
        """Gives every free worker a piece, as far as there are any."""
        free = max(1, sum(client.nthreads().values())) - running.count()
        for _, piece in zip(range(free), waiting, strict=False):
            running.add(client.submit(piece, pure=False))

    def _client(self) -> Any:
        from distributed import Client

        logging.getLogger("distributed").setLevel(logging.ERROR)  # it does not talk to users
        if self.scheduler:
            return Client(self.scheduler)
        return Client(
            n_workers=1,
            threads_per_worker=self.workers,
            processes=False,
            memory_limit=None,
            dashboard_address=None,
            scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},  # any port, not to others
        )


def workers_that_fit() -> int:
    """Returns how many runs at a time this machine bears: a processor and a gigabyte of memory for
    each."""
    processors = len(os.sched_getaffinity(0))
    free_MiB = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**20
    return max(1, min(processors, int(free_MiB / PER_RUN_MIB)))
