"""The failures that end a run without a fault of the case, and contexts that add the solver and the time."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from traceback import clear_frames

from orchestrator.ports.clock import Interval
from orchestrator.ports.interface_records import BrokenRecord


class SolverMissing(Exception):
    """An error for a solver whose package is not installed; the message says what to install (exit code
    3)."""


class SolverFailed(Exception):
    """An error of a solver that failed or went unstable; the message says which, when and why (exit code
    4)."""


class NamedSolverFailed(SolverFailed):
    """A failure whose message says which solver failed, and when."""


def solver_failure_context(member: str, interval: Interval | None) -> SolverFailureContext:
    """Make failures inside the context say which solver failed, and when.

    ``interval`` is the running interval, None at t = 0.  NamedSolverFailed takes the place of SolverFailed,
    BrokenRecord, FloatingPointError and MemoryError; other exceptions get the same words as a note.  Only the
    innermost of nested contexts speaks.
    """
    return SolverFailureContext(member, interval)


class SolverFailureContext:
    """The context of ``solver_failure_context``; several are entered in each interval, so it is no
    generator."""

    __slots__ = ("_interval", "_member")

    def __init__(self, member: str, interval: Interval | None) -> None:
        self._member, self._interval = member, interval

    def __enter__(self) -> None: ...

    def __exit__(self, _: object, error: BaseException | None, trace: object) -> None:
        if not isinstance(error, Exception) or isinstance(error, NamedSolverFailed):
            return
        what = f"{self._member} failed {_when(self._interval)}"
        if isinstance(error, SolverFailed | BrokenRecord | FloatingPointError):
            raise NamedSolverFailed(f"{what}: {error}") from error
        if isinstance(error, MemoryError):
            clear_frames(error.__traceback__)  # what they hold is needed to close the books
            raise NamedSolverFailed(f"{what}: {f'out of memory. {error}'.strip()}") from error
        if not hasattr(error, "__notes__"):
            error.add_note(f"{self._member} {_when(self._interval)}")


def _when(interval: Interval | None) -> str:
    if interval is None:
        return "at t = 0 s"
    return (
        f"between t = {interval.start_s:.6g} s and {interval.end_s:.6g} s "
        f"(sync interval {interval.index // interval.parts})"
    )


@contextmanager
def write_failure_context(what: str, time_s: float) -> Iterator[None]:
    """Make an error of the disk, or of memory, say what could not be written, and at which time."""
    try:
        yield
    except MemoryError as error:
        error.add_note(f"the {what} at t = {time_s:.6g} s cannot be written")
        raise
    except OSError as error:
        raise OSError(f"the {what} at t = {time_s:.6g} s cannot be written: {error}") from error
