"""All forces on a frame at the recorded moments, in axes that move with the frame."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from orchestrator.case.file.errors import CaseError, CaseProblem, did_you_mean
from orchestrator.case.file.folder import FolderUnusable
from orchestrator.case.solver_plans import frames_plan
from orchestrator.output.results.run_reader import RunReader
from orchestrator.ports import Array
from orchestrator.ports.interface_records import turn

DIGITS = 12  # of places in m
GRAVITY, INERTIA, LAG, HELD = (f"{kind}/frame/1" for kind in ("gravity", "inertia", "lag", "held"))


@dataclass(frozen=True)
class FrameForces:
    """The k loads on a frame at n moments, in the deck axes that move with it.

    At t = 0 these axes, and their origin, are those of the case.  ``names`` (k,) are kind/part/number.
    ``place_m`` (k, 3) are fixed to the frame.  ``force_N`` and ``moment_N_m`` (n, k, 3) act there;
    ``center_m`` (3,) is the centre of mass.
    """

    time_s: Array
    names: tuple[str, ...]
    place_m: Array
    force_N: Array
    moment_N_m: Array
    center_m: Array

    def out_of_balance(self) -> tuple[float, float]:
        """Return the largest sum of forces, and of moments about the centre of mass, as shares of the largest
        one."""
        moment_N_m = self.moment_N_m + np.cross(self.place_m - self.center_m, self.force_N)
        forces, moments = (
            float(np.abs(each.sum(axis=1)).max() / np.abs(each).max()) for each in (self.force_N, moment_N_m)
        )
        return forces, moments


def read_forces(folder: Path, frame: str, from_s: float, to_s: float) -> FrameForces:
    """Return the loads on a frame of a run, at the recorded moments of a span in s.

    Gravity and inertia act at the centre of mass, with the accelerations of the frames' own solver.  The lag
    is the moment by which that solver's loads differ from the forces at their places.  What holds frames that
    cannot turn is the moment that is missing.  Raises CaseError for an unknown frame and a span without rows,
    and FolderUnusable for a run without such rows.
    """
    with RunReader(folder) as run:
        case, group = run.case, f"loads/{frame}"
        if frame not in case.screen.frames:
            raise _refusal("--frame", f'no frame "{frame}"; {did_you_mean(frame, list(case.screen.frames))}')
        if run.share_of_width != 1:
            raise FolderUnusable(
                f"{folder}: is the run of a slice, whose frames have only a share of the loads"
            )
        if not run.has(f"{group}/time_s"):
            why = "holds no loads of this frame; run it with --set output.loads_s=1e-3"
            raise FolderUnusable(f"{folder}: {why} (frames that a drive moves have none)")
        time_s = run.read(f"{group}/time_s")
        rows = (time_s >= from_s - 1e-9) & (time_s <= to_s + 1e-9)
        if not rows.any():
            what = (
                f"there are no rows from {from_s:g} to {to_s:g} s, but from {time_s[0]:g} to {time_s[-1]:g} s"
            )
            raise _refusal("--from-s, --to-s", what)
        # in the axes of the case, turned with the frame
        turned = Rotation.from_rotvec(run.read(f"{group}/rotation_rad")[rows]).as_matrix() @ run.deck_axes
        back = turned.swapaxes(-1, -2)
        center_m, acceleration, growth, spin, lag_N_m = (
            run.read(f"{group}/{name}")[rows]
            for name in (
                *("center_m", "acceleration_m_per_s2", "angular_acceleration_rad_per_s2"),
                *("spin_rad_per_s", "lag_N_m"),
            )
        )
        world_m, world_N = (run.read(f"{group}/{name}")[rows] for name in ("place_m", "force_N"))
        names = [str(name) for name in run.history[group].attrs["names"]]
        plan = frames_plan(case, np.empty((0, 3)), (), np.empty((0, 3)))
        deck = run.deck_axes
    body = next(each for each in plan.bodies if each.name == frame)
    drawn_m = body.center_of_mass_m @ deck
    at_m = drawn_m + turn(back[:, None], world_m - center_m[:, None])
    ends = {f"bushing/{each.name}/1": each.position_m @ deck for each in plan.bushings}
    places_m = [ends.get(name, at_m[:, k].mean(axis=0)) for k, name in enumerate(names)]
    place_m = np.array(places_m).reshape(-1, 3).round(DIGITS)
    force_N = turn(back[:, None], world_N)
    inertia_kg_m2 = deck.T @ body.inertia_kg_m2 @ deck
    spin, growth = turn(back, spin), turn(back, growth)
    turning_N_m = turn(inertia_kg_m2, growth) + np.cross(spin, turn(inertia_kg_m2, spin))
    none = np.zeros_like(spin)
    at_center = {
        GRAVITY: (body.mass_kg * turn(back, np.broadcast_to(plan.gravity_m_per_s2, spin.shape)), none),
        INERTIA: (-body.mass_kg * turn(back, acceleration), -turning_N_m),
        LAG: (none, turn(back, lag_N_m)),
    }
    moment_N_m = np.cross(at_m - place_m, force_N)
    if not case.frames.adapter.rotates:
        held_N_m = -(moment_N_m + np.cross(place_m - drawn_m, force_N)).sum(axis=1)
        at_center[HELD] = none, held_N_m
    forces, moments = (np.stack(each, axis=1) for each in zip(*at_center.values(), strict=True))
    return FrameForces(
        time_s[rows],
        (*names, *at_center),
        np.concatenate([place_m, np.tile(drawn_m, (len(at_center), 1))]),
        np.concatenate([force_N, forces], axis=1),
        np.concatenate([moment_N_m, moments], axis=1),
        drawn_m,
    )


def _refusal(option: str, what: str) -> CaseError:
    return CaseError([CaseProblem((), what, file=option)])
