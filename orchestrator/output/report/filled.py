"""The program's pages: templates that hold everything in themselves, under one head and style."""

from __future__ import annotations

from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape


def fill_template(template: str, **values: Any) -> str:
    """Returns the HTML of a template, named by its place below ``orchestrator/``."""
    environment = Environment(
        loader=PackageLoader("orchestrator", "."),
        autoescape=select_autoescape(["html"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(template).render(**values)
