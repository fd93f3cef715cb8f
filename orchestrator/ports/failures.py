"""Why a run ends that is not the case's fault."""

from __future__ import annotations


class SolverMissing(Exception):
    """A solver's package is not installed; the message says what to install (exit code 3)."""


class SolverFailed(Exception):
    """A solver failed or went unstable; the message says which, when and why (exit code 4)."""
