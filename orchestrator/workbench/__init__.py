"""What a study works with: all that studies know of the rest of the program.

A ``Case`` is read with overlays, checked, compared, predicted, and refined by a ``Setting`` of a
``RefinementSeries`` that it can ``Offer``.  A ``Run`` is made, answers a ``Question`` and has ``Metrics``.  A
``StudyFolder`` takes what a study writes, and a ``Picture`` and a ``console_table`` show it.  ``CaseError``
with its ``CaseProblem``, ``FolderUnusable`` and ``Unknown`` say what is wrong.  ``vocabulary`` has the words
that belong to no room, such as kinds of values and units.
"""

from orchestrator.case.file.errors import CaseError, CaseProblem
from orchestrator.case.file.folder import FolderUnusable
from orchestrator.output.results.quantities import Metrics, Question, Unknown
from orchestrator.output.tables import console_table
from orchestrator.preflight.refinement import Offer, RefinementSeries, Setting
from orchestrator.workbench import vocabulary
from orchestrator.workbench.case import Case
from orchestrator.workbench.folder import StudyFolder
from orchestrator.workbench.picture import Picture
from orchestrator.workbench.run import Run

__all__ = [
    "Case",
    "CaseError",
    "CaseProblem",
    "FolderUnusable",
    "Metrics",
    "Offer",
    "Picture",
    "Question",
    "RefinementSeries",
    "Run",
    "Setting",
    "StudyFolder",
    "Unknown",
    "console_table",
    "vocabulary",
]
