"""Pictures of the bed and of wear: mass balance, partition curve, and what is along the deck."""

from __future__ import annotations

from typing import Any

import numpy as np

from orchestrator.output.report.drawing import FEED, HALF, HELD, OVER, UNDER, WIDE, embedded, figure
from orchestrator.output.report.tables import MM_IN_1000_H

FEW = 3  # sections that look well side by side


def mass_balance(results: dict[str, Any]) -> str:
    """Draws the rates in and out by cycle, and the hold-up; the cycles averaged over are shaded."""
    flows, state = results["screening"]["in_time"], results["steady"]
    whole = 1.0 / results["share_of_width"]
    drawn, ((rates, held),) = figure(1, 2, WIDE, 3.2)
    for name, colour in (("feed", FEED), ("undersize", UNDER), ("oversize", OVER)):
        rates.plot(flows["time_s"], whole * np.array(flows[f"{name}_kg_per_s"]), color=colour, label=name)
    rates.set(title="mass flow, mean of each cycle", ylabel="rate / (kg/s)")
    held.plot(flows["time_s"], whole * np.array(flows["hold_up_kg"]), color=HELD, label="hold-up")
    held.set(title="mass in the machine", ylabel="hold-up / kg")
    for axes in (rates, held):
        axes.set(xlabel="time / s", xlim=(0, flows["time_s"][-1]))
        axes.set_ylim(bottom=0)
        if state["is_steady"]:
            axes.axvspan(state["start_s"], state["end_s"], color="#c9d6e8", alpha=0.5, lw=0)
    rates.legend(loc="upper left", ncols=3, bbox_to_anchor=(0, -0.2))
    return embedded(drawn)


def partition_curve(screening: dict[str, Any]) -> str:
    """Draws the partition number over size, with the cut size, d50 and the feed's sizes behind."""
    table = screening["partition"]
    mean, number = np.array(table["mean_m"], float), np.array(table["oversize_percent"], float)
    edges = 1e3 * np.array(table["edges_m"], float)
    drawn, ((axes,),) = figure(1, 1, HALF, 3.4)
    share = table["feed_percent"]
    axes.bar(edges[:-1], share, np.diff(edges), align="edge", color="#dfe3e8", label="feed's mass")
    there = np.isfinite(number)
    axes.plot(1e3 * mean[there], number[there], "o-", color=HELD, ms=4, label="to the oversize")
    if screening["cut_size_m"]:
        axes.axvline(1e3 * screening["cut_size_m"], color=OVER, ls="--", label="cut size")
    if table["d50_m"]["value"] is not None:
        axes.plot(1e3 * table["d50_m"]["value"], 50, "D", color="#a23b72", label="d50")
    axes.set(title="partition curve", xlabel="diameter / mm", ylabel="share of mass / %")
    axes.set(ylim=(0, 105))
    axes.legend(loc="upper left", ncols=2, bbox_to_anchor=(0, -0.18))
    return embedded(drawn)


def sections(screening: dict[str, Any]) -> str:
    """Draws the cumulative and local efficiency of the sections; yields where there is no cut size."""
    rows = screening["sections"]
    drawn, ((axes,),) = figure(1, 1, HALF, 3.4)
    place = np.arange(len(rows))
    divided = "local_efficiency_percent" in rows[0]
    bars = ("local_efficiency", "yield") if divided else ("yield",)
    for number, name in enumerate(bars):
        values, errors = _bars([row[f"{name}_percent"] for row in rows])
        shift = (number - (len(bars) - 1) / 2) * 0.38
        label = {"local_efficiency": "local efficiency", "yield": "yield"}[name]
        style = {"label": label, "color": (UNDER, "#b9c3cc")[number], "error_kw": {"lw": 1}}
        axes.bar(place + shift, values, 0.36, yerr=errors, **style)
    if divided:
        values, errors = _bars([row["cumulative_efficiency_percent"] for row in rows])
        axes.errorbar(place, values, errors, fmt="o-", color=HELD, ms=4, label="efficiency up to here")
    axes.set_xticks(place, [row["exit"] for row in rows])
    axes.set(title="sections", ylabel="%", ylim=(0, 105), xlabel="section (exit)")
    axes.set_xlim(-0.6, max(len(rows), FEW) - 0.4)
    axes.grid(axis="x", visible=False)
    axes.legend(loc="upper left", ncols=3, bbox_to_anchor=(-0.05, -0.18), columnspacing=1.0)
    return embedded(drawn)


def _bars(estimates: list[dict[str, Any]]) -> tuple[list[float], list[float]]:
    values = [np.nan if e["value"] is None else e["value"] for e in estimates]
    return values, [e["half_width"] or 0.0 for e in estimates]


def along_the_deck(results: dict[str, Any]) -> str:
    """Draws bed depth, velocity, mass and, where it is counted, passing rate."""
    profile, whole = results["bed"]["profile"], 1.0 / results["share_of_width"]
    series = [
        ("depth_m", 1e3, "bed depth / mm", HELD),
        ("velocity_m_per_s", 1.0, "velocity / (m/s)", OVER),
        ("mass_kg_per_m", whole, "bed mass / (kg/m)", FEED),
    ]
    passing = results.get("transport", {}).get("passing")
    drawn, axes = figure(2, 2, WIDE, 4.8)
    for ax, (name, scale, label, colour) in zip(axes.flat, series, strict=False):
        values = np.array(profile[name], float) * scale
        ax.plot(profile["along_m"], values, "o-", ms=3, color=colour)
        ax.set(ylabel=label, xlabel="distance along the deck / m")
        if name != "velocity_m_per_s":
            ax.set_ylim(bottom=0)
    last = axes[1, 1]
    if passing is None:
        last.axis("off")
    else:
        step = passing["along_m"][1] - passing["along_m"][0]
        last.bar(passing["along_m"], whole * np.array(passing["rate_kg_per_s_m"]), 0.85 * step, color=UNDER)
        last.set(ylabel="passing rate / (kg/(s m))", xlabel="distance along the deck / m")
    return embedded(drawn)


def wear_map(wear: dict[str, Any]) -> str:
    """Draws the depth in 1000 h of all panels' patches, one panel beside the other."""
    maps = {n: MM_IN_1000_H * np.array(p["depth_m_per_h"], float) for n, p in wear["panels"].items()}
    drawn, ((axes,),) = figure(1, 1, WIDE, 2.6)
    deepest = max(float(np.nanmax(values)) for values in maps.values())
    for place, values in enumerate(maps.values()):
        edges = place + np.linspace(0.02, 0.98, len(values) + 1)
        across = np.linspace(0.0, 1.0, values.shape[1] + 1)
        shown = axes.pcolormesh(edges, across, values.T, vmin=0.0, vmax=deepest, cmap="magma_r")
    drawn.colorbar(shown, ax=axes, label="mm in 1000 h")
    axes.set_xticks(np.arange(len(maps)) + 0.5, list(maps))
    axes.set(ylabel="share of the width", title="wear, each panel from its first clamp")
    axes.grid(visible=False)
    return embedded(drawn)
