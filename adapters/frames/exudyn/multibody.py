"""An Exudyn system of the bodies, bushings, exciters and weight of a plan."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import exudyn
import numpy as np

from adapters.frames.common import linear
from adapters.frames.common.exciter import Unbalance
from orchestrator.ports import Array
from orchestrator.ports.plans import Body, Bushing, FramesPlan

items: Any = exudyn.itemInterface
homogeneous: Any = exudyn.HT

HEAVY_kg = 1e18
"""Mass (and inertia in kg m2) put on the coordinates of a driven body: a meganewton turns it from
its path by 1e6 N (1 ms)^2 / 4 / 1e18 kg = 2.5e-19 m in a step of a millisecond."""


@dataclass(frozen=True)
class Multibody:
    """``system`` lives as long as ``container``; ``exciters``, ``forces`` and ``torques`` are
    load numbers: one per exciter, and a wrench about each body's centre of mass."""

    container: Any
    system: Any
    exciters: list[int]
    forces: list[int]
    torques: list[int]


def assembled(plan: FramesPlan, sag_m: Array) -> Multibody:
    """``sag_m`` (bushings, 3): how far each bushing is stretched along its axes as drawn."""
    container = exudyn.SystemContainer()
    system = container.AddSystem()
    ground = system.AddObject(items.ObjectGround())
    nodes = [_node(system, body) for body in plan.bodies]
    bodies = [_body(system, node, body) for node, body in zip(nodes, plan.bodies, strict=True)]
    for number in linear.driven(plan):
        system.AddObject(
            items.ObjectGenericODE2(nodeNumbers=[nodes[number]], massMatrix=HEAVY_kg * np.eye(6))
        )
    centers = [system.AddMarker(items.MarkerBodyRigid(bodyNumber=number)) for number in bodies]

    def marker(number: int, position_m: Array, axes: Array) -> int:
        """On a body or the ground (-1), with ``axes`` (rows) for its own."""
        place_m = position_m - plan.bodies[number].center_of_mass_m if number >= 0 else position_m
        body = bodies[number] if number >= 0 else ground
        pose = homogeneous(rotation=axes.T, translation=place_m)
        return int(system.AddMarker(items.MarkerBodyRigid(bodyNumber=body, localHT=pose)))

    for bushing, stretched_m in zip(plan.bushings, sag_m, strict=True):
        numbers = linear.numbers(plan, bushing.bodies)
        ends = [marker(n, bushing.position_m, bushing.axes) for n in numbers]
        _add_bushing(system, bushing, ends, stretched_m)
    for body, center in zip(plan.bodies, centers, strict=True):
        weight_N = body.mass_kg * plan.gravity_m_per_s2
        system.AddLoad(items.LoadForceVector(markerNumber=center, loadVector=weight_N))
    excited = linear.numbers(plan, tuple(exciter.body for exciter in plan.exciters))
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


def _node(system: Any, body: Body) -> int:
    """Tait-Bryan angles: their coordinates are total displacements, as ``Poses.of`` reads them."""
    place = [*body.center_of_mass_m, 0.0, 0.0, 0.0]
    return int(system.AddNode(items.NodeRigidBodyRxyz(referenceCoordinates=place)))


def _body(system: Any, node: int, body: Body) -> int:
    i = body.inertia_kg_m2
    inertia = [i[0, 0], i[1, 1], i[2, 2], i[1, 2], i[0, 2], i[0, 1]]
    return int(system.AddObject(items.ObjectRigidBody(nodeNumber=node, mass=body.mass_kg, inertia=inertia)))


def _add_bushing(system: Any, bushing: Bushing, markers: list[int], stretched_m: Array) -> None:
    stiffness, damping = np.zeros((2, 6, 6))
    np.fill_diagonal(stiffness[:3, :3], bushing.stiffness_N_per_m)
    np.fill_diagonal(damping[:3, :3], bushing.damping_N_s_per_m)
    system.AddObject(
        items.ObjectConnectorRigidBodySpringDamper(
            markerNumbers=markers, stiffness=stiffness, damping=damping, offset=[*-stretched_m, 0.0, 0.0, 0.0]
        )
    )


def _force(system: Any, marker: int, force_N: Array) -> int:
    load = items.LoadForceVector(markerNumber=marker, loadVector=force_N)
    return int(system.AddLoad(load))
