"""The common style of all figures and pages of the program, and the embedding of figures in pages.

It stands in the lowest room that draws, because all rooms above it draw in it.
"""

from __future__ import annotations

import base64
import io
from pathlib import Path
from typing import Any

import matplotlib
from cycler import cycler
from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape

matplotlib.use("Agg")
import matplotlib.pyplot as plt

FEED, UNDER, OVER, HELD = "#4a5560", "#0f8a8a", "#d9822b", "#3b5ba5"
LINES = ("#3b5ba5", "#d9822b", "#0f8a8a", "#a23b72", "#6b7f1f", "#7a5195", "#4a5560", "#c1443c")
WIDE, HALF, TALL = 10.7, 5.4, 3.4  # inches
TEMPLATES = Path(__file__).parents[1]

plt.rcParams.update(
    {
        "font.size": 9.5,
        "font.family": "DejaVu Sans",
        "axes.spines.top": False,
        "axes.spines.right": False,
        "axes.grid": True,
        "axes.axisbelow": True,
        "axes.titlesize": 10,
        "axes.titleweight": "bold",
        "axes.titlelocation": "left",
        "axes.prop_cycle": cycler(color=LINES),
        "grid.alpha": 0.3,
        "legend.frameon": False,
        "lines.linewidth": 1.4,
        "svg.hashsalt": "flipflow",
        "figure.constrained_layout.use": True,
    }
)


def figure(rows: int = 1, columns: int = 1, width: float = HALF, height: float = TALL, **more: Any) -> Any:
    """Return a figure and its axes (rows, columns) in the page's style.

    ``more`` are arguments of ``matplotlib.pyplot.subplots``.
    """
    return plt.subplots(rows, columns, figsize=(width, height), squeeze=False, **more)


def save(fig: Any, file: Path) -> None:
    """Write a figure into a file, and close the figure."""
    fig.savefig(file, dpi=110)
    plt.close(fig)


def embed(fig: Any) -> str:
    """Return a figure as a data URI with its SVG, and close the figure."""
    return data_uri(draw_svg(fig), "image/svg+xml")


def draw_svg(fig: Any) -> bytes:
    """Return a figure as SVG, and close the figure."""
    svg = io.BytesIO()
    fig.savefig(svg, format="svg", metadata={"Date": None})
    plt.close(fig)
    return svg.getvalue()


def data_uri(content: bytes, kind: str) -> str:
    """Return a file's content as a data URI, so that a page needs no other file."""
    return f"data:{kind};base64,{base64.b64encode(content).decode()}"


def fill_template(template: str, **values: Any) -> str:
    """Return the HTML of a page from a template, named by its path below ``orchestrator/``."""
    environment = Environment(
        loader=FileSystemLoader(TEMPLATES),  # a package loader finds the folder of what is compiled instead
        autoescape=select_autoescape(["html"]),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["zip"] = zip
    return environment.get_template(template).render(**values)
