"""A picture of one part or of several, in the style of all pages."""

from __future__ import annotations

from pathlib import Path
from typing import Any, ClassVar

from orchestrator.views.style import LINES, figure, save


class Picture:
    """A picture whose parts, axes of Matplotlib, stand in rows of ``columns``.

    ``width`` and ``height`` of a part, and the ``margin`` beside all parts, are in inches; ``more`` are
    arguments of ``matplotlib.pyplot.subplots``.  ``figure`` is Matplotlib's, and ``grid`` has its parts by
    row and column.
    """

    colours: ClassVar[tuple[str, ...]] = LINES
    """The colours of lines, in the order in which they are taken."""

    def __init__(
        self, parts: int, columns: int, width: float, height: float, margin: float = 0.0, **more: Any
    ) -> None:
        rows = -(-parts // columns)
        self.figure, self.grid = figure(rows, columns, width * columns + margin, height * rows, **more)
        for axis in self.grid.flat[parts:]:
            axis.axis("off")
        self.parts: list[Any] = list(self.grid.flat[:parts])

    def save(self, file: Path) -> Path:
        """Write the picture into a file, close it, and return the file."""
        save(self.figure, file)
        return file
