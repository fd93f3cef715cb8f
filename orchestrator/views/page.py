"""All views of a machine: as files in a folder, and as one page that opens without a network."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from orchestrator.case.file.folder import admit
from orchestrator.case.file.whole import write_text
from orchestrator.case.tables.case import Case
from orchestrator.preflight.checks.bed import rates_above_the_level
from orchestrator.preflight.judge import JudgedCase
from orchestrator.preflight.scene.frame_modes import frame_modes
from orchestrator.preflight.scene.scene import scene
from orchestrator.views.drawings import SIDE, TOP, draw_view
from orchestrator.views.mats import draw_mats
from orchestrator.views.modes import modes_svg
from orchestrator.views.openings import draw_openings
from orchestrator.views.outline import MachineOutline, outline
from orchestrator.views.style import data_uri, draw_svg, embed, fill_template
from orchestrator.views.worker import worker

DPI = 130
PAGE, MODEL, MODES = "machine.html", "model.html", "modes.svg"


@dataclass(frozen=True)
class CheckFindings:
    """What ``flipflow check`` says about a case: problems, warnings, and lines about contents and cost."""

    problems: Sequence[str] = ()
    warnings: Sequence[str] = ()
    lines: Sequence[str] = ()


class Views:
    """The views of a judged case; a slice is shown as a part of its whole machine."""

    def __init__(self, loaded: JudgedCase) -> None:
        """Take the case's geometry.  Raises stl.UnreadableSurface."""
        self._loaded = loaded
        self._case: Case = loaded.case.whole_machine
        rates_kg_per_s = rates_above_the_level(loaded.origin.given, loaded.layers)
        self.machine: MachineOutline = outline(self._case, loaded.folder, rates_kg_per_s)

    def figures(self) -> Iterator[tuple[str, Any]]:
        """Yield the name and the figure of each drawing: side and top view, kinds of openings and of mats."""
        of_mats = draw_mats(scene(self._case))
        for view in (SIDE, TOP):
            yield view.name, draw_view(self.machine, view)
        for name, figure in draw_openings(self._case):
            yield f"openings-{name}", figure
        for name, figure in of_mats:
            yield f"mats-{name}", figure

    def modes(self) -> str:
        """Return the animated SVG of the frames' modes; "" if no frame is free."""
        shaken = scene(self._case)
        if not (modes := frame_modes(shaken)):
            return ""
        return modes_svg(self.machine, modes, [row.speed_rad_per_s / (2 * math.pi) for row in shaken.shaken])

    def write(self, folder: Path, findings: CheckFindings) -> list[Path]:
        """Write all views into a folder, which is made if needed, and return the files.

        Raises FolderUnusable for a foreign folder, and OSError if a file cannot be written.
        """
        admit(folder).mkdir(parents=True, exist_ok=True)
        written: list[Path] = []
        drawings: dict[str, str] = {}
        with made_apart(self.machine) as model:
            for name, figure in self.figures():
                written += [folder / f"{name}.png", folder / f"{name}.svg"]
                figure.savefig(written[-2], dpi=DPI)
                svg = draw_svg(figure)
                written[-1].write_bytes(svg)
                drawings[name] = data_uri(svg, "image/svg+xml")
            modes = self.modes()
            page = self._page(findings, drawings, modes, model())
        for name, text in ((MODES, modes), (MODEL, model()), (PAGE, page)):
            if text:
                write_text(folder / name, text)
                written.append(folder / name)
        return written

    def page(self, findings: CheckFindings) -> str:
        """Return the HTML of one page with the findings and all views."""
        with made_apart(self.machine) as model:
            drawings = {name: embed(figure) for name, figure in self.figures()}
            return self._page(findings, drawings, self.modes(), model())

    def _page(self, findings: CheckFindings, drawings: dict[str, str], modes: str, model: str) -> str:
        return fill_template(
            "views/page.html",
            loaded=self._loaded,
            case=self._case,
            findings=findings,
            drawings=drawings,
            modes=modes,
            model=model,
        )


@contextmanager
def made_apart(machine: MachineOutline) -> Iterator[Callable[[], str]]:
    """Make the model's page in a process of its own, and yield the function that waits for it.

    LIGGGHTS brings another VTK, which cannot share a process with this one.  The function returns "" if the
    process crashed.
    """
    with worker("spawn") as apart:
        made = apart.submit(_model_page, machine)

        def model() -> str:
            try:
                return made.result()
            except BrokenProcessPool:
                return ""

        yield model


def _model_page(machine: MachineOutline) -> str:
    """Return the model's page; only the process that makes it loads VTK."""
    from orchestrator.views.model import model_page

    return model_page(machine)
