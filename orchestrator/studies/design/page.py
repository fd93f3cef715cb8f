"""What a study says in words, and its page."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np

from orchestrator.studies.design.campaign import BEST, CENTRE, SAME, SIMPLER, Campaign, role_of
from orchestrator.studies.design.findings import ConfidenceInterval, Confirmed, Findings
from orchestrator.studies.design.optimisers import predict_each
from orchestrator.studies.design.surrogates import settings_of
from orchestrator.studies.design.tables import effect_rows, point_rows, term_name
from orchestrator.workbench import StudyFolder
from orchestrator.workbench.vocabulary import Array, align_rows

AT_THE_END = 0.95  # coded: from there on a setting is at the end of a range
SURE = 0.005  # by which the probability that the limits are kept may miss the confidence: by the search
WIDENED = 1.05  # factor on the noise from which on it is mentioned
ON_SCALE = {"percent": "logit ln(p / (100 − p))", "logarithm": "natural logarithm"}
OUTLIER = 4.0  # studentised residual from which on a run is named
SHOWN = (
    (
        "trade_off",
        "Trade-off",
        "The line is what the surrogate expects at best, with its 95 % band. Small dots are random "
        "settings, as predicted; points with bars are runs, open ones beyond another limit.",
    ),
    (
        "effects",
        "What each factor does",
        "What a factor changes itself, averaged over settings of the others, with the 95 % band.",
    ),
    (
        "surface",
        "The two strongest factors",
        "The other factors stand as in the best setting (the star), or in the centre. "
        "Hatched: a limit is missed.",
    ),
    (
        "sensitivity",
        "What decides",
        "Sobol indices: the share of a response's variance that each factor explains.",
    ),
    (
        "parity",
        "Predicted and measured",
        "Each run was predicted from all other settings. Points on the line are right; bars are 95 % "
        "intervals.",
    ),
    ("progress", "Progress", "The line is the best run so far that keeps all limits."),
)


def answers(findings: Findings) -> Iterator[str]:
    """Yield the answer for each aim in one sentence: the best setting, measured where it was run again.

    With two goals the setting is the best in the first alone, which is said.
    """
    study = findings.campaign.study
    confirmed = {each.role: each for each in findings.confirmed}
    for name, aim in study.aims.items():
        goals = [
            f"{'largest' if goal.sign > 0 else 'smallest'} {findings.responses[goal.response]}"
            for goal in aim.goals
        ]
        limits = name or ", ".join(study.file.limits)
        at_limits = f" at {limits}" if limits else ""
        asked = f"For the {' and '.join(goals)}{at_limits}"
        if name in findings.why_no_optimum:
            yield f"{asked} the data support no optimum: {findings.why_no_optimum[name]}."
        elif name in findings.best:
            if len(goals) > 1:
                asked = f"For the {goals[0]} alone{at_limits} (front.csv trades it for the {goals[1]})"
            setting = setting_in_words(findings, findings.best[name])
            each = confirmed.get(role_of(BEST, name))
            if each is None:
                said = responses_in_words(findings, findings.predict(findings.best[name]))
                failed = findings.failures_of(role_of(BEST, name))
                why = (
                    f"NOT measured: its runs gave no data ({failed[0].why})" if failed else "not yet measured"
                )
                yield f"{asked} take {setting}: predicted {said}, {why}."
            else:
                said = responses_in_words(findings, each.measured)
                verdict = "as predicted" if not each.why_not else f"NOT as predicted: {each.why_not}"
                yield f"{asked} take {setting}: measured {said} in {each.runs} runs, {verdict}."


def doubts(findings: Findings) -> Iterator[str]:
    """Yield how many planned runs are not made, which data lie outside the ranges, and how many of them did
    not become steady."""
    campaign = findings.campaign
    if campaign.study.file.case and (left := campaign.planned_left):
        made = "flipflow study design makes them"
        if campaign.study.file.hours is not None:
            made += f" as far as they fit into {hours_in_words(campaign)}; all need more hours"
        yield f"{left} of {campaign.planned} planned runs {'is' if left == 1 else 'are'} not made: {made}."
    x, numbers = findings.data.x, [f"{number:04d}" for number in findings.data.numbers]
    if outside := np.flatnonzero((np.abs(x) > 1.0 + SAME).any(axis=1)).tolist():
        row, factor = divmod(int(np.abs(x).argmax()), x.shape[1])
        name, value = list(campaign.study.actual(x[row]).items())[factor]
        yield (
            f"{len(outside)} of the {len(x)} data lie outside the ranges "
            f"({', '.join(numbers[each] for each in outside)}), farthest {numbers[row]} with {name} = "
            f"{value:.4g}. Surrogates are fitted to them, too, and what is far outside weighs most: is it "
            "mistyped, or of wider ranges?"
        )
    data = [each for each in campaign.outcomes if each.is_data]
    if unsteady := sorted(each.trial.name for each in data if each.not_steady):
        yield (
            f"{len(unsteady)} of the {len(data)} runs that are data did not become steady "
            f"({', '.join(unsteady)}; not_steady in points.csv says why): a deck that still fills, or a "
            "machine that still starts, gives other numbers than later. Longer runs help (duration_s in "
            "overrides); steady = true under a response leaves out those whose deck still fills."
        )


def hours_in_words(campaign: Campaign) -> str:
    """Return the hours for the planned runs."""
    hours, left = campaign.study.file.hours, campaign.hours_before_confirming
    return f"{left:g} h" + (f" ({hours:g} h less those for the confirming runs)" if hours != left else "")


def borders(findings: Findings) -> Iterator[str]:
    """Yield which best settings are less sure than was asked for, which lie at the ends of ranges, and which
    limits rule nothing out."""
    study = findings.campaign.study
    for name, setting in findings.best.items():
        of_limit, aim = f" for {name}" if name else "", study.aims[name]
        every = np.vstack([setting, findings.random_settings])
        sure = np.exp(aim.log_probability(*predict_each(findings.campaign.fit_before_confirming(), every)))
        if sure.max() < aim.confidence - SURE:
            yield (
                f"No setting was expected to keep the limits{of_limit} as surely as was asked for "
                f"({100 * aim.confidence:.3g} %). The best setting is the one that keeps them most probably "
                f"({100 * sure[0]:.2g} %), whatever the goal: more runs, or other limits, help."
            )
        at_end = [
            f"{factor} at the {'upper' if coded > 0 else 'lower'} end"
            for factor, coded in zip(study.file.factors, setting, strict=True)
            if abs(coded) > AT_THE_END
        ]
        if at_end:
            yield (
                f"The best setting{of_limit} lies at the border of what was searched "
                f"({', '.join(at_end)}): wider ranges may have more."
            )
        if aim.limits and findings.fitted is not None:
            mean, _ = predict_each(findings.fitted, findings.random_settings)
            if aim.kept(mean).all():
                yield f"The limits{of_limit} do not bind: all settings are expected to keep them."


def rivals(findings: Findings) -> Iterator[str]:
    """Yield how much each best setting differs from its simpler rival and from the centre."""
    study = findings.campaign.study
    for name, aim in study.aims.items():
        for goal in aim.goals:
            for other, words in ((role_of(SIMPLER, name), "the best simpler design"), (CENTRE, "the centre")):
                difference = findings.against(role_of(BEST, name), other, goal.response)
                if difference is not None:
                    response = findings.responses[goal.response]
                    unit = study.file.responses[response].unit
                    chance = "beyond" if abs(difference.value) > difference.half_width else "within"
                    yield (
                        f"{role_of(BEST, name)} against {words}: {response} differs by {difference} {unit} "
                        f"({chance} chance, from pairs of runs with equal seeds)."
                    )


def setting_in_words(findings: Findings, setting: Array) -> str:
    """Return a coded setting in the factors' units."""
    factors = findings.campaign.study.file.factors
    actual = findings.campaign.study.actual(setting)
    return ", ".join(f"{name} = {value:.4g} {factors[name].unit}".rstrip() for name, value in actual.items())


def responses_in_words(findings: Findings, intervals: Mapping[str, ConfidenceInterval]) -> str:
    """Return responses with their intervals and units."""
    responses = findings.campaign.study.file.responses
    return ", ".join(f"{name} {each} {responses[name].unit}".rstrip() for name, each in intervals.items())


def noise_in_words(findings: Findings) -> Iterator[str]:
    """Yield what is known about the noise, and runs that stand out."""
    for name, factor in zip(findings.responses, findings.data.widened, strict=True):
        if factor > WIDENED:
            yield (
                f"Repeated runs of {name} scatter {factor:.2g} times as much as the runs' own intervals "
                "say; all intervals are widened by this factor."
            )
    yield from _untold_noise(findings)
    if findings.fitted is None:
        return
    mean, deviation = findings.fitted.left_out()
    residual = np.abs(findings.data.y - mean) / np.sqrt(deviation**2 + findings.data.variance)
    for row, column in zip(*np.nonzero(residual > OUTLIER), strict=True):
        yield (
            f"Run {findings.data.numbers[row]} stands out: its {findings.responses[column]} is "
            f"{residual[row, column]:.1f} standard deviations from what other settings predict. It is kept."
        )


def _untold_noise(findings: Findings) -> Iterator[str]:
    """Yield for which responses neither intervals nor repeated settings tell the noise."""
    data = findings.data
    measured = [each.responses for each in findings.campaign.outcomes if each.is_data]
    told = {name for each in measured for name, one in each.items() if one.deviation is not None}
    for i, name in enumerate(findings.responses):
        known = np.isfinite(data.y[:, i])
        y, settings = data.y[known, i], settings_of(data.x[known])
        if name in told or not known.any():
            continue
        if len(np.unique(settings)) == len(y):
            share = float(np.sqrt(data.variance[known, i].mean()) / (y.std() or 1.0))
            yield (
                f"Nothing tells of the noise of {name}: no run has an interval, no setting was run twice. It "
                f"is taken as what no smooth surface explains, {100 * share:.2g} % of the spread of the "
                "runs. Repeated runs tell it."
            )
        elif all(np.ptp(y[settings == number]) == 0.0 for number in settings):
            yield (
                f"All runs of one setting have one {name}: they are copies, or of a case without random "
                "numbers. They tell nothing of the noise, but count as runs of their own in the quadratic "
                "surface, whose standard errors and p are too small."
            )


def anova_tables(findings: Findings) -> Iterator[dict[str, Any]]:
    """Yield the analysis of variance of each response for the page."""
    factors = list(findings.campaign.study.file.factors)
    scales = findings.campaign.study.file.responses
    for name, surface in findings.quadratic.items():
        quality, lack = surface.quality(), surface.lack_of_fit()
        words = (
            f"R² {quality['r2']:.3f}, adjusted {quality['r2_adjusted']:.3f}, predicted "
            f"{quality['r2_predicted']:.3f}; F {quality['f']:.4g}, p {quality['p']:.2g}; "
            f"standard error of one run {quality['standard_error']:.3g}."
        )
        if lack is not None:
            verdict = (
                "does not fit within the scatter of repeated runs" if lack["p"] < 0.05 else "is not rejected"
            )
            words += f" Lack of fit: F {lack['f']:.4g}, p {lack['p']:.2g}: the quadratic {verdict}."
        if scales[name].scale != "plain":
            words += f" All of it is of the {ON_SCALE[scales[name].scale]}, not of {name} itself."
        rows = [{**row, "term": term_name(row["term"], factors)} for row in surface.anova()]
        yield {"response": name, "words": words, "rows": rows}


def members_in_words(findings: Findings) -> Iterator[str]:
    """Yield a sentence for each response about the spread of a surrogate that has several members."""
    for judged in findings.surrogates:
        if judged.members is not None:
            for name, shares in zip(findings.responses, judged.members.T, strict=True):
                low, middle, high = np.quantile(shares, (0.0, 0.5, 1.0))
                yield (
                    f"{judged.name}: {len(shares)} members, each with a split and start of its own, explain "
                    f"{middle:.2f} of the variance of {name} in settings that they have not seen (median; "
                    f"{low:.2f} to {high:.2f})."
                )


def scope(findings: Findings) -> str:
    """Return for which model of the machine the answer holds."""
    file = findings.campaign.study.file
    if file.table:
        return f"All of it rests on the table {file.table}; nothing was run."
    level = f"level {file.level}" if file.level else "its default level"
    case = findings.campaign.study.path(file.case).resolve().name
    return (
        f"All of it holds for the case {case} at {level}: a computation with the effects and meshes of "
        "that level, not a measurement on a machine."
    )


def write_study_page(findings: Findings, pictures: dict[str, Path], folder: Path) -> Path:
    """Write ``design.html``, which holds its pictures."""
    study = findings.campaign.study
    return StudyFolder(folder).write_page(
        "design.html",
        "design/page.html",
        title=study.file.title or f"Design study of {study.file.case or study.file.table}",
        answers=list(answers(findings)),
        borders=[*doubts(findings), *borders(findings)],
        scope=scope(findings),
        factors=list(study.file.factors),
        responses=findings.responses,
        best=[_best_row(findings, each) for each in findings.confirmed],
        rivals=list(rivals(findings)),
        shown=SHOWN,
        pictures=pictures,
        surrogates=[
            {
                "name": each.name,
                "why_not": each.why_not,
                "quality": list(zip(each.explained, each.coverage, strict=True)),
            }
            for each in findings.surrogates
        ],
        members=list(members_in_words(findings)),
        noise=list(noise_in_words(findings)),
        anova=list(anova_tables(findings)),
        effects=align_rows(effect_rows(findings)),
        failures=[row for row in point_rows(findings) if row["why_no_data"]],
        provenance=f"{len(findings.campaign.outcomes)} runs, of which {len(findings.data.x)} are data. "
        "The tables are points.csv, costs.csv, fit.json, front.csv and best.csv beside this page; each run "
        "has a folder in runs/.",
    )


def _best_row(findings: Findings, each: Confirmed) -> dict[str, Any]:
    actual = findings.campaign.study.actual(each.setting)
    return {
        "role": each.role,
        "runs": each.runs,
        "setting": [f"{value:.4g}" for value in actual.values()],
        "responses": [(str(each.measured[name]), str(each.predicted[name])) for name in findings.responses],
        "verdict": each.why_not or "as predicted",
    }
