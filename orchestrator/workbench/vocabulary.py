"""General words, which belong to no room and know neither cases nor runs.

Kinds of values and tables for the files of studies, with the reading of such files; units; numbers with their
uncertainty, and errors that are known of a run; exact times.
"""

from orchestrator.case.file.errors import Key, did_you_mean, from_validation, show_value
from orchestrator.case.file.layers import read_toml
from orchestrator.case.file.units import NUMBER_ALONE, parse_quantity, split_quantity
from orchestrator.case.tables.quantities import (
    Few,
    Name,
    Number,
    OneLine,
    Positive,
    Share,
    Switch,
    Table,
    Whole,
    same_unit,
    unit_of,
)
from orchestrator.figures.accuracy import Accuracy, Basis, KnownError
from orchestrator.figures.figure import in_unit, to_json
from orchestrator.figures.short_names import Value
from orchestrator.output.report.formatting import interval
from orchestrator.output.results.estimate import CONFIDENCE, NORMAL_95
from orchestrator.output.tables import Cell, align_rows
from orchestrator.ports import Array
from orchestrator.ports.clock import exact, sample_s
from orchestrator.preflight.cost import in_words
