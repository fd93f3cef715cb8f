"""A screen without particles as one Exudyn system: frames and panels in one set of equations.

Nothing of the project's solvers is in it.  In the plane of x and z, frames are 2-D rigid bodies,
bushings are spring-dampers between markers, panels are ANCF cables (Gerstmayr and Irschik,
Journal of Sound and Vibration 318, 2008, 461-487, doi 10.1016/j.jsv.2008.04.019) that joints clamp
to the frames; one implicit step (generalized-alpha) is for all of them.  The cables' axial law is
linear, their damping viscous.  Frames have no weight, as bushings would hold it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import exudyn
import numpy as np

from orchestrator.case.deck.panels import SinglePanel, single_panels
from orchestrator.case.file.slice import hindered_share_of
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.frames import Bushing, Exciter
from orchestrator.ports import Array

items: Any = exudyn.itemInterface
ELEMENTS = 16


@dataclass(frozen=True)
class Histories:
    """Displacements along x and z at the times (n,): (n, 2) each, of the frames' centres by name and of the
    panels' middles."""

    time_s: Array
    frames_m: dict[str, Array]
    middles_m: list[Array]


def solved(case: Case, duration_s: float, step_s: float) -> Histories:
    """Solve from rest with the panels' weight on the machine."""
    model = Model(case)
    for bushing in case.screen.bushings.values():
        model.add_bushing(bushing)
    middles = [model.add_panel(panel) for panel in single_panels(case)]
    for exciter in case.screen.exciters.values():
        model.add_exciter(exciter)
    nodes = [*model.frames.values(), *middles]
    times_s, moved_m = _run(model.system, nodes, duration_s, step_s)
    frames_m = dict(zip(model.frames, moved_m, strict=False))
    return Histories(times_s, frames_m, moved_m[len(frames_m) :])


class Model:
    """``frames``: node numbers by name."""

    def __init__(self, case: Case) -> None:
        self.case, self.container = case, exudyn.SystemContainer()
        self.system = self.container.AddSystem()
        self.frames: dict[str, int] = {}
        self._bodies = {"ground": self.system.AddObject(items.ObjectGround())}
        self._centers_m = {"ground": np.zeros(3)}
        for name, frame in case.screen.frames.items():
            x, _, z = frame.center_of_mass_m
            node = self.system.AddNode(items.NodeRigidBody2D(referenceCoordinates=[x, z, 0.0]))
            assert frame.inertia_kg_m2 is not None
            mass = {"mass": frame.mass_kg, "inertia": frame.inertia_kg_m2[1]}
            self._bodies[name] = self.system.AddObject(items.ObjectRigidBody2D(nodeNumber=node, **mass))
            self.frames[name], self._centers_m[name] = node, np.array([x, 0.0, z])

    def add_bushing(self, bushing: Bushing) -> None:
        stiffness, damping = bushing.stiffness_N_per_m, bushing.damping_N_s_per_m
        for place_m in bushing.positions_m:
            self.system.AddObject(
                items.ObjectConnectorCartesianSpringDamper(
                    markerNumbers=[self._marker(name, place_m) for name in bushing.between],
                    stiffness=[stiffness[0], stiffness[2], 0.0],
                    damping=[damping[0], damping[2], 0.0],
                )
            )

    def add_exciter(self, exciter: Exciter) -> None:
        marker = self._marker(exciter.frame, exciter.position_m)
        self.system.AddLoad(
            items.LoadForceVector(markerNumber=marker, loadVectorUserFunction=_unbalance(exciter))
        )

    def add_panel(self, panel: SinglePanel) -> int:
        """The middle node."""
        rectangle = panel.rectangle
        nodes = [self._node(panel, n / ELEMENTS) for n in range(ELEMENTS + 1)]
        cables = [self._cable(panel, [a, b]) for a, b in pairwise(nodes)]
        element_m = rectangle.length_m / ELEMENTS
        for frame, cable, end in ((panel.frames[0], cables[0], 0), (panel.frames[1], cables[-1], 1)):
            clamp_m = rectangle.corner_m + end * rectangle.span_m * rectangle.along
            of_cable = items.MarkerBodyRigid(bodyNumber=cable, localPosition=[end * element_m, 0.0, 0.0])
            both = [self._marker(frame, clamp_m), self.system.AddMarker(of_cable)]
            joint = items.ObjectJointGeneric(markerNumbers=both, constrainedAxes=[1, 1, 0, 0, 0, 1])
            self.system.AddObject(joint)
        return nodes[ELEMENTS // 2]

    def _node(self, panel: SinglePanel, share: float) -> int:
        rectangle = panel.rectangle
        place_m = rectangle.corner_m + share * rectangle.length_m * rectangle.along
        moved_m = share * (rectangle.span_m - rectangle.length_m) * rectangle.along
        steeper = (rectangle.span_m / rectangle.length_m - 1) * rectangle.along
        reference = np.concatenate([place_m[[0, 2]], rectangle.along[[0, 2]]])
        initial = np.concatenate([moved_m[[0, 2]], steeper[[0, 2]]])
        node = items.NodePoint2DSlope1(
            referenceCoordinates=reference.tolist(), initialCoordinates=initial.tolist()
        )
        return int(self.system.AddNode(node))

    def _cable(self, panel: SinglePanel, nodes: list[int]) -> int:
        material = self.case.materials[panel.table.material]
        assert material.hyperelastic is not None
        law, thickness_m = material.hyperelastic, panel.table.thickness_m
        viscosity_s = sum(branch.ratio * branch.relaxation_s for branch in law.maxwell)
        area_m2 = panel.rectangle.width_m * thickness_m
        at = panel.rectangle
        stiffening = 1 + hindered_share_of(at.width_m / at.length_m) / 3
        axial_N = stiffening * 6 * (law.c10_Pa + law.c01_Pa) * area_m2
        bending_N_m2 = axial_N * thickness_m**2 / 12
        cable = self.system.AddObject(
            items.ObjectANCFCable2D(
                nodeNumbers=nodes,
                length=panel.rectangle.length_m / ELEMENTS,
                massPerLength=material.density_kg_per_m3 * area_m2,
                bendingStiffness=bending_N_m2,
                axialStiffness=axial_N,
                axialDamping=viscosity_s * axial_N,
                bendingDamping=viscosity_s * bending_N_m2,
                useReducedOrderIntegration=1,
            )
        )
        x, _, z = self.case.gravity_m_per_s2
        mass = self.system.AddMarker(items.MarkerBodyMass(bodyNumber=cable))
        self.system.AddLoad(items.LoadMassProportional(markerNumber=mass, loadVector=[x, z, 0.0]))
        return int(cable)

    def _marker(self, body: str, place_m: Any) -> int:
        x, _, z = np.array(place_m) - self._centers_m[body]
        at = items.MarkerBodyRigid(bodyNumber=self._bodies[body], localPosition=[x, z, 0.0])
        return int(self.system.AddMarker(at))


def _unbalance(exciter: Exciter) -> Callable[[Any, float, Any], list[float]]:
    """Minus the second derivative of  u (sin angle, cos angle),  0 while statics are solved."""
    full, run_up_s, size = exciter.speed_rad_per_s, exciter.run_up_s, exciter.mass_moment_kg_m
    rate = math.pi / run_up_s

    def force_N(system: Any, time_s: float, _: Any) -> list[float]:
        if not system.variables["turning"]:
            return [0.0, 0.0, 0.0]
        rising_s = min(time_s, run_up_s)
        angle = full * (time_s - rising_s / 2) - full / 2 * math.sin(rate * rising_s) / rate
        speed = full / 2 * (1 - math.cos(rate * rising_s))
        growth = full / 2 * rate * math.sin(rate * rising_s)
        along = speed**2 * math.sin(angle) - growth * math.cos(angle)
        up = speed**2 * math.cos(angle) + growth * math.sin(angle)
        return [size * along, size * up, 0.0]

    return force_N


def _run(system: Any, nodes: list[int], duration_s: float, step_s: float) -> tuple[Array, list[Array]]:
    displacement = {"outputVariableType": exudyn.OutputVariableType.Displacement, "storeInternal": True}
    sensors = [system.AddSensor(items.SensorNode(nodeNumber=node, **displacement)) for node in nodes]
    system.Assemble()
    settings = exudyn.SimulationSettings()
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = step_s
    settings.staticSolver.newton.relativeTolerance = 1e-10
    settings.staticSolver.verboseMode = settings.timeIntegration.verboseMode = 0
    system.variables["turning"] = False
    system.SolveStatic(settings, updateInitialValues=True)
    system.variables["turning"] = True
    settings.timeIntegration.endTime = duration_s
    settings.timeIntegration.numberOfSteps = round(duration_s / step_s)
    settings.timeIntegration.generalizedAlpha.spectralRadius = 0.9
    system.SolveDynamic(settings)
    series = [np.array(system.GetSensorStoredData(sensor)) for sensor in sensors]
    return series[0][:, 0], [each[:, 1:3] - each[0, 1:3] for each in series]
