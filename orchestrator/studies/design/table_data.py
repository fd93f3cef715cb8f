"""Trials read from a table of measured or published data instead of runs."""

from __future__ import annotations

import warnings
from dataclasses import replace

import numpy as np
import pandas as pd

from orchestrator.studies.design.scales import SCALES
from orchestrator.studies.design.study_file import Study, StudyError
from orchestrator.studies.design.trials import DONE, Measured, Outcome, Trial
from orchestrator.workbench import CaseProblem
from orchestrator.workbench.vocabulary import Array, Key, did_you_mean

LARGEST = 1e100  # beyond it, and below one over it, squares are no numbers
DEVIATION = " deviation"  # ends the name of the column with a response's standard deviation


def read_table(study: Study, key: Key = ("table",)) -> list[Outcome]:
    """Return one outcome for each row of the study's table, which stands at ``key`` of its file.

    An empty cell of a response is a response that was not measured; rows without any are no data.
    Raises StudyError where the file cannot be read, lacks a column, or a cell of a factor is not a number.
    """
    file, path = study.file, study.path(study.file.table)
    try:
        if path.exists() and not path.is_file():  # a pipe would be waited for
            raise ValueError("it is not a file")
        with warnings.catch_warnings(action="error", category=pd.errors.ParserWarning):
            table = pd.read_csv(path, comment="#", skipinitialspace=True, index_col=False)
            head = pd.read_csv(path, comment="#", skipinitialspace=True, header=None, nrows=1, dtype=str)
    except pd.errors.ParserWarning:
        what = f"{path} has rows with more cells than columns (decimals have points, not commas)"
        raise StudyError([CaseProblem(key, what, kind="wrong-type")]) from None
    except (OSError, ValueError) as error:
        what = f"{path} cannot be read: {str(error).splitlines()[0]}"
        raise StudyError([CaseProblem(key, what, kind="file")]) from None
    columns = {name: response.result or name for name, response in file.responses.items()}
    optional = [column + DEVIATION for column in columns.values() if column + DEVIATION in table]
    problems = [
        CaseProblem(
            key, f'{path.name} has no column "{name}"', did_you_mean(name, table.columns), kind="unknown-name"
        )
        for name in [*file.factors, *columns.values()]
        if name not in table
    ]
    written = head.iloc[0].tolist()  # pandas gives the second of two equal names another one
    problems += [
        CaseProblem(key, f'{path.name} has {written.count(name)} columns "{name}"')
        for name in dict.fromkeys([*file.factors, *columns.values(), *optional])
        if written.count(name) > 1
    ]
    if not problems and table.empty:
        problems.append(CaseProblem(key, f"{path.name} has no rows", kind="file"))
    if problems:
        raise StudyError(problems)
    wanted = dict.fromkeys([*file.factors, *columns.values(), *optional])  # two responses may share a column
    numbers = table[[*wanted]].apply(pd.to_numeric, errors="coerce")
    sizes = numbers.abs()
    numbers = numbers.where((sizes == 0) | (sizes > 1 / LARGEST) & (sizes < LARGEST))
    text = numbers.isna() & table[numbers.columns].notna()
    text[list(file.factors)] |= numbers[list(file.factors)].isna()
    for row, column in zip(*np.nonzero(text.to_numpy()), strict=True):
        cell = table[numbers.columns[column]].iloc[row]
        what = f'row {row + 1} of {path.name}: "{cell}" is not a number of {numbers.columns[column]}'
        problems.append(CaseProblem(key, what, "a column's unit belongs into study.toml", kind="wrong-type"))
    for name, column in columns.items():
        low, high = SCALES[file.responses[name].scale].ends
        for row in np.flatnonzero((numbers[column] < low) | (numbers[column] > high)):
            what = f"row {row + 1} of {path.name}: {column} = {numbers[column].iloc[row]:g}"
            problems.append(
                CaseProblem(
                    key, f'{what} is not on the scale "{file.responses[name].scale}"', kind="out-of-range"
                )
            )
    for column in optional:
        for row in np.flatnonzero(numbers[column] < 0):
            what = f"row {row + 1} of {path.name}: {column} = {numbers[column].iloc[row]:g} is negative"
            problems.append(CaseProblem(key, what, kind="out-of-range"))
    if problems:
        raise StudyError(problems)
    settings = study.space.coded(numbers[list(file.factors)].to_numpy(float))
    return [
        _outcome(number, setting, row, columns, study)
        for number, (setting, (_, row)) in enumerate(zip(settings, numbers.iterrows(), strict=True), start=1)
    ]


def read_published(study: Study) -> list[list[Outcome]]:
    """Return the outcomes of each published table of the study, in the order of its file; none where a
    published result has no table.

    A table has a column with the name of the response.  Raises StudyError as :func:`read_table`.
    """
    outcomes = []
    for place, table in enumerate(study.file.published):
        response = study.file.responses[table.response].model_copy(update={"result": ""})
        changes = {"table": table.table, "case": "", "responses": {table.response: response}}
        alone = replace(study, file=study.file.model_copy(update=changes))
        outcomes.append(read_table(alone, ("published", place, "table")) if table.table else [])
    return outcomes


def _outcome(number: int, setting: Array, row: pd.Series, columns: dict[str, str], study: Study) -> Outcome:
    measured = {}
    for name, column in columns.items():
        if np.isfinite(row[column]):
            deviation = row.get(column + DEVIATION, np.nan)
            noise = float(deviation) if np.isfinite(deviation) else study.file.responses[name].noise
            measured[name] = Measured(float(row[column]), noise)
    trial = Trial(number, "plan", tuple(map(float, setting)), 0)
    return Outcome(trial, DONE, "" if measured else "no response was measured", measured)
