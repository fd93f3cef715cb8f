"""The state of solvers and books as plain arrays, and back: what ``Restorable`` is made of.

``save_attributes`` copies named attributes into arrays, ``restore_attributes`` sets them again from
these.  An attribute is an array, a number, a text, a record (a dataclass) or a dictionary of these.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, ClassVar

import numpy as np

from orchestrator.ports import Restorable, Saved


def save_attributes(owner: object, *names: str) -> Saved:
    """The attributes ``names``, without the underscore that marks them as private."""
    return {name.lstrip("_"): as_arrays(getattr(owner, name)) for name in names}


def restore_attributes(owner: object, saved: Saved, *names: str) -> None:
    """The reverse; the attributes' present values tell what they are made of."""
    for name in names:
        setattr(owner, name, like(getattr(owner, name), saved[name.lstrip("_")]))


def restorable(solver: object) -> Restorable:
    """The solver, as one that can be saved; TypeError names one that cannot."""
    if not isinstance(solver, Restorable):
        raise TypeError(f"{type(solver).__name__} can be neither saved nor restored")
    return solver


def as_arrays(value: Any) -> Any:
    """Copies of all that a value holds, in arrays."""
    if is_dataclass(value):
        return {field.name: as_arrays(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {name: as_arrays(one) for name, one in value.items()}
    return np.array(value)


def like(present: Any, saved: Any) -> Any:
    """A value of the kind of ``present`` with the saved arrays in it."""
    if is_dataclass(present) and not isinstance(present, type):
        names = [field.name for field in fields(present)]
        return replace(present, **{n: like(getattr(present, n), saved[n]) for n in names})
    if isinstance(present, Mapping):
        return {name: like(present[name], one) for name, one in saved.items()}
    if isinstance(present, np.ndarray):
        return np.array(saved)
    return type(present)(saved[()])


class SavedAttributes:
    """A solver whose state is the attributes named in ``STATE``, and that holds nothing open."""

    STATE: ClassVar[tuple[str, ...]] = ()

    def save(self) -> Saved:
        """Copies of the attributes."""
        return save_attributes(self, *self.STATE)

    def restore(self, saved: Saved) -> None:
        """Takes the solver back to what was saved."""
        restore_attributes(self, saved, *self.STATE)

    def close(self) -> None:
        """There is nothing to close."""
