"""docs/case-format.md, made from the tables themselves:

python -m orchestrator.commands.case_reference > docs/case-format.md
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from types import NoneType
from typing import Annotated, Any, Literal, get_args, get_origin

from annotated_types import Ge, Gt, Le, Lt
from pydantic import BaseModel
from pydantic.fields import FieldInfo

from orchestrator.casefile.case import Case
from orchestrator.scene.catalogue import EFFECTS
from orchestrator.scene.effect import Part

# by the end of a key; the longest that fits counts
UNITS = {
    "_min": "min",
    "_m": "m",
    "_m_s": "m/s",
    "_m_s2": "m/s2",
    "_s": "s",
    "_kg": "kg",
    "_kg_s": "kg/s",
    "_kg_m": "kg m",
    "_kg_m2": "kg m2",
    "_kg_m3": "kg/m3",
    "_J_m2": "J/m2",
    "_Pa": "Pa",
    "_Pa_m": "Pa/m",
    "_N_m": "N/m",
    "_N_s_m": "N s/m",
    "_m3_N_m": "m3/(N m)",
    "_rad": "rad",
    "_rad_s": "rad/s",
    "_deg": "degree",
    "_Hz": "Hz",
    "_W": "W",
    "_N_m_s": "N m s",
}
DIMENSIONLESS = frozenset(
    {
        "along",
        "across",
        "axis",
        "stagger",
        "start",
        "at",
        "passing",
        "poisson_ratio",
        "ratio",
        "restitution",
        "sliding_friction",
        "rolling_friction",
        "rayleigh_fraction",
        "coarse_graining",
        "damping_ratio",
        "mass_fraction",
        "loss_factor",
        "storage_ratio",
        "rated_slip",
        "breakdown_ratio",
        "tolerance",
        "largest_created_share",
        "largest_created_in_total",
        "largest_growing_share",
        "largest_stretch",
        "largest_overlap",
        "largest_step_share",
    }
)
HEAD = """\
# The case format

A case is a folder: `case.toml` says what (physics), `levels/<level>.toml` say how finely (solvers
and numerics), and STL files lie beside. `flipflow check <folder>` finds every mistake before
anything starts and says what is in the case.

Good examples to start from: `cases/ball-on-panel` (small), `cases/panel-cycle` (a frame moved by a
`drive`), `cases/quickstart` (everything).

Mind the axes: everything in `[screen]`, STL files, probe points and blocks are in deck axes;
`domain_m`, single particles and feeds are in world axes.
With `inclination_deg = 0` both are the same.

This page is made from the tables of the program
(`python -m orchestrator.commands.case_reference`); a test keeps it true.

## Rules

- SI units; the unit ends the name of every key that has one. Degrees only where a key says `_deg`.
- **Deck axes**: x along the deck and downhill, y across, z normal to it and up. `screen.*`, its STL
  files, `bed.blocks` and the `point_m` of probes are in deck axes. `screen.inclination_deg` turns
  them about y, around the origin, into **world axes**, where gravity points down. `gravity_m_s2`,
  `domain_m`, `bed.particles` and `bed.feeds` are in world axes.
- `<name>` stands for a name of yours (letters, digits, `_`, `-`, at most 60); "ground" is the
  fixed frame.
- Levels and STL files lie in the case's folder: those that are links to elsewhere are refused.
- A key without a default must be given.

## Levels

A level overlays the case: tables are merged key by key, everything else is replaced. It may give
any key, and two of its own: `about`, a line of text, and `without`, the list of what it leaves out
of the case's physics:

| name | is left out by |
| --- | --- |
| `panel-deformation` | `panel.solver = "rigid"` |
| `panel-response`, and with particles `particle-load` | `panel.solver = "recorded"` |
| `variation-across` | `panel.solver = "strip"` |
| `frame-rotation` | `frames.solver = "two-mass"` |
| `sideways-motion` | `frames.solver = "planar"` |
| `motor-slip` | `frames.solver` "prescribed" or "two-mass" in a case with a motor |
| `frame-dynamics` | `frames.solver = "prescribed"` in a case with frames that forces move |
| `rolling-friction` | `particles.rolling = "none"` in a case with rolling friction |
| `adhesion` | `particles.adhesion = "none"` in a case with works of adhesion |
| `wear` | `particles.wear = "none"` in a case with specific wear |
| `frame-motion`, `panel-motion`, `particle-load`, `panel-reaction` | `hand_over.*` turned off |
| `particles`, `exciters`, `bushings`, `surfaces`, `gravity`, effects below | taking all away |

A level that leaves out what it does not name is refused, and so is one that names what it does not
leave out. Without `--level`, the case's `default_level` is taken, else its only level.

## --set

`--set KEY=VALUE` overlays last, as often as given, with the same rules: `--set panel.solver=rigid`,
`--set screen.panels.deck.thickness_m=0.003`, `--set 'gravity_m_s2=[0, 0, -1.6]'`. The value is
TOML; what is not TOML is taken as text. Elements of lists go by number:
`--set contacts.0.restitution=0.5`.
"""
EFFECTS_HEAD = """\
## Effects

`effects` says which effects the case has, of those that can be left out (docs/theory/effects.md):

- absent: what the case describes.
- `effects = ["frame-dynamics", "frame-motion", "panel-deformation"]`: exactly these; everything
  else that can be left out is. An effect that needs another wants it named, too. Of an effect with
  several laws a law may be named instead, which chooses it; two laws of one effect exclude each
  other. What is named must be in the case, and in its solvers unless the level says `without`.
- `effects = "auto"`: what `flipflow explain` says may be left out is left out; what matters, and
  where it cannot say, stays. What matters and the case does not have is a warning: no data are
  invented.

It may stand in the case, in a level, or be given by `--set effects=auto`. It acts by changing other
keys before the case is read; the case in a run's folder has those, and no `effects`. What is left
out, and why, is said when a run starts and in `run.log`, `summary.json` and the report.

| effect | part | can be left out | laws | what else has it or not |
| --- | --- | --- | --- | --- |"""


def reference() -> str:
    """The whole page."""
    return "\n".join([HEAD, *_effects(), *_sections(Case, "", set())]).rstrip() + "\n"


def _effects() -> Iterator[str]:
    """All that there are, by part."""
    yield EFFECTS_HEAD
    for part in get_args(Part):
        for name, effect in EFFECTS.items():
            if effect.part == part:
                left_out = "yes" if effect.optional else "no"
                laws = ", ".join(f"`{law}`" for law in effect.laws)
                yield f"| `{name}` | {part} | {left_out} | {laws} | {effect.key} |"
    yield ""


def _sections(table: type[BaseModel], path: str, seen: set[type[BaseModel]]) -> Iterator[str]:
    """This table's keys, then those of the tables in it; each table once."""
    seen.add(table)
    yield f"## `{path}`" if path else "## `case.toml`"
    yield f"\n{_text(table.__doc__)}\n"
    yield "| key | value | unit | default | meaning |\n| --- | --- | --- | --- | --- |"
    inner = []
    for key, field in table.model_fields.items():
        found, place = table_in(field.annotation)
        yield _row(key, field, found)
        if found is not None and found not in seen:
            name = f"{path.strip('[]')}.{key}{place}".lstrip(".")
            inner.append((found, f"[[{name}]]" if _is_list(field) else f"[{name}]"))
    yield ""
    for found, place in inner:
        yield from _sections(found, place, seen)


def _row(key: str, field: FieldInfo, table: type[BaseModel] | None) -> str:
    if table is not None:
        value = "tables" if get_origin(field.annotation) in (dict, tuple) else "table"
    else:
        value = _kind(field.annotation) + _limits(field)
    meaning = _text(field.description)
    return f"| `{key}` | {value} | {unit(key)} | {_default(field)} | {meaning} |"


def _text(words: str | None) -> str:
    return " ".join((words or "").split()).replace("``", "`")


def _is_list(field: FieldInfo) -> bool:
    """Whether the tables of a field are rows of a list."""
    return get_origin(field.annotation) is tuple


def unit(key: str) -> str:
    """The unit that a key's name ends with; empty without one."""
    ends = [end for end in UNITS if key.endswith(end)]
    return UNITS[max(ends, key=len)] if ends and key not in DIMENSIONLESS else ""


def table_in(kind: Any) -> tuple[type[BaseModel] | None, str]:
    """The table that a value of this type is made of, if any, and how its name goes on."""
    if isinstance(kind, type) and issubclass(kind, BaseModel):
        return kind, ""
    place = ".<name>" if get_origin(kind) is dict else ""
    for argument in get_args(kind):
        found, inner = table_in(argument)
        if found is not None:
            return found, place + inner
    return None, ""


def _kind(kind: Any) -> str:
    """A type in words."""
    origin, arguments = get_origin(kind), get_args(kind)
    if origin is Annotated:
        return _kind(arguments[0])
    if origin is Literal:
        return " or ".join(f'"{word}"' for word in arguments)
    if origin is tuple:
        if arguments[-1] is Ellipsis:
            return f"list of [{_kind(arguments[0])}]"
        return f"{len(arguments)} x {_kind(arguments[0])}"
    if NoneType in arguments:
        return " or ".join(_kind(one) for one in arguments if one is not NoneType)
    return {float: "number", int: "whole number", bool: "true or false", str: "text"}[kind]


def _limits(field: FieldInfo) -> str:
    said = {Gt: "> {0.gt}", Ge: ">= {0.ge}", Lt: "< {0.lt}", Le: "<= {0.le}"}
    marks = [*field.metadata, *_marks(field.annotation)]
    found = [said[type(mark)].format(mark) for mark in marks if type(mark) in said]
    return " " + ", ".join(dict.fromkeys(found)) if found else ""


def _marks(kind: Any) -> Iterator[Any]:
    yield from getattr(kind, "__metadata__", ())
    for argument in get_args(kind):
        yield from _marks(argument)


def _default(field: FieldInfo) -> str:
    if field.is_required():
        return "must be given"
    value = field.get_default(call_default_factory=True)
    if isinstance(value, BaseModel):
        return "see there"
    if value is None or value in ({}, ()):
        return "none"
    if isinstance(value, tuple):
        value = list(value)
    text = str(value).lower() if isinstance(value, bool) else repr(value).replace("'", '"')
    return f"`{text}`"


if __name__ == "__main__":
    sys.stdout.write(reference())
