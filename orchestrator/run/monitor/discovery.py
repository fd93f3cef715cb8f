"""How the monitor finds its items, and what a case wants of them.

Each module in ``items/`` has one item: a quantity that a run observes.  Installed packages bring more
by an entry point of the group ``flipflow.monitor``.  Nothing else names an item: a case gives its limit in
``[monitor.items.<name>]``, and those that every case has (with a ``limit_key``) are keys of
``[monitor]`` itself.
"""

from __future__ import annotations

from importlib import import_module
from importlib.metadata import entry_points
from inspect import isclass
from pkgutil import iter_modules
from typing import NamedTuple

from orchestrator.case.file.errors import CaseProblem, did_you_mean
from orchestrator.case.tables.case import Case
from orchestrator.case.tables.numerics import MonitorSettings, Then
from orchestrator.run.monitor import items
from orchestrator.run.monitor.item import MonitorItem

GROUP = "flipflow.monitor"


class ItemLimit(NamedTuple):
    """What a case wants of an item: the limit, its key in the case, and what to do beyond it."""

    then: Then
    limit: float
    key: str


def all_items() -> dict[str, type[MonitorItem]]:
    """Returns every item by its name: those in ``items/``, then those of installed packages."""
    names = [f"{items.__name__}.{module.name}" for module in iter_modules(items.__path__)]
    classes = [kind for name in names for kind in vars(import_module(name)).values() if _is_item(kind)]
    classes += [point.load() for point in entry_points(group=GROUP)]
    return {kind.name: kind for kind in classes}


def _is_item(kind: object) -> bool:
    return isclass(kind) and issubclass(kind, MonitorItem) and kind is not MonitorItem


def item_limit(settings: MonitorSettings, kind: type[MonitorItem]) -> ItemLimit | None:
    """Returns what ``[monitor]`` wants of an item, or None for one that the case does not name."""
    if kind.limit_key:
        limit = getattr(settings, kind.limit_key)
        return ItemLimit(getattr(settings, kind.name), limit, f"monitor.{kind.limit_key}")
    wanted = settings.items.get(kind.name)
    if wanted is None:
        return None
    return ItemLimit(wanted.then, wanted.limit, f"monitor.items.{kind.name}.limit")


def unknown_items(case: Case) -> list[CaseProblem]:
    """Returns a problem for each table ``[monitor.items.<name>]`` whose item is nowhere to be found."""
    if not case.monitor.items:
        return []
    names = [name for name, kind in all_items().items() if not kind.limit_key]
    return [
        CaseProblem(
            ("monitor", "items", name),
            f'there is no item "{name}" of the monitor',
            did_you_mean(name, names) if names else "docs/how-to/add-a-monitor-item.md adds one",
        )
        for name in case.monitor.items
        if name not in names
    ]
