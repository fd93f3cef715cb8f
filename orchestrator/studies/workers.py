"""Work side by side, with Dask: on this machine, or wherever a Dask scheduler has workers.

Each piece of work starts a process of its own, so that workers are threads.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

PER_RUN_MIB = 1000  # of memory: a run with sheets and tens of thousands of particles takes less


@dataclass(frozen=True)
class Crew:
    """``workers`` at a time on this machine, or those of the ``scheduler`` at an address, which
    must see the same files under the same names."""

    workers: int
    scheduler: str = ""

    def each(self, work: Sequence[Callable[[], str]]) -> Iterator[str]:
        """What each piece of work says, in the order in which they end.  Interrupted, pieces that
        have not begun are dropped."""
        if not work:
            return
        if self.workers == 1 and not self.scheduler:
            yield from (piece() for piece in work)
            return
        from distributed import as_completed

        with self._client() as client:
            futures = [client.submit(piece, pure=False) for piece in work]
            try:
                for future in as_completed(futures):
                    yield future.result()
            except KeyboardInterrupt:  # which the runs have got, too, and end at a sync point
                client.cancel(futures)
                raise

    @contextmanager
    def _client(self) -> Iterator[Any]:
        from distributed import Client, LocalCluster

        logging.getLogger("distributed").setLevel(logging.ERROR)  # it does not talk to users
        if self.scheduler:
            with Client(self.scheduler) as client:
                yield client
            return
        with (
            LocalCluster(
                n_workers=1,
                threads_per_worker=self.workers,
                processes=False,
                memory_limit=None,
                dashboard_address=None,
                scheduler_kwargs={"dashboard_address": "127.0.0.1:0"},  # any port, not to others
            ) as cluster,
            Client(cluster) as client,
        ):
            yield client


def fitting() -> int:
    """How many runs at a time this machine bears: a processor and a gigabyte of memory for each."""
    processors = len(os.sched_getaffinity(0))
    free_MiB = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**20
    return max(1, min(processors, int(free_MiB / PER_RUN_MIB)))
