"""``flipflow report``: from a run's folder to its page, or to words about what is wrong."""

from __future__ import annotations

from pathlib import Path

from orchestrator.casefile.errors import CaseError
from orchestrator.records.run_folder import FolderUnusable, write_text
from orchestrator.report.film import film
from orchestrator.report.page import NAME, page
from orchestrator.results.compute import results

NEEDED = ("case.toml", "summary.json", "provenance.json", "history.h5")


def report(folder: Path) -> Path:
    """Writes the page and returns its path.

    Raises FolderUnusable where ``folder`` is no run, or is a run from which nothing can be read.
    """
    missing = [name for name in NEEDED if not (folder / name).is_file()]
    if not folder.is_dir():
        raise FolderUnusable(f"{folder}: no such folder")
    if missing:
        raise FolderUnusable(
            f"{folder}: no run, or one that has not ended: it has no {', '.join(missing)}"
        )
    try:
        text = page(folder, results(folder), film)
        made = folder / NAME
        write_text(made, text)
    except CaseError as error:
        raise FolderUnusable(f"{folder}: its case cannot be read\n{error}") from None
    except KeyError as error:
        raise FolderUnusable(
            f"{folder}: there is no {error} in its files: the run was made by another version of "
            "flipflow; run the case again"
        ) from error
    except (ValueError, TypeError, IndexError, AttributeError, RuntimeError) as error:
        raise FolderUnusable(
            f"{folder}: something in its files is damaged, or of another version of flipflow "
            f"({type(error).__name__}: {error})"
        ) from error
    except OSError as error:
        raise FolderUnusable(f"{folder}: {error}") from None
    return made
