"""The tables of a study: points, fit, front, best settings, and levels to run them again."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from orchestrator.case.file.errors import CaseProblem
from orchestrator.case.file.whole import write_json, write_text
from orchestrator.figures.figure import to_json
from orchestrator.ports import Array
from orchestrator.preflight.judge import JudgedCase
from orchestrator.preflight.level_file import level_text
from orchestrator.studies.design.campaign import BEST, role_of
from orchestrator.studies.design.data import Data
from orchestrator.studies.design.findings import ConfidenceInterval, Confirmed, Findings
from orchestrator.studies.design.quadratic import Surface, Term, least_squares, model_matrix, quadratic_terms
from orchestrator.studies.design.study_file import StudyError
from orchestrator.studies.design.surrogates import TooFewPoints
from orchestrator.studies.design.table_data import read_published
from orchestrator.studies.design.trials import Outcome
from orchestrator.studies.quantities import NORMAL_95
from orchestrator.studies.report import Cell, write_csv, write_parquet

Row = dict[str, Cell]


def write_tables(findings: Findings, folder: Path) -> Iterator[Path]:
    """Write all tables that follow from the outcomes, and yield their files.

    Tables and levels of an earlier call are removed: what follows no more from the outcomes must not stay.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for pattern in ("front.csv", "best.csv", "effects.csv", "recommended*.toml"):
        for old in folder.glob(pattern):
            old.unlink()
    file, study = folder / "study.toml", findings.campaign.study
    if study.folder != folder.resolve():  # there, the file with its comments is the user's own
        write_text(file, tomli_w.dumps(study.table_for(folder)))
        yield file
    points = point_rows(findings)
    yield write_csv(points, folder / "points.csv")
    yield write_parquet(points, folder / "points.parquet")
    yield write_csv(cost_rows(findings), folder / "costs.csv")
    file = folder / "fit.json"
    write_json(file, to_json(fit_table(findings)))  # what is not defined is no number in JSON
    yield file
    if len(findings.front):
        rows = [{**study.actual(x), **_intervals(findings.predict(x), "")} for x in findings.front]
        yield write_csv(rows, folder / "front.csv")
    if best := best_rows(findings):
        yield write_csv(best, folder / "best.csv")
    if effects := effect_rows(findings):
        yield write_csv(effects, folder / "effects.csv")


def point_rows(findings: Findings) -> list[Row]:
    """Return a row for each trial: setting, status, responses with their standard deviations as the
    surrogates take them, and what was predicted before the run."""
    data, rows = findings.data, []
    places = {int(number): place for place, number in enumerate(data.numbers)}
    study = findings.campaign.study
    for outcome in sorted(findings.campaign.outcomes, key=lambda each: each.trial.number):
        trial = outcome.trial
        row: Row = {"trial": trial.number, "stage": trial.stage, "role": trial.role, "seed": trial.seed}
        row |= trial.values or study.actual(np.array(trial.setting))
        row |= {
            "status": outcome.status,
            "why_no_data": outcome.why,
            "not_steady": outcome.not_steady,
            "particle_steps": outcome.particle_steps,
        }
        for i, (name, scale) in enumerate(findings.campaign.scales.items()):
            measured = outcome.responses.get(name)
            row[name] = measured.value if measured else None
            place = places.get(trial.number)
            if measured is not None and place is not None:
                error = float(np.sqrt(data.variance[place, i]))
                row[f"{name} deviation"] = error / float(scale.slope(measured.value))
            if name in trial.predicted:
                mean, deviation, *_ = trial.predicted[name]
                predicted = ConfidenceInterval.of(scale, mean, NORMAL_95 * deviation)
                row |= _intervals({name: predicted}, " predicted")
        rows.append(row)
    return rows


def cost_rows(findings: Findings) -> list[Row]:
    """Return the wall and processor time of each trial, apart from ``points.csv``, which is the same however
    often the study was interrupted."""
    return [
        {"trial": each.trial.number, "wall_s": each.wall_s, "processor_s": each.processor_s}
        for each in sorted(findings.campaign.outcomes, key=lambda each: each.trial.number)
    ]


def fit_table(findings: Findings) -> dict[str, Any]:
    """Return what was fitted: each surrogate's quality, the quadratic with its analysis of variance, and the
    Sobol indices."""
    factors, responses = list(findings.campaign.study.file.factors), findings.responses
    table: dict[str, Any] = {"factors": factors, "responses": responses, "runs": len(findings.data.x)}
    table["noise_widened"] = dict(zip(responses, map(float, findings.data.widened), strict=True))
    table["surrogates"] = {
        judged.name: {"why_not": judged.why_not}
        if judged.fitted is None
        else {
            name: {"explained": float(judged.explained[i]), "coverage_95": float(judged.coverage[i])}
            | ({} if judged.members is None else {"explained_by_members": judged.members[:, i].tolist()})
            for i, name in enumerate(responses)
        }
        for judged in findings.surrogates
    }
    table["quadratic"] = {
        name: surface_table(name, surface, findings) for name, surface in findings.quadratic.items()
    }
    if findings.sobol is not None:
        keys = ("first", "first_half_width", "total", "total_half_width")
        table["sobol"] = {
            name: {
                key: dict(zip(factors, values.tolist(), strict=True))
                for key, values in zip(keys, indices, strict=True)
            }
            for name, indices in zip(responses, findings.sobol, strict=True)
        }
    table["why_no_optimum"] = {name or "all limits": why for name, why in findings.why_no_optimum.items()}
    return table


def surface_table(response: str, surface: Surface, findings: Findings) -> dict[str, Any]:
    """Return the quadratic surface of a response, all of it on the scale on which it is fitted.

    It has quality, analysis of variance with coefficients for coded and actual units, lack of fit, groups of
    terms, residuals, and Sobol indices in closed form.
    """
    factors = list(findings.campaign.study.file.factors)
    settings = findings.campaign.study.space.actual(surface.x)
    actual = least_squares(model_matrix(settings, surface.terms), surface.y)
    terms = [
        {**row, "term": term_name(row["term"], factors), "coefficient_in_units": float(b)}
        for row, b in zip(surface.anova(), actual, strict=True)
    ]
    variance, first, total = surface.sobol_indices()
    return {
        "scale": findings.campaign.study.file.responses[response].scale,
        **surface.quality(),
        "residual_degrees_of_freedom": float(surface.fitted.df_resid),
        "anova": [{key: v if isinstance(v, str) else float(v) for key, v in row.items()} for row in terms],
        "lack_of_fit": surface.lack_of_fit(),
        "sequential": surface.sequential(),
        "residuals": surface.fitted.resid.tolist(),
        "studentised_residuals": surface.studentised_residuals().tolist(),
        "sobol": {
            "variance": variance,
            "first": dict(zip(factors, first.tolist(), strict=True)),
            "total": dict(zip(factors, total.tolist(), strict=True)),
        },
    }


def term_name(term: Term, factors: Sequence[str]) -> str:
    """Return the name of a term: ``1``, ``a``, ``a*b`` or ``a**2``."""
    if len(term) == 2 and term[0] == term[1]:
        return f"{factors[term[0]]}**2"
    return "*".join(factors[i] for i in term) or "1"


def best_rows(findings: Findings) -> list[Row]:
    """Return the best setting of each aim, its simpler rival and the centre: predicted and measured."""
    confirmed = {each.role: each for each in findings.confirmed}
    rows = [_confirmed_row(findings, each) for each in confirmed.values()]
    for name, setting in findings.best.items():
        if role_of(BEST, name) not in confirmed:
            predicted = findings.predict(setting)
            row: Row = {"role": role_of(BEST, name), "runs": 0, "verdict": "not run again"}
            rows.append(row | findings.campaign.study.actual(setting) | _intervals(predicted, " predicted"))
    for name, why in findings.why_no_optimum.items():
        rows.append({"role": role_of(BEST, name), "runs": 0, "verdict": why})
    return rows


def _confirmed_row(findings: Findings, each: Confirmed) -> Row:
    row: Row = {"role": each.role, "runs": each.runs, "verdict": each.why_not or "as predicted"}
    row |= findings.campaign.study.actual(each.setting)
    return row | _intervals(each.measured, "") | _intervals(each.predicted, " predicted")


def _intervals(intervals: Mapping[str, ConfidenceInterval], suffix: str) -> Row:
    row: Row = {}
    for name, interval in intervals.items():
        row |= {name + suffix: interval.value, f"{name}{suffix} half width": interval.half_width}
    return row


def effect_rows(findings: Findings) -> list[Row]:
    """Return the effect of each factor on each response, beside those of published tables.

    An effect is the change from the lower to the upper end of the factor in the quadratic surface, on the
    scale on which the response is fitted.  A
    published effect has the same sign, the opposite sign, or is chance: one of the two intervals has zero in
    it.  The verdict says, too, if the two effects differ beyond chance.
    """
    study = findings.campaign.study
    rows: list[Row] = []
    for name, surface in findings.quadratic.items():
        published = {
            table.source: _published_effects(findings, name, outcomes)
            for table, outcomes in zip(study.file.published, read_published(study), strict=True)
            if table.table and table.response == name
        }
        for number, factor in enumerate(study.file.factors):
            own = surface.effects()[number]
            scale = study.file.responses[name].scale
            row: Row = {"response": name, "scale": scale, "factor": factor}
            row |= {"effect": own[0], "half width": own[1]}
            for source, effects in published.items():
                theirs = effects[number]
                chance = abs(own[0]) < own[1] or abs(theirs[0]) < theirs[1]
                row |= {f"{source}": theirs[0], f"{source} half width": theirs[1]}
                sign = "same sign" if own[0] * theirs[0] > 0 else "opposite sign"
                differ = abs(own[0] - theirs[0]) > np.hypot(own[1], theirs[1])
                row[f"{source} verdict"] = f"{'chance' if chance else sign}{', of another size' * differ}"
            rows.append(row)
    return rows


def _published_effects(findings: Findings, response: str, outcomes: list[Outcome]) -> Array:
    """Fit the quadratic surface to a published table, and return its effects, (factors, 2)."""
    data = Data.of(outcomes, {response: findings.campaign.scales[response]})
    terms = quadratic_terms(findings.campaign.study.space.factors)
    try:
        return Surface.fit(data.x, data.y[:, 0], terms).effects()
    except TooFewPoints as few:
        what = f"the published table of {response} has no quadratic surface: {few}"
        raise StudyError([CaseProblem(("published",), what)]) from None


def write_recommended(findings: Findings, loaded: JudgedCase, folder: Path) -> Iterator[Path]:
    """Write a level file for each best setting that was confirmed, which ``flipflow run CASE --level FILE``
    takes."""
    study = findings.campaign.study
    for number, (name, setting) in enumerate(findings.best.items()):
        confirmed = [each for each in findings.confirmed if each.role == role_of(BEST, name)]
        if confirmed and not confirmed[0].why_not:
            file = folder / f"recommended{f'-{number + 1}' if name else ''}.toml"
            about = (
                f"recommended by a design study{f' for {name}' if name else ''}, measured by runs of its own"
            )
            write_text(file, level_text(loaded, study.overlays(study.actual(setting)), about))
            yield file
