"""``flipflow report``: from a run's folder to its page, or to words about what is wrong."""

from __future__ import annotations

from concurrent.futures import ProcessPoolExecutor
from concurrent.futures.process import BrokenProcessPool
from multiprocessing import get_context
from pathlib import Path

from jinja2 import UndefinedError

from orchestrator.case.file.errors import CaseError
from orchestrator.output import checkpoints
from orchestrator.output.records.run_folder import HISTORY, SUMMARY, FolderUnusable, is_at_work, write_text
from orchestrator.output.report.page import NAME, make_film, page
from orchestrator.output.results.compute import compute_results

DAMAGED = (ValueError, TypeError, IndexError, AttributeError, RuntimeError, UndefinedError)
NEEDED = ("case.toml", SUMMARY, "provenance.json", HISTORY)


def report(folder: Path) -> Path:
    """Writes the page and returns its path.

    Raises FolderUnusable where ``folder`` is no run, or is a run from which nothing can be read.
    """
    _complete(folder)
    with ProcessPoolExecutor(1, get_context("fork")) as apart:  # HDF5 crashes on some damaged files
        try:
            return apart.submit(_made, folder).result()
        except BrokenProcessPool:
            raise FolderUnusable(
                f"{folder}: reading history.h5 crashed: it is damaged, or memory ran out"
            ) from None


def _complete(folder: Path) -> None:
    """Raises FolderUnusable where a file is missing."""
    missing = [name for name in NEEDED if not (folder / name).is_file()]
    if not folder.is_dir():
        raise FolderUnusable(f"{folder}: no such folder")
    if missing == [SUMMARY]:
        raise FolderUnusable(f"{folder}: {_why_open(folder)}")
    if missing:
        raise FolderUnusable(f"{folder}: no run, or a damaged one: it has no {', '.join(missing)}")


def _made(folder: Path) -> Path:
    """Raises FolderUnusable where something in the files cannot be used."""
    try:
        write_text(folder / NAME, page(folder, compute_results(folder), make_film))
    except FolderUnusable:
        raise
    except CaseError as error:
        raise FolderUnusable(f"{folder}: its case cannot be read\n{error}") from None
    except KeyError as error:
        raise FolderUnusable(
            f"{folder}: there is no {error} in its files: the run was made by another version of "
            "flipflow; run the case again"
        ) from error
    except DAMAGED as error:
        raise FolderUnusable(
            f"{folder}: something in its files is damaged, or of another version of flipflow "
            f"({type(error).__name__}: {error})"
        ) from error
    except OSError as error:
        raise FolderUnusable(f"{folder}: {error}") from None
    return folder / NAME


def _why_open(folder: Path) -> str:
    """Why the run has no summary, and what can be done."""
    if is_at_work(folder):
        return "the run is still going on"
    killed = "the run was killed before it could close its books"
    save = checkpoints.newest(folder)
    if save is None:
        return f"{killed}, and nothing had been saved; run the case again"
    end = f"duration_s={save.simulated_s:.12g}"
    return (
        f"{killed}; `flipflow resume {folder}` goes on from t = {save.simulated_s:g} s, where it "
        f"was saved, or closes them there with --set {end}"
    )
