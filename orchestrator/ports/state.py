"""The state of solvers and books as plain arrays, and back, as ``Restorable`` needs it.

``save_attributes`` copies named attributes into arrays, ``restore_attributes`` sets them again from these.
An attribute is an array, a number, a text, a record (a dataclass) or a dictionary of these.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import fields, is_dataclass, replace
from typing import Any, ClassVar, Protocol

import numpy as np

from orchestrator.ports.interface_records import Account

Saved = dict[str, Any]
"""A solver's state: arrays by name, or dictionaries of the same."""


class Restorable(Protocol):
    """A solver that can be taken back to a sync point, or another one brought there.

    A run that goes on after ``restore`` is, bit for bit, the one that never stopped.  So a restore
    must undo everything that later calls depend on: motion, histories of material and contact,
    random numbers, counters, and all sums behind ``account``.  Both calls are collective under MPI;
    what each rank saves is its own.
    """

    def save(self) -> Saved:
        """Return copies of all that decides how the solver goes on.  The call changes nothing.

        Returns
        -------
        Saved
            Arrays that later calls of the solver leave alone.
        """
        ...

    def restore(self, saved: Saved) -> None:
        """Take this solver to the sync point at which ``saved`` was made.

        Parameters
        ----------
        saved
            What ``save`` of this solver gave, or of another one built from the same plan.
        """
        ...


class Solver(Restorable, Protocol):
    """The calls that the members of every port answer."""

    def account(self) -> Account:
        """Return what the solver owns now, and the flows through it since t = 0."""
        ...

    def close(self) -> None:
        """Release everything that the solver holds; no call follows."""
        ...


def save_attributes(owner: object, *names: str) -> Saved:
    """Return copies of some attributes of ``owner`` as arrays, or dictionaries of these, by name.

    The keys lack the underscore that marks attributes as private.

    Examples
    --------
    >>> from types import SimpleNamespace
    >>> ball = SimpleNamespace(_height_m=0.5, hits=3)
    >>> saved = save_attributes(ball, "_height_m", "hits")
    >>> ball._height_m, ball.hits = 0.0, 4
    >>> restore_attributes(ball, saved, "_height_m", "hits")
    >>> ball._height_m, ball.hits
    (0.5, 3)
    """
    return {name.lstrip("_"): as_arrays(getattr(owner, name)) for name in names}


def restore_attributes(owner: object, saved: Saved, *names: str) -> None:
    """Set attributes to the values that ``save_attributes`` returned; raise KeyError where ``saved`` lacks
    one.

    The present values tell the kinds of the restored values.
    """
    for name in names:
        setattr(owner, name, like(getattr(owner, name), saved[name.lstrip("_")]))


def as_arrays(value: Any) -> Any:
    """Return copies of all contents of a value as arrays."""
    if isinstance(value, np.ndarray):  # the most, and quicker to tell than a dataclass
        return value.copy()
    if is_dataclass(value):
        return {field.name: as_arrays(getattr(value, field.name)) for field in fields(value)}
    if isinstance(value, Mapping):
        return {name: as_arrays(inner) for name, inner in value.items()}
    return np.array(value)


def like(present: Any, saved: Any) -> Any:
    """Return a value of the kind of ``present`` with the saved arrays in it."""
    if isinstance(present, np.ndarray):
        return np.array(saved)
    if is_dataclass(present) and not isinstance(present, type):
        names = [field.name for field in fields(present)]
        return replace(present, **{n: like(getattr(present, n), saved[n]) for n in names})
    if isinstance(present, Mapping):
        return {name: like(present[name], inner) for name, inner in saved.items()}
    return type(present)(saved[()])


class SavedAttributes:
    """A solver whose state is the attributes named in ``STATE``, and that holds nothing open.

    ``PARTS`` names the attributes that are ``Restorable`` themselves, whose states belong to its own.
    """

    STATE: ClassVar[tuple[str, ...]] = ()
    PARTS: ClassVar[tuple[str, ...]] = ()

    def save(self) -> Saved:
        """Return copies of the attributes, and the states of the parts."""
        parts = {name.lstrip("_"): getattr(self, name).save() for name in self.PARTS}
        return save_attributes(self, *self.STATE) | parts

    def restore(self, saved: Saved) -> None:
        """Take the solver back to a saved state."""
        restore_attributes(self, saved, *self.STATE)
        for name in self.PARTS:
            getattr(self, name).restore(saved[name.lstrip("_")])

    def close(self) -> None:
        """Do nothing, since nothing is open."""
