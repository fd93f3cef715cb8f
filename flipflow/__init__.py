"""flipflow from Python: load a case, change and check it, run it, and read the run.

``case.run()`` makes the run in a process of its own and returns a ``Run``; ``flipflow.open_run`` opens the
folder of an earlier one.  These names stay as they are from version to version; all else belongs to the
inside of the program.

Examples
--------
>>> import flipflow
>>> case = flipflow.load("cases/panel-cycle", level="draft")
>>> case = case.change({"duration_s": 0.02})
>>> case.check()
[]
"""

from flipflow.case import Case, load
from flipflow.run import Run, RunFailed, RunInterrupted, open_run
from orchestrator.case.file.errors import CaseError
from orchestrator.case.file.folder import FolderUnusable
from orchestrator.run.progress import ProgressReport

__all__ = [
    "Case",
    "CaseError",
    "FolderUnusable",
    "ProgressReport",
    "Run",
    "RunFailed",
    "RunInterrupted",
    "load",
    "open_run",
]
