"""Records of arrays with one row for each of the same things."""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, Self

import numpy as np
import numpy.typing as npt

from orchestrator.ports import Indices


class Rows:
    """Base of a dataclass whose fields are arrays, or such records, of equally many rows."""

    def part(self, rows: Indices | npt.NDArray[np.bool_]) -> Self:
        """Some of the rows."""

        def chosen(value: Any) -> Any:
            return value.part(rows) if isinstance(value, Rows) else value[rows]

        return self._from_each(chosen)

    def followed_by(self, others: Self) -> Self:
        """All of these, then all of those."""

        def both(value: Any, other: Any) -> Any:
            return value.followed_by(other) if isinstance(value, Rows) else np.concatenate([value, other])

        return self._from_each(both, others)

    def _from_each(self, make: Any, *others: Self) -> Self:
        names = [field.name for field in fields(self)]  # type: ignore[arg-type]
        made = {name: make(*(getattr(each, name) for each in (self, *others))) for name in names}
        return replace(self, **made)  # type: ignore[type-var]
