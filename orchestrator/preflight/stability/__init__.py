"""The stability of a coupled run: bounds on its sync interval, computed before the run.

``report.py`` is the entry.  docs/theory/stability.md has derivations, tests and measured limits.
"""
