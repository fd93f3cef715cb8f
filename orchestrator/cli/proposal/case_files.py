"""The files of a proposed case, from templates of commented TOML."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined


def fill_templates(folder: str, values: Mapping[str, Any], files: Sequence[str]) -> dict[str, str]:
    """Return the texts of files from the templates in ``templates/<folder>``, by their paths in the case."""
    return {file: _environment().get_template(f"{folder}/{file}").render(**values) for file in files}


@cache
def _environment() -> Environment:
    """Return the environment of the templates, with filters that write numbers."""
    environment = Environment(
        loader=PackageLoader("orchestrator.cli.proposal"),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {"toml": toml_value, "mm": lambda length_m: f"{1e3 * length_m:.4g}"}
    return environment


def toml_value(value: float | Sequence[Any]) -> str:
    """Return a number or nested lists of numbers as TOML, with up to ten digits."""
    if isinstance(value, int | float):
        text = f"{value + 0.0:.10g}"  # The sum turns -0.0 into 0.0.
        return text if any(mark in text for mark in ".e") else f"{text}.0"
    rows = [toml_value(row) for row in value]
    if value and not isinstance(value[0], int | float) and len(value) > 2:
        return "[\n" + "".join(f"  {row},\n" for row in rows) + "]"
    return f"[{', '.join(rows)}]"


def toml_answer(text: str) -> str:
    """Return an answer as TOML: a number, or a text such as "750 rpm"."""
    try:
        return toml_value(float(text))
    except ValueError:
        return f'"{text}"'
