"""An Exudyn system of a plan: its bodies, the solver's steps by hand, and its driven bodies."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import exudyn
import numpy as np

from adapters.frames.common.drive import driving
from adapters.frames.exudyn.poses import turning
from orchestrator.ports import Array, Saved, linear_frames
from orchestrator.ports.plans import BodyPlan, BushingPlan, DrivePlan, FramesPlan, SolverFailed
from orchestrator.ports.unbalance import Unbalance

items: Any = exudyn.itemInterface
homogeneous: Any = exudyn.HT

HEAVY_kg = 1e18
"""Mass (and inertia in kg m2) put on the coordinates of a driven body: a meganewton turns it from
its path by 1e6 N (1 ms)^2 / 4 / 1e18 kg = 2.5e-19 m in a step of a millisecond."""

ElementForce = Callable[[int, Sequence[float]], list[float]]


@dataclass(frozen=True)
class Multibody:
    """An Exudyn system, which lives as long as ``container``.

    ``exciters``, ``forces`` and ``torques`` are numbers of loads: one load for each exciter, and a force and
    a torque at each body's centre of mass.
    """

    container: Any
    system: Any
    exciters: list[int]
    forces: list[int]
    torques: list[int]


def assemble_system(plan: FramesPlan, sag_m: Array, element_force_N: ElementForce) -> Multibody:
    """Assemble the system of ``plan``.

    ``sag_m`` (bushings, 3) is the stretch of each bushing along its axes in the drawn position.
    ``element_force_N`` returns the force that elements add to a bushing, from its number and the distance
    (3,) of its ends along its axes; Exudyn calls it only for bushings that have elements.
    """
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.AddObject(items.ObjectGround())
    nodes = [_node(system, body) for body in plan.bodies]
    bodies = [_body(system, node, body) for node, body in zip(nodes, plan.bodies, strict=True)]
    for number in linear_frames.driven(plan):
        system.AddObject(
            items.ObjectGenericODE2(nodeNumbers=[nodes[number]], massMatrix=HEAVY_kg * np.eye(6))
        )
    centers = [system.AddMarker(items.MarkerBodyRigid(bodyNumber=number)) for number in bodies]

    def marker(number: int, position_m: Array, axes: Array) -> int:
        """Add a marker on a body or the ground (-1), with ``axes`` (rows) for its own."""
        place_m = position_m - plan.bodies[number].center_of_mass_m if number >= 0 else position_m
        body = bodies[number] if number >= 0 else ground
        pose = homogeneous(rotation=axes.T, translation=place_m)
        return int(system.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localHT=pose)))

    for place, (bushing, stretched_m) in enumerate(zip(plan.bushings, sag_m, strict=True)):
        numbers = linear_frames.numbers(plan, bushing.bodies)
        ends = [marker(n, bushing.position_m, bushing.axes) for n in numbers]
        _add_bushing(system, bushing, ends, stretched_m)
        if bushing.hysteresis or bushing.characteristics:
            _add_elements(system, ends, partial(element_force_N, place))
    for body, center in zip(plan.bodies, centers, strict=True):
        weight_N = body.mass_kg * plan.gravity_m_per_s2
        system.AddLoad(items.LoadForceVector(markerNumber=center, loadVector=weight_N))
    excited = linear_frames.numbers(plan, tuple(exciter.body for exciter in plan.exciters))
    multibody = Multibody(
        container,
        system,
        [
            _force(system, marker(n, e.position_m, np.eye(3)), Unbalance(e).force_N(np.zeros(1))[0])
            for n, e in zip(excited, plan.exciters, strict=True)
        ],
        [_force(system, center, np.zeros(3)) for center in centers],
        [system.AddLoad(items.LoadTorqueVector(markerNumber=center)) for center in centers],
    )
    system.Assemble()
    return multibody


def _node(system: Any, body: BodyPlan) -> int:
    """Add a node of total displacements and Tait-Bryan angles, as ``frames/kernel`` reads its coordinates."""
    place = [*body.center_of_mass_m, 0.0, 0.0, 0.0]
    return int(system.AddNode(items.NodeRigidBodyRxyz(referenceCoordinates=place)))


def _body(system: Any, node: int, body: BodyPlan) -> int:
    i = body.inertia_kg_m2
    inertia = [i[0, 0], i[1, 1], i[2, 2], i[1, 2], i[0, 2], i[0, 1]]
    return int(system.AddObject(items.ObjectRigidBody(nodeNumber=node, mass=body.mass_kg, inertia=inertia)))


def _add_bushing(system: Any, bushing: BushingPlan, markers: list[int], stretched_m: Array) -> None:
    stiffness, damping = np.zeros((2, 6, 6))
    np.fill_diagonal(stiffness[:3, :3], bushing.stiffness_N_per_m)
    np.fill_diagonal(damping[:3, :3], bushing.damping_N_s_per_m)
    system.AddObject(
        items.ObjectConnectorRigidBodySpringDamper(
            markerNumbers=markers, stiffness=stiffness, damping=damping, offset=[*-stretched_m, 0.0, 0.0, 0.0]
        )
    )


def _add_elements(system: Any, markers: list[int], force_N: Callable[[Sequence[float]], list[float]]) -> None:
    """Add a connector whose force on the markers depends on their distance as ``force_N`` says."""

    def force_and_torque(
        _system: Any, _time_s: float, _item: int, apart_m: Any, *_others: Any
    ) -> list[float]:
        return [*force_N(apart_m), 0.0, 0.0, 0.0]

    system.AddObject(
        items.ObjectConnectorRigidBodySpringDamper(
            markerNumbers=markers, springForceTorqueUserFunction=force_and_torque
        )
    )


def _force(system: Any, marker: int, force_N: Array) -> int:
    load = items.LoadForceVector(markerNumber=marker, loadVector=force_N)
    return int(system.AddLoad(load))


def settings(plan: FramesPlan, elements_N_per_m: float) -> Any:
    """Return settings for steps that are made by hand.

    A machine at rest has no larger residual than the rounding of all its bushings' forces.
    ``elements_N_per_m`` is the stiffness of all elements.
    """
    stiffness_N_per_m = sum(float(bushing.stiffness_N_per_m.sum()) for bushing in plan.bushings)
    stiffness_N_per_m += elements_N_per_m
    chosen = exudyn.SimulationSettings()
    chosen.solution.file.write = False
    time = chosen.timeIntegration
    time.endTime, time.numberOfSteps = 1e9, 10**12  # steps are made by hand, without end
    time.adaptiveStep = False
    time.generalizedAlpha.useNewmark = True
    time.newton.relativeTolerance = 1e-13
    time.newton.absoluteTolerance = max(1e-10, 1e-15 * stiffness_N_per_m)
    return chosen


def open_solver(system: Any, settings: Any) -> Any:
    """Open a solver of ``system`` at t = 0."""
    solver: Any = exudyn.MainSolverImplicitSecondOrder()
    if not solver.InitializeSolver(system, settings):
        raise SolverFailed(f"exudyn at 0 s: no start: {solver.GetErrorString()}")
    return solver


def start_interval(solver: Any, step_s: float) -> None:
    """Set the step's length and ask for a new Jacobian.

    Newton's method would keep its first Jacobian for the whole run, and the last bits would depend on the
    start of the run.  A new Jacobian in each interval halves the iterations and costs as much as it saves.
    """
    solver.it.currentStepSize = step_s
    solver.conv.jacobianUpdateRequested = True


def save_system(system: Any, solver: Any) -> Saved:
    """Save the state from which the next step goes on.

    With ``useNewmark`` a step takes from the step before, besides the system's coordinates, only the
    accelerations; algorithmic accelerations, which Exudyn gives out but does not take back, play no part
    (measured: without it the next steps of a restored solver differ by 1e-4).
    """
    data, at = system.systemData, solver.it
    coordinates = {str(n): np.array(part) for n, part in enumerate(data.GetSystemState())}
    return {
        "coordinates": coordinates,
        "accelerations": np.array(data.GetODE2Coordinates_tt()),
        "time_s": np.array([data.GetTime(), at.currentTime]),
    }


def restore_system(system: Any, solver: Any, saved: Saved) -> None:
    """Restore the state that ``save_system`` saved, so that a solver goes on from it."""
    data, at = system.systemData, solver.it
    coordinates = saved["coordinates"]
    data.SetSystemState([coordinates[str(n)] for n in range(len(coordinates))])
    data.SetODE2Coordinates_tt(saved["accelerations"])
    time_s, at.currentTime = map(float, saved["time_s"])
    data.SetTime(time_s)


def largest_step_s(plan: FramesPlan, machine: linear_frames.LinearMachine) -> float:
    """Return ``plan.step_s`` or, where it is 0, 0.05 over the fastest rate, and no longer than the
    interval."""
    speeds = [exciter.speed_rad_per_s for exciter in plan.exciters]
    speeds += [drive.speed_rad_per_s for drive in plan.drives]
    fastest = max([machine.fastest_rad_per_s(), *speeds])
    own_s = 0.05 / fastest if fastest > 0 else math.inf
    return plan.step_s if plan.step_s > 0 else min(own_s, plan.sync_interval_s)


class Driven:
    """A driven body among free ones, number ``body``, steered so that every step ends where its drive says.

    A trapezoidal step evaluates forces at its end only (those of its start are in the stored accelerations).
    So a driven body may start each step wherever it takes to *coast*, without acceleration, into its exact
    position with its exact velocity; and it is made so heavy that nothing turns it from that path
    (``HEAVY_kg``).  The motion that bushings and their dampers see is then the drive's motion to rounding,
    and no constraint has to be solved.

    Raises ValueError if the rotation vector could grow beyond ``largest_tilt_rad``, where the rotation angles
    end.
    """

    def __init__(self, number: int, body: BodyPlan, drive: DrivePlan, largest_tilt_rad: float) -> None:
        self.body, self._drive = number, drive
        self._drawn_m = body.center_of_mass_m
        largest_rad = float(np.linalg.norm(drive.rotation_rad))
        if largest_rad > largest_tilt_rad:
            raise ValueError(
                f"the drive of {drive.body!r} may turn it by {largest_rad:.3g} rad; the limit is "
                f"{largest_tilt_rad:g} rad"
            )

    def coordinates(self, time_s: float) -> tuple[Array, Array]:
        """Return displacement of the centre of mass with Tait-Bryan angles, and their rates: (6,) each,
        as ``frames/kernel`` reads them."""
        now = driving(self._drive, time_s)
        position_m, velocity_m_per_s = now.carried((self._drawn_m - self._drive.center_m)[None])
        angles_rad = now.rotation.as_euler("XYZ")
        axes = turning(angles_rad[None])[1][0]
        rates_rad_per_s = np.linalg.solve(axes, now.spin_rad_per_s)
        place = np.concatenate([position_m[0] - self._drawn_m, angles_rad])
        return place, np.concatenate([velocity_m_per_s[0], rates_rad_per_s])

    def steer(self, data: Any, step_s: float, end_s: float) -> None:
        """Put the body, in Exudyn's system data, where the coming step starts for it."""
        place, rate = self.coordinates(end_s)
        for get, put, value in (
            (data.GetODE2Coordinates, data.SetODE2Coordinates, place - step_s * rate),
            (data.GetODE2Coordinates_t, data.SetODE2Coordinates_t, rate),
            (data.GetODE2Coordinates_tt, data.SetODE2Coordinates_tt, 0.0),
        ):
            coordinates = get()
            coordinates[6 * self.body : 6 * self.body + 6] = value
            put(coordinates)


def place_at_start(data: Any, every: Sequence[Driven], bodies: int) -> None:
    """Place driven bodies at t = 0, by the initial values from which Exudyn finds the first accelerations."""
    places, rates = np.zeros((2, bodies, 6))
    for driven in every:
        places[driven.body], rates[driven.body] = driven.coordinates(0.0)
    data.SetODE2Coordinates(places.ravel(), exudyn.ConfigurationType.Initial)
    data.SetODE2Coordinates_t(rates.ravel(), exudyn.ConfigurationType.Initial)
