"""The output of ``flipflow results``: the results of runs as rows, for the terminal or for other programs."""

from __future__ import annotations

import csv
import sys
from collections.abc import Mapping, Sequence
from pathlib import Path

from orchestrator.case.file.printable import escape_unprintable
from orchestrator.cli.console import CONSOLE, ERRORS, refuse, reported_errors
from orchestrator.cli.json_forms import print_json
from orchestrator.output.results.tidy import doubtful, read_results
from orchestrator.output.tables import write_csv, write_parquet

WRITERS = {".csv": write_csv, ".parquet": write_parquet}


def print_results(folders: Sequence[Path], out: Path | None, as_json: bool) -> None:
    """Write the results of runs into the file ``out``, or print them as JSON or CSV."""
    if out is not None and out.suffix not in WRITERS:
        refuse(f"--out {out}: a file ending in {' or '.join(WRITERS)} is wanted")
    with reported_errors():
        runs = read_results(folders)
    rows = [row for run in runs for row in run.rows()]
    for line in doubtful(runs):
        ERRORS.print(f"warning: {line}")
    if out is not None:
        try:
            WRITERS[out.suffix](rows, out)
        except OSError as error:
            refuse(f"{out}: cannot be written: {error.strerror or error}")
        if not as_json:
            CONSOLE.print(f"written: {out}")
    if as_json:
        print_json({"results": rows})
    elif out is None:
        print_csv(rows)


def print_csv(rows: Sequence[Mapping[str, str | float | None]]) -> None:
    """Print rows as CSV on standard output, with the escapes of characters that a terminal could obey."""
    writer = csv.DictWriter(sys.stdout, [*rows[0]])
    writer.writeheader()
    writer.writerows(
        {key: escape_unprintable(v) if isinstance(v, str) else v for key, v in row.items()} for row in rows
    )
