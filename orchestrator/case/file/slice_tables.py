"""A case's tables for a slice of the width: the share ``part`` of everything extensive, and what
lies between the slice's sides ``y_m``."""

from __future__ import annotations

from typing import TypeVar

from orchestrator.case.tables.bed import Bed, Block, Feed
from orchestrator.case.tables.frames import Bushing, Exciter, Frame
from orchestrator.case.tables.quantities import Box
from orchestrator.case.tables.screen import PanelTable, Screen

Filled = TypeVar("Filled", Block, Feed)


def screen(screen: Screen, part: float, y_m: tuple[float, float]) -> Screen:
    """With frames, bushings and exciters of ``part``, and panels cut."""
    return screen.model_copy(
        update={
            "frames": {name: _frame(row, part) for name, row in screen.frames.items()},
            "bushings": {name: _bushing(row, part) for name, row in screen.bushings.items()},
            "exciters": {name: _exciter(row, part) for name, row in screen.exciters.items()},
            "panels": {name: _panel(row, y_m) for name, row in screen.panels.items()},
        }
    )


def _frame(row: Frame, part: float) -> Frame:
    update: dict[str, object] = {"products_of_inertia_kg_m2": _times(row.products_of_inertia_kg_m2, part)}
    if row.mass_kg is not None:
        update["mass_kg"] = part * row.mass_kg
    if row.inertia_kg_m2 is not None:
        update["inertia_kg_m2"] = _times(row.inertia_kg_m2, part)
    return row.model_copy(update=update)


def _bushing(row: Bushing, part: float) -> Bushing:
    update = {
        "stiffness_N_per_m": _times(row.stiffness_N_per_m, part),
        "damping_N_s_per_m": _times(row.damping_N_s_per_m, part),
    }
    return row.model_copy(update=update)


def _exciter(row: Exciter, part: float) -> Exciter:
    update: dict[str, object] = {"mass_moment_kg_m": part * row.mass_moment_kg_m}
    if row.motor is not None:
        extensive = ("rated_power_W", "moment_of_inertia_kg_m2", "bearing_loss_N_m_s")
        share = {key: part * getattr(row.motor, key) for key in extensive}
        update["motor"] = row.motor.model_copy(update=share)
    return row.model_copy(update=update)


def _panel(row: PanelTable, y_m: tuple[float, float]) -> PanelTable:
    """The part of a panel that the slice has, perforated from side to side."""
    x, _, z = row.corner_m
    corner_m = (x, y_m[0] if row.across[1] > 0 else y_m[1], z)
    update: dict[str, object] = {"corner_m": corner_m, "width_m": y_m[1] - y_m[0]}
    if row.apertures is not None:
        update["apertures"] = row.apertures.model_copy(update={"margin_across_m": 0.0})
    return row.model_copy(update=update)


def bed(bed: Bed, part: float, y_m: tuple[float, float]) -> Bed:
    """With boxes cut, ``part`` of the particles in blocks (at least one) and of feeds."""
    blocks = {
        name: _cut(row, y_m).model_copy(update={"count": max(1, round(part * row.count))})
        for name, row in bed.blocks.items()
    }
    feeds = {
        name: _cut(row, y_m).model_copy(update={"rate_kg_per_s": part * row.rate_kg_per_s})
        for name, row in bed.feeds.items()
    }
    return bed.model_copy(update={"blocks": blocks, "feeds": feeds})


def _cut(row: Filled, y_m: tuple[float, float]) -> Filled:
    return row.model_copy(update={"box_m": between(row.box_m, y_m)})


def between(box_m: Box, y_m: tuple[float, float]) -> Box:
    """The part of a box."""
    (x0, y0, z0), (x1, y1, z1) = box_m
    return (x0, max(y0, y_m[0]), z0), (x1, min(y1, y_m[1]), z1)


def _times(values: tuple[float, ...], part: float) -> tuple[float, ...]:
    return tuple(part * value for value in values)
