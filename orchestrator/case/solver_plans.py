"""The plans made from a case: plain records in world axes with everything that each solver needs.

Wherever a plan or a surface has a material's index, ``material_numbers`` defines it.
"""

from __future__ import annotations

import logging
import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.case.bed.adhesion import adhesive_step_s, planned_adhesion
from orchestrator.case.bed.contact_times import contact_moduli, shortest_rayleigh_s
from orchestrator.case.bed.grains import largest_length_m, material_numbers, shapes
from orchestrator.case.bed.push_out import push_out
from orchestrator.case.bed.sources import combine_feeds, initial_particles
from orchestrator.case.deck.panels import (
    SinglePanel,
    axes,
    planned_stops,
    single_panels,
    to_world,
    unit_vector,
)
from orchestrator.case.file.bushing_curve import elements_of
from orchestrator.case.file.characteristic import plan_of
from orchestrator.case.file.slice import hindered_share, joins_sides, period_m
from orchestrator.case.tables import frames as tables
from orchestrator.case.tables.case import Case, Material, has_particles
from orchestrator.ports import Array
from orchestrator.ports.geometry import TriangleSurface
from orchestrator.ports.plans import (
    AirPlan,
    BodyPlan,
    BushingPlan,
    DeckPlan,
    DrivePlan,
    ExciterPlan,
    ExitPlan,
    FramesPlan,
    GrainMaterial,
    HyperelasticPlan,
    HysteresisPlan,
    MeshSize,
    MotorPlan,
    PanelPlan,
    ParticleList,
    ParticlesPlan,
    PointMass,
    Rebound,
)

LOG = logging.getLogger("flipflow")


def hyperelastic(material: Material) -> HyperelasticPlan:
    """Return the plan of a panel's material."""
    law = material.hyperelastic
    assert law is not None, "checks.references refuses panels of other materials"
    return HyperelasticPlan(
        density_kg_per_m3=material.density_kg_per_m3,
        c10_Pa=law.c10_Pa,
        c01_Pa=law.c01_Pa,
        bulk_modulus_Pa=law.bulk_modulus_Pa,
        branches=tuple((branch.ratio, branch.relaxation_s) for branch in law.maxwell),
    )


def by_pair(case: Case, numbers: dict[str, int], field: str, otherwise: float = 0.0) -> Array:
    """Return a field of ``contacts`` for each pair of k materials, (k, k).

    Pairs that the case does not give have the value ``otherwise``.
    """
    table = np.full((len(numbers), len(numbers)), otherwise)
    for contact in case.contacts:
        if set(contact.between) <= set(numbers):
            one, two = (numbers[name] for name in contact.between)
            table[one, two] = table[two, one] = getattr(contact, field)
    return table


def frames_plan(case: Case, points_m: Array, carrier: tuple[str, ...], reaction_N: Array) -> FramesPlan:
    """Return the plan for the frames' solver.

    ``points_m`` (n, 3) are points in the world at t = 0, and ``carrier`` names the frame of each.
    ``reaction_N`` (n, 3) is the panels' force on them at t = 0.  The plan of a solver whose frames
    are not moved by forces contains drives, but no bushings and no exciters.
    """
    forces = case.frames.adapter.moved_by_forces
    frames = case.screen.frames
    return FramesPlan(
        bodies=tuple(_body(case, name, frame) for name, frame in frames.items()),
        bushings=tuple(bushings(case)) if forces else (),
        exciters=tuple(exciters(case)) if forces else (),
        drives=tuple(_drive(case, name, row.drive) for name, row in frames.items() if row.drive),
        gravity_m_per_s2=np.array(case.gravity_m_per_s2),
        points_m=points_m,
        carrier=carrier,
        reaction_N=reaction_N,
        drawn_at_rest=case.screen.drawn_at_rest,
        step_s=case.frames.step_s,
        sync_interval_s=case.coupling.sync_interval_s,
    )


def _body(case: Case, name: str, frame: tables.Frame) -> BodyPlan:
    """Return the plan of a frame; its mass is 0 where the case gives none, as driven frames need none."""
    tensor = np.diag(frame.inertia_kg_m2 or (0.0, 0.0, 0.0))
    upper = np.zeros((3, 3))
    upper[[0, 0, 1], [1, 2, 2]] = frame.products_of_inertia_kg_m2
    turn = axes(case)
    return BodyPlan(
        name=name,
        mass_kg=frame.mass_kg or 0.0,
        inertia_kg_m2=turn @ (tensor + upper + upper.T) @ turn.T,
        center_of_mass_m=to_world(case, frame.recorded_point_m),
    )


def bushing_axes(case: Case, row: tables.Bushing) -> Array:
    """Return the axes of a bushing in the world, (3, 3): one in each row."""
    from scipy.spatial.transform import Rotation

    return to_world(case, Rotation.from_euler("xyz", row.rotation_deg, True).as_matrix().T)


def bushings(case: Case) -> list[BushingPlan]:
    """Return the plans of all single bushings, in world axes and at their temperatures."""
    return [
        BushingPlan(
            name=name if len(row.positions_m) == 1 else f"{name}-{number + 1}",
            bodies=row.between,
            position_m=to_world(case, position),
            axes=bushing_axes(case, row),
            stiffness_N_per_m=ratio * np.array(row.stiffness_N_per_m),
            damping_N_s_per_m=ratio * np.array(row.damping_N_s_per_m),
            hysteresis=tuple(_hysteresis(row, ratio)) if case.frames.adapter.hysteresis else (),
            characteristics=tuple(
                plan_of(each, "xyz".index(axis), ratio) for each in row.characteristics for axis in each.axes
            ),
        )
        for name, row in case.screen.bushings.items()
        for ratio in (1.0 if row.temperature is None else row.temperature.ratio,)
        for number, position in enumerate(row.positions_m)
    ]


def _hysteresis(bushing: tables.Bushing, ratio: float) -> Iterator[HysteresisPlan]:
    """Yield the laws of a bushing along the axes that have a measured curve, with ``ratio`` times its
    stiffness."""
    for curve in bushing.curves:
        elements = elements_of(curve)
        (friction, slip_m), (maxwell, relaxation_s) = (
            np.array(rows, dtype=np.float64).reshape(-1, 2).T
            for rows in (elements.friction, elements.maxwell)
        )
        for axis in curve.axes:
            yield HysteresisPlan(
                axis="xyz".index(axis),
                elastic_N_per_m=ratio * elements.elastic_N_per_m,
                friction_N_per_m=ratio * friction,
                slip_m=slip_m,
                maxwell_N_per_m=ratio * maxwell,
                relaxation_s=relaxation_s,
            )


def exciters(case: Case) -> list[ExciterPlan]:
    """Return the plans of the exciters, in world axes, with motors if the frames' solver has them."""
    motors = case.frames.adapter.motors
    return [
        ExciterPlan(
            body=exciter.frame,
            position_m=to_world(case, exciter.position_m),
            axis=to_world(case, unit_vector(exciter.axis)),
            start=to_world(case, unit_vector(exciter.start)),
            mass_moment_kg_m=exciter.mass_moment_kg_m,
            speed_rad_per_s=exciter.speed_rad_per_s,
            run_up_s=exciter.run_up_s,
            phase_rad=exciter.phase_rad,
            start_s=exciter.start_s,
            stop_s=math.inf if exciter.stop_s is None else exciter.stop_s,
            run_down_s=exciter.run_down_s,
            motor=_motor(exciter.motor) if motors else None,
            name=name,
        )
        for name, exciter in case.screen.exciters.items()
    ]


def _motor(motor: tables.Motor | None) -> MotorPlan | None:
    """Return the plan of a motor; None for an exciter without a motor."""
    if motor is None:
        return None
    return MotorPlan(
        rated_power_W=motor.rated_power_W,
        synchronous_rad_per_s=motor.synchronous_speed_rad_per_s,
        rated_slip=motor.rated_slip,
        breakdown_ratio=motor.breakdown_ratio,
        inertia_kg_m2=motor.moment_of_inertia_kg_m2,
        bearing_N_m_s=motor.bearing_loss_N_m_s,
    )


def _drive(case: Case, name: str, drive: tables.Drive) -> DrivePlan:
    """Return the plan of the drive of the frame ``name``, in world axes."""
    amplitude_m, phase_rad = _turn_oscillation(case, drive.amplitude_m, drive.phase_rad)
    rotation_rad, rotation_phase_rad = _turn_oscillation(case, drive.rotation_rad, drive.rotation_phase_rad)
    return DrivePlan(
        body=name,
        center_m=to_world(case, drive.center_m or (0.0, 0.0, 0.0)),
        speed_rad_per_s=drive.speed_rad_per_s,
        amplitude_m=amplitude_m,
        phase_rad=phase_rad,
        rotation_rad=rotation_rad,
        rotation_phase_rad=rotation_phase_rad,
        run_up_s=drive.run_up_s,
    )


def _turn_oscillation(case: Case, size: Sequence[float], phase_rad: Sequence[float]) -> tuple[Array, Array]:
    """Turn the sizes (3,) and phases (3,) of an oscillation from the deck axes to the world axes."""
    phasor = axes(case) @ (np.array(size) * np.exp(1j * np.array(phase_rad)))
    return np.abs(phasor), np.angle(phasor)


def panel_plans(case: Case) -> tuple[PanelPlan, ...]:
    """Return a plan for each panel, in the order of the case."""
    return tuple(
        PanelPlan(
            name=panel.name,
            rectangle=panel.rectangle,
            frames=panel.frames,
            thickness_m=panel.table.thickness_m,
            material=hyperelastic(case.materials[panel.table.material]),
            gravity_m_per_s2=np.array(case.gravity_m_per_s2),
            cells=case.panel.cells,
            step_s=case.panel.step_s,
            integrator=case.panel.integrator,
            sync_interval_s=case.coupling.sync_interval_s,
            apertures=panel.mean_apertures,
            stops=planned_stops(case, panel),
            point_masses=sensors(case, panel),
            joined_sides=joins_sides(case, panel.rectangle.length_m),
            hindered_share=hindered_share(case, panel.rectangle),
            moulded_sag_m=panel.table.moulded_sag_m,
        )
        for panel in single_panels(case)
    )


def sensors(case: Case, panel: SinglePanel) -> tuple[PointMass, ...]:
    """Return the masses of the sensors on a panel."""
    at = panel.rectangle
    return tuple(
        PointMass(probe.at[0] * at.length_m, probe.at[1] * at.width_m, probe.sensor_kg)
        for probe in case.probes.values()
        if probe.panel == panel.name and probe.at is not None and probe.sensor_kg > 0
    )


UNKNOWNS = 3  # Each node of a mesh has so many.


def mesh_sizes(case: Case) -> dict[str, MeshSize]:
    """Return the size of each panel's mesh, by name; nothing for solvers whose meshes are small.

    Raises ValueError for openings that the solver cannot resolve.
    """
    size = case.panel.adapter.mesh_size
    return {} if size is None else {plan.name: size(plan) for plan in panel_plans(case)}


def memory_GiB(case: Case) -> float:
    """Return an estimate of the memory that all panels' meshes need; it is right within a factor of two."""
    each_GiB = case.panel.adapter.memory_GiB
    return 0.0 if each_GiB is None else sum(each_GiB(plan) for plan in panel_plans(case))


def meshes(case: Case) -> Iterator[str]:
    """Yield a line for ``flipflow check`` about each size of mesh and the number of panels that have it."""
    sizes = list(mesh_sizes(case).values())
    for size in dict.fromkeys(sizes):
        yield (
            f"  mesh       {size.cells} cells, {UNKNOWNS * size.nodes} unknowns and some "
            f"{size.memory_GiB:.2g} GiB on each of {sizes.count(size)} panels"
        )


def particles_plan(
    case: Case,
    surface: TriangleSurface,
    communicator: Any = None,
    folder: Path | None = None,
    deck: DeckPlan | None = None,
) -> ParticlesPlan | None:
    """Return the plan for the particles' solver; None for a case without particles.

    ``surface`` is the surface that particles touch; ``material_numbers`` has numbered its materials.
    ``deck`` is the deck whose contacts are counted, from ``case/deck/deck_plan.py``.
    """
    if not has_particles(case):
        return None
    numbers = material_numbers(case)
    particles = initial_particles(case)
    if case.bed.carried is not None and case.bed.push_out:
        particles = _make_room(particles, surface, case)
    cap = case.particles.largest_youngs_modulus_Pa
    return ParticlesPlan(
        surface=surface,
        materials=tuple(GrainMaterial(name, *contact_moduli(case.materials[name], cap)) for name in numbers),
        restitution=by_pair(case, numbers, "slow_restitution", 1.0),
        rebounds=_rebounds(case, numbers),
        sliding_friction=by_pair(case, numbers, "sliding_friction"),
        rolling_friction=by_pair(case, numbers, "rolling_friction") * (case.particles.rolling != "none"),
        adhesion=planned_adhesion(case, numbers),
        rolling="cdt" if case.particles.rolling == "cdt" else "epsd2",
        wear_m3_per_N_m=_wear(case, numbers),
        air=air_plan(case),
        predicts_load=case.coupling.scheme == "robin",
        shapes=shapes(case),
        particles=particles,
        largest_radius_m=largest_length_m(case) / 2,
        domain_m=np.array(case.domain_m),
        gravity_m_per_s2=np.array(case.gravity_m_per_s2),
        step_s=particle_step_s(case),
        sync_interval_s=case.coupling.sync_interval_s,
        feed=combine_feeds(case, particles),
        exits=exits(case),
        deck=deck,
        periodic_y=period_m(case) > 0,
        communicator=communicator,
        folder=folder,
    )


def _make_room(particles: ParticleList, surface: TriangleSurface, case: Case) -> ParticleList:
    """Return the particles after they were pushed out of the surface, and log how many were moved how far."""
    gravity_m_per_s2 = np.array(case.gravity_m_per_s2)
    size = float(np.linalg.norm(gravity_m_per_s2))
    up = -gravity_m_per_s2 / size if size else np.array([0.0, 0.0, 1.0])
    pushed = push_out(particles, surface.corners_m, up, period_m(case))
    moved_m = np.linalg.norm(pushed.position_m - particles.position_m, axis=1)
    if moved_m.any():
        count, mean_m = int((moved_m > 0).sum()), moved_m[moved_m > 0].mean()
        text = "bed.push_out moved %d of %d particles, by %.3g m in the mean and %.3g m at most"
        LOG.info(text, count, len(moved_m), mean_m, moved_m.max())
    return pushed


def exits(case: Case) -> tuple[ExitPlan, ...]:
    """Return the exits as boxes in the world, in the order of the case."""
    plans = []
    for name, row in case.screen.exits.items():
        low, high = np.array(row.box_m)
        center_m = to_world(case, (low + high) / 2.0)
        plans.append(ExitPlan(name, row.product, center_m, axes(case).T, (high - low) / 2.0))
    return tuple(plans)


def _rebounds(case: Case, numbers: dict[str, int]) -> tuple[Rebound, ...]:
    """Return the restitutions over speed of the pairs of k materials that have one."""
    return tuple(
        Rebound(
            (numbers[row.between[0]], numbers[row.between[1]]),
            np.array([point.impact_m_per_s for point in row.rebound]),
            np.array([point.restitution for point in row.rebound]),
        )
        for row in case.contacts
        if row.rebound and set(row.between) <= set(numbers)
    )


def _wear(case: Case, numbers: dict[str, int]) -> Array | None:
    """Return the specific wear of each pair of k materials, (k, k); None if nothing wears."""
    rate_m3_per_N_m = by_pair(case, numbers, "specific_wear_m3_per_N_m")
    return rate_m3_per_N_m if rate_m3_per_N_m.any() and case.particles.wear != "none" else None


def air_plan(case: Case) -> AirPlan | None:
    """Return the air around the particles; None without its drag.

    A coarse grain is slowed down as those for which it stands: with k times the density and k^2 times the
    viscosity, it has their Reynolds number, and k^3 times the drag of one.
    """
    if case.air is None or case.particles.air_drag == "none":
        return None
    k = case.particles.coarse_graining
    return AirPlan(k * case.air.density_kg_per_m3, k**2 * case.air.viscosity_Pa_s)


def particle_step_s(case: Case) -> float:
    """Return the largest step that the case allows its particles."""
    if case.particles.step_s > 0:
        return case.particles.step_s
    return min(
        case.particles.rayleigh_fraction * shortest_rayleigh_s(case),
        adhesive_step_s(case),
        case.coupling.sync_interval_s,
    )
