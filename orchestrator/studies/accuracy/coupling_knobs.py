"""The coupling's knobs: how long a sync interval is, and what happens within it."""

from __future__ import annotations

from orchestrator.case.file.contents import damped_contacts, has_particles
from orchestrator.case.tables.case import Case
from orchestrator.coupling.schemes import SCHEMES
from orchestrator.ports.clock import exact
from orchestrator.preflight.stability.choice import settled
from orchestrator.studies.accuracy.setting import Family, NotOffered, Setting, degrees

LENGTH = "sync interval / s"
ORDERS = {"particles-first": 2.0, "serial-staggered": 1.0, "aitken": 2.0, "quasi-newton": 2.0}
"""Of the position (docs/theory/coupling.md); those of the other schemes are nowhere derived."""
WITHOUT_PARTICLES = ("particles-first", "serial-staggered")  # the others repeat the first then

DAMPED = (
    "contacts with restitution below 1 cost particles-first an order in motion and force, not in "
    "energy (docs/theory/coupling.md)"
)


def sync(case: Case, points: int) -> list[Family]:
    """The interval of the case's own scheme, or of the one that is taken for it, halved and
    doubled."""
    name = settled(case).coupling.scheme
    overlay = f"coupling.scheme={name}" if case.coupling.scheme != name else ""
    return [_family("sync", case, name, overlay, points)]


def scheme(case: Case, points: int) -> list[Family]:
    """Every other scheme, at the same intervals.  Raises NotOffered."""
    if not (case.screen.panels and (has_particles(case) or case.screen.frames)):
        raise NotOffered("nothing is coupled: schemes differ only where panels meet others")
    some, own = has_particles(case), settled(case).coupling.scheme
    return [
        _family("scheme", case, name, f"coupling.scheme={name}", points)
        for name in SCHEMES
        if name != own and (some or name in WITHOUT_PARTICLES)
    ]


def _family(knob: str, case: Case, name: str, overlay: str, points: int) -> Family:
    own_s = exact(case.coupling.sync_interval_s)
    settings = []
    for halved in degrees(points):
        length_s = float(own_s / 2**halved if halved >= 0 else own_s * 2**-halved)
        sets = (f"coupling.sync_interval_s={length_s!r}",) if halved else ()
        label = f"{name}, {length_s:g} s"
        named = (overlay,) if overlay and (sets or knob == "scheme") else ()
        settings.append(Setting(label, (*named, *sets), length_s))
    order = ORDERS.get(name)
    rank = (order or 0.0) + (0.5 if knob == "sync" else 0.0)
    note = DAMPED if name == "particles-first" and damped_contacts(case) else ""
    return Family(knob, "coupling", name, tuple(settings), LENGTH, order, rank, note)
