"""Layers of a case laid over each other, and who gave each key.

Tables are merged key by key; anything else is replaced whole.  An element of a list is reached
by its number, as if the list were a table: ``contacts.0.restitution``.
"""

from __future__ import annotations

import tomllib
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from orchestrator.case.file.errors import CaseError, CaseProblem, Key
from orchestrator.case.file.toml_file import TOO_DEEP, is_too_deep


class Layers:
    """``merged`` is what all layers so far amount to."""

    def __init__(self, given: Mapping[str, Any], source: str) -> None:
        self._first = source
        self._source: dict[tuple[str, ...], str] = {}
        self.merged: dict[str, Any] = dict(given)

    def copy(self) -> Layers:
        """The same layers, to lay others over."""
        twin = Layers(self.merged, self._first)
        twin._source = dict(self._source)
        return twin

    def lay(self, overlay: Mapping[str, Any], source: str) -> None:
        """None takes a key away.  Raises CaseError when it reaches for an element that a list does
        not have."""
        self.merged = self._over(self.merged, overlay, (), source)

    def source(self, key: Key) -> str:
        """The file or option that gave this key, or the table it is in, last."""
        words = tuple(str(part) for part in key)
        for end in range(len(words), 0, -1):
            if words[:end] in self._source:
                return self._source[words[:end]]
        return self._first

    def named(self, problems: Sequence[CaseProblem]) -> list[CaseProblem]:
        """The problems with their files filled in."""
        return [m if m.file else replace(m, file=self.source(m.key)) for m in problems]

    def _over(self, below: Any, overlay: Any, key: tuple[str, ...], source: str) -> Any:
        """``overlay`` over ``below`` at ``key``; changes neither."""
        if not isinstance(overlay, Mapping):
            self._source[key] = source
            return overlay
        if isinstance(below, list):
            below = list(below)
            for word, value in overlay.items():
                number = _number(word, below, key, source)
                below[number] = self._over(below[number], value, (*key, word), source)
            return below
        if not isinstance(below, Mapping):
            self._source[key] = source
            below = {}
        merged = dict(below)
        for word, value in overlay.items():
            merged[word] = self._over(below.get(word), value, (*key, word), source)
            if value is None:
                del merged[word]
        return merged


def _number(word: str, below: Sequence[Any], key: Key, source: str) -> int:
    if word.isdecimal() and int(word) < len(below):
        return int(word)
    what = f'"{word}" is no element of this list'
    hint = f"its elements are numbered 0 to {len(below) - 1}" if below else "it is empty"
    raise CaseError([CaseProblem((*key, word), what, hint, source)])


def parsed(override: str) -> dict[str, Any]:
    """'panel.solver=rigid' as an overlay: {"panel": {"solver": "rigid"}}.

    The value is TOML; what is no TOML is taken as a bare string.
    """
    path, equals, text = override.partition("=")
    words = [word.strip() for word in path.split(".")]
    if not equals or not all(words):
        hint = "for example --set panel.solver=rigid"
        raise CaseError([CaseProblem((), "is not key=value", hint, f"--set {override}")])
    value: Any = _value(text.strip())
    for word in reversed(words):
        value = {word: value}
    if is_too_deep(value):
        raise CaseError([CaseProblem((), TOO_DEEP, file=f"--set {override}")])
    return dict(value)


def _value(text: str) -> Any:
    try:
        found = tomllib.loads(f"value = {text}")
    except (ValueError, RecursionError):
        return text
    return found["value"] if list(found) == ["value"] else text


def changed(before: Any, after: Any, key: tuple[str, ...] = ()) -> Iterator[tuple[str, ...]]:
    """The keys whose values differ."""
    if isinstance(before, Mapping) and isinstance(after, Mapping):
        for word in dict.fromkeys((*before, *after)):
            yield from changed(before.get(word), after.get(word), (*key, word))
    elif before != after:
        yield key
