"""The pictures of a study."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.ports import Array
from orchestrator.studies.design.campaign import BEST, CENTRE, FEWEST_EXPLAINED, SIMPLER
from orchestrator.studies.design.findings import Findings
from orchestrator.studies.design.optimisers import predict_each
from orchestrator.studies.quantities import NORMAL_95
from orchestrator.studies.report import figure_parts
from orchestrator.views.style import LINES, figure, save

GREY, BLACK, RED, GREEN, BLUE = "#9aa3ad", "#222222", "#c1443c", "#6b7f1f", LINES[0]
BINS = 12  # of a factor's range, over which predictions are averaged
GRID = 41  # settings along each side of a surface
MARKS = {BEST: ("*", 15, RED), SIMPLER: ("D", 7, GREEN), CENTRE: ("s", 7, BLACK)}


def draw_all(findings: Findings, folder: Path) -> dict[str, Path]:
    """Write the pictures for which there are enough data, and return their files by name."""
    if findings.fitted is None:
        return {}
    drawings: dict[str, Callable[[Findings], Any]] = {
        "trade_off": _trade_off,
        "effects": _effects,
        "surface": _surface,
        "sensitivity": _sensitivity,
        "parity": _parity,
        "progress": _progress,
    }
    files = {}
    for name, draw in drawings.items():
        if (drawn := draw(findings)) is not None:
            files[name] = folder / f"{name}.png"
            save(drawn, files[name])
    return files


def label_of(findings: Findings, response: int) -> str:
    """Return a response's name with its unit."""
    name = findings.responses[response]
    return _with_unit(name, findings.campaign.study.file.responses[name].unit)


def factor_label(findings: Findings, name: str) -> str:
    """Return a factor's name with its unit."""
    return _with_unit(name, findings.campaign.study.file.factors[name].unit)


def _with_unit(name: str, unit: str) -> str:
    return " / ".join(filter(None, [name, f"({unit})" if "/" in unit else unit]))


def _own(findings: Findings, response: int, fitted: Array) -> Array:
    """Return values on a surrogate's scale in the response's unit."""
    return findings.campaign.scales[findings.responses[response]].from_fit(fitted)


def _trade_off(findings: Findings) -> Any:
    """Draw the front with its 95 % band, random settings, all runs, and the settings that were run again.

    Random settings that are expected to break a limit beside the trade-off are left out, and runs that do are
    open marks: they may lie beyond the front.
    """
    if findings.trade_off is None or findings.fitted is None:
        return None
    first, second, *_ = findings.trade_off
    drawn, ((axis,),) = figure(width=8.4, height=5.2)
    mean, _ = predict_each(findings.fitted, findings.random_settings)
    mean = mean[:, findings.beside.kept(mean)]
    places = (_own(findings, response, mean[response]) for response in (second, first))
    axis.plot(*places, ".", ms=2, color=GREY, label=f"{mean.shape[1]} random settings, predicted")
    widths = NORMAL_95 * np.sqrt(findings.data.variance)
    (x, dx), (y, dy) = (_with_bars(findings, r, findings.data.y[:, r], widths[:, r]) for r in (second, first))
    beyond = np.zeros(len(x), bool)  # not where a limited response was not measured
    for limit in findings.beside.limits:
        beyond |= limit.sign * (findings.data.y[:, limit.response] - limit.value) < 0.0
    for mine, fill, which in ((~beyond, BLUE, "runs"), (beyond, "white", "runs beyond another limit")):
        if mine.any():
            bars = dy[:, mine], dx[:, mine]
            axis.errorbar(x[mine], y[mine], *bars, "o", ms=3, mfc=fill, lw=0.6, color=BLUE, label=which)
    if len(findings.front):
        mean, deviation = predict_each(findings.fitted, findings.front)
        along = _own(findings, second, mean[second])
        low, high = (_own(findings, first, mean[first] + s * NORMAL_95 * deviation[first]) for s in (-1, 1))
        order = np.argsort(along)
        axis.plot(
            along[order], _own(findings, first, mean[first])[order], color=BLACK, label="front, predicted"
        )
        axis.fill_between(along[order], low[order], high[order], color=BLACK, alpha=0.12, lw=0)
    for each in findings.confirmed:
        kind = each.role.split(",")[0]
        mark, size, colour = MARKS[kind]
        a, b = (each.measured[findings.responses[r]] for r in (second, first))
        label = f"{kind}, run again" if kind not in axis.get_legend_handles_labels()[1] else None
        axis.errorbar(a.value, b.value, b.half_width, a.half_width, mark, ms=size, color=colour, label=label)
    for aim in findings.campaign.study.aims.values():
        for limit in aim.limits:
            if limit.response == second:
                axis.axvline(float(_own(findings, second, np.array(limit.value))), color=RED, lw=0.8, ls="--")
    axis.set(xlabel=label_of(findings, second), ylabel=label_of(findings, first), title="Trade-off")
    handles = dict(zip(*reversed(axis.get_legend_handles_labels()), strict=True))
    axis.legend(handles.values(), handles, fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return drawn


def _with_bars(findings: Findings, response: int, y: Array, width: Array) -> tuple[Array, Array]:
    """Return values in the response's unit and the lengths, (2, n), of their error bars."""
    low, middle, high = (_own(findings, response, y + s * width) for s in (-1, 0, 1))
    return middle, np.abs([middle - low, high - middle])


def main_effects(findings: Findings, factor: int) -> tuple[Array, Array, Array]:
    """Add up what a factor's steps from bin to bin change, on the average of the random settings in a bin.

    Return the bins' middles, (b,), in the factor's unit; averages and mean 95 % half widths, (b, m), on the
    surrogates' scales.  Mere averages in bins would show the effects of other factors where these are ordered
    and move together.  Source: D. W. Apley, J. Zhu, J. R. Stat. Soc. B 82 (2020) 1059,
    doi:10.1111/rssb.12377.
    """
    assert findings.fitted is not None
    x = findings.random_settings
    mean, deviation = predict_each(findings.fitted, x)
    edges = np.quantile(x[:, factor], np.linspace(0, 1, BINS + 1))
    numbers = np.clip(np.searchsorted(edges, x[:, factor], side="right") - 1, 0, BINS - 1)
    bins = [numbers == number for number in range(BINS)]
    low, high = x.copy(), x.copy()
    low[:, factor], high[:, factor] = edges[numbers], edges[numbers + 1]
    change = predict_each(findings.fitted, high)[0] - predict_each(findings.fitted, low)[0]
    steps = np.array([change[:, b].mean(axis=1) for b in bins])
    curve = np.cumsum(steps, axis=0) - steps / 2.0
    space, middles = findings.campaign.study.space, (edges[:-1] + edges[1:]) / 2.0
    in_units = 0.5 * (space.low[factor] * (1.0 - middles) + space.high[factor] * (1.0 + middles))
    widths = np.array([NORMAL_95 * deviation[:, b].mean(axis=1) for b in bins])
    return in_units, curve - curve.mean(axis=0) + mean.mean(axis=1), widths


def _effects(findings: Findings) -> Any:
    names, responses = list(findings.campaign.study.file.factors), findings.responses
    drawn, grid = figure(
        len(responses), len(names), 2.6 * len(names) + 0.8, 2.6 * len(responses), sharey="row", sharex="col"
    )
    for column, name in enumerate(names):
        place, mean, width = main_effects(findings, column)
        for row in range(len(responses)):
            axis = grid[row, column]
            low, middle, high = (_own(findings, row, mean[:, row] + s * width[:, row]) for s in (-1, 0, 1))
            axis.fill_between(place, low, high, color=BLUE, alpha=0.2, lw=0)
            axis.plot(place, middle, color=BLUE)
            if column == 0:
                axis.set_ylabel(label_of(findings, row))
            if row == len(responses) - 1:
                axis.set_xlabel(factor_label(findings, name))
    drawn.suptitle(
        "Main effects: averages over all other factors, with the 95 % band", fontsize=10, x=0.01, ha="left"
    )
    return drawn


def strongest_pair(findings: Findings) -> tuple[int, int] | None:
    """Return the two factors whose main effects on the first goal, or the first response, span the most."""
    factors = findings.campaign.study.space.factors
    if factors < 2:
        return None
    goals = findings.campaign.study.aim.goals
    response = goals[0].response if goals else 0
    spans = [float(np.ptp(main_effects(findings, factor)[1][:, response])) for factor in range(factors)]
    first, second = sorted(range(factors), key=lambda factor: -spans[factor])[:2]
    return first, second


def _surface(findings: Findings) -> Any:
    """Draw each response over the two strongest factors, the others as in the best setting; settings that
    miss a limit are hatched."""
    pair = strongest_pair(findings)
    if pair is None or findings.fitted is None:
        return None
    study = findings.campaign.study
    base = next(iter(findings.best.values()), study.space.ordered(np.zeros((1, study.space.factors)))[0])
    side = np.linspace(-1.0, 1.0, GRID)
    settings = np.tile(base, (GRID * GRID, 1))
    settings[:, pair[0]], settings[:, pair[1]] = (each.ravel() for each in np.meshgrid(side, side))
    possible = (np.abs(study.space.ordered(settings.copy()) - settings) < 1e-9).all(axis=1)
    mean, _ = predict_each(findings.fitted, settings)
    missed = ~study.aim.kept(mean) & possible
    names = list(study.file.factors)
    actual = study.space.actual(settings)
    x, y = (actual[:, factor].reshape(GRID, GRID) for factor in pair)
    drawn, parts = figure_parts(len(findings.responses), min(2, len(findings.responses)), 5.2, 4.2)
    for response, axis in enumerate(parts):
        values = np.where(possible, _own(findings, response, mean[response]), np.nan).reshape(GRID, GRID)
        filled = axis.contourf(x, y, values, 12, cmap="viridis")
        drawn.colorbar(filled, ax=axis)
        if missed.any():
            axis.contourf(x, y, missed.reshape(GRID, GRID), [0.5, 1.5], colors="none", hatches=["///"])
        if findings.best:
            place = study.space.actual(base)[list(pair)]
            axis.plot(*place, "*", ms=15, color=RED, mec="white")
        axis.set(xlabel=factor_label(findings, names[pair[0]]), ylabel=factor_label(findings, names[pair[1]]))
        axis.set_title(label_of(findings, response))
        axis.grid(visible=False)
    return drawn


def _sensitivity(findings: Findings) -> Any:
    """Draw first-order and total Sobol indices with the 95 % intervals of their sampling.

    They are those of the surrogate; where it explains too little, that is said in their place.
    """
    if findings.sobol is None:
        return None
    own = findings.campaign.study.file.search.surrogate
    explained = next(each.explained for each in findings.surrogates if each.name == own)
    names = list(findings.campaign.study.file.factors)
    drawn, parts = figure_parts(len(findings.responses), min(2, len(findings.responses)), 5.2, 3.2)
    place = np.arange(len(names))
    for response, axis in enumerate(parts):
        first, first_width, total, total_width = findings.sobol[response]
        axis.bar(place - 0.2, first, 0.38, yerr=first_width, color=BLUE, label="alone", capsize=2)
        axis.bar(place + 0.2, total, 0.38, yerr=total_width, color=GREY, label="with others", capsize=2)
        axis.set_xticks(place, names, rotation=20, ha="right")
        axis.set_ylabel("share of the surrogate's variance")
        name, share = findings.responses[response], float(explained[response])
        little = f"{name}: the surrogate explains {100 * max(share, 0.0):.0f} % only"
        axis.set_title(little if share < FEWEST_EXPLAINED else f"What decides {name}")
        axis.legend(fontsize=8)
    return drawn


def _parity(findings: Findings) -> Any:
    """Draw measured against predicted responses, each predicted without its own run, for every surrogate."""
    judged = [each for each in findings.surrogates if each.fitted is not None]
    responses = findings.responses
    drawn, grid = figure(len(responses), len(judged), 3.5 * len(judged), 3.3 * len(responses))
    for column, each in enumerate(judged):
        assert each.fitted is not None
        mean, deviation = each.fitted.left_out()
        for row in range(len(responses)):
            axis = grid[row, column]
            known = np.isfinite(findings.data.y[:, row]) & np.isfinite(mean[:, row])
            x, dx = _with_bars(findings, row, mean[known, row], NORMAL_95 * deviation[known, row])
            width = NORMAL_95 * np.sqrt(findings.data.variance[known, row])
            y, dy = _with_bars(findings, row, findings.data.y[known, row], width)
            axis.errorbar(x, y, dy, dx, "o", ms=3, lw=0.5, color=BLUE)
            ends = [min(x.min(), y.min()), max(x.max(), y.max())]
            axis.plot(ends, ends, color=BLACK, lw=0.8)
            beside = 0.1 * (ends[1] - ends[0]) or 1.0
            limits = (ends[0] - beside, ends[1] + beside)  # wide bars end at the frame
            axis.set(xlim=limits, ylim=limits, box_aspect=1)
            quality = f"Q² = {each.explained[row]:.2f}, in 95 %: {100 * each.coverage[row]:.0f} %"
            axis.set_title(f"{each.name}: {responses[row]}\n{quality}", fontsize=9)
            axis.set(xlabel="predicted without this setting", ylabel="run" if column == 0 else "")
    return drawn


def progress(findings: Findings) -> Iterator[tuple[int, float]]:
    """Yield the number of each run and the best first goal so far of runs that keep all limits."""
    study, data = findings.campaign.study, findings.data
    goal = study.aim.goals[0]
    best = np.nan
    for number, y in zip(data.numbers, data.y, strict=True):
        if np.isfinite(y).all() and study.aim.kept(y[:, None])[0]:
            gain = goal.sign * y[goal.response]
            best = gain if np.isnan(best) else max(best, gain)
        yield int(number), float(goal.sign * best)


def _progress(findings: Findings) -> Any:
    study = findings.campaign.study
    if not study.aim.goals:
        return None
    goal = study.aim.goals[0]
    drawn, ((axis,),) = figure(width=8.4, height=3.2)
    colours = {"centre": BLACK, "plan": GREY, "search": BLUE, "confirm": RED}
    stages = {each.trial.number: each.trial.stage for each in findings.campaign.outcomes}
    y = _own(findings, goal.response, findings.data.y[:, goal.response])
    for stage, colour in colours.items():
        mine = np.array([stages[int(number)] == stage for number in findings.data.numbers])
        if mine.any():
            axis.plot(findings.data.numbers[mine], y[mine], "o", ms=4, color=colour, label=stage)
    numbers, best = zip(*progress(findings), strict=True)
    best_own = _own(findings, goal.response, np.array(best))
    axis.step(numbers, best_own, where="post", color=BLACK, lw=1, label="best so far")
    axis.set(xlabel="run", ylabel=label_of(findings, goal.response), title="Progress")
    axis.legend(fontsize=8, loc="upper left", bbox_to_anchor=(1.01, 1.0))
    return drawn
