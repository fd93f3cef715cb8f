"""Points of a study: runs of a case, each in a process and a folder of its own, never made twice.

A point is a case with ``--set`` overlays.  ``run_points`` makes the missing runs side by side.  However it is
ended, another call makes the rest.  A ``Crew`` of workers makes the runs with Dask: on this machine, or
wherever a Dask scheduler has workers.  Each piece of work starts a process of its own, so that the workers
are threads.
"""

from __future__ import annotations

import logging
import os
import signal
import time
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from itertools import islice
from pathlib import Path
from typing import TypeVar

from orchestrator.workbench import Case, CaseError, CaseProblem, FolderUnusable, Run, StudyFolder
from orchestrator.workbench.vocabulary import (
    NUMBER_ALONE,
    exact,
    parse_quantity,
    sample_s,
    split_quantity,
    unit_of,
)

MOST_VALUES = 1000
WAIT_S = 0.5  # between two looks at a run of a study that was killed
PER_RUN_MIB = 1000  # memory of a run: a run with sheets and tens of thousands of particles takes less
# Dask's workers look around many times a second (4 % of a processor); those that wait for runs need not.
QUIET = {
    "distributed.worker.profile.enabled": False,
    "distributed.admin.tick.interval": "10s",
    "distributed.admin.tick.limit": "1h",
    "distributed.admin.system-monitor.interval": "10s",
    "distributed.admin.system-monitor.gil.enabled": False,
    "distributed.scheduler.work-stealing": False,
    "distributed.scheduler.active-memory-manager.start": False,
}
T = TypeVar("T")


@dataclass(frozen=True)
class Crew:
    """A crew of workers.

    ``workers`` is the number of runs at a time on this machine.  ``scheduler`` is the address of a Dask
    scheduler, if its workers make the runs; they must see the same files under the same names.
    """

    workers: int = 1
    scheduler: str = ""

    def size(self) -> int:
        """Return the number of workers, here or those that the scheduler has now."""
        if not self.scheduler:
            return self.workers
        from distributed import Client

        with Client(self.scheduler) as client:
            return max(1, sum(map(int, client.nthreads().values())))

    def each(self, work: Iterable[Callable[[], T]]) -> Iterator[T]:
        """Yield the result of each piece of work, in the order in which they end.

        A piece is begun when a worker is free.  After an interruption, no more pieces are begun.
        """
        if self.workers == 1 and not self.scheduler:
            yield from (piece() for piece in work)
            return
        import dask
        from distributed import Client, as_completed

        logging.getLogger("distributed").setLevel(logging.ERROR)  # its messages are not for users
        here = {
            "n_workers": 1,
            "threads_per_worker": self.workers,
            "processes": False,
            "memory_limit": None,
            "dashboard_address": None,
            # any free port, reachable from this machine only
            "scheduler_kwargs": {"dashboard_address": "127.0.0.1:0"},
        }
        with dask.config.set(QUIET), Client(self.scheduler) if self.scheduler else Client(**here) as client:
            waiting, running = iter(work), as_completed()

            def fill() -> None:
                free = max(1, sum(client.nthreads().values())) - running.count()
                for piece in islice(waiting, free):
                    running.add(client.submit(piece, pure=False))

            fill()
            for future in running:
                yield future.result()
                fill()


def workers_that_fit() -> int:
    """Return the number of simultaneous runs that this machine bears.

    Each run needs a processor and a gigabyte of memory.
    """
    processors = len(os.sched_getaffinity(0))
    free_MiB = os.sysconf("SC_AVPHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") / 2**20
    return max(1, min(processors, int(free_MiB / PER_RUN_MIB)))


@dataclass(frozen=True)
class Point:
    """One run of a study.

    ``value`` is its name, ``loaded`` its case and ``folder`` its folder.  The command ``words`` makes the
    run, and a second command ``then``, if there is one, continues in the same folder.  ``ended`` says whether
    nothing of the run is left to be made.  A finished run may differ from the case in the keys ``free``.
    The command ``job`` makes the run unless it is done.
    """

    value: str
    loaded: Case
    words: tuple[str, ...]
    folder: Path
    then: tuple[str, ...] = ()
    ended: Callable[[Run], bool] = Run.came_to_its_end
    free: tuple[str, ...] = ()
    job: tuple[str, ...] = ()

    def done(self) -> bool:
        """Return whether the point has been run to its end.

        Raises FolderUnusable if the folder holds a finished run of another case.
        """
        if not self.ended(self.run):
            return False
        changes = [key for key in self.loaded.changes_in(self.folder) if key not in self.free]
        if differing := ", ".join(changes[:3]):
            raise FolderUnusable(
                f"{self.folder}: holds a run of another case (it differs in {differing}); "
                "give another folder with --out"
            )
        return True

    @property
    def run(self) -> Run:
        """Its run, as it is now."""
        return Run(self.folder)

    def status(self) -> str:
        """Return the state of the run, as in its summary; "missing" without one."""
        return self.run.status

    def side_by_side(self) -> int:
        """Return the number of runs that were made at a time when this run was made; 0 if it is unknown."""
        try:
            return int(StudyFolder(self.folder.parent).read_json(_about(self.folder))["side_by_side"])
        except (OSError, ValueError, KeyError, TypeError):
            return 0


@dataclass(frozen=True)
class CaseStudy:
    """A user's study of one case, which makes the points of the study.

    ``sets`` are ``--set`` overlays of all points; ``out`` is the study's folder, by default
    runs/<case>-<name>.
    """

    case: Path
    level: str | None = None
    sets: tuple[str, ...] = ()
    out: Path | None = None
    crew: Crew = field(default_factory=Crew)
    name: str = ""

    @property
    def folder(self) -> Path:
        """The folder in which the runs of the study and its tables are kept."""
        return self.out or Path("runs") / f"{self.case.resolve().name}-{self.name}"

    def check(self, sets: Sequence[str] = ()) -> Case:
        """Return the case with more overlays.  Raises CaseError with all its problems."""
        return Case.load(self.case, self.level, [*self.sets, *sets])

    def point(self, value: str, sets: Sequence[str] = (), folder: str = "") -> Point:
        """Return the run of the case with more overlays.

        ``folder`` is the run's folder in the study's folder; by default it has the name ``value``.  Raises
        CaseError for a case with problems.
        """
        loaded, place = self.check(sets), self.folder / (folder or value)
        every = (*self.sets, *sets)
        level = ("--level", loaded.level) if loaded.level else ()
        options = [word for each in every for word in ("--set", each)]
        at = ("--out", str(self.folder.resolve()), "--folder", place.name)
        job = ("flipflow", "study", "job", str(self.case.resolve()), *level, *options, *at)
        return Point(value, loaded, Run(place).command(self.case, loaded.level, every), place, job=job)

    def run(self, points: Sequence[Point]) -> Iterator[str]:
        """Run the points that are not done, and yield a line when a run has ended.

        Raises FolderUnusable.
        """
        with StudyFolder(self.folder).lock():
            yield from run_points(points, self.crew)


def run_points(points: Sequence[Point], crew: Crew) -> Iterator[str]:
    """Run the points that are not done, side by side, and yield a line when a run has ended.

    Files of an unfinished run are kept under another name.  Raises FolderUnusable before anything is run, and
    where two different runs would have the same folder.
    """
    waiting: list[Point] = []
    done: list[Point] = []
    made_by: dict[Path, tuple[str, ...]] = {}
    for each in points:
        if made_by.get(each.folder, each.words) != each.words:
            raise FolderUnusable(f"{each.folder}: two different runs of this study have this folder")
        if each.folder in made_by:
            continue
        made_by[each.folder] = each.words
        if each.run.is_at_work:
            raise FolderUnusable(f"{each.folder}: a run is at work there; wait for its end")
        (done if each.done() else waiting).append(each)
    yield from (f"{each.folder.name}: done before" for each in done)
    if waiting:
        beside = min(crew.size(), len(waiting))
        yield from crew.each(partial(_run, (p.words, p.then), p.folder.resolve(), beside) for p in waiting)


def run_point(point: Point, beside: int) -> str:
    """Run one point, which is not done, in a process of its own, and return a line about its end.

    ``beside`` is the number of runs at a time.  A run that still goes on, because a worker elsewhere outlives
    its killed study, is waited for.
    """
    while point.run.is_at_work:
        time.sleep(WAIT_S)
    if point.done():
        return f"{point.folder.name}: {point.status()}"
    return _run((point.words, point.then), point.folder.resolve(), beside)


def _run(commands: Sequence[Sequence[str]], folder: Path, beside: int) -> str:
    _put_aside(folder)
    log = folder.with_name(f"{folder.name}.log")
    log.parent.mkdir(parents=True, exist_ok=True)
    StudyFolder(folder.parent).write_json(_about(folder), {"side_by_side": beside})
    code = 0
    with log.open("w", encoding="utf-8") as text:
        for words in commands:
            if words and code == 0:
                code = Run.carry_out(words, text)
    how = f"killed ({signal.Signals(-code).name})" if code < 0 else Run(folder).status
    return f"{folder.name}: {how}" + (f" ({log})" if code else "")


def _about(folder: Path) -> str:
    return f"{folder.name}.json"


def _put_aside(folder: Path) -> None:
    number = 1
    while folder.exists():
        aside = folder.with_name(f"{folder.name}-unfinished-{number}")
        if not aside.exists():
            folder.rename(aside)
        number += 1


@dataclass(frozen=True)
class Vary:
    """A varied key of a case: the dotted ``key``, as ``--set`` takes it, and its ``values`` as text.

    ``given`` has the texts of values that were given with a unit, such as "700 rpm"; the values themselves
    are in the key's own unit.
    """

    key: str
    values: tuple[str, ...]
    given: Mapping[str, str] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The last word of the key, which ends in the unit."""
        return self.key.rpartition(".")[2]

    @property
    def keys(self) -> tuple[str, ...]:
        """The varied key alone."""
        return (self.key,)

    def points(self, study: CaseStudy, sets: Sequence[str] = ()) -> list[Point]:
        """Return the point of each value; nothing is run here.

        Raises CaseError if the case is wrong with one of the values.
        """
        return [
            study.point(value, [*sets, f"{self.key}={value}"], self.folder(value)) for value in self.values
        ]

    def setting_of(self, point: Point) -> dict[str, str]:
        """Return the value of the key at a point."""
        return {self.key: point.value}

    def given_of(self, point: Point) -> dict[str, str]:
        """Return the value of the key at a point with the unit in which it was given; {} without one."""
        return {self.key: self.given[point.value]} if point.value in self.given else {}

    def folder(self, value: str) -> str:
        """Return the name of the folder of a value's run, with the unit in which the value was given."""
        text = self.given.get(value, value)
        return f"{self.name}-" + "".join(c if c.isalnum() or c in "+-._" else "_" for c in text)


def parse_vary(text: str, repeats: bool = False) -> Vary:
    """Read 'key=a,b,c' or 'key=first:last:step' (both ends included).  Raises CaseError.

    Values may have units, and one unit serves all numbers without one: 'speed_rad_per_s=700,750 rpm' and
    'speed_rad_per_s=700:800:50 rpm'.  Only with ``repeats`` may a value stand there more than once.
    """
    key, equals, values = text.partition("=")
    if not equals or not key.strip() or not values.strip():
        raise _wrong(text, "is not key=values")
    if values.count(":") == 2:
        each = _range(text, values)
    else:
        each = _list(text, key, [value.strip() for value in _split(values)])
    vary = vary_of(key.strip(), each)
    each = vary.values
    if not all(each) or (len(set(each)) < len(each) and not repeats):
        raise _wrong(text, "has an empty value or one twice")
    if len({vary.folder(value) for value in each}) < len(set(each)):
        raise _wrong(text, "has two values whose folders would have the same name")
    return vary


def vary_of(key: str, texts: Sequence[str]) -> Vary:
    """Return a key with values that may have units."""
    own = tuple(in_own_unit(text, key) for text in texts)
    return Vary(key, own, {value: text for value, text in zip(own, texts, strict=True) if value != text})


def _list(text: str, key: str, values: Sequence[str]) -> tuple[str, ...]:
    """Return the values of a list; numbers without a unit have the one unit that others have."""
    units = {split_quantity(value)[1] for value in values} - {""}
    is_bare = [NUMBER_ALONE.fullmatch(value) is not None for value in values]
    if not unit_of(_last_name(key), "") or not units or not any(is_bare):
        return tuple(values)
    if len(units) > 1:
        raise _wrong(text, "has several units, and a number without one")
    return tuple(
        f"{value} {max(units)}" if bare else value for value, bare in zip(values, is_bare, strict=True)
    )


def _range(text: str, values: str) -> tuple[str, ...]:
    """Return the values of a range, computed in exact fractions: 0.1:0.3:0.1 has three values.

    The values have the unit of the range's parts.  Those of a key without a unit are written as whole numbers
    where all of them are whole: the key may be a count.
    """
    try:
        parts = with_one_unit(values.split(":"))
    except ValueError as error:
        raise _wrong(text, str(error)) from None
    try:
        first, last, step = (exact(float(split_quantity(part)[0])) for part in parts)
    except ValueError:
        raise _wrong(text, "is not a range of numbers") from None
    if step == 0 or (last - first) / step < 0 or (last - first) / step >= MOST_VALUES:
        raise _wrong(text, f"is not a range of 1 to {MOST_VALUES} values")
    count = int((last - first) / step) + 1
    unit = split_quantity(parts[-1])[1]
    has_unit = unit_of(_last_name(text.partition("=")[0]), "")
    number_of = int if first.denominator == step.denominator == 1 and not has_unit else float
    numbers = [repr(number_of(first + number * step)) for number in range(count)]
    return tuple(f"{number.removesuffix('.0')} {unit}" if unit else number for number in numbers)


def with_one_unit(parts: Sequence[str]) -> list[str]:
    """Return the parts of a range, all with the unit that some of them have; "700", "50 rpm" is "700 rpm",
    "50 rpm".

    Raises ValueError for different units.
    """
    numbers, units = zip(*map(split_quantity, parts), strict=True)
    if len(set(units) - {""}) > 1:
        raise ValueError("has several units")
    return [f"{number} {max(units)}".strip() for number in numbers]


def in_own_unit(value: str, key: str) -> str:
    """Return a value of a key in the key's own unit; a value without a known unit is returned as it is."""
    name = _last_name(key)
    try:
        return repr(parse_quantity(value, name)) if unit_of(name, "") else value
    except ValueError:
        return value  # the check of the case says why


def _last_name(key: str) -> str:
    """Return the last word of a key that is no number of an element of a list."""
    return next((word for word in reversed(key.strip().split(".")) if not word.isdecimal()), "")


def _split(values: str) -> list[str]:
    parts, depth = [""], 0
    for letter in values:
        depth += (letter in "[{") - (letter in "]}")
        if letter == "," and depth == 0:
            parts.append("")
        else:
            parts[-1] += letter
    return parts


def _wrong(text: str, what: str) -> CaseError:
    hint = "for example --vary screen.exciters.shaft.speed_rad_per_s=58:110:4"
    return CaseError([CaseProblem((), what, hint, f"--vary {text}", kind="wrong-type")])


def seed_sets(case: Case, number: int) -> tuple[str, ...]:
    """Return the ``--set`` overlays of another choice of random numbers; number 0 is the case's own."""
    if number == 0:
        return ()
    tables = (("blocks", case.tables.bed.blocks), ("feeds", case.tables.bed.feeds))
    return tuple(
        f"bed.{kind}.{name}.seed={row.seed + number}" for kind, table in tables for name, row in table.items()
    )


def is_random(case: Case) -> bool:
    """Return whether other seeds change the run of a case."""
    return bool(seed_sets(case, 1)) and case.tables.particles.adapter is not None


def sampling_sets(interval_s: float) -> tuple[str, ...]:
    """Return the ``--set`` overlays of a run for measurement.

    The run writes frequent rows, at whole sync intervals, and no pictures.
    """
    every_s = float(sample_s(interval_s))
    return (f"output.series_s={every_s!r}", f"output.shapes_s={every_s!r}", "output.pictures=false")
