"""The values of nested tables and lists."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any


def leaves(value: Any, key: tuple[str | int, ...] = ()) -> Iterator[tuple[tuple[str | int, ...], Any]]:
    """Yield each value of nested tables and lists that is neither, with its key below ``key``."""
    if isinstance(value, Mapping | list | tuple):
        for word, inner in value.items() if isinstance(value, Mapping) else enumerate(value):
            yield from leaves(inner, (*key, word))
    else:
        yield key, value
