"""The forces on a frame over time, for programs that compute its strength."""

from enum import StrEnum


class Format(StrEnum):
    """The format in which the loads are written."""

    CSV = "csv"
    CALCULIX = "calculix"
    APDL = "apdl"
