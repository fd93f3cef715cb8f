"""What a stored study of accuracy says about the errors of a run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, ClassVar, Literal

Basis = Literal["measured", "predicted", "not known"]


@dataclass(frozen=True)
class KnownError:
    """An estimated relative error of a quantity.

    ``value`` includes the part that ``remains`` in the finest settings of the study; that part is None where
    it is not known.  ``half_width`` is half the width of its 95 % interval by chance: 0 where nothing is
    random, None where it is not known.
    """

    value: float
    half_width: float | None
    remains: float | None


@dataclass(frozen=True)
class Accuracy:
    """What the nearest stored study of accuracy says about a run.

    ``basis``: the study "measured" the run's settings, or each of them alone, so that their errors are
    "predicted"; else the errors are "not known".  ``why`` says how near the study is, or why nothing is
    known.  ``study`` is its file, and ``study_s`` the simulated time of its runs.  ``errors`` are by name of
    the quantities that studies compare.  ``reference_error`` is the study's estimate of what its reference is
    off itself, and ``chance`` its largest half width of an error that decides; each is None where it is not
    known.  ``command`` is the command that would tell, where errors are not known.
    """

    basis: Basis
    why: str
    study: str = ""
    study_s: float | None = None
    reference_error: float | None = None
    chance: float | None = None
    errors: Mapping[str, KnownError] = field(default_factory=dict)
    command: str = ""
    stored_in: ClassVar[str] = "accuracy.json"
    """The name of the file that a study of accuracy leaves in its folder."""

    def as_json(self) -> dict[str, Any]:
        """Return the record as a table for JSON."""
        return asdict(self)

    @classmethod
    def from_json(cls, table: Mapping[str, Any]) -> Accuracy:
        """Return the record that ``as_json`` made a table of."""
        errors = {name: KnownError(**error) for name, error in table["errors"].items()}
        return cls(**{**table, "errors": errors})
