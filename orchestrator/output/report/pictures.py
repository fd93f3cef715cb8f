"""The pictures of a run: of its machine, for the page and as files, and of its results, for the page.

``python -m orchestrator.output.report.pictures RUN`` writes the files.  It runs in a process of its
own: the libraries of the renderer then share no memory with the solvers, and a picture that fails loses
nothing else.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib import colormaps
from matplotlib.cm import ScalarMappable
from matplotlib.colors import ListedColormap
from scipy.integrate import trapezoid

from orchestrator.case.deck.panels import single_panels
from orchestrator.case.file.folder import admit
from orchestrator.figures.estimate import Estimate
from orchestrator.figures.machine import Course, PanelWear
from orchestrator.figures.material import (
    Contacts,
    FlowsInTime,
    Partition,
    Passing,
    Profile,
    Screening,
    Section,
    Steady,
)
from orchestrator.figures.results import FIGURES, Results
from orchestrator.output.results.run_reader import RunReader
from orchestrator.views.style import FEED, HALF, HELD, OVER, UNDER, WIDE, figure, save
from orchestrator.views.worker import worker

COLUMNS = 4  # panels or bushings side by side
LOWEST = 3.8  # inches: least height, at which a single row of panels is legible
MOMENTS = 8  # of a cycle
PROGRESS = ListedColormap(colormaps["viridis"](np.linspace(0.0, 0.9, 256)))  # without pale colours
INSTANTS = 4  # of a cycle, for panels with probes
FEWEST_PROBES = 3  # on a panel or on frames, for a picture of their motion
MM_IN_1000_H = 1e6  # 1 m/h
MOST_POINTS = 4000  # of a line
FEWEST_SECTIONS = 3  # least width of the axes in sections, so that bars do not become too wide
LABEL_GAP = 4  # pixels: least distance of labels side by side
SMALLEST_SHARE = 1e-3  # of the largest term of a picture: smaller ones are left out


def draw_frames(run: RunReader) -> Any:
    """Draw the displacements of the frames' centres of mass along and normal to the deck, and their orbits.

    The displacements are drawn over the whole run, the orbits over the last cycle.
    """
    fig, axes = figure(2, 2, WIDE, 5.0, width_ratios=(2, 1))
    for row in axes:
        row[1].remove()
    orbit = fig.add_subplot(axes[0, 1].get_gridspec()[:, 1])
    for name in run.names("frames"):
        time_s = run.read(f"frames/{name}/time_s")
        moved_mm = 1e3 * run.read(f"frames/{name}/displacement_m") @ run.deck_axes
        stride = max(len(moved_mm) // MOST_POINTS, 1)
        for series, axis in ((axes[0, 0], 0), (axes[1, 0], 2)):
            series.plot(time_s[::stride], moved_mm[::stride, axis], lw=0.8, label=name)
        last_mm = moved_mm[time_s > time_s[-1] - run.cycle_s]
        last_mm = last_mm - (last_mm.max(axis=0) + last_mm.min(axis=0)) / 2
        orbit.plot(last_mm[:, 0], last_mm[:, 2], lw=1)
    axes[0, 0].set(ylabel="along / mm", title="frames' centres of mass")
    axes[1, 0].set(ylabel="normal / mm", xlabel="time / s")
    axes[1, 0].legend(loc="upper left", ncols=3, bbox_to_anchor=(0, -0.25))
    orbit.set(xlabel="along the deck / mm", ylabel="normal to the deck / mm", title="orbits, last cycle")
    orbit.set_aspect("equal", "datalim")
    return fig


def draw_panel_shapes(run: RunReader) -> Any:
    """Draw the centre lines of the panels at moments of the last cycle, or of the whole run without a drive.

    Heights are over the straight line between the panels' ends as built.
    """
    panels = {panel.name: panel.rectangle for panel in single_panels(run.case)}
    fig, axes = _grid(len(panels), "height / mm, enlarged", 0.6, 2.3)
    for ax, (name, at) in zip(axes.flat, panels.items(), strict=False):
        time_s = run.read(f"panels/{name}/time_s")
        lines_m = run.read(f"panels/{name}/centre_line_m") - at.corner_m
        span_s = 15 / 16 * run.cycle_s if run.is_driven else np.inf  # each phase once
        last = np.flatnonzero(time_s > time_s[-1] - span_s)
        for number in last[np.linspace(0, len(last) - 1, min(MOMENTS, len(last))).astype(int)]:
            phase = time_s[number] / run.cycle_s % 1.0 if run.is_driven else time_s[number] / time_s[-1]
            line_mm = 1e3 * lines_m[number]
            ax.plot(line_mm @ at.along, line_mm @ at.normal, lw=1.1, color=PROGRESS(phase))
        ax.set(title=name, xlabel="along / mm")
    fig.colorbar(
        ScalarMappable(cmap=PROGRESS),
        ax=axes,
        label="share of the cycle" if run.is_driven else "share of the run",
    )
    return fig


def draw_panel_instants(run: RunReader, panels: Mapping[str, Sequence[str]]) -> Any:
    """Draw panels with the probes on them at four instants of the last cycle, a quarter of a cycle apart.

    ``panels`` has the names of the probes on each panel.  Heights are over the straight line between the
    panel's ends as built.
    """
    rectangles = {panel.name: panel.rectangle for panel in single_panels(run.case)}
    fig, axes = _grid(len(panels) * INSTANTS, "height / mm", 0.6, 2.3)
    for number, (name, probes) in enumerate(panels.items()):
        at, time_s = rectangles[name], run.read(f"panels/{name}/time_s")
        of_panel = axes.flat[number * INSTANTS : (number + 1) * INSTANTS]
        for instant, ax in enumerate(of_panel):
            wanted_s = run.end_s - (INSTANTS - 1 - instant) / INSTANTS * run.cycle_s
            row = int(np.abs(time_s - wanted_s).argmin())
            line_mm = 1e3 * (run.read(f"panels/{name}/centre_line_m")[row] - at.corner_m)
            ax.plot(line_mm @ at.along, line_mm @ at.normal, lw=1.2, color=HELD)
            points_s = run.read(f"probes/{probes[0]}/time_s")
            near = int(np.abs(points_s - time_s[row]).argmin())
            points_m = np.array([run.read(f"probes/{probe}/position_m")[near] for probe in probes])
            points_mm = 1e3 * (points_m - at.corner_m)
            ax.plot(points_mm @ at.along, points_mm @ at.normal, "o", ms=3.5, color=OVER)
            ax.set(title=f"{name}, t = {time_s[row]:.4f} s", xlabel="along / mm")
        lows_mm, highs_mm = zip(*(ax.get_ylim() for ax in of_panel), strict=True)
        for ax in of_panel:
            ax.set_ylim(min(lows_mm), max(highs_mm))
    return fig


def draw_point_orbits(run: RunReader, probes: Sequence[str]) -> Any:
    """Draw the orbits of probes on frames in the last cycle, along and normal to the deck."""
    fig, axes = _grid(len(probes), "normal / mm", 0.6, 2.6)
    for ax, name in zip(axes.flat, probes, strict=False):
        time_s = run.read(f"probes/{name}/time_s")
        last = time_s > time_s[-1] - run.cycle_s
        moved_mm = 1e3 * run.read(f"probes/{name}/position_m")[last] @ run.deck_axes
        moved_mm = moved_mm - (moved_mm.max(axis=0) + moved_mm.min(axis=0)) / 2
        ax.plot(moved_mm[:, 0], moved_mm[:, 2], lw=1)
        ax.plot(moved_mm[:1, 0], moved_mm[:1, 2], "o", ms=3.5)
        ax.set(title=f"{name} ({run.case.probes[name].frame})", xlabel="along / mm")
        ax.set_aspect("equal", "datalim")
    return fig


def draw_bushing_loops(run: RunReader) -> Any:
    """Draw the force over the deformation of every bushing in the last cycle, along its most deformed axis.

    The area of a loop is the energy lost in the cycle.  A bushing of a slice has its share of the force and
    of the loss; those of the whole machine's bushing are drawn.
    """
    names, part = run.names("bushings"), run.share_of_width
    ylabel = "force / kN" if part == 1.0 else "force / kN, of the whole width"
    fig, axes = _grid(len(names), ylabel, 1.0, 2.8)
    for ax, name in zip(axes.flat, names, strict=False):
        end_s = float(run.read(f"bushings/{name}/time_s")[-1])
        deformation_m, force_N = (
            run.read_between(f"bushings/{name}", what, end_s - run.cycle_s, end_s)
            for what in ("deformation_m", "force_N")
        )
        axis = int(np.ptp(deformation_m, axis=0).argmax())
        x, y = 1e3 * deformation_m[:, axis], 1e-3 * force_N[:, axis] / part
        ax.plot(x, y, lw=1.2)
        ax.set(title=f"{name}, {'xyz'[axis]}: {abs(trapezoid(y, x)):.3g} J", xlabel="deformation / mm")
    return fig


def draw_energy(run: RunReader) -> Any:
    """Draw the energy ledger in three parts: energy in and out, stored energy, and terms that should be zero.

    Terms below a thousandth of the largest term of a part are left out.  Those of a slice are of the slice.
    """
    ylabel = "energy / J" if run.share_of_width == 1.0 else "energy of the slice / J"
    time_s = run.read("energy/time_s")
    terms_J = {name: run.read(f"energy/{name}") for name in run.names("energy") if name != "time_s"}
    parts = {
        "supplied and lost since t = 0": ("supplied.", "lost."),
        "change of what is stored": ("stored.",),
        "out of nothing: should be small": ("created.", "defect."),
    }
    fig, (row,) = figure(1, 3, WIDE, 3.8)
    for ax, (title, books) in zip(row, parts.items(), strict=True):
        sizes_J = {name: float(np.abs(v).max()) for name, v in terms_J.items() if name.startswith(books)}
        for name in sorted(sizes_J, key=lambda name: -sizes_J[name])[:8]:
            if sizes_J[name] >= SMALLEST_SHARE * max(sizes_J.values()):
                ax.plot(time_s, terms_J[name], lw=1.2, label=name.removesuffix("_J").removeprefix("stored."))
        ax.set(title=title, xlabel="time / s", ylabel=ylabel)
        ax.legend(loc="upper left", bbox_to_anchor=(0, -0.2), fontsize=7.5)
    return fig


def draw_cost(wall_by_part_s: dict[str, float]) -> Any:
    """Draw the wall time of every part of the program."""
    fig, ((axes,),) = figure(1, 1, HALF, 2.6)
    parts = list(wall_by_part_s)[::-1]
    seconds = [wall_by_part_s[part] for part in parts]
    bars = axes.barh(parts, seconds, color=HELD)
    whole = sum(seconds) or 1.0
    axes.bar_label(bars, [f" {100 * s / whole:.0f} %" for s in seconds], fontsize=9)
    axes.set(title="where the time went", xlabel="wall time / s", xlim=(0, 1.15 * max(seconds)))
    axes.grid(axis="y", visible=False)
    return fig


def draw_balance(flows: FlowsInTime, state: Steady | None) -> Any:
    """Draw the mass rates in and out and the hold-up by cycle, with the steady state shaded."""
    fig, ((rates, held),) = figure(1, 2, WIDE, 3.2)
    for name, colour in (("feed", FEED), ("undersize", UNDER), ("oversize", OVER)):
        rates.plot(flows.time_s, getattr(flows, f"{name}_kg_per_s"), color=colour, label=name)
    rates.set(title="mass flow, mean of each cycle", ylabel="rate / (kg/s)")
    held.plot(flows.time_s, flows.hold_up_kg, color=HELD, label="hold-up")
    held.set(title="mass in the machine", ylabel="hold-up / kg")
    for axes in (rates, held):
        axes.set(xlabel="time / s", xlim=(0, flows.time_s[-1]))
        axes.set_ylim(bottom=0)
        if state and state.is_steady:
            axes.axvspan(state.start_s, state.end_s, color="#c9d6e8", alpha=0.5, lw=0)
    rates.legend(loc="upper left", ncols=3, bbox_to_anchor=(0, -0.2))
    return fig


def draw_partition(screening: Screening, table: Partition) -> Any:
    """Draw the partition number over the size, with the cut size, d50 and the sizes of the feed."""
    mean, number, edges = table.mean_m, table.oversize_percent, 1e3 * table.edges_m
    fig, ((axes,),) = figure(1, 1, HALF, 3.4)
    axes.bar(
        edges[:-1], table.feed_percent, np.diff(edges), align="edge", color="#dfe3e8", label="feed's mass"
    )
    there = np.isfinite(number)
    axes.plot(1e3 * mean[there], number[there], "o-", color=HELD, ms=4, label="to the oversize")
    if (whole := screening.whole_feed) and (curve := whole.curve):
        axes.plot(
            1e3 * curve.sieve_size_m,
            curve.oversize_percent,
            ":",
            color=HELD,
            label="continued to finer sizes",
        )
    if screening.cut_size_m:
        axes.axvline(1e3 * screening.cut_size_m, color=OVER, ls="--", label="cut size")
    if table.d50_m.value is not None:
        axes.plot(1e3 * table.d50_m.value, 50, "D", color="#a23b72", label="d50")
    axes.set(title="partition curve", xlabel="size / mm", ylabel="share of mass / %", ylim=(0, 105))
    axes.legend(loc="upper left", ncols=2, bbox_to_anchor=(0, -0.18))
    return fig


def draw_sections(rows: Sequence[Section]) -> Any:
    """Draw the yields of the sections and, if there is a cut size, their efficiencies."""
    fig, ((axes,),) = figure(1, 1, HALF, 3.4)
    place = np.arange(len(rows))
    divided = rows[0].local_efficiency_percent is not None
    bars = ("local_efficiency", "yield") if divided else ("yield",)
    for number, name in enumerate(bars):
        values, errors = _bars([getattr(row, f"{name}_percent") for row in rows])
        shift = (number - (len(bars) - 1) / 2) * 0.38
        label = {"local_efficiency": "local efficiency", "yield": "yield"}[name]
        style = {"label": label, "color": (UNDER, "#b9c3cc")[number], "error_kw": {"lw": 1}}
        axes.bar(place + shift, values, 0.36, yerr=errors, **style)
    if divided:
        values, errors = _bars([row.cumulative_efficiency_percent for row in rows])
        axes.errorbar(place, values, errors, fmt="o-", color=HELD, ms=4, label="efficiency up to here")
    axes.set_xticks(place, [row.exit for row in rows])
    axes.set(title="sections", ylabel="%", ylim=(0, 105), xlabel="section (exit)")
    axes.set_xlim(-0.6, max(len(rows), FEWEST_SECTIONS) - 0.4)
    axes.grid(axis="x", visible=False)
    fig.legend(loc="outside lower left", ncols=3, columnspacing=1.0)
    _raise_crowded_labels(axes)
    return fig


def _raise_crowded_labels(axes: Any) -> None:
    """Turn the labels below the axes upright if some of them would overlap side by side."""
    axes.figure.draw_without_rendering()
    labels = [label.get_window_extent() for label in axes.get_xticklabels()]
    if any(label.x1 + LABEL_GAP > following.x0 for label, following in pairwise(labels)):
        axes.tick_params(axis="x", labelrotation=90)


def _bars(estimates: Sequence[Estimate | None]) -> tuple[list[float], list[float]]:
    known = [each or Estimate(None) for each in estimates]
    values = [np.nan if each.value is None else each.value for each in known]
    return values, [each.half_width or 0.0 for each in known]


def draw_contacts(why: Contacts) -> Any:
    """Draw the chance of a contact by size beside the geometric one, and what has passed along the deck.

    The share of the fines that has passed at each panel's end is drawn over the time that those which went on
    spent over the deck up to there, with the curve of one rate.
    """
    fig, ((chances, course),) = figure(1, 2, WIDE, 3.4)
    sizes, fit = why.sizes, why.fit
    mean_mm = 1e3 * sizes.mean_m
    for key, style, label in (
        ("chance_percent", "o-", "counted: passed over contacts"),
        ("geometric_percent", "--", "geometric: straight down, untouched"),
    ):
        chances.plot(mean_mm, getattr(sizes, key), style, ms=4, label=label)
    chances.set(title="chance of a contact", xlabel="size / mm", ylabel="%")
    course.plot(fit.time_s, [row.passed_percent for row in why.along], "o", label="up to each panel's end")
    time_s = np.linspace(0.0, fit.time_s[-1], 50)
    label = f"1 − exp(−k t), k = {fit.rate_per_s:.2g} 1/s"
    course.plot(time_s, -100.0 * np.expm1(-fit.rate_per_s * time_s), label=label)
    course.set(title="fines that have passed", xlabel="time over the deck / s", ylabel="%")
    for axes in (chances, course):
        axes.set_ylim(bottom=0)
        axes.legend(loc="upper left", bbox_to_anchor=(0, -0.2))
    return fig


ALONG = {"depth_m": HELD, "velocity_m_per_s": OVER, "mass_kg_per_m": FEED}
"""Means along the deck, with the colours in which they are drawn."""


def draw_along_deck(profile: Profile, passing: Passing | None) -> Any:
    """Draw the bed's height, velocity, mass and, if it was counted, the passing rate along the deck.

    95 % of the mass lies below the height.
    """
    fig, axes = figure(2, 2, WIDE, 4.8)
    for ax, (name, colour) in zip(axes.flat, ALONG.items(), strict=False):
        record = FIGURES[f"results.bed.profile.{name}"]
        values = getattr(profile, name) * record.shown_scale
        ax.plot(profile.along_m, values, "o-", ms=3, color=colour)
        ax.set(ylabel=record.label, xlabel="distance along the deck / m")
        if name != "velocity_m_per_s":
            ax.set_ylim(bottom=0)
    last = axes[1, 1]
    if passing is None:
        last.axis("off")
    else:
        step = passing.along_m[1] - passing.along_m[0]
        last.bar(passing.along_m, passing.rate_kg_per_s_m, 0.85 * step, color=UNDER)
        last.set(ylabel="passing rate / (kg/(s m))", xlabel="distance along the deck / m")
    return fig


def draw_course(course: Course) -> Any:
    """Draw the amplitude of the frames against each other and the mass on the full deck, over time."""
    fig, axes = figure(1, 1, WIDE, 3.2)
    ax, end_s = axes[0, 0], course.end_s
    highest_mm = 1e3 * max((max(pair.along_m) for pair in course.relative.values()), default=0.0)
    for name, pair in course.relative.items():
        width_mm = 1e3 * np.nan_to_num(pair.half_width_m)
        along_mm = 1e3 * np.asarray(pair.along_m)
        ax.errorbar(end_s, along_mm, width_mm, marker="o", ms=3, lw=1, capsize=2, label=name)
    ax.set(
        xlabel="time / s",
        ylabel="amplitude along / mm",
        title="frames against each other, windows of twelve cycles",
    )
    ax.set_ylim(0, 1.25 * highest_mm)  # where the machine runs up, intervals are far wider
    ax.legend(loc="lower left")
    if course.on_deck_kg is not None:
        load = ax.twinx()
        load.fill_between(end_s, course.on_deck_kg, color=FEED, alpha=0.25, lw=0)
        load.set(ylabel="on the deck / kg")
        load.set_ylim(bottom=0)
        load.grid(visible=False)
    return fig


def draw_wear(panels: Mapping[str, PanelWear]) -> Any:
    """Draw the depth of wear in 1000 h in the patches of all panels, side by side."""
    maps = {name: MM_IN_1000_H * panel.depth_m_per_h for name, panel in panels.items()}
    fig, ((axes,),) = figure(1, 1, WIDE, 2.6)
    deepest = max(float(np.nanmax(values)) for values in maps.values())
    for place, values in enumerate(maps.values()):
        edges = place + np.linspace(0.02, 0.98, len(values) + 1)
        across = np.linspace(0.0, 1.0, values.shape[1] + 1)
        mesh = axes.pcolormesh(edges, across, values.T, vmin=0.0, vmax=deepest, cmap="magma_r")
    fig.colorbar(mesh, ax=axes, label="mm in 1000 h")
    axes.set_xticks(np.arange(len(maps)) + 0.5, list(maps))
    axes.set(ylabel="share of the width", title="wear, each panel from its first clamp")
    axes.grid(visible=False)
    _raise_crowded_labels(axes)
    return fig


def draw_results(results: Results) -> Iterator[tuple[str, Any]]:
    """Yield the name and the figure of every picture for which results, of the whole width, have numbers."""
    if screening := results.screening:
        yield "balance", draw_balance(screening.in_time, results.steady)
        if screening.partition:
            yield "partition", draw_partition(screening, screening.partition)
        if screening.sections:
            yield "sections", draw_sections(screening.sections)
    if results.contacts:
        yield "contacts", draw_contacts(results.contacts)
    if results.bed:
        passing = results.transport.passing if results.transport else None
        yield "along", draw_along_deck(results.bed.profile, passing)
    if results.course:
        yield "course", draw_course(results.course)
    if results.wear:
        yield "wear", draw_wear(results.wear.panels)


def draw_machine(run: RunReader) -> Iterator[tuple[str, Any]]:
    """Yield the name and the figure of every picture for which the run has data."""
    drawings = {
        "frames": ("frame_motion", draw_frames),
        "panels": ("panel_shapes", draw_panel_shapes),
        "bushings": ("bushing_loops", draw_bushing_loops),
        "energy": ("energy", draw_energy),
    }
    for group, (name, draw) in drawings.items():
        if run.has(group):
            yield name, draw(run)
    if not (run.has("probes") and run.is_driven):
        return
    on_frames = [name for name, probe in run.case.probes.items() if probe.frame is not None]
    if len(on_frames) >= FEWEST_PROBES:
        yield "point_orbits", draw_point_orbits(run, on_frames)
    on_panels = {
        panel: [name for name, probe in run.case.probes.items() if probe.panel == panel]
        for panel in run.names("panels")
    }
    if equipped := {panel: names for panel, names in on_panels.items() if len(names) >= FEWEST_PROBES}:
        yield "panel_instants", draw_panel_instants(run, equipped)


def write_pictures(folder: Path) -> None:
    """Write all pictures for which the folder of a run has data, that of the deck beside the others."""
    with worker() as renderer, RunReader(folder) as run:
        deck = renderer.submit(_write_deck, folder, run.end_s)
        for name, fig in draw_machine(run):
            save(fig, folder / f"{name}.png")
        deck.result()


def _write_deck(folder: Path, end_s: float) -> None:
    if (folder / "surface.pvd").is_file():
        from orchestrator.output.report.rendering import render_deck

        render_deck(folder, end_s, folder / "deck.png")


def _grid(count: int, ylabel: str, edge: float, height: float) -> tuple[Any, Any]:
    """Return a figure with axes for ``count`` parts, side by side in rows."""
    columns = min(COLUMNS, count)
    rows = -(-count // columns)
    fig, axes = figure(rows, columns, WIDE, max(edge + height * rows, LOWEST))
    for ax in axes.flat[count:]:
        ax.axis("off")
    for row in axes:
        row[0].set_ylabel(ylabel)
    return fig, axes


if __name__ == "__main__":
    write_pictures(admit(Path(sys.argv[1])))
