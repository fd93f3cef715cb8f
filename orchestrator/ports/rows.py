"""Records of arrays with one row for each of the same things."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Self

import numpy as np


class Rows:
    """Base of a frozen record whose fields are arrays, or such records, of equally many rows.

    A field that the record does not tell is None.
    """

    def part(self, rows: Any) -> Self:
        """Return the record of some rows, in their order; of one row, if ``rows`` is its number."""

        def chosen(value: Any) -> Any:
            return value if value is None else value.part(rows) if isinstance(value, Rows) else value[rows]

        return replace(self, **{name: chosen(value) for name, value in vars(self).items()})  # type: ignore[type-var]

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """Return the rows of all parts, of which there is one at least, in order."""

        def both(values: list[Any]) -> Any:
            first = values[0]
            return type(first).joined(values) if isinstance(first, Rows) else np.concatenate(values)

        columns = {name: [vars(part)[name] for part in parts] for name in vars(parts[0])}
        made = {name: None if values[0] is None else both(values) for name, values in columns.items()}
        return replace(parts[0], **made)  # type: ignore[type-var]
