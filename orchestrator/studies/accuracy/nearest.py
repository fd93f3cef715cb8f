"""The error of a run by the nearest stored study of accuracy.

A study tells the error of a run of the same case and level whose physics is that of the study.  The run may
last longer or shorter, write other output, be watched by another monitor, and draw other random numbers.
"""

from __future__ import annotations

import math
import re
import shlex
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

from orchestrator.studies.accuracy.stored import StoredStudy, find_study
from orchestrator.studies.points import seed_sets
from orchestrator.workbench import Case, CaseError
from orchestrator.workbench.vocabulary import Accuracy, Basis, KnownError

NEARNESS = ("not known", "predicted", "measured")
OBSERVES = ("title", "description", "default_level", "effects_for", "duration_s", "checkpoint", "monitor")
"""Keys and tables that change neither the physics of a run nor how it is computed."""
DEFINES = "output.cut_size_m"
"""The key of the output that changes what results mean."""
SCHEME = "coupling.scheme"
SAME = 1e-6  # relative difference of values that count as equal: steps are given with a margin of rounding
Values = Mapping[str, Any]
Option = Mapping[str, Any]


def accuracy_of(case: Case, files: Iterable[Path]) -> Accuracy:
    """Return what the nearest of the studies in ``files`` says about a run of a case; the first of those that
    are equally near.

    Files of other cases and levels are passed over.
    """
    told, damaged = [], ""
    for file in files:
        try:
            study = find_study(case, file)
        except CaseError:
            continue
        assert study is not None  # a given file has a study, or is refused
        try:
            told.append(_by_study(study, case))
        except (KeyError, TypeError, ValueError, AttributeError, StopIteration) as error:
            damaged = f"; {file} is damaged: {type(error).__name__}: {error}"
    unknown = Accuracy("not known", f"no study of this case and level{damaged}")
    return max(told, key=lambda one: NEARNESS.index(one.basis), default=unknown)


def _by_study(study: StoredStudy, case: Case) -> Accuracy:
    """Return what one study says about a run of a case."""
    table, file = study.table, str(study.file)

    def unknown(why: str) -> Accuracy:
        return Accuracy("not known", why, file, table["duration_s"])

    if study.is_empty:
        return unknown(f"nothing happened in {file} that could be resolved")
    if changed := _changes_of_physics(study, case):
        return unknown(f"{file} is of the case before changes in {_names_of(changed)}")
    settings = _settings(study, case)
    if isinstance(settings, str):
        return unknown(f"{file} did not measure {settings}")
    sets = {word for one in settings for word in one["sets"]}
    point = next((one for one in table["points"] if {*shlex.split(one["sets"])} == sets), None)
    if point is not None and point["status"] == "done":
        basis: Basis = "measured"
        why, errors = "by a study of this case with these settings", _measured_errors(study, point)
    else:
        options = zip(table["options"], settings, strict=True)
        changes = "; ".join(f"{axis}: {one['label']}" for axis, one in options if one["sets"])
        why = f"by a study of this case that measured each setting alone ({changes})"
        basis, errors = "predicted", _predicted_errors(study, settings)
    if not errors:
        return unknown(f"{file} has no errors of these settings")
    return Accuracy(basis, why, file, table["duration_s"], table["reference_error"], table["chance"], errors)


def _changes_of_physics(study: StoredStudy, case: Case) -> list[str]:
    """Return the keys and files by which the case differs from the study's in more than its numerics."""
    changed = [key for key in case.changes_since(study.table["read"]) if not _observes(key)]
    if study.table.get("left_out") != case.left_out:
        changed.append("effects")
    changed += sorted(word for word in {*study.table["sets"]} ^ {*case.overrides} if _is_of_taken_bed(word))
    if changed:
        return changed
    try:
        there = case.with_sets(study.table["sets"])
    except CaseError:
        return ["what the study set"]
    return [key for key in differing(there, case) if not Case.is_numeric(key) or key == DEFINES]


def _is_of_taken_bed(overlay: str) -> bool:
    """Return whether an overlay may say from which run the particles are taken, which no value shows."""
    key = overlay.partition("=")[0].strip()
    return key in ("bed", "bed.table") or key.startswith("bed.from_")


def _settings(study: StoredStudy, case: Case) -> list[Option] | str:
    """Return the option of each axis that a case has, or the keys that no option of the study explains."""
    given, base = study.table["sets"], case.with_sets(study.table["sets"])
    differ, chosen = differing(base, case), []
    for options in study.table["options"].values():
        explained = {
            n: _explained(base, case, [*given, *one["sets"]], one, differ) for n, one in enumerate(options)
        }
        best = max(explained, key=lambda n: explained[n], default=None)
        if best is None or explained[best] < 0:
            return "all of these settings"
        chosen.append(options[best])
    joint = case.with_sets([*given, *(word for one in chosen for word in one["sets"])])
    left = differing(joint, case)
    return _names_of(left) if left else chosen


def _names_of(keys: Iterable[str]) -> str:
    """Return dotted keys in words; those of all elements of a list are one."""
    return ", ".join(dict.fromkeys(re.sub(r"(\.\d+)+$", "", key) for key in keys))


def _explained(base: Case, case: Case, sets: Sequence[str], option: Option, differ: Iterable[str]) -> int:
    """Return how many keys in which a case differs from the study's an option explains; -1 where the case
    does not have the option."""
    if not option["sets"]:
        return 0
    keys = [one.partition("=")[0].strip() for one in option["sets"]]
    if not any(_is_inside(key, other) or _is_inside(other, key) for key in keys for other in differ):
        return -1
    there = case.with_sets(sets)
    changed, apart = {*differing(base, there)}, {*differing(there, case)}
    return -1 if changed & apart or not changed else len(changed)


def differing(one: Case, other: Case) -> list[str]:
    """Return the dotted keys whose values make two cases of one folder different runs."""
    seeds = {word.partition("=")[0] for word in seed_sets(other, 1)}
    keys = dict.fromkeys((*one.values, *other.values))
    apart = [
        key
        for key in keys
        if key not in seeds and not _observes(key) and not _equal(one.values.get(key), other.values.get(key))
    ]
    if SCHEME in apart and one.scheme == other.scheme:  # one of them leaves it to the program
        apart.remove(SCHEME)
    return apart


def _observes(key: str) -> bool:
    """Return whether a key changes neither the physics of a run, nor how it is computed, nor what its results
    mean."""
    if _is_inside(key, "output"):
        return key != DEFINES
    return any(_is_inside(key, table) for table in OBSERVES)


def _is_inside(key: str, table: str) -> bool:
    return key == table or key.startswith(f"{table}.")


def _equal(one: Any, other: Any) -> bool:
    if isinstance(one, float) and isinstance(other, float):
        return math.isclose(one, other, rel_tol=SAME)
    return bool(one == other)


def _quantities(study: StoredStudy) -> Iterator[str]:
    """Yield the quantities of which the study has errors."""
    ending = "_error_half_width"
    names = {key.removesuffix(ending) for one in study.table["points"] for key in one if key.endswith(ending)}
    yield from sorted(names - {""})


def _half_width(study: StoredStudy, name: str) -> float | None:
    """Return the largest half width of a quantity's errors in the study; None where one is not known."""
    of_points = [one for one in study.table["points"] if one.get(f"{name}_error") is not None]
    widths = [one[f"{name}_error_half_width"] for one in of_points]
    return None if None in widths else max(widths, default=None)


def _measured_errors(study: StoredStudy, point: Mapping[str, Any]) -> dict[str, KnownError]:
    """Return the errors of a measured point, with what its reference is off itself."""
    is_reference, errors = point["point"] == study.table["reference"], {}
    for name in _quantities(study):
        value, width = point.get(f"{name}_error"), point.get(f"{name}_error_half_width")
        if is_reference:
            value, width = 0.0, _half_width(study, name)
        remains = _reference_remains(study, name)
        if value is not None:
            errors[name] = KnownError(value + (remains or 0.0), width, remains)
    return errors


def _reference_remains(study: StoredStudy, name: str) -> float | None:
    """Return what the study's reference is estimated to be off itself in a quantity; None if not known."""
    table = study.table
    reference = next(one for one in table["points"] if one["point"] == table["reference"])
    sets, total = {*shlex.split(reference["sets"])}, table["remaining"].get(name)
    for options in table["options"].values():
        own = [one for one in options if sets.issuperset(one["sets"])]
        best = max(own, key=lambda one: len(one["sets"]), default=None)
        if best is None or total is None or name not in best["error"]:
            return None
        total += best["error"][name]
    return None if total is None or table["reference_error"] is None else float(total)


def _predicted_errors(study: StoredStudy, settings: Sequence[Option]) -> dict[str, KnownError]:
    """Return the sums of the errors of single settings, with what remains in the finest settings.

    The errors of settings that differ from the unchanged case add their chance by squares.
    """
    changed = max(1, sum(bool(one["sets"]) for one in settings))
    errors = {}
    for name in _quantities(study):
        remains = study.table["remaining"].get(name)
        if remains is None or not all(name in one["error"] for one in settings):
            continue
        width = _half_width(study, name)
        value = remains + sum(one["error"][name] for one in settings)
        errors[name] = KnownError(value, width and math.sqrt(changed) * width, remains)
    return errors
