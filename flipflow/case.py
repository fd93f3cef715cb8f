"""A case that Python loads, changes, checks and runs."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from html import escape
from pathlib import Path
from typing import Any

import tomli_w

from flipflow.run import Run, make_run
from orchestrator.case import shipped
from orchestrator.case.file.base import CASE_FILE, lay_chain, level_names, read_chain
from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.file.nested import value_at
from orchestrator.case.load import choose_level
from orchestrator.cli.console import find_all_problems, find_all_problems_when_open
from orchestrator.output.records.run_folder import resolved_case
from orchestrator.preflight.check import warnings
from orchestrator.preflight.judge import JudgedCase, load_judged
from orchestrator.run.progress import ProgressReport

Setting = str | bool | int | float | list[Any] | tuple[Any, ...] | Mapping[str, Any]


@dataclass(frozen=True, repr=False)
class Case:
    """A case at a level, with changed keys.

    A case does not change: ``change`` and ``at_level`` return another one.  ``folder`` is the folder of the
    case, ``level`` the name of its level ("" if it has none), and ``overrides`` has the changes as
    ``flipflow run --set`` takes them.
    """

    folder: Path
    level: str = ""
    overrides: tuple[str, ...] = ()

    def change(self, settings: Mapping[str, Setting]) -> Case:
        """Return the case with other values, by their keys with dots: ``{"particles.step_s": 1e-5}``.

        A number is in the unit of its key, or a text with a unit of its own:
        ``{"screen.panels.deck.thickness_m": "4 mm"}``.  A table changes the keys that it has, and the others
        stay.  Nothing is judged here; ``check`` finds unknown keys and wrong values.
        """
        added = tuple(line for key, value in settings.items() for line in _as_overrides(key, value))
        return replace(self, overrides=self.overrides + added)

    def at_level(self, level: str | Path) -> Case:
        """Return the case at another level.  Raises CaseError if the case has no such level."""
        return load(self.folder, level, self.overrides)

    @property
    def levels(self) -> list[str]:
        """The names of the levels of the case."""
        return level_names(self.folder)

    @cached_property
    def _judged(self) -> JudgedCase:
        return load_judged(self.folder, self.level or None, self.overrides)

    @property
    def settings(self) -> dict[str, Any]:
        """All keys of the case with their values, defaults included, as nested tables.

        Raises CaseError for a case whose tables are wrong.
        """
        return resolved_case(self._judged)

    def __getitem__(self, key: str) -> Any:
        """Return the value of a key with dots.  Raises KeyError if there is no such key."""
        value = value_at(self.settings, key.split("."))
        if value is None:
            raise KeyError(key)
        return value

    def check(self) -> list[str]:
        """Return every problem that prevents a run, each as one line; an empty list means that the case can
        be run.
        """
        try:
            return [str(problem) for problem in find_all_problems_when_open(self._judged)]
        except CaseError as error:
            return [str(problem) for problem in error.problems]

    def warnings(self) -> list[str]:
        """Return what is allowed but doubtful in the case.  Raises CaseError if the case cannot be run."""
        if problems := find_all_problems(self._judged):
            raise CaseError(problems)
        return list(warnings(self._judged))

    def run(
        self,
        out: str | Path | None = None,
        progress: Callable[[ProgressReport], None] | None = None,
        ranks: int = 1,
    ) -> Run:
        """Run the case in a process of its own, and return the run when it has ended.

        Parameters
        ----------
        out
            The new folder of the run; by default ``runs/<case>-<number>`` in the current folder.
        progress
            Is called every five seconds with the progress of the run.
        ranks
            Number of processes; with more than one, they are started by ``mpirun``.

        Raises
        ------
        CaseError
            The case has problems.  Nothing is written.
        RunFailed
            The run ended before its end.  ``error.run`` is what it left behind.
        RunInterrupted
            Ctrl-C ended the run, which can be resumed.
        """
        if problems := find_all_problems(self._judged):
            raise CaseError(problems)
        level = ("--level", self.level) if self.level else ()
        sets = tuple(word for line in self.overrides for word in ("--set", line))
        return make_run(("run", str(self.folder), *level, *sets), out, progress, ranks)

    def __repr__(self) -> str:
        return f"Case({self.folder.name!r}, level={self.level!r}, overrides={self.overrides!r})"

    def _repr_html_(self) -> str:
        """Return a short description for a notebook."""
        lines = "".join(f"<li><code>{escape(line)}</code></li>" for line in self.overrides)
        level = f", level <b>{escape(self.level)}</b>" if self.level else ""
        return f"<p>Case <b>{escape(self.folder.name)}</b>{level}</p>" + (
            f"<ul>{lines}</ul>" if lines else ""
        )


def load(path: str | Path, level: str | Path | None = None, overrides: str | Sequence[str] = ()) -> Case:
    """Return the case in a folder, at a level; without one, at the case's default level.

    ``path`` is the folder or the case.toml in it, or the name of a case that comes with the program;
    ``level`` is a name or the file of a level.  Raises CaseError if there is no case, or if it has no such
    level.
    """
    path = shipped.find(Path(path))
    file = Path(path) if path.is_file() else path / CASE_FILE
    if not file.is_file() or file.name != CASE_FILE:
        what = f"no such case: there is no {CASE_FILE}" if not file.is_file() else f"is no {CASE_FILE}"
        hint = shipped.no_such_case_hint(path) or "name the folder of a case"
        raise CaseError([CaseProblem((), what, hint, file=str(path), kind="file")])
    chain = read_chain(file)
    folder, wanted = chain[0].folder, None if level is None else str(level)
    lines = (overrides,) if isinstance(overrides, str) else tuple(overrides)
    return Case(folder, choose_level(folder, lay_chain(chain).merged, wanted), lines)


def _as_overrides(key: str, value: Setting) -> Iterator[str]:
    """Yield the ``--set`` overlays that give a key this value; a table gives one for each of its keys."""
    if isinstance(value, Mapping):
        for word, inner in value.items():
            yield from _as_overrides(f"{key}.{word}", inner)
        return
    yield f"{key}={_toml(value)}"


def _toml(value: Any) -> str:
    """Return a value as TOML on one line.  Raises TypeError for a value that TOML does not know."""
    if hasattr(value, "tolist"):  # an array or a number of NumPy
        value = value.tolist()
    if isinstance(value, Mapping):
        keys = (tomli_w.dumps({str(word): 0}).removesuffix("0\n") for word in value)
        rows = (key + _toml(inner) for key, inner in zip(keys, value.values(), strict=True))
        return f"{{ {', '.join(rows)} }}"
    if isinstance(value, list | tuple):
        return f"[{', '.join(map(_toml, value))}]"
    plain = str(value) if isinstance(value, Path) else value
    return tomli_w.dumps({"value": plain}).removeprefix("value = ").removesuffix("\n")
