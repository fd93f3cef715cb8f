"""What is said of one effect."""

from __future__ import annotations

from dataclasses import dataclass

TENTH = 0.1
"""What changes a result by less than a tenth may be left out: the project's own choice, as the
amplitudes of cases/ffs0827-empty meet the published ones to about a tenth."""


@dataclass(frozen=True)
class Verdict:
    """One effect in one scene.

    ``present``: whether the case has it; ``number`` names the dimensionless number that decides,
    ``value`` is its value (None: there is none), ``threshold`` what it is compared with;
    ``matters`` is None where the scene does not tell; ``why`` says so in words; ``key`` is what to
    change in the case ("": nothing can be), ``cost`` what the effect costs.
    """

    effect: str
    present: bool
    number: str
    value: float | None
    threshold: str
    matters: bool | None
    why: str
    key: str = ""
    cost: str = ""

    @property
    def lacking(self) -> bool:
        """It matters, and the case does not have it."""
        return self.matters is True and not self.present

    @property
    def spare(self) -> bool:
        """The case has it, could do without, and a key takes it out."""
        return self.matters is False and self.present and bool(self.key)
