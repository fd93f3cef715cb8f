"""The step that reads the particles with which a case begins from a run or from a table.

A run has recorded its particles in two ways: ``bed.h5`` in each checkpoint has them in full precision,
and the ParaView files of the output times have them in single precision.  Places, velocities, spins,
sizes, shapes and materials are taken over.  Tangential springs of contacts are not: they start anew.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
from pydantic import ValidationError

from orchestrator.case.bed import saved_bed
from orchestrator.case.bed.bed_table import read_table
from orchestrator.case.bed.grains import material_numbers, shapes
from orchestrator.case.bed.saved_bed import BED, UnreadableBed
from orchestrator.case.file.coarse import coarsen
from orchestrator.case.file.errors import CaseError, CaseProblem, Key, did_you_mean
from orchestrator.case.file.folder import FolderUnusable, UnreadableFile, admit, part_of, read_json
from orchestrator.case.file.layers import read_toml
from orchestrator.case.file.slice import bounds_m, cut_to_slice, period_m
from orchestrator.case.tables.carried_bed import CarriedBed
from orchestrator.case.tables.case import Case
from orchestrator.ports import Array
from orchestrator.ports.grains import ShapeTable

CHECKPOINTS, SERIES = "checkpoints", "particles.pvd"
SUMMARY, TRUSTED = "summary.json", ("done", "incomplete")  # a run that is incomplete lacks results alone
SAME = 1e-9  # times with a smaller relative difference are one time


@dataclass(frozen=True)
class RecordedState:
    """A state of a run's particles: its time and its file, exact in a checkpoint's ``bed.h5``."""

    time_s: float
    file: Path

    @property
    def is_exact(self) -> bool:
        """True if the file has the particles in full precision."""
        return self.file.name == BED


def carry_bed(case: Case, folder: Path) -> Case:
    """Return the case with the particles that ``[bed]`` takes over; without any, the case itself.

    ``folder`` is the folder of the case.  Raises CaseError with every reason why they cannot be taken over.
    """
    bed = case.bed
    if not bed.is_carried:
        if bed.from_time_s is not None:
            raise CaseError(
                [
                    CaseProblem(
                        ("bed", "from_time_s"),
                        "has no effect without bed.from_run",
                        "add that, or remove this key",
                    )
                ]
            )
        return case
    if bed.from_run is not None and bed.table is not None:
        raise CaseError([CaseProblem(("bed", "table"), "contradicts bed.from_run", "give one of them")])
    key: Key = ("bed", "from_run" if bed.from_run is not None else "table")
    try:
        found = _find_particles(case, folder)
    except UnreadableBed as error:
        raise CaseError([CaseProblem(key, str(error), kind="file")]) from None
    if not len(found):
        raise CaseError([CaseProblem(key, f"{found.source} has no particles", kind="file")])
    if unfit := (*_unfit(case, found),):
        stand_ins = _stand_ins(case, found)
        if stand_ins is None:
            raise CaseError([CaseProblem(key, *problem) for problem in unfit])
        found = replace(found, materials=stand_ins, unfit=unfit)
    return case.model_copy(update={"bed": bed.with_carried(_as_wanted(case, found))})


def _find_particles(case: Case, folder: Path) -> CarriedBed:
    """Return the particles that the table ``[bed]`` names.  Raises UnreadableBed."""
    bed = case.bed
    if bed.from_run is not None:
        run = _locate(bed.from_run, folder)
        found = read_run(run, bed.from_time_s)
        status, doubt = _status(run)
        if status == "failed" and bed.from_time_s is None:
            raise UnreadableBed(f"{doubt}; bed.from_time_s takes a state from before it failed")
        return replace(found, doubt=doubt)
    assert bed.table is not None
    if bed.from_time_s is not None:
        raise UnreadableBed("a table has no times: bed.from_time_s belongs to bed.from_run")
    path = _locate(bed.table, folder)
    return saved_bed.read(path) if path.suffix == ".h5" else read_table(path, case)


def _status(run: Path) -> tuple[str, str]:
    """Return how a run ended, by its summary, and in words what that says against its particles."""
    try:
        summary = read_json(run / SUMMARY)
        status, reasons = str(summary["status"]), [summary["reason"], *summary["doubts"]]
    except FileNotFoundError:
        status, reasons = "not at its end", []
    except (OSError, UnreadableFile, ValueError, KeyError, TypeError):
        status, reasons = "without a readable summary", []
    if status in TRUSTED:
        return status, ""
    why = next((str(reason).rstrip(".") for reason in reasons if reason), "")
    return status, f"the run {run} is {status}{f': {why}' if why else ''}"


def _locate(name: str, folder: Path) -> Path:
    """Return the file or folder of this name, seen from a case's ``folder`` or from the working directory.

    Raises UnreadableBed if there is none.
    """
    for place in (folder / name, Path(name)):
        with suppress(OSError):  # a folder on the way that this user may not enter
            if place.exists():
                return place
    raise UnreadableBed(f'there is no "{name}", neither in {folder} nor in the working directory')


def read_run(run: Path, time_s: float | None) -> CarriedBed:
    """Read the particles of a run, at the recorded time that is nearest to ``time_s``; None takes the last.

    Those of a slice with periodic sides are between these.  Raises UnreadableBed.
    """
    states = sorted(_recorded_states(run), key=lambda state: (state.time_s, state.is_exact))
    if not states:
        raise UnreadableBed(f"{run}: has no recorded particles, neither checkpoints nor {SERIES}")
    end_s = states[-1].time_s
    if time_s is None:
        return _between_sides(_read_state(run, states[-1]), run)
    if time_s > end_s * (1 + SAME):
        raise UnreadableBed(f"{run}: ends at t = {end_s:g} s, before bed.from_time_s = {time_s:g} s")
    away_s = min(abs(state.time_s - time_s) for state in states)
    nearest = [state for state in states if abs(state.time_s - time_s) <= away_s + SAME * end_s]
    return _between_sides(_read_state(run, nearest[-1]), run)


def _between_sides(found: CarriedBed, run: Path) -> CarriedBed:
    """Return the particles of a run with periodic sides between these; of another run, as they are.

    A solver wraps particles only when it looks for neighbours anew, so that a state has some beyond a side.
    """
    try:
        case = Case.model_validate(read_toml(run / "case.toml"))
        if not period_m(case):
            return found
        first_m, last_m = bounds_m(case)
    except (ValidationError, CaseError):
        return found  # the sides of a case of another version are not known
    place_m = found.position_m.copy()
    y_m = place_m[:, 1]
    beyond = (y_m < first_m) | (y_m > last_m)
    y_m[beyond] = first_m + (y_m[beyond] - first_m) % (last_m - first_m)
    return replace(found, position_m=place_m)


def _recorded_states(run: Path) -> Iterator[RecordedState]:
    """Yield the states of a run that can be read.  Raises UnreadableBed for what is no folder of a run."""
    if not (run / "case.toml").is_file() or not (run / "provenance.json").is_file():
        raise UnreadableBed(f"{run}: is not the folder of a run")
    try:
        admit(run)
    except FolderUnusable as error:
        raise UnreadableBed(str(error)) from None
    for file in run.glob(f"{CHECKPOINTS}/[0-9]*/{BED}"):
        if (time_s := saved_bed.read_time_s(file)) is not None:
            yield RecordedState(time_s, file)
    if (run / SERIES).is_file():
        try:
            rows = [row.attrib for row in ElementTree.parse(run / SERIES).iter("DataSet")]
            yield from [RecordedState(float(row["timestep"]), part_of(run, row["file"])) for row in rows]
        except (OSError, ValueError, KeyError, ElementTree.ParseError) as error:
            raise UnreadableBed(f"{run / SERIES}: cannot be read ({error})") from None


def _read_state(run: Path, state: RecordedState) -> CarriedBed:
    """Read the particles of a recorded state.  Raises UnreadableBed."""
    if state.is_exact:
        return saved_bed.read(state.file)
    import meshio  # It is imported here because most cases take nothing over.

    case = _case_of_run(run)
    by_number = sorted(numbers := material_numbers(case), key=lambda name: numbers[name])
    try:
        mesh = meshio.read(state.file)
        data = {name: np.asarray(values, dtype=float) for name, values in mesh.point_data.items()}
        kinds = {name: data[name].astype(np.int64) for name in ("material", "shape")}
        bed = CarriedBed(
            materials=tuple(by_number),
            position_m=np.asarray(mesh.points, dtype=float),
            velocity_m_per_s=data["velocity_m_per_s"].reshape(-1, 3),
            spin_rad_per_s=data["spin_rad_per_s"].reshape(-1, 3),
            orientation=_unit(data["orientation"].reshape(-1, 4)),
            grains=saved_bed.grains_of(data | kinds, ShapeTable.of(shapes(case))),
            time_s=state.time_s,
            coarse_graining=case.particles.coarse_graining,
            source=str(state.file),
        )
    except IndexError:  # which meshio raises for a file without points
        raise UnreadableBed(f"{state.file}: there are no particles at that time") from None
    except SystemExit:  # by which meshio ends the program for a file that it does not understand
        raise UnreadableBed(f"{state.file}: cannot be read: is it whole?") from None
    except (OSError, KeyError, ValueError, meshio.ReadError) as error:
        raise UnreadableBed(f"{state.file}: cannot be read ({error})") from None
    return saved_bed.keep_used_materials(bed)


def _unit(quaternions: Array) -> Array:
    """Return quaternions (n, 4), which were recorded in single precision, of length 1."""
    return np.asarray(quaternions / np.linalg.norm(quaternions, axis=1, keepdims=True))


def _case_of_run(run: Path) -> Case:
    """Return a run's case with the particles that it began with, which decide about the materials' numbers.

    Raises UnreadableBed.
    """
    try:
        case = Case.model_validate(read_toml(run / "case.toml"))
    except (ValidationError, CaseError) as error:
        first = str(error).splitlines()[-1].strip()
        raise UnreadableBed(f"{run}: its case is not one of this flipflow's ({first})") from None
    if case.bed.table is None:
        return case
    begun = case.model_copy(update={"bed": case.bed.with_carried(saved_bed.read(run / BED))})
    return leave_out_outside(cut_to_slice(coarsen(begun)))


def _unfit(case: Case, found: CarriedBed) -> Iterator[tuple[str, str]]:
    """Yield what is wrong, and what helps, of materials that the case lacks and of other coarseness."""
    for number, name in enumerate(found.materials):
        if name not in case.materials:
            count = int((found.grains.material == number).sum())
            what = f'{count} particles of {found.source} are of "{name}", which the case does not have'
            yield what, did_you_mean(name, case.materials)
    own = case.particles.coarse_graining
    if not math.isnan(found.coarse_graining) and found.coarse_graining != own:
        what = f"its particles have a coarse graining of {found.coarse_graining:g}, those of the case {own:g}"
        yield what, f"take particles.coarse_graining = {found.coarse_graining:g}"


def _stand_ins(case: Case, found: CarriedBed) -> tuple[str, ...] | None:
    """Return the materials of the particles, and for each that the case lacks one of its grains' materials.

    The result is None if no grains of the case are known.
    """
    grains = [name for name in found.materials if name in case.materials]
    grains += [row.material for row in (*case.bed.particles.values(), *case.bed.sources)]
    known = [name for name in grains if name in case.materials]
    if not known:
        return None
    return tuple(name if name in case.materials else known[0] for name in found.materials)


def leave_out_outside(case: Case) -> Case:
    """Return the case without the carried particles outside of its domain or slice, if ``bed.outside`` wants
    it.  Raises CaseError if none is left.
    """
    carried = case.bed.carried
    if carried is None or case.bed.outside == "refuse":
        return case
    low, high = np.array(case.domain_m)
    if case.slice is not None:
        y_m = bounds_m(case.whole_machine)
        low[1], high[1] = max(low[1], y_m[0]), min(high[1], y_m[1])
    inside = ((carried.position_m >= low) & (carried.position_m <= high)).all(axis=1)
    if not inside.any():
        what = f"all {len(carried)} particles of {carried.source} are outside domain_m"
        raise CaseError([CaseProblem(("bed", "outside"), what, kind="misplaced")])
    left = case.bed.with_carried(saved_bed.keep_used_materials(carried.part(inside)))
    if case.original is case:
        return case.computed_with({"bed": left})
    return case.model_copy(update={"bed": left})


def _as_wanted(case: Case, found: CarriedBed) -> CarriedBed:
    """Return the particles with the velocities that ``[bed]`` wants."""
    if case.bed.velocities == "keep":
        return found
    at_rest = np.zeros_like(found.velocity_m_per_s)
    return replace(found, velocity_m_per_s=at_rest, spin_rad_per_s=at_rest.copy())
