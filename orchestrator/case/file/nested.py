"""Nested tables and lists: their values and their keys."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any


def leaves(value: Any, key: tuple[str | int, ...] = ()) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    """Yield each value of nested tables and lists that is neither, with its key below ``key``."""
    if isinstance(value, Mapping | list | tuple):
        for word, inner in value.items() if isinstance(value, Mapping) else enumerate(value):
            yield from leaves(inner, (*key, word))
    else:
        yield key, value


def value_at(value: Any, key: Sequence[str]) -> Any:
    """Return the value at a key, whose words are names or numbers of elements; None where there is none."""
    for word in key:
        if isinstance(value, list) and word.isdecimal() and int(word) < len(value):
            value = value[int(word)]
        else:
            value = value.get(word) if isinstance(value, Mapping) else None
    return value


def nested(key: Sequence[str], value: Any) -> dict[str, Any]:
    """Return a table that holds nothing but a value at a key of one word or more."""
    for word in reversed(key[1:]):
        value = {word: value}
    return {key[0]: value}
